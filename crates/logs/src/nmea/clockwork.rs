//! The clock of a file of sentences: sentences of one kind from one receiver, or a stamp before each sentence.

use refusal::{Invalid, foreign};

use super::fields::FieldColumn;
use super::sentence::Sentence;
use super::table::{Between, Heard, SensorTable};
use super::timeline::{ClockStep, Reported, Stamp, Timeline, has_time, is_dated, reported_time};
use crate::columns::cell_of;
use crate::stamp::moment;
use crate::{ClockNotes, FileSpec, LogError, Stamps, WarningKind, WarningSummary};

/// The source of times, and the times so far.
pub(super) struct SentenceClock<'a> {
    from: From<'a>,
    timeline: Timeline,
    /// Preferred talkers, best first, and how long the best may be silent \[s\].
    prefer: &'a [String],
    max_gap_s: f64,
    /// The receiver whose time counts, and another that could be used.
    address: Option<String>,
    other: Option<String>,
    /// The time of sentences without one \[s\]; NaN where it is unknown.
    time: f64,
    known: Option<Stamp>,
    /// Later times in other sentences of the receiver, each with the number of waiting sentences.
    marks: Vec<(Reported, usize)>,
    trust: Trust,
    late: usize,
    is_back: bool,
}

enum From<'a> {
    /// Sentences of this kind, possibly of one talker.
    Sentence(String),
    /// A prefix of each sentence: a time as text or a number.
    Prefix(Option<&'a Stamps>),
}

/// What a sentence contributes to the clock.
#[derive(Clone, Copy)]
pub(super) enum Timing {
    Nothing,
    /// It follows a stamp with this time \[s\].
    Prefix(f64),
    /// It is a sentence of the clock, which may have a time.
    Clock(Option<Reported>),
    /// It has a time of its own.
    Own(Reported),
}

