//! Commands that reach a ship by way of her actuators.

use std::sync::Arc;

use engine::{Command, Helm, Program, Seen};
use model::{Actuator, Vessel};

/// `helm` by way of the actuators of `vessel`, which are at `settings` before its first command; itself where all of them follow at
/// once.
pub(crate) fn actuated(helm: Helm, vessel: &Vessel, settings: &[f64]) -> Helm {
    let is_slow = |own: &Actuator| own.lag_s > 0.0 || own.rate_per_s.is_some();
    if !vessel.actuators.iter().any(is_slow) {
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
            settings: self.settings.to_vec(),
            sample_s: self.sample_s,
        })
    }

    fn tracks(&self) -> bool {
        self.helm.tracks()
    }
}

/// Commands with the present settings.
struct Following {
    command: Box<dyn Command>,
    actuators: Arc<[Actuator]>,
    settings: Vec<f64>,
    sample_s: f64,
}

impl Command for Following {
    fn command(&mut self, seen: &Seen, inputs: &mut [f64]) {
        self.command.command(seen, inputs);
        for ((input, setting), own) in inputs.iter_mut().zip(&mut self.settings).zip(&*self.actuators) {
            *setting = own.after(*setting, *input, self.sample_s);
            *input = *setting;
        }
    }
}
