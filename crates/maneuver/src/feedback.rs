//! Motions that are held by feedback: the motion of the nominal ship, where inputs alone would make another ship do
//! something else.

use std::sync::Arc;

use numerics::inverse;
use refusal::Invalid;
use schemars::JsonSchema;
use serde::Deserialize;
use ship::engine::{Command, Compiled, Helm, Program, Progress, Seen};
use ship::model::{Actuator, ActuatorState, SampleCommand, Vessel};

use crate::standard::Sensors;

refusal::choices! {
    /// How a motion is carried out.
    pub enum Executed {
        /// By the inputs that would move the nominal ship so.
        Inputs = "inputs",
        /// By a controller that corrects these inputs until the ship moves so.
        Feedback = "feedback",
    }
}

/// The controller of a motion that is executed by feedback.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Controller {
    /// What it reads.
    #[serde(default = "own_sensors")]
    pub sensors: Sensors,
    /// Its period \[s\]; by default that of the samples.
    pub every_s: Option<f64>,
    /// Multiplies its gains.
    #[serde(default = "one")]
    pub strength: f64,
}

fn own_sensors() -> Sensors {
    Sensors::Own
}

fn one() -> f64 {
    1.0
}

impl Default for Controller {
    fn default() -> Self {
        Self { sensors: own_sensors(), every_s: None, strength: one() }
    }
}

impl Controller {
    /// Refuses what is no controller of maneuver `name`.
    pub(crate) fn check(&self, name: &str) -> Result<(), Invalid> {
        let refuse = |key: &str, given: f64, expected: &str| {
            let thing = format!("maneuver `{name}`, `feedback.{key}`");
            Err(Invalid::new(thing, given.to_string(), expected, "correct it"))
        };
        match self.every_s {
            Some(every) if !(every > 0.0 && every <= 1e6) => {
                refuse("every_s", every, "more than 0, at most 1e6 s")
            }
            _ if !(self.strength > 0.0 && self.strength <= 10.0) => {
                refuse("strength", self.strength, "more than 0, at most 10")
            }
            _ => Ok(()),
        }
    }
}

/// Gains of proportional and integral feedback of u, v and r, per sample: the fraction of an error that is made up for in a
/// sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gains {
    proportional: [f64; 3],
    integral: [f64; 3],
}

/// The greatest fractions of errors of u, v and r in a sample, and of their sums.
const MOST: [[f64; 3]; 2] = [[0.3, 0.15, 0.5], [0.03, 0.03, 0.25]];

/// A controller is so many times as fast as the ship …
const FASTER: f64 = 3.0;

/// … but no slower than this part of the greatest gains: forces such as u |u| have no slope at rest.
const SLOWEST: f64 = 0.1;

impl Gains {
    /// For a ship whose u, v and r decay by these fractions in a sample.
    pub fn of(decay: [f64; 3]) -> Self {
        let [proportional, integral] = MOST;
        let part = [0, 1, 2].map(|d| (FASTER * decay[d] / proportional[d]).clamp(SLOWEST, 1.0));
        Self {
            proportional: [0, 1, 2].map(|d| part[d] * proportional[d]),
            integral: [0, 1, 2].map(|d| part[d] * part[d] * integral[d]),
        }
    }

    fn times(self, strength: f64) -> Self {
        let Self { proportional, integral } = self;
        Self { proportional: proportional.map(|k| strength * k), integral: integral.map(|k| strength * k) }
    }
}

/// The state of a control loop: what its integrators have learnt.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Loop {
    learnt: [f64; 3],
}

impl Loop {
    /// The increments of u, v and r in a sample that make up for `errors`.
    pub fn wanted(&self, gains: &Gains, errors: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|d| gains.proportional[d] * errors[d] + self.learnt[d])
    }

    /// Integrates; not to be called while an actuator is at the end of its range.
    pub fn learn(&mut self, gains: &Gains, errors: [f64; 3]) {
        (0..3).for_each(|d| self.learnt[d] += gains.integral[d] * errors[d]);
    }
}