/// Where sentences go: the waiting ones, the tables, the wanted columns.
pub(super) type Into<'a, 'b> = (&'a mut Heard, &'a mut Vec<SensorTable>, &'b [FieldColumn]);

/// Most sentences that wait for the time to be known again.
const WAITING: usize = 1 << 16;

/// How much later the time of a sentence may be that belongs to the clock's next time \[s\].
const NEXT: f64 = 3.0;

impl<'a> SentenceClock<'a> {
    /// The clock that `spec` declares.
    pub(super) fn new(spec: &'a FileSpec, max_gap_s: f64, stamps: &'a Stamps) -> Result<Self, Invalid> {
        let from = match spec.time.column.as_str() {
            "prefix" => From::Prefix(spec.time.is_text().then_some(stamps)),
            kind if has_time(kind) => From::Sentence(kind.to_owned()),
            column => {
                let expected = "RMC, ZDA, GGA, GNS or GLL, which have a time, or `prefix`";
                let remedy = "correct the time's `column`";
                return Err(Invalid::new("time of sentences", format!("`{column}`"), expected, remedy));
            }
        };
        Ok(Self {
            from,
            timeline: Timeline::default(),
            prefer: &spec.prefer,
            max_gap_s,
            address: None,
            other: None,
            time: f64::NAN,
            known: None,
            marks: Vec::new(),
            trust: Trust::default(),
            late: 0,
            is_back: false,
        })
    }

    /// What `sentence` contributes; `is_wanted` says whether it has wanted fields.
    pub(super) fn timing(
        &self,
        prefix: &str,
        sentence: &Sentence,
        line: usize,
        (is_wanted, written_in): (bool, &str),
    ) -> Result<Timing, LogError> {
        let kind = match &self.from {
            From::Prefix(stamps) => return Ok(Timing::Prefix(of_prefix(*stamps, prefix, line, written_in)?)),
            From::Sentence(kind) => kind,
        };
        let is_clock = sentence.is_a(kind);
        match reported_time(sentence) {
            Ok(reported) if is_clock => Ok(Timing::Clock(reported)),
            Ok(reported) => Ok(reported.map_or(Timing::Nothing, Timing::Own)),
            Err((value, expected)) if is_clock || is_wanted => {
                let cell = cell_of(line, &format!("{}.time", sentence.address));
                let quoted = format!("`{}`", foreign(value));
                Err(Invalid::new(cell, quoted, expected, "correct or leave out the line").into())
            }
            Err(_) => Ok(Timing::Nothing),
        }
    }

    /// Advances to the time in `sentence`; the waiting sentences get their times.
    pub(super) fn step(&mut self, timing: Timing, sentence: &Sentence, into: Into) {
        match timing {
            Timing::Prefix(time) if time == self.time => {}
            Timing::Prefix(time) => {
                let (heard, tables, wanted) = into;
                let all = heard.len();
                heard.put(all, &Between { time: self.time, before: None, after: None }, tables, wanted);
                self.time = time;
            }
            Timing::Clock(reported) if self.heeds(sentence.address, reported) => {
                let From::Sentence(kind) = &self.from else { return };
                let step = self.timeline.next(reported, is_dated(kind));
                self.follow(step, into);
            }
            Timing::Own(reported)
                if self.address.as_ref().is_none_or(|clock| clock[..2] == sentence.address[..2]) =>
            {
                self.marks.push((reported, into.0.len()));
            }
            Timing::Clock(_) | Timing::Own(_) | Timing::Nothing => {}
        }
    }

    /// Whether the clock follows sentences from `address` with this time.
    fn heeds(&mut self, address: &str, reported: Option<Reported>) -> bool {
        let Some(followed) = self.address.as_deref().filter(|followed| *followed != address) else {
            self.address.get_or_insert_with(|| address.to_owned());
            return true;
        };
        let Some(reported) = reported.filter(|reported| reported.is_fix) else { return false };
        let rank = |address: &str| self.prefer.iter().position(|talker| address.starts_with(talker.as_str()));
        let knew = self.timeline.eras.iter().any(|era| era.fixes > 0);
        let is_better = match (rank(address), rank(followed)) {
            (None, None) if knew => {
                self.other.get_or_insert_with(|| address.to_owned());
                return false;
            }
            (Some(_), None) => true,
            (Some(new), Some(old)) if new < old => true,
            _ => !knew,
        };
        if is_better {
            self.address = Some(address.to_owned());
        }
        is_better || self.timeline.last.is_some_and(|last| last.until(&reported) > self.max_gap_s)
    }

    fn follow(&mut self, step: ClockStep, into: Into) {
        let all = into.0.len();
        match step {
            ClockStep::To(stamp) if stamp.time == self.time => {}
            ClockStep::To(stamp) => {
                self.put(self.before(&stamp, all), Some(stamp), into);
                self.go_to(stamp);
            }
            ClockStep::Unknown if self.time.is_finite() || self.known.is_some() && all > WAITING => {
                self.put(all, None, into);
                self.time = f64::NAN;
            }
            ClockStep::Unknown => {}
            ClockStep::Late { in_doubt } => {
                self.late += 1;
                if in_doubt && self.trust.doubt.is_none() {
                    self.trust.doubt = Some(self.trust.last.clone());
                }
            }
            ClockStep::Back(stamp) => {
                self.is_back = true;
                self.trust.doubt.get_or_insert_with(|| lengths(into.1));
                self.put(all, None, into);
                self.go_to(stamp);
            }
            ClockStep::Set(stamp) => {
                let (heard, tables, wanted) = into;
                self.put(self.before(&stamp, all), None, (heard, tables, wanted));
                self.trust.set.push(lengths(tables));
                self.go_to(stamp);
            }
        }
    }

    /// How many of the waiting sentences came before `stamp` was first reported, perhaps by another sentence.
    fn before(&self, stamp: &Stamp, all: usize) -> usize {
        let first = self.marks.iter().find(|(reported, _)| stamp.is_reached(reported, NEXT));
        first.map_or(all, |(_, count)| *count)
    }

    fn go_to(&mut self, stamp: Stamp) {
        self.time = stamp.time;
        self.known = Some(stamp);
        self.marks.clear();
    }

    /// Puts the first `count` sentences into their tables; the clock's next time is `after`.
    fn put(&mut self, count: usize, after: Option<Stamp>, (heard, tables, wanted): Into) {
        let last = lengths(tables);
        heard.put(count, &Between { time: self.time, before: self.known, after }, tables, wanted);
        if let Some(doubt) = self.trust.doubt.take() {
            self.trust.doubted.push([doubt, lengths(tables)]);
        }
        self.trust.last = last;
    }

    /// Puts the remaining sentences into the tables.
    pub(super) fn finish(&mut self, into: Into) {
        self.put(into.0.len(), None, into);
    }

    /// Whether the clock's own sentences set the time of the following ones.
    pub(super) fn is_stamping(&self) -> bool {
        matches!(self.from, From::Sentence(_))
    }

    /// Findings about its times.
    pub(super) fn notes(&self) -> ClockNotes {
        let of_day = matches!(&self.from, From::Sentence(kind) if !is_dated(kind));
        ClockNotes { of_day, leap_s: self.timeline.leap_s, ..ClockNotes::default() }
    }

    /// Whether rows with times of their own are in order but for a few late ones.
    pub(super) fn is_in_order(&self) -> bool {
        !self.is_back && self.is_stamping()
    }

    /// Removes untrusted times; returns how many of the clock's sentences came late.
    pub(super) fn check(
        &self,
        tables: &mut [SensorTable],
        wanted: &[FieldColumn],
        warnings: &mut Vec<WarningSummary>,
    ) -> Result<usize, Invalid> {
        let From::Sentence(kind) = &self.from else { return Ok(0) };
        if let (Some(followed), Some(other)) = (&self.address, &self.other) {
            let (times, talkers) =
                (format!("times from {followed} and {other}"), [&followed[..2], &other[..2]]);
            let remedy = format!(
                "name `{followed}` as the time's `column`, or set `prefer = [\"{}\", \"{}\"]` in [[file]]",
                talkers[0], talkers[1]
            );
            return Err(Invalid::new("time of sentences", times, "one receiver", remedy));
        }
        self.trust.check((kind, &self.timeline, self.late), tables, wanted, warnings)?;
        Ok(self.late)
    }

    /// The missing clock where none of `addresses` has its time.
    pub(super) fn lacks<'b>(&self, mut addresses: impl Iterator<Item = &'b str>) -> Option<&str> {
        match &self.from {
            From::Sentence(kind) => {
                (!addresses.any(|address| address.ends_with(kind.as_str()))).then_some(kind)
            }
            From::Prefix(_) => None,
        }
    }
}

