//! Which numbers of a column are not values: those that stand for none, and impossible ones.

mod frozen;
mod limit;

pub(crate) use frozen::keep_alive;
pub(crate) use limit::{Limit, check_share, keep_possible};

use std::sync::LazyLock;

use crate::{ChannelSpec, Omissions, Reason, Unit};

/// Judges the numbers of a column in order, in the column's own unit. There are two passes, because some
/// numbers can be judged only when all have been seen.
pub(crate) struct Gate<'a> {
    spec: &'a ChannelSpec,
    limit: &'a Limit,
    /// `None` where the configuration says which numbers stand for no value.
    sentinels: Option<Sentinels>,
    /// For angles.
    beyond: Option<Beyond>,
    /// Numbers judged in the second pass.
    numbers: u64,
    /// Of these, left out as missing and as out of range.
    left_out: [u64; 2],
}

/// Whether two numbers are equal up to single precision.
fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 2e-7 * a.abs()
}

impl<'a> Gate<'a> {
    /// Before the first number of the column of `spec`, which is in `unit`.
    pub(crate) fn new(spec: &'a ChannelSpec, unit: &Unit, limit: &'a Limit) -> Self {
        let (turn, is_heading) = (limit.turn(spec, unit), spec.channel == "psi");
        let sentinels = spec.missing.is_none().then(|| Sentinels::new(turn, of_instruments(spec)));
        Self {
            spec,
            limit,
            sentinels,
            beyond: turn.map(|turn| Beyond::new(turn, is_heading)),
            numbers: 0,
            left_out: [0; 2],
        }
    }

    /// First pass over a number; NaN if it is rejected on its own.
    #[inline]
    pub(crate) fn see(&mut self, number: f64) -> f64 {
        if !number.is_finite() || self.by_itself(number).is_some() {
            return f64::NAN;
        }
        self.sentinels.iter_mut().for_each(|sentinels| sentinels.see(number));
        self.beyond.iter_mut().for_each(|beyond| beyond.see(number));
        number
    }

    /// Second pass; NaN, and counted, if the number is left out.
    #[inline]
    pub(crate) fn keep(&mut self, number: f64) -> f64 {
        if !number.is_finite() {
            return number;
        }
        self.numbers += 1;
        let reason = self.by_itself(number).or_else(|| {
            if self.sentinels.as_mut().is_some_and(|sentinels| !sentinels.keeps(number)) {
                return Some(Reason::Missing);
            }
            self.beyond.as_mut().is_some_and(|beyond| !beyond.keeps(number)).then_some(Reason::Range)
        });
        match reason {
            None => number,
            Some(reason) => {
                self.left_out[usize::from(reason == Reason::Range)] += 1;
                f64::NAN
            }
        }
    }

    /// Why a number is rejected regardless of its neighbours.
    fn by_itself(&self, number: f64) -> Option<Reason> {
        let missing =
            self.spec.missing.as_ref().is_some_and(|missing| missing.iter().any(|none| same(*none, number)));
        let [low, high] = self.limit.numbers;
        if missing {
            Some(Reason::Missing)
        } else if number < low || number > high {
            Some(Reason::Range)
        } else {
            None
        }
    }

    /// The number of values, and how many of them were left out.
    pub(crate) fn counted(&self) -> (u64, Omissions) {
        let mut omitted = Omissions::default();
        let [missing, range] = self.left_out;
        omitted.add(&self.spec.channel, Reason::Missing, missing);
        omitted.add(&self.spec.channel, Reason::Range, range);
        (self.numbers, omitted)
    }
}

/// Consecutive numbers that continue each other before they are taken for a heading that kept counting over a gap.
const IN_A_ROW: usize = 5;

/// Judges angles beyond a turn, which are kept where they continue the previous ones.
struct Beyond {
    /// A turn, in the column's unit.
    turn: f64,
    start: ColumnStart,
    /// The last number that was kept.
    kept: Option<f64>,
    /// The last number that was not kept, and how many of these continue each other.
    dropped: (f64, usize),
    /// How many numbers are beyond a turn, of how many: where most are, the unit is in doubt and not the
    /// numbers. `None` for a heading.
    seen: Option<[usize; 2]>,
}

