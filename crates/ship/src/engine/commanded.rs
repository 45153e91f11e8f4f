use std::array::from_fn;

use crate::model::Model;
use numerics::{Lane, Wide, vectorized};

use crate::engine::simulate::{AT_ONCE, Follow, mark_beyond};
use crate::engine::{Ambient, Command, Compiled, Helm, Pose, Recording, Seen};

/// A run under commands, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct Commanded {
    /// N × exogenous.
    pub exogenous: Vec<f64>,
    /// What was commanded: N × inputs. It differs from the inputs where actuators follow it.
    pub commands: Vec<f64>,
    /// u, v \[m/s\], r \[rad/s\]: (N+1) × 3.
    pub states: Vec<f64>,
}

/// The inputs of runs in lanes, row-major.
pub struct Driving<'a> {
    /// N × exogenous.
    pub exogenous: &'a mut [Lane],
    /// What was commanded, N × inputs; empty where it is not needed.
    pub commands: &'a mut [Lane],
}

/// Simulates one run in still water under commands. The helmsman sees the true states.
pub fn simulate_command(
    model: &Model,
    parameters: &[f64],
    initial: [f64; 3],
    samples: usize,
    rate_hz: f64,
    helm: &Helm,
) -> Commanded {
    let width = model.exogenous().max(1);
    let mut compiled = Compiled::new(model, parameters);
    let mut helmsman = Helmsman::new(helm, width);
    let (mut exogenous, mut states) = (Vec::with_capacity(width * samples), initial.to_vec());
    let mut commands = Vec::with_capacity(model.inputs * samples);
    let mut state = initial;
    for _ in 0..samples {
        let row = helmsman.commands(model, state, state, rate_hz);
        exogenous.extend_from_slice(row);
        state = compiled.step(state, row, Ambient::default());
        states.extend(state);
        commands.extend_from_slice(helmsman.commanded(model));
    }
    Commanded { exogenous, commands, states }
}

/// Simulates and measures up to [`numerics::LANES`] disturbed runs, each commanded by its own of `helms`, who
/// see the measured states. `driving` is filled with their inputs. Returns a number above zero in lanes where a state
/// is beyond [`crate::engine::DIVERGED`] or not finite.
pub fn simulate_commanded(
    model: &Model,
    parameters: &[Lane],
    initial: [Lane; 3],
    helms: &[Helm],
    rate_hz: f64,
    recording: Recording,
    driving: Driving,
) -> Lane {
    let Driving { exogenous, commands } = driving;
    let Recording { mut disturbing, truth, measured } = recording;
    let width = model.exogenous().max(1);
    let mut helmsmen: Vec<Helmsman> = helms.iter().map(|helm| Helmsman::new(helm, width)).collect();
    let mut follow = Follow::<1>::new(model, parameters, initial.map(Wide::from));
    let mut beyond = Lane::ZERO;
    let (samples, mut noise) = (measured.len() / 3 - 1, [Lane::ZERO; 3 * AT_ONCE + 3]);
    for first in (0..samples.max(1)).step_by(AT_ONCE) {
        let count = samples.min(first + AT_ONCE) - first;
        let rows = count + usize::from(first + count == samples);
        let noise = &mut noise[..3 * rows];
        disturbing.noise(noise);
        let weather = disturbing.next(count);
        for i in 0..rows {
            let state = follow.state.map(|own| own.0[0]);
            let seen: [Lane; 3] = from_fn(|d| state[d] + noise[3 * i + d]);
            let k = first + i;
            for d in 0..3 {
                measured[3 * k + d] = state[d];
                mark_beyond(&mut beyond, state[d]);
                if let Some(own) = truth.get_mut(3 * k + d) {
                    *own = state[d];
                }
            }
            if i == count {
                break;
            }
            let row = &mut exogenous[width * k..width * (k + 1)];
            for (lane, helmsman) in helmsmen.iter_mut().enumerate() {
                let of = |states: [Lane; 3]| states.map(|own| own[lane]);
                let own = helmsman.commands(model, of(seen), of(state), rate_hz);
                row.iter_mut().zip(own).for_each(|(to, from)| to[lane] = *from);
                if !commands.is_empty() {
                    let to = commands[model.inputs * k..].iter_mut();
                    to.zip(helmsman.commanded(model)).for_each(|(to, from)| to[lane] = *from);
                }
            }
            let here = [weather.from(i)];
            vectorized!(follow.go(&&*row, 0..1, &here, &mut [&mut []]));
        }
        disturbing.measure(&mut measured[3 * first..3 * (first + rows)]);
    }
    beyond
}

/// A running command, and the pose of its ship.
struct Helmsman {
    command: Box<dyn Command>,
    pose: Pose,
    row: Vec<f64>,
}

impl Helmsman {
    fn new(helm: &Helm, width: usize) -> Self {
        Self { command: helm.begin(), pose: Pose::default(), row: vec![0.0; width] }
    }

    /// The exogenous inputs of a sample: the commanded ones for `seen`, and the ones that follow from them.
    fn commands(&mut self, model: &Model, seen: [f64; 3], state: [f64; 3], rate_hz: f64) -> &[f64] {
        let seen = Seen { state: seen, own: state, pose: self.pose };
        self.command.command(&seen, &mut self.row[..model.inputs]);
        model.complete(&mut self.row);
        self.pose.advance(state, 1.0 / rate_hz);
        &self.row
    }

    /// What was commanded in the last sample.
    fn commanded(&self, model: &Model) -> &[f64] {
        self.command.commanded().unwrap_or(&self.row[..model.inputs])
    }
}