impl Timing {
    /// The sentence's own time.
    pub(super) fn reported(self) -> Option<Reported> {
        match self {
            Self::Clock(reported) => reported,
            Self::Own(reported) => Some(reported),
            Self::Nothing | Self::Prefix(_) => None,
        }
    }
}

/// The time before a sentence \[s\]; NaN where there is none.
fn of_prefix(stamps: Option<&Stamps>, prefix: &str, line: usize, written_in: &str) -> Result<f64, Invalid> {
    let text = prefix.trim_matches([' ', '\t', ',', ';', '[', ']', '"']);
    match stamps {
        Some(stamps) => {
            stamps.seconds(text).map_err(|why| stamps.refused(line, "prefix", text, why, written_in))
        }
        None if text.is_empty() => Ok(f64::NAN),
        None => {
            let number = text.parse().ok().filter(|number: &f64| number.is_finite());
            let remedy = "correct the line, or state the `format` of the stamps";
            number.ok_or_else(|| {
                Invalid::new(cell_of(line, "prefix"), format!("`{}`", foreign(text)), "a number", remedy)
            })
        }
    }
}

/// How many rows the tables had.
pub(super) type Lengths = Vec<usize>;

/// The rows whose times are not trusted.
#[derive(Default)]
struct Trust {
    /// Before the rows of the last time.
    pub(super) last: Lengths,
    /// Where they became doubtful.
    doubt: Option<Lengths>,
    /// Where they were doubtful.
    doubted: Vec<[Lengths; 2]>,
    /// Where the clock was set.
    pub(super) set: Vec<Lengths>,
}