/// Slopes of a vessel's increments around a motion.
pub(crate) struct Linearised<'a> {
    vessel: &'a Vessel,
    model: Compiled<'a, f64>,
    gradients: Vec<[f64; 3]>,
}

impl<'a> Linearised<'a> {
    pub fn new(vessel: &'a Vessel, parameters: &[f64]) -> Self {
        let model = Compiled::new(&vessel.model, parameters);
        Self { vessel, model, gradients: vec![[0.0; 3]; vessel.model.variables.len()] }
    }

    /// At a state and the exogenous inputs of a sample.
    pub fn look(&mut self, state: [f64; 3], exogenous: &[f64]) {
        self.model.look(state, exogenous, None);
        self.model.gradients(&mut self.gradients);
        self.vessel.model.by_sources(exogenous, &mut self.gradients);
    }

    /// How fast u, v and r decay \[1/sample\].
    pub fn decay(&self) -> [f64; 3] {
        [0, 1, 2].map(|d| -self.gradients[d][d])
    }

    /// By the inputs.
    pub fn by_inputs(&self) -> &[[f64; 3]] {
        &self.gradients[3..3 + self.vessel.model.inputs]
    }

    /// Changes of the `free` inputs per increment of each of `rows`, as many as there are free inputs; `None` where
    /// these inputs do not move the ship so.
    fn corrections(&self, free: &[usize], rows: &[usize], coupled: bool) -> Option<Vec<f64>> {
        let n = free.len();
        let slope = |d: usize, leader: usize| {
            let followers =
                self.vessel.couplings.iter().enumerate().filter_map(|(i, coupling)| match coupling {
                    Some((of, factor)) if *of == leader && coupled => Some(factor * self.by_inputs()[i][d]),
                    _ => None,
                });
            self.by_inputs()[leader][d] + followers.sum::<f64>()
        };
        let mut slopes: Vec<f64> = rows.iter().flat_map(|d| free.iter().map(|i| slope(*d, *i))).collect();
        let mut out = vec![0.0; n * n];
        inverse(n, &mut slopes, &mut out)?;
        out.iter().all(|x| x.is_finite()).then_some(out)
    }
}

/// A motion and the inputs that lead to it, corrected by feedback.
#[derive(Clone, Debug)]
pub(crate) struct Tracked(Arc<Track>);

#[derive(Debug)]
struct Track {
    /// Inputs, N × inputs, and motion, (N+1) × 3, of the nominal ship.
    inputs: Vec<f64>,
    reference: Vec<f64>,
    /// Per sample the changes of all inputs per increment of u, v, r: N × inputs × 3.
    corrections: Vec<f64>,
    ranges: Vec<Option<[f64; 2]>>,
    gains: Gains,
    /// The controller's period \[samples\].
    period: usize,
    sensors: Sensors,
}

