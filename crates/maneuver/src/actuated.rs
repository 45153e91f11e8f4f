//! Commands that reach a ship by way of her actuators.

use std::sync::Arc;

use ship::engine::{Command, Helm, Program, Progress, Seen};
use ship::model::{Actuator, ActuatorState, SampleCommand, Vessel};

/// `helm` by way of the actuators of `vessel`, which are at `settings` before its first command; itself where all of them follow at
/// once.
pub(crate) fn actuated(helm: Helm, vessel: &Vessel, settings: &[f64]) -> Helm {
    if vessel.actuators.iter().all(Actuator::is_immediate) {
        return helm;
    }
    let (actuators, settings) = (vessel.actuators.clone().into(), settings.into());
    Helm::new(Actuated { helm, actuators, settings, sample_s: 1.0 / vessel.sample_rate_hz })
}

#[derive(Debug)]
struct Actuated {
    helm: Helm,
    actuators: Arc<[Actuator]>,
    settings: Arc<[f64]>,
    sample_s: f64,
}

impl Program for Actuated {
    fn begin(&self) -> Box<dyn Command> {
        Box::new(Following {
            command: self.helm.begin(),
            actuators: Arc::clone(&self.actuators),
            acting: self.settings.iter().map(|setting| ActuatorState::at(*setting)).collect(),
            commanded: Vec::new(),
            sample_s: self.sample_s,
        })
    }

    fn tracks(&self) -> bool {
        self.helm.tracks()
    }
}

/// Commands while actuators follow them.
struct Following {
    command: Box<dyn Command>,
    actuators: Arc<[Actuator]>,
    acting: Vec<ActuatorState>,
    /// The commands of the last sample.
    commanded: Vec<f64>,
    sample_s: f64,
}

impl Command for Following {
    fn command(&mut self, seen: &Seen, inputs: &mut [f64]) {
        self.command.command(seen, inputs);
        self.commanded.clear();
        self.commanded.extend_from_slice(inputs);
        let ends = self.command.ends();
        for (i, (acting, own)) in self.acting.iter_mut().zip(&*self.actuators).enumerate() {
            inputs[i] = acting.follow(own, SampleCommand::of(i, inputs[i], ends), self.sample_s);
        }
    }

    fn commanded(&self) -> Option<&[f64]> {
        Some(&self.commanded)
    }

    fn progress(&self) -> Progress {
        self.command.progress()
    }
}
