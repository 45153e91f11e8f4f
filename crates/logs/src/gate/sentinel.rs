//! Numbers such as 65535 or -9999 that instruments write for unknown values.

use std::sync::LazyLock;

use crate::ChannelSpec;

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
pub(super) fn of_instruments(spec: &ChannelSpec) -> &'static [f64] {
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
pub(super) struct Sentinels {
    /// A turn, of angles that wrap.
    turn: Option<f64>,
    of_instruments: &'static [f64],
    /// The last number that is not a candidate.
    before: f64,
    /// Sum of the moduli of all steps, and how many.
    steps: (f64, u64),
    found: Vec<Found>,
    /// The candidate that the last number is.
    open: Option<usize>,
    /// Whether the first pass is over.
    all_seen: bool,
}

/// A candidate.
struct Found {
    number: f64,
    /// The step to its last occurrence.
    entry: f64,
    /// The greatest distance from both neighbours.
    apart: f64,
}

impl Sentinels {
    pub(super) fn new(turn: Option<f64>, of_instruments: &'static [f64]) -> Self {
        Self {
            turn,
            of_instruments,
            before: f64::NAN,
            steps: (0.0, 0),
            found: Vec::new(),
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
    pub(super) fn see(&mut self, number: f64) {
        if let Some(open) = self.open {
            if number == self.found[open].number {
                return;
            }
            self.leave(open, self.step(self.found[open].number, number));
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
        let place = self.found.iter().position(|found| found.number == number).unwrap_or(self.found.len());
        if place == MOST {
            return false;
        }
        if place == self.found.len() {
            self.found.push(Found { number, entry: f64::NAN, apart: 0.0 });
        }
        self.found[place].entry = step;
        self.open = Some(place);
        true
    }

    /// Notes that the number after candidate `place` is `step` away from it; NaN at the end, like the step to
    /// the very first number.
    fn leave(&mut self, place: usize, step: f64) {
        let found = &mut self.found[place];
        found.apart = found.apart.max(found.entry.min(step));
        self.open = None;
    }

    /// Second pass: whether a number is a value.
    #[inline]
    pub(super) fn keeps(&mut self, number: f64) -> bool {
        if self.found.is_empty() {
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
            self.found.retain(|found| !has_others || found.apart > SENTINEL * mean);
            (self.all_seen, self.before) = (true, f64::NAN);
        }
        let known = self.found.iter().any(|found| found.number == number);
        let is_near = self.step(self.before, number) <= CANDIDATE * mean;
        if known && !is_near {
            return false;
        }
        self.before = number;
        true
    }
}