/// How a column begins.
#[derive(Clone, Copy, PartialEq)]
enum ColumnStart {
    /// Beyond a turn; the last number so far.
    Open(Option<f64>),
    /// With angles.
    Fine,
    /// With numbers that are not angles.
    Wrong,
}

impl Beyond {
    /// For a column whose angles have this `turn`.
    fn new(turn: f64, is_heading: bool) -> Self {
        let seen = (!is_heading).then_some([0; 2]);
        Self { turn, start: ColumnStart::Open(None), kept: None, dropped: (f64::NAN, 0), seen }
    }

    fn is_beyond(&self, number: f64) -> bool {
        number.abs() > 1.001 * self.turn
    }

    fn continues(&self, from: f64, to: f64) -> bool {
        (to - from).abs() <= 0.5 * self.turn
    }

    /// First pass: the first numbers are judged by those after them.
    #[inline]
    fn see(&mut self, number: f64) {
        if let Some([beyond, all]) = &mut self.seen {
            *beyond += usize::from(number.abs() > 1.001 * self.turn);
            *all += 1;
        }
        if let ColumnStart::Open(last) = self.start {
            self.start = match last {
                Some(last) if !self.continues(last, number) => ColumnStart::Wrong,
                _ if self.is_beyond(number) => ColumnStart::Open(Some(number)),
                _ => ColumnStart::Fine,
            };
        }
    }

    /// Second pass: whether a number is an angle.
    #[inline]
    fn keeps(&mut self, number: f64) -> bool {
        if self.seen.is_some_and(|[beyond, all]| 2 * beyond > all) {
            return true;
        }
        let keeps = !self.is_beyond(number)
            || match self.kept {
                Some(kept) => self.continues(kept, number) || self.again(number),
                None => self.start != ColumnStart::Wrong || self.again(number),
            };
        if keeps {
            (self.kept, self.dropped) = (Some(number), (f64::NAN, 0));
        }
        keeps
    }

    /// Whether a number continues so many dropped ones that they are not a fault.
    fn again(&mut self, number: f64) -> bool {
        let (last, count) = self.dropped;
        let moves = number != last && self.continues(last, number);
        self.dropped = (number, if moves { count + 1 } else { 0 });
        self.dropped.1 >= IN_A_ROW
    }
}

/// All ones in two or four bytes, and one less or more.
const BYTES: [f64; 6] = [65_535.0, 32_767.0, 32_768.0, 4_294_967_295.0, 2_147_483_647.0, 2_147_483_648.0];

/// Powers of ten that these may have been divided by.
const DECIMALS: i32 = 7;

/// Nines, which may have been divided by up to a hundred.
const NINES: [f64; 4] = [9_999.0, 99_999.0, 999_999.0, 9_999_999.0];

/// Fill values of formats and programs.
const FILLS: [f64; 5] = [1e20, 1e30, 1e36, 9.969_209_968_386_869e36, 3.402_823_466_385_288_6e38];

/// Smaller numbers are too common.
const LEAST: f64 = 3.0;

/// All moduli, in order.
static KNOWN: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let divided = |of: &'static [f64], decimals: i32| {
        of.iter().flat_map(move |number| (0..=decimals).map(move |k| number / 10.0_f64.powi(k)))
    };
    let mut known: Vec<f64> = divided(&BYTES, DECIMALS).chain(divided(&NINES, 2)).chain(FILLS).collect();
    known.retain(|number| *number >= LEAST);
    known.sort_by(f64::total_cmp);
    known
});

/// Numbers that instruments write for unknown values of the channel of `spec`, ordinary ones elsewhere: no rate of turn, or one
/// beyond what is measured; no speed; no heading.
fn of_instruments(spec: &ChannelSpec) -> &'static [f64] {
    match (spec.channel.as_str(), spec.unit.as_str()) {
        (_, "deg/min") => &[720.0, 731.0, 708.0, 127.0, 128.0],
        (_, "kn" | "knot" | "kt") => &[102.3, 102.2],
        ("psi", _) => &[511.0],
        _ => &[],
    }
}

/// Whether a number is one of them in single precision, or of those `of_instruments`.
fn is_known(number: f64, of_instruments: &[f64]) -> bool {
    let (size, rounding) = (number.abs(), 2e-7 * number.abs());
    if of_instruments.iter().any(|known| (known - size).abs() <= rounding) {
        return true;
    }
    if size < LEAST {
        return false;
    }
    let next = KNOWN.partition_point(|known| *known < size - rounding);
    number == -999.0 || KNOWN.get(next).is_some_and(|known| *known <= size + rounding)
}

