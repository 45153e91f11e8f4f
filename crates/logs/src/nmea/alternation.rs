//! Two sensors under one address: values that alternate between two series.

/// Detects values that jump and return.
#[derive(Default)]
pub(super) struct Alternation {
    /// The last two values, the latest first, and the number of values.
    last: [f64; 2],
    count: usize,
    /// Distance of the previous value from the mean of its neighbours.
    before: f64,
    /// How often values jumped and returned, and the mean size of these jumps.
    returns: usize,
    away: f64,
}

/// Least distance of two sensors, by field \[deg\]: two antennas are a metre apart.
const APART: [(&str, f64); 6] = [
    ("heading", 1.5),
    ("magnetic", 1.5),
    ("starboard", 1.5),
    ("port", 1.5),
    ("latitude", 1e-5),
    ("longitude", 1e-5),
];

/// The value before a jump deviates from the mean of its neighbours too, the other way, by at least this
/// fraction.
const RETURN: f64 = 0.25;

/// Share of values that return if there are two sensors.
const SHARE: f64 = 0.15;

/// Least number of returns.
const SOME: usize = 6;

impl Alternation {
    /// Takes the next value of a field called `name`.
    pub(super) fn see(&mut self, value: f64, name: &str) {
        let Some((_, apart)) = APART.into_iter().find(|(own, _)| *own == name) else { return };
        let [previous, first] = self.last;
        let turned = |difference: f64| difference - 360.0 * (difference / 360.0).round();
        // A steady turn keeps every value at the mean of its neighbours.
        let away = 0.5 * (turned(previous - first) - turned(value - previous));
        if self.count >= 2 {
            if away.abs() > apart && away * self.before < -RETURN * away * away {
                self.returns += 1;
                self.away += (away.abs() - self.away) / self.returns as f64;
            }
            self.before = away;
        }
        self.last = [value, previous];
        self.count += 1;
    }

    /// The number of returns and the mean jump, if there seem to be two sensors.
    pub(super) fn found(&self) -> Option<(usize, f64)> {
        let often = self.returns >= SOME && self.returns as f64 > SHARE * self.count as f64;
        often.then_some((self.returns, self.away))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(values: impl Iterator<Item = f64>) -> Option<f64> {
        let mut alternation = Alternation::default();
        values.for_each(|value| alternation.see(value, "heading"));
        alternation.found().map(|(_, away)| away)
    }

    fn turning(k: usize) -> f64 {
        let t = 0.2 * k as f64;
        (350.0 + 35.0 * (0.13 * t).sin()).rem_euclid(360.0)
    }

    #[test]
    fn two_gyros_that_take_turns_are_found_and_a_turning_ship_is_not() {
        let mixed = |every: usize| (0..300).map(move |k| turning(k) + if k % every == 0 { 3.0 } else { 0.0 });
        assert!(
            [2, 3, 5]
                .into_iter()
                .all(|every| found(mixed(every)).is_some_and(|away| (away - 3.0).abs() < 0.5))
        );
        assert!(found((0..300).map(turning)).is_none());
        // White noise of a degree, and occasional spikes.
        let mut seed = 1_u64;
        let mut noise = move || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 40) as f64 / (1_u64 << 23) as f64 - 1.0
        };
        assert!(found((0..300).map(|k| turning(k) + noise())).is_none());
        assert!(found((0..300).map(|k| turning(k) + if k % 40 == 0 { 20.0 } else { 0.0 })).is_none());
    }
}