impl Tracked {
    /// A controller of the nominal motion of the ship with `parameters`: inputs, N × inputs, which keep to their couplings where they
    /// are `coupled`, and states, (N+1) × 3.
    ///
    /// # Errors
    /// A vessel without two or three inputs to correct surge, yaw and sway by.
    pub fn new(
        vessel: &Vessel,
        parameters: &[f64],
        (inputs, states): (&[f64], &[f64]),
        coupled: bool,
        controller: &Controller,
    ) -> Result<Self, Invalid> {
        let width = vessel.model.inputs;
        let leads = |i: &usize| !coupled || vessel.couplings[*i].is_none();
        let free: Vec<usize> = (0..width).filter(leads).collect();
        let rows: &[usize] = match free.len() {
            3 => &[0, 1, 2],
            2 => &[0, 2],
            count => {
                return Err(Invalid::new(
                    "`executed`",
                    format!("feedback by {count} independent inputs"),
                    "2 that correct surge and yaw, or 3",
                    "couple inputs with `follows`, or leave `executed` out",
                ));
            }
        };
        let exogenous = vessel.model.undisturbed(inputs);
        let samples = inputs.len() / width.max(1);
        let mut linearised = Linearised::new(vessel, parameters);
        let mut decay = [0.0_f64; 3];
        let mut corrections = Vec::with_capacity(samples * width * 3);
        for (state, row) in
            states.as_chunks::<3>().0.iter().zip(exogenous.chunks_exact(vessel.model.exogenous()))
        {
            linearised.look(*state, row);
            let now = linearised.decay();
            (0..3).for_each(|d| decay[d] = decay[d].max(now[d]));
            let inverse = linearised.corrections(&free, rows, coupled);
            let first = corrections.len();
            corrections.resize(first + 3 * width, 0.0);
            let here = &mut corrections[first..];
            for (i, leader) in free.iter().enumerate() {
                for (j, d) in rows.iter().enumerate() {
                    here[3 * leader + d] =
                        inverse.as_ref().map_or(0.0, |inverse| inverse[i * free.len() + j]);
                }
            }
            for (i, coupling) in vessel.couplings.iter().enumerate().filter(|_| coupled) {
                if let Some((leader, factor)) = coupling {
                    (0..3).for_each(|d| here[3 * i + d] = factor * here[3 * leader + d]);
                }
            }
        }
        let period = controller.every_s.map_or(1, |every| vessel.samples(every).max(1));
        Ok(Self(Arc::new(Track {
            inputs: inputs.to_vec(),
            reference: states.to_vec(),
            corrections,
            ranges: vessel.actuators.iter().map(|actuator| actuator.range).collect(),
            gains: Gains::of(decay).times(controller.strength),
            period,
            sensors: controller.sensors,
        })))
    }
}

impl Program for Tracked {
    fn begin(&self) -> Box<dyn Command> {
        Box::new(Tracking {
            of: Arc::clone(&self.0),
            sample: 0,
            wanted: [0.0; 3],
            errors: [0.0; 3],
            control: Loop::default(),
        })
    }

    fn tracks(&self) -> bool {
        true
    }
}

/// A motion while it is tracked.
struct Tracking {
    of: Arc<Track>,
    sample: usize,
    /// Increments that are wanted beside those of the motion, since the controller last looked.
    wanted: [f64; 3],
    errors: [f64; 3],
    control: Loop,
}

impl Command for Tracking {
    fn command(&mut self, seen: &Seen, inputs: &mut [f64]) {
        let (of, width) = (&self.of, inputs.len());
        let k = self.sample.min(of.inputs.len() / width - 1);
        if self.sample.is_multiple_of(of.period) {
            let state = match of.sensors {
                Sensors::Own => seen.own,
                Sensors::Logged => seen.state,
            };
            self.errors = [0, 1, 2].map(|d| of.reference[3 * k + d] - state[d]);
            self.wanted = self.control.wanted(&of.gains, self.errors);
        }
        let mut is_limited = false;
        let nominal = &of.inputs[k * width..][..width];
        let corrections = of.corrections[3 * k * width..].as_chunks::<3>().0;
        for (((input, u), correction), range) in
            inputs.iter_mut().zip(nominal).zip(corrections).zip(&of.ranges)
        {
            let wanted: f64 = (0..3).map(|d| correction[d] * self.wanted[d]).sum();
            *input = range.map_or(u + wanted, |[low, high]| (u + wanted).clamp(low, high));
            is_limited |= *input != u + wanted;
        }
        if !is_limited {
            self.control.learn(&of.gains, self.errors);
        }
        self.sample += 1;
    }
}

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
        for (i, (acting, actuator)) in self.acting.iter_mut().zip(&*self.actuators).enumerate() {
            inputs[i] = acting.follow(actuator, SampleCommand::of(i, inputs[i], ends), self.sample_s);
        }
    }

    fn commanded(&self) -> Option<&[f64]> {
        Some(&self.commanded)
    }

    fn progress(&self) -> Progress {
        self.command.progress()
    }
}
