//! The range, lag, rate, dead band and hold of an actuator.

use refusal::{Invalid, check_numbers};

use crate::model::InputSpec;

/// The actuator of an input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Actuator {
    /// The range of settings, if known.
    pub range: Option<[f64; 2]>,
    /// Time constant of the response to a command \[s\]; 0 for an immediate one.
    pub lag_s: f64,
    /// The greatest change per second, if known.
    pub rate_per_s: Option<f64>,
    /// The greatest difference of command and setting at which it rests; 0 for none.
    pub dead_band: f64,
    /// The time from taking a command to taking the next one \[s\]; 0 where it takes that of every sample.
    pub hold_s: f64,
}

/// The longest lag and hold \[s\]: a slower actuator cannot steer.
const LONGEST_S: f64 = 1e4;

impl Actuator {
    /// Of an input as written.
    ///
    /// # Errors
    /// An empty range, a lag or dead band below 0, a rate or hold that is not above 0, a dead band as wide as the range.
    pub(crate) fn new(input_spec: &InputSpec) -> Result<Self, Invalid> {
        let InputSpec { name, range, lag_s, rate_per_s, dead_band, hold_s, .. } = input_spec;
        let thing = |key: &str| format!("{key}` of input `{name}");
        if let Some([low, high]) = *range
            && !(low.is_finite() && high.is_finite() && low < high)
        {
            return Err(Invalid::new(
                format!("input `{name}`"),
                format!("`range` [{low}, {high}]"),
                "a lowest and a higher, highest setting, both finite",
                "swap or correct them",
            ));
        }
        let expected = format!("0 to {LONGEST_S} s");
        let lag = lag_s.map(|lag| (thing("lag_s"), lag));
        check_numbers(lag, &expected, |lag| (0.0..=LONGEST_S).contains(&lag))?;
        let rate = rate_per_s.map(|rate| (thing("rate_per_s"), rate));
        check_numbers(rate, "a finite rate above 0", |rate| rate > 0.0 && rate.is_finite())?;
        let band = dead_band.map(|band| (thing("dead_band"), band));
        let width = range.map_or(f64::INFINITY, |[low, high]| high - low);
        let expected = range.map_or("0 or more, finite".to_owned(), |[low, high]| {
            format!("0 or more, and less than {}, the width of its `range` [{low}, {high}]", high - low)
        });
        check_numbers(band, &expected, |band| band >= 0.0 && band < width)?;
        let hold = hold_s.map(|hold| (thing("hold_s"), hold));
        let expected = format!("more than 0 s, at most {LONGEST_S} s");
        check_numbers(hold, &expected, |hold| hold > 0.0 && hold <= LONGEST_S)?;
        let or_none = |number: Option<f64>| number.unwrap_or(0.0);
        Ok(Self {
            range: *range,
            lag_s: or_none(*lag_s),
            rate_per_s: *rate_per_s,
            dead_band: or_none(*dead_band),
            hold_s: or_none(*hold_s),
        })
    }

    /// Whether the setting is always what is commanded.
    pub fn is_immediate(&self) -> bool {
        self.lag_s == 0.0 && self.rate_per_s.is_none() && self.takes_every_command()
    }

    /// Whether any command moves it, at any sample.
    pub(crate) fn takes_every_command(&self) -> bool {
        self.dead_band == 0.0 && self.hold_s == 0.0
    }

    /// The setting after `seconds` under a `command` that it has taken, starting at `setting`: an exponential approach
    /// within the rate limit.
    pub fn after(&self, setting: f64, command: f64, seconds: f64) -> f64 {
        self.no_faster(setting, self.lagging(setting, command, seconds), seconds)
    }

    /// The setting nearest to `wanted` that any command reaches within `seconds`, from `setting`, if it is taken.
    pub fn towards(&self, setting: f64, wanted: f64, seconds: f64) -> f64 {
        let reached = self.range.map_or(wanted, |ends| {
            let [low, high] = ends.map(|end| self.lagging(setting, end, seconds));
            wanted.clamp(low, high)
        });
        self.no_faster(setting, reached, seconds)
    }

    /// The command that reaches `wanted` by the end of its hold, or of a sample of `seconds`, within the range.
    pub(crate) fn command_for(&self, setting: f64, wanted: f64, seconds: f64) -> f64 {
        let command = match self.lag_s > 0.0 {
            true => setting - (wanted - setting) / libm::expm1(-seconds.max(self.hold_s) / self.lag_s),
            false => wanted,
        };
        self.range.map_or(command, |[low, high]| command.clamp(low, high))
    }

    /// The setting that the lag alone would give.
    fn lagging(&self, setting: f64, command: f64, seconds: f64) -> f64 {
        match self.lag_s > 0.0 {
            true => setting - libm::expm1(-seconds / self.lag_s) * (command - setting),
            false => command,
        }
    }

    fn no_faster(&self, setting: f64, reached: f64, seconds: f64) -> f64 {
        // Not `clamp`, which panics where a ship that diverges commands no numbers.
        let most = |rate: f64| reached.max(setting - rate * seconds).min(setting + rate * seconds);
        self.rate_per_s.map_or(reached, most)
    }
}
