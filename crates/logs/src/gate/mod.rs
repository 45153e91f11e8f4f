//! Which numbers of a column are no values: those that stand for none, and those that are not possible.

mod beyond;
mod frozen;
mod hold;
mod limit;
mod places;
mod sentinel;
mod share;

pub(crate) use frozen::keep_alive;
pub(crate) use limit::Limit;
pub(crate) use places::keep_possible;
pub(crate) use share::check_share;

use beyond::Beyond;
use sentinel::Sentinels;

use crate::{ChannelSpec, Omissions, Reason, Unit};

/// Judges the numbers of a column one after the other, as they stand there. Twice: some are known for what they are only when all
/// have been seen.
pub(crate) struct Gate<'a> {
    spec: &'a ChannelSpec,
    limit: &'a Limit,
    /// None where the configuration says which numbers stand for no value.
    sentinels: Option<Sentinels>,
    /// Of angles.
    beyond: Option<Beyond>,
    /// Numbers that were judged the second time.
    numbers: u64,
    /// Of these, left out as missing and as out of range.
    left_out: [u64; 2],
}

/// Whether two numbers are the same where one of them had 32 bits.
fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 2e-7 * a.abs()
}

impl<'a> Gate<'a> {
    /// No number seen yet of the column of `spec`, which is in `unit`.
    pub(crate) fn new(spec: &'a ChannelSpec, unit: &Unit, limit: &'a Limit) -> Self {
        let (turn, is_heading) = (limit.turn(spec, unit), spec.channel == "psi");
        let sentinels = spec.missing.is_none().then(|| Sentinels::new(turn));
        Self {
            spec,
            limit,
            sentinels,
            beyond: turn.map(|turn| Beyond::new(turn, is_heading)),
            numbers: 0,
            left_out: [0; 2],
        }
    }

    /// Looks at a number for the first time; NaN if it counts for none by itself.
    #[inline]
    pub(crate) fn see(&mut self, number: f64) -> f64 {
        if !number.is_finite() || self.by_itself(number).is_some() {
            return f64::NAN;
        }
        self.sentinels.iter_mut().for_each(|sentinels| sentinels.see(number));
        self.beyond.iter_mut().for_each(|beyond| beyond.see(number));
        number
    }

    /// The same number when all have been seen; NaN, and counted, if it is left out.
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

    /// Why a number counts for none, whatever stands around it.
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

    /// How many numbers there were, and how many of them were left out.
    pub(crate) fn counted(&self) -> (u64, Omissions) {
        let mut omitted = Omissions::default();
        let [missing, range] = self.left_out;
        omitted.add(&self.spec.channel, Reason::Missing, missing);
        omitted.add(&self.spec.channel, Reason::Range, range);
        (self.numbers, omitted)
    }
}
