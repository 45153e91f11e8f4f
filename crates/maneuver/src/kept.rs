//! Declared ranges of a maneuver's motion.

use refusal::Invalid;
use schemars::JsonSchema;
use serde::Deserialize;

/// Ranges that the undisturbed motion of a maneuver has to keep, as \[from, to\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Kept {
    /// Of the surge speed \[m/s\].
    pub u_m_s: Option<[f64; 2]>,
    /// Of the sway speed \[m/s\].
    pub v_m_s: Option<[f64; 2]>,
    /// Of the yaw rate \[rad/s\].
    pub r_rad_s: Option<[f64; 2]>,
}

/// The fraction of a range by which rounding may exceed it.
const ROUNDING: f64 = 1e-9;

impl Kept {
    /// Refuses empty ranges; `maneuver` is the name.
    pub(super) fn check(&self, maneuver: &str) -> Result<(), Invalid> {
        let none =
            |(_, _, [low, high]): &(_, _, [f64; 2])| !(low.is_finite() && high.is_finite() && low <= high);
        match self.ranges().find(none) {
            None => Ok(()),
            Some((state, unit, [low, high])) => Err(Invalid::new(
                format!("maneuver `{maneuver}`, `keeps.{}`", key(state, unit)),
                format!("[{low}, {high}]"),
                "two finite numbers, the lower one first",
                "correct it",
            )),
        }
    }

    /// Refuses `states`, (N+1) × 3 row-major, of `maneuver` that leave a range.
    ///
    /// # Errors
    /// Names the maneuver, the sample, what was found and the range.
    pub fn check_states(&self, maneuver: &str, states: &[f64]) -> Result<(), Invalid> {
        for (state, unit, [low, high]) in self.ranges() {
            let slack = ROUNDING * low.abs().max(high.abs());
            let own = states.iter().skip(state).step_by(3);
            let beyond = |x: &f64| !(low - slack..=high + slack).contains(x);
            if let Some((sample, x)) = own.enumerate().find(|(_, x)| beyond(x)) {
                return Err(Invalid::new(
                    format!("maneuver `{maneuver}`, sample {sample}"),
                    format!("{} = {x} {unit}", NAMES[state]),
                    format!("from {low} to {high} {unit}, as its `keeps.{}` says", key(state, unit)),
                    "lower its amplitudes, or correct the range",
                ));
            }
        }
        Ok(())
    }

    /// The declared ranges, with their states and units.
    fn ranges(&self) -> impl Iterator<Item = (usize, &'static str, [f64; 2])> {
        let all = [(0, "m/s", self.u_m_s), (1, "m/s", self.v_m_s), (2, "rad/s", self.r_rad_s)];
        all.into_iter().filter_map(|(state, unit, range)| range.map(|range| (state, unit, range)))
    }
}

const NAMES: [&str; 3] = ["u", "v", "r"];

/// Such as `u_m_s`.
fn key(state: usize, unit: &str) -> String {
    format!("{}_{}", NAMES[state], unit.replace('/', "_"))
}