/// How many mean steps a number must be away from its neighbours to become a candidate …
const CANDIDATE: f64 = 3.0;

/// … and to be taken for a sentinel.
const SENTINEL: f64 = 5.0;

/// Steps after which their mean is trusted.
const FEW: u64 = 8;

/// Most candidates per column.
const MOST: usize = 4;

/// Finds sentinels: known numbers that stand apart from those before and after them.
struct Sentinels {
    /// A turn, of angles that wrap.
    turn: Option<f64>,
    of_instruments: &'static [f64],
    /// The last number that is not a candidate.
    before: f64,
    /// Sum of the moduli of all steps, and how many.
    steps: (f64, u64),
    candidates: Vec<Candidate>,
    /// The candidate that the last number is.
    open: Option<usize>,
    /// Whether the first pass is over.
    all_seen: bool,
}

/// A candidate.
struct Candidate {
    number: f64,
    /// The step to its last occurrence.
    entry: f64,
    /// The greatest distance from both neighbours.
    apart: f64,
}

impl Sentinels {
    fn new(turn: Option<f64>, of_instruments: &'static [f64]) -> Self {
        Self {
            turn,
            of_instruments,
            before: f64::NAN,
            steps: (0.0, 0),
            candidates: Vec::new(),
            open: None,
            all_seen: false,
        }
    }

    /// The modulus of a step; for angles within a turn.
    fn step(&self, from: f64, to: f64) -> f64 {
        let step = (to - from).abs();
        match self.turn {
            Some(turn) if step > 0.5 * turn => (step - turn * (step / turn).round()).abs(),
            _ => step,
        }
    }

    fn mean(&self) -> f64 {
        self.steps.0 / self.steps.1.max(1) as f64
    }

    #[inline]
    fn see(&mut self, number: f64) {
        if let Some(open) = self.open {
            if number == self.candidates[open].number {
                return;
            }
            self.leave(open, self.step(self.candidates[open].number, number));
        }
        let step = self.step(self.before, number);
        let near = self.steps.1 >= FEW && step <= CANDIDATE * self.mean();
        if !near && number != self.before && is_known(number, self.of_instruments) && self.enter(number, step)
        {
            return;
        }
        if step.is_finite() {
            self.steps = (self.steps.0 + step, self.steps.1 + 1);
        }
        self.before = number;
    }

    /// Notes a candidate that is `step` away from the previous number; `false` if there are too many.
    fn enter(&mut self, number: f64, step: f64) -> bool {
        let place = self
            .candidates
            .iter()
            .position(|candidate| candidate.number == number)
            .unwrap_or(self.candidates.len());
        if place == MOST {
            return false;
        }
        if place == self.candidates.len() {
            self.candidates.push(Candidate { number, entry: f64::NAN, apart: 0.0 });
        }
        self.candidates[place].entry = step;
        self.open = Some(place);
        true
    }

    /// Notes that the number after candidate `place` is `step` away from it; NaN at the end, like the step to
    /// the very first number.
    fn leave(&mut self, place: usize, step: f64) {
        let candidate = &mut self.candidates[place];
        candidate.apart = candidate.apart.max(candidate.entry.min(step));
        self.open = None;
    }

    /// Second pass: whether a number is a value.
    #[inline]
    fn keeps(&mut self, number: f64) -> bool {
        if self.candidates.is_empty() {
            return true;
        }
        self.keeps_among_candidates(number)
    }

    fn keeps_among_candidates(&mut self, number: f64) -> bool {
        let mean = self.mean();
        if !self.all_seen {
            if let Some(open) = self.open {
                self.leave(open, f64::NAN);
            }
            // Candidates that do not stand apart are ordinary numbers, unless there are no others; from here on `before` is that
            // of this pass.
            let has_others = self.before.is_finite();
            self.candidates.retain(|candidate| !has_others || candidate.apart > SENTINEL * mean);
            (self.all_seen, self.before) = (true, f64::NAN);
        }
        let known = self.candidates.iter().any(|candidate| candidate.number == number);
        let is_near = self.step(self.before, number) <= CANDIDATE * mean;
        if known && !is_near {
            return false;
        }
        self.before = number;
        true
    }
}
