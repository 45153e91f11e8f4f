use model::{Model, Moved};

use crate::simulate_one;

/// Simulates one logged run in still water. As [`simulate_one`], but forces act by inputs that are linear between samples, as
/// logged ones are; the last row is held.
pub fn replay(model: &Model, parameters: &[f64], initial: [f64; 3], exogenous: &[f64]) -> Vec<f64> {
    match &model.forces {
        None => simulate_one(model, parameters, initial, exogenous),
        Some(moved) => moved_on(moved, parameters, initial, (exogenous, model.exogenous().max(1))),
    }
}

fn moved_on(
    moved: &Moved,
    parameters: &[f64],
    initial: [f64; 3],
    (exogenous, width): (&[f64], usize),
) -> Vec<f64> {
    let body = moved.forces.body::<f64>(parameters);
    let acting = body.acting(exogenous, width, moved.sample_s);
    let rows: Vec<&[f64]> = acting.chunks_exact(width).collect();
    let mut states = initial.to_vec();
    let mut state = initial;
    for (k, row) in rows.iter().enumerate() {
        let end = rows.get(k + 1).unwrap_or(row);
        state = body.step(state, row, end, moved.sample_s);
        states.extend(state);
    }
    states
}
