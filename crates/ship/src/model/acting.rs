//! Actuators under way.

use crate::model::Actuator;

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