/// Share of the clock's sentences that may be late, or of another date.
const FEW: f64 = 0.1;

fn lengths(tables: &[SensorTable]) -> Lengths {
    tables.iter().map(SensorTable::rows).collect()
}

impl Trust {
    /// Removes untrusted times. The clock's sentences are of `kind`, and `late` of them came late.
    pub(super) fn check(
        &self,
        (kind, timeline, late): (&str, &Timeline, usize),
        tables: &mut [SensorTable],
        wanted: &[FieldColumn],
        warnings: &mut Vec<WarningSummary>,
    ) -> Result<(), Invalid> {
        let main = main_era(kind, timeline)?;
        let stamps: usize = timeline.eras.iter().map(|era| era.stamps).sum();
        if late as f64 > FEW * stamps as f64 && late > 3 {
            let counted = format!("{late} of {stamps} that are earlier than one before them");
            let remedy = "name one receiver as the time's `column`, or correct the file";
            return Err(Invalid::new("time of sentences", counted, "times that increase", remedy));
        }
        let (weeks_s, moved) = timeline.weeks();
        let weeks = "has dates 1024 weeks off, as after a rollover of the GPS week: moved to the other dates";
        let leaps = "has a leap second: all times after it are taken as a second later";
        for (count, text) in [(moved, weeks), (timeline.leaps, leaps)] {
            let (count, text) = (count as u64, format!("`{kind}` {text}"));
            if count > 0 {
                let channel = kind.to_owned();
                warnings.push(WarningSummary { kind: WarningKind::Clock, channel, count, text });
            }
        }
        for (i, table) in tables.iter_mut().enumerate() {
            table.correct(&self.distrusted(i, table, main), weeks_s, wanted);
        }
        Ok(())
    }

    /// The rows of table `i` whose times are not trusted.
    fn distrusted(&self, i: usize, table: &SensorTable, main: usize) -> Vec<[usize; 2]> {
        let at = |lengths: &Lengths| lengths.get(i).copied().unwrap_or(0);
        let starts = [0].into_iter().chain(self.set.iter().map(at));
        let ends = self.set.iter().map(at).chain([table.rows()]);
        let eras = starts.zip(ends).enumerate().filter(|(era, _)| *era != main);
        let eras = eras.map(|(_, (from, to))| [from, to]);
        // Sentences with times of their own do not depend on it.
        let doubted = self.doubted.iter().filter(|_| !has_time(&table.address));
        eras.chain(doubted.map(|[from, to]| [at(from), at(to)])).collect()
    }
}

/// The period of the clock that is the log's.
fn main_era(kind: &str, timeline: &Timeline) -> Result<usize, Invalid> {
    const YEAR_2000: f64 = 946_684_800.0;
    let eras = &timeline.eras;
    let is_of_log = |i: &usize| eras[*i].fixes > 0 || !is_dated(kind) || eras[*i].first.time > YEAR_2000;
    let main = (0..eras.len()).filter(is_of_log).max_by_key(|i| (eras[*i].fixes, eras[*i].stamps));
    let Some(main) = main else {
        return Err(Invalid::new(
            format!("column `{kind}`"),
            "sentences without a time, or without a date, throughout the file",
            "a time from a receiver with a fix",
            "name other sentences as the time's `column`, such as GGA or ZDA",
        ));
    };
    let fixes: usize = eras.iter().map(|era| era.fixes).sum();
    let other = eras.iter().enumerate().find(|(i, era)| *i != main && era.fixes as f64 > FEW * fixes as f64);
    match other {
        None => Ok(main),
        Some((_, other)) => Err(Invalid::new(
            "time of sentences",
            format!("{} and {}", moment(eras[main].first.time), moment(other.first.time)),
            "dates within a year of each other",
            "cut the file where the clock was set, or name other sentences as the time's `column`",
        )),
    }
}
