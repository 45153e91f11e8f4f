//! The range, lag and rate of an actuator.

use refusal::{Invalid, check_numbers};

/// The actuator of an input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Actuator {
    /// The range of settings, if known.
    pub range: Option<[f64; 2]>,
    /// Time constant of the response to a command \[s\]; 0 for an immediate one.
    pub lag_s: f64,
    /// The greatest change per second, if known.
    pub rate_per_s: Option<f64>,
}

/// The longest lag \[s\]: a slower actuator cannot steer.
const LONGEST_LAG_S: f64 = 1e4;

impl Actuator {
    /// Of input `name`, as written: its range, lag \[s\] and rate \[1/s\].
    ///
    /// # Errors
    /// An empty range, a lag below 0, a rate that is not above 0.
    pub(crate) fn new(
        name: &str,
        range: Option<[f64; 2]>,
        lag_s: Option<f64>,
        rate_per_s: Option<f64>,
    ) -> Result<Self, Invalid> {
        let thing = |key: &str| format!("{key}` of input `{name}");
        if let Some([low, high]) = range
            && !(low.is_finite() && high.is_finite() && low < high)
        {
            return Err(Invalid::new(
                format!("input `{name}`"),
                format!("`range` [{low}, {high}]"),
                "a lowest and a higher, highest setting, both finite",
                "swap or correct them",
            ));
        }
        let expected = format!("0 to {LONGEST_LAG_S} s");
        let lag = lag_s.map(|lag| (thing("lag_s"), lag));
        check_numbers(lag, &expected, |lag| (0.0..=LONGEST_LAG_S).contains(&lag))?;
        let rate = rate_per_s.map(|rate| (thing("rate_per_s"), rate));
        check_numbers(rate, "a finite rate above 0", |rate| rate > 0.0 && rate.is_finite())?;
        Ok(Self { range, lag_s: lag_s.unwrap_or(0.0), rate_per_s })
    }

    /// The setting after `seconds` under `command`, starting at `setting`: an exponential approach within the
    /// rate limit.
    pub fn after(&self, setting: f64, command: f64, seconds: f64) -> f64 {
        self.no_faster(setting, self.lagging(setting, command, seconds), seconds)
    }

    /// The setting nearest to `wanted` that any command reaches within `seconds`, from `setting`.
    pub fn towards(&self, setting: f64, wanted: f64, seconds: f64) -> f64 {
        let reached = self.range.map_or(wanted, |ends| {
            let [low, high] = ends.map(|end| self.lagging(setting, end, seconds));
            wanted.clamp(low, high)
        });
        self.no_faster(setting, reached, seconds)
    }

    /// The setting that the lag alone would give.
    fn lagging(&self, setting: f64, command: f64, seconds: f64) -> f64 {
        match self.lag_s > 0.0 {
            true => setting - libm::expm1(-seconds / self.lag_s) * (command - setting),
            false => command,
        }
    }

    fn no_faster(&self, setting: f64, reached: f64, seconds: f64) -> f64 {
        let most = |rate: f64| reached.clamp(setting - rate * seconds, setting + rate * seconds);
        self.rate_per_s.map_or(reached, most)
    }
}
