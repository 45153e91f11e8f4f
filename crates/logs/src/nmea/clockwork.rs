//! The clock of a file of sentences: sentences of one kind from one receiver, or a stamp before each
//! sentence.

use refusal::{Invalid, foreign};

use super::clock::{Reported, has_time, is_dated, reported_time};
use super::fields::Column;
use super::heard::{Between, Heard};
use super::sentence::Sentence;
use super::table::Table;
use super::timeline::{Stamp, Step, Timeline};
use super::trust::{Trust, lengths};
use crate::columns::cell_of;
use crate::{ClockNotes, FileSpec, LogError, Stamps, WarningSummary};

/// The source of times, and the times so far.
pub(super) struct Clock<'a> {
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
pub(super) type Into<'a, 'b> = (&'a mut Heard, &'a mut Vec<Table>, &'b [Column]);

/// Most sentences that wait for the time to be known again.
const WAITING: usize = 1 << 16;

/// How much later the time of a sentence may be that belongs to the clock's next time \[s\].
const NEXT: f64 = 3.0;

impl<'a> Clock<'a> {
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
            Err((found, expected)) if is_clock || is_wanted => {
                let cell = cell_of(line, &format!("{}.time", sentence.address));
                let found = format!("`{}`", foreign(found));
                Err(Invalid::new(cell, found, expected, "correct or leave out the line").into())
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
            Timing::Own(reported) if self.is_of_clock(sentence.address) => {
                self.marks.push((reported, into.0.len()));
            }
            Timing::Clock(_) | Timing::Own(_) | Timing::Nothing => {}
        }
    }

    fn is_of_clock(&self, address: &str) -> bool {
        self.address.as_ref().is_none_or(|own| own[..2] == address[..2])
    }

    /// Whether the clock follows sentences from `address` with this time.
    fn heeds(&mut self, address: &str, reported: Option<Reported>) -> bool {
        let Some(own) = self.address.as_deref().filter(|own| *own != address) else {
            self.address.get_or_insert_with(|| address.to_owned());
            return true;
        };
        let Some(reported) = reported.filter(|reported| reported.is_fix) else { return false };
        let rank = |address: &str| self.prefer.iter().position(|talker| address.starts_with(talker.as_str()));
        let knew = self.timeline.eras.iter().any(|era| era.fixes > 0);
        match (rank(address), rank(own)) {
            (None, None) if knew => {
                self.other.get_or_insert_with(|| address.to_owned());
                false
            }
            (Some(_), None) => {
                self.address = Some(address.to_owned());
                true
            }
            (Some(new), Some(old)) if new < old => {
                self.address = Some(address.to_owned());
                true
            }
            _ if !knew => {
                self.address = Some(address.to_owned());
                true
            }
            _ => self.timeline.last.is_some_and(|last| last.until(&reported) > self.max_gap_s),
        }
    }

    fn follow(&mut self, step: Step, into: Into) {
        let all = into.0.len();
        match step {
            Step::To(stamp) if stamp.time == self.time => {}
            Step::To(stamp) => {
                self.put(self.before(&stamp, all), Some(stamp), into);
                self.go_to(stamp);
            }
            Step::Unknown if self.time.is_finite() || self.known.is_some() && all > WAITING => {
                self.put(all, None, into);
                self.time = f64::NAN;
            }
            Step::Unknown => {}
            Step::Late { in_doubt } => {
                self.late += 1;
                if in_doubt && self.trust.doubt.is_none() {
                    self.trust.doubt = Some(self.trust.last.clone());
                }
            }
            Step::Back(stamp) => {
                self.is_back = true;
                self.trust.doubt.get_or_insert_with(|| lengths(into.1));
                self.put(all, None, into);
                self.go_to(stamp);
            }
            Step::Set(stamp) => {
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
    ///
    /// # Errors
    /// Two receivers; refusals of [`Trust::check`].
    pub(super) fn check(
        &self,
        tables: &mut [Table],
        wanted: &[Column],
        warnings: &mut Vec<WarningSummary>,
    ) -> Result<usize, Invalid> {
        let From::Sentence(kind) = &self.from else { return Ok(0) };
        if let (Some(own), Some(other)) = (&self.address, &self.other) {
            let (found, talkers) = (format!("times from {own} and {other}"), [&own[..2], &other[..2]]);
            let remedy = format!(
                "name `{own}` as the time's `column`, or set `prefer = [\"{}\", \"{}\"]` in [[file]]",
                talkers[0], talkers[1]
            );
            return Err(Invalid::new("time of sentences", found, "one receiver", remedy));
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
    pub(super) fn own(self) -> Option<Reported> {
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
