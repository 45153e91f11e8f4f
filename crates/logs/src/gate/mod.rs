//! Which numbers of a column are not values: those that stand for none, and impossible ones.

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
use sentinel::{Sentinels, of_instruments};

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
