//! The clock of a file of sentences: those of one kind of one receiver, or a stamp before each.

use refusal::{Invalid, foreign};

use super::clock::{Told, is_dated, tells, told};
use super::fields::Column;
use super::heard::{Between, Heard};
use super::sentence::Sentence;
use super::table::Table;
use super::timeline::{Stamp, Step, Timeline};
use super::trust::{Trust, lengths};
use crate::columns::cell_of;
use crate::{FileSpec, LogError, Stamps, WarningSummary};

/// Where times come from, and what they were so far.
pub(super) struct Clock<'a> {
    from: From<'a>,
    timeline: Timeline,
    /// Talkers, best first, and how long the best may be silent \[s\].
    prefer: &'a [String],
    max_gap_s: f64,
    /// The receiver that tells the time, and another that could.
    address: Option<String>,
    other: Option<String>,
    /// The time of sentences that tell none \[s\]; NaN where it is not known.
    time: f64,
    known: Option<Stamp>,
    /// Times that other sentences of the receiver told since, and how many sentences had been heard then.
    marks: Vec<(Told, usize)>,
    trust: Trust,
    late: usize,
    is_back: bool,
}

enum From<'a> {
    /// Sentences of this kind, perhaps of one talker.
    Sentence(String),
    /// What stands before a sentence: a time as text or a number.
    Prefix(Option<&'a Stamps>),
}

/// What a sentence tells of the time.
#[derive(Clone, Copy)]
pub(super) enum Tells {
    Nothing,
    /// It stands after this time \[s\].
    Prefix(f64),
    /// It is one of the clock's, and may have a time.
    Clock(Option<Told>),
    /// It has a time of its own.
    Own(Told),
}

/// What sentences go into: those heard, the tables, the columns that are wanted.
pub(super) type Into<'a, 'b> = (&'a mut Heard, &'a mut Vec<Table>, &'b [Column]);

/// So many sentences wait for the time to be known again.
const WAITING: usize = 1 << 16;

/// How much later a sentence may be that is taken to be of the clock's next time \[s\].
const NEXT: f64 = 3.0;

impl<'a> Clock<'a> {
    /// The clock that `spec` names.
    pub(super) fn new(spec: &'a FileSpec, max_gap_s: f64, stamps: &'a Stamps) -> Result<Self, Invalid> {
        let from = match spec.time.column.as_str() {
            "prefix" => From::Prefix(spec.time.is_text().then_some(stamps)),
            kind if tells(kind) => From::Sentence(kind.to_owned()),
            column => {
                let expected = "RMC, ZDA, GGA, GNS or GLL, which tell a time, or `prefix`";
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

    /// What `sentence` tells of the time; `is_wanted` is whether something else of it is wanted.
    pub(super) fn tells(
        &self,
        prefix: &str,
        sentence: &Sentence,
        line: usize,
        (is_wanted, written_in): (bool, &str),
    ) -> Result<Tells, LogError> {
        let kind = match &self.from {
            From::Prefix(stamps) => return Ok(Tells::Prefix(of_prefix(*stamps, prefix, line, written_in)?)),
            From::Sentence(kind) => kind,
        };
        let is_clock = sentence.is_a(kind);
        match told(sentence) {
            Ok(told) if is_clock => Ok(Tells::Clock(told)),
            Ok(told) => Ok(told.map_or(Tells::Nothing, Tells::Own)),
            Err((found, expected)) if is_clock || is_wanted => {
                let cell = cell_of(line, &format!("{}.time", sentence.address));
                let found = format!("`{}`", foreign(found));
                Err(Invalid::new(cell, found, expected, "correct or leave out the line").into())
            }
            Err(_) => Ok(Tells::Nothing),
        }
    }

    /// Goes on to what `sentence` tells; sentences before it get their times.
    pub(super) fn step(&mut self, tells: Tells, sentence: &Sentence, into: Into) {
        match tells {
            Tells::Prefix(time) if time == self.time => {}
            Tells::Prefix(time) => {
                let (heard, tables, wanted) = into;
                let all = heard.len();
                heard.put(all, &Between { time: self.time, before: None, after: None }, tables, wanted);
                self.time = time;
            }
            Tells::Clock(told) if self.heeds(sentence.address, told) => {
                let From::Sentence(kind) = &self.from else { return };
                let step = self.timeline.next(told, is_dated(kind));
                self.follow(step, into);
            }
            Tells::Own(told) if self.is_of_clock(sentence.address) => {
                self.marks.push((told, into.0.len()));
            }
            Tells::Clock(_) | Tells::Own(_) | Tells::Nothing => {}
        }
    }

    fn is_of_clock(&self, address: &str) -> bool {
        self.address.as_ref().is_none_or(|own| own[..2] == address[..2])
    }

    /// Whether the clock is of sentences from `address`, which tell this time.
    fn heeds(&mut self, address: &str, told: Option<Told>) -> bool {
        let Some(own) = self.address.as_deref().filter(|own| *own != address) else {
            self.address.get_or_insert_with(|| address.to_owned());
            return true;
        };
        let Some(told) = told.filter(|told| told.is_fix) else { return false };
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
            _ => self.timeline.last.is_some_and(|last| last.until(&told) > self.max_gap_s),
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

    /// How many of the sentences that were heard came before `stamp` was told first, perhaps by another sentence.
    fn before(&self, stamp: &Stamp, all: usize) -> usize {
        let first = self.marks.iter().find(|(told, _)| stamp.is_reached(told, NEXT));
        first.map_or(all, |(_, count)| *count)
    }

    fn go_to(&mut self, stamp: Stamp) {
        self.time = stamp.time;
        self.known = Some(stamp);
        self.marks.clear();
    }

    /// Puts the first `count` sentences into their tables, before the clock tells `after`.
    fn put(&mut self, count: usize, after: Option<Stamp>, (heard, tables, wanted): Into) {
        let last = lengths(tables);
        heard.put(count, &Between { time: self.time, before: self.known, after }, tables, wanted);
        if let Some(doubt) = self.trust.doubt.take() {
            self.trust.doubted.push([doubt, lengths(tables)]);
        }
        self.trust.last = last;
    }

    /// Puts what is left into the tables.
    pub(super) fn finish(&mut self, into: Into) {
        self.put(into.0.len(), None, into);
    }

    /// Whether sentences of its own tell the time of those after them.
    pub(super) fn is_stamping(&self) -> bool {
        matches!(self.from, From::Sentence(_))
    }

    /// Whether rows that tell their own time are in the order of time but for some that came late.
    pub(super) fn is_in_order(&self) -> bool {
        !self.is_back && self.is_stamping()
    }

    /// Takes the times away that are not to be trusted; how many of the clock's sentences came late.
    ///
    /// # Errors
    /// Two receivers; what [`Trust::check`] refuses.
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

    /// What lacks where none of `addresses` tells the time.
    pub(super) fn lacks<'b>(&self, mut addresses: impl Iterator<Item = &'b str>) -> Option<&str> {
        match &self.from {
            From::Sentence(kind) => {
                (!addresses.any(|address| address.ends_with(kind.as_str()))).then_some(kind)
            }
            From::Prefix(_) => None,
        }
    }
}

impl Tells {
    /// The time that a sentence has of its own.
    pub(super) fn own(self) -> Option<Told> {
        match self {
            Self::Clock(told) => told,
            Self::Own(told) => Some(told),
            Self::Nothing | Self::Prefix(_) => None,
        }
    }
}

/// The time that stands before a sentence \[s\]; NaN where there is none.
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
