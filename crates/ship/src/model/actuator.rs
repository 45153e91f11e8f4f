//! The range, lag, rate, dead band and hold of an actuator.

use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::model::ChannelRole;

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

impl Actuator {
    /// Of an input as written.
    pub(crate) fn new(input_spec: &InputSpec) -> Result<Self, Invalid> {
        let InputSpec { name, range, lag_s, rate_per_s, dead_band, hold_s, .. } = input_spec;
        if let Some([low, high]) = *range
            && low >= high
        {
            return Err(Invalid::new(
                format!("input `{name}`"),
                format!("`range` [{low}, {high}]"),
                "a lowest and a higher, highest setting, both finite",
                "swap or correct them",
            ));
        }
        if let (Some(band), Some([low, high])) = (*dead_band, *range)
            && band >= high - low
        {
            let expected = format!("less than {}, the width of its `range` [{low}, {high}]", high - low);
            let thing = format!("`dead_band` of input `{name}`");
            return Err(Invalid::new(thing, band.to_string(), expected, "correct it"));
        }
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
    fn takes_every_command(&self) -> bool {
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
    fn command_for(&self, setting: f64, wanted: f64, seconds: f64) -> f64 {
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

/// The command to an actuator during a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleCommand {
    /// At the beginning of the sample.
    pub first: f64,
    /// Mean over the sample.
    pub mean: f64,
    /// At the end of the sample.
    pub last: f64,
}

impl SampleCommand {
    /// Of actuator `index`, with this `mean`; `ends` are the commands to all at the beginning and the end of the sample, if they
    /// change within it.
    pub fn of(index: usize, mean: f64, ends: Option<[&[f64]; 2]>) -> Self {
        ends.map_or(mean.into(), |[first, last]| Self { first: first[index], mean, last: last[index] })
    }
}

impl From<f64> for SampleCommand {
    /// The same throughout the sample.
    fn from(command: f64) -> Self {
        Self { first: command, mean: command, last: command }
    }
}

/// An actuator under way: it follows commands from sample to sample.
///
/// With a hold it takes the command at its first sample, and every so many seconds the one at that time. With a dead
/// band it rests while the command is that near to its setting. As a steering gear, it goes all the way to a command
/// that is farther, and stops where it meets the present command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActuatorState {
    setting: f64,
    /// The command of the present hold.
    held: f64,
    /// Where it goes.
    bound_for: f64,
    /// Samples since it began.
    samples: u64,
}

/// Part of a hold by which rounding may put its end later than a sample.
const ROUNDING: f64 = 1e-9;

impl ActuatorState {
    /// At rest at `setting`.
    pub fn at(setting: f64) -> Self {
        Self { setting, held: setting, bound_for: setting, samples: 0 }
    }

    /// After a first sample in which it was at `command`.
    pub fn begun(command: f64) -> Self {
        Self { samples: 1, ..Self::at(command) }
    }

    /// The present setting.
    pub fn setting(&self) -> f64 {
        self.setting
    }

    /// The setting after a sample of `seconds`.
    pub fn follow(&mut self, actuator: &Actuator, command: SampleCommand, seconds: f64) -> f64 {
        let command = self.held(actuator, command, seconds);
        let off = (command.last - self.setting).abs();
        let to = if actuator.dead_band == 0.0 || off > actuator.dead_band {
            self.bound_for = command.last;
            command.mean
        } else {
            let (low, high) = (self.setting.min(self.bound_for), self.setting.max(self.bound_for));
            self.bound_for = command.last.max(low).min(high);
            self.bound_for
        };
        self.setting = actuator.after(self.setting, to, seconds);
        self.setting
    }

    /// The setting after a sample of `seconds`, as near to `wanted` as commands take it.
    pub fn reach(&mut self, actuator: &Actuator, wanted: f64, seconds: f64) -> f64 {
        if !actuator.takes_every_command() {
            let command = actuator.command_for(self.setting, wanted, seconds);
            return self.follow(actuator, command.into(), seconds);
        }
        *self = Self::at(actuator.towards(self.setting, wanted, seconds));
        self.setting
    }

    /// The command of the present hold.
    fn held(&mut self, actuator: &Actuator, command: SampleCommand, seconds: f64) -> SampleCommand {
        if actuator.hold_s == 0.0 {
            return command;
        }
        // Takes the command at the first sample that is not before the end of the hold.
        let holds = |samples: u64| (samples as f64 * seconds / actuator.hold_s + ROUNDING).floor();
        if self.samples == 0 || holds(self.samples) > holds(self.samples - 1) {
            self.held = command.first;
        }
        self.samples += 1;
        self.held.into()
    }
}

/// An input.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "ModelInput")]
pub struct InputSpec {
    /// Name as used in terms and as a column.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Another input that this one is coupled to …
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub follows: Option<String>,
    /// … by this factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<f64>,
    /// Between which the actuator can be set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Time constant with which the actuator follows a command \[s\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1e4))]
    pub lag_s: Option<f64>,
    /// How much it changes in a second at most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "in its unit per second"))]
    pub rate_per_s: Option<f64>,
    /// How far a command has to be from the setting to move the actuator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub dead_band: Option<f64>,
    /// How long the actuator follows a command before it takes the next one \[s\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(max = 1e4), extend("exclusiveMinimum" = 0.0))]
    pub hold_s: Option<f64>,
    /// What it is to a search for terms; found by unit and name without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<ChannelRole>,
}
