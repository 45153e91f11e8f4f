use crate::forces::Body;
use crate::model::{ForceModel, Model};

use crate::engine::simulate_one;

/// Simulates one run in still water along its inputs. Where they are held during each sample, as those of simulated runs are, this
/// is [`simulate_one`]. Else forces act by inputs that are linear between samples, as logged ones are; the last row is held.
pub fn replay(
    model: &Model,
    parameters: &[f64],
    initial: [f64; 3],
    exogenous: &[f64],
    are_inputs_held: bool,
) -> Vec<f64> {
    let width = model.exogenous().max(1);
    let moved = match &model.forces {
        Some(moved) if !are_inputs_held => moved,
        _ => return simulate_one(model, parameters, initial, exogenous),
    };
    let replayed = Replayed::new(moved, parameters, (exogenous, width), false);
    let (mut state, mut states) = (initial, initial.to_vec());
    for k in 0..exogenous.len() / width {
        state = replayed.step(k, state);
        states.extend(state);
    }
    states
}

/// A ship that forces move along the inputs of a logged or simulated run, in still water.
pub struct Replayed<'m> {
    body: Body<'m, f64>,
    /// What acts in every sample, in rows of `width`.
    acting: Vec<f64>,
    width: usize,
    sample_s: f64,
    are_inputs_held: bool,
}

impl<'m> Replayed<'m> {
    /// With these parameters, along rows of so many inputs and measured disturbances. Those of simulated runs are held during
    /// each sample, as they are.
    pub fn new(
        moved: &'m ForceModel,
        parameters: &[f64],
        (exogenous, width): (&[f64], usize),
        are_inputs_held: bool,
    ) -> Self {
        let body = moved.forces.body::<f64>(parameters);
        let acting = match are_inputs_held {
            true => exogenous.to_vec(),
            false => body.acting(exogenous, width, moved.sample_s),
        };
        Self { body, acting, width, sample_s: moved.sample_s, are_inputs_held }
    }

    /// The state after `state` at sample `k`. Inputs are held, or linear between samples and held after the last row.
    pub fn step(&self, k: usize, state: [f64; 3]) -> [f64; 3] {
        let row = &self.acting[k * self.width..][..self.width];
        if self.are_inputs_held {
            return self.body.step_held(state, row, self.sample_s);
        }
        let end = self.acting[(k + 1) * self.width..].get(..self.width).unwrap_or(row);
        self.body.step(state, row, end, self.sample_s)
    }
}
