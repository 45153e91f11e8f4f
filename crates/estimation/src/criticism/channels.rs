use numerics::{LANES, Lane};
use ship::engine::Compiled;
use ship::model::Model;

use super::library::Effect;

/// The lag that is tested \[samples\]: the effects of shorter and longer ones are similar.
const LAG: f64 = 4.0;

/// Inputs and measured disturbances followed by the channels of [`Effect::ALL`], N × (exogenous + 12).
///
/// `states`: as predicted, (N+1) × 3. An effect on the states is their derivative by inputs or water, along them.
pub(super) fn with_effects(
    model: &Model,
    parameters: &[Lane],
    states: &[Lane],
    exogenous: &[Lane],
    rate_hz: f64,
) -> Vec<Lane> {
    let width = model.exogenous();
    let mut compiled = Compiled::new(model, parameters);
    let mut gradients = vec![[Lane::ZERO; 3]; model.variables.len()];
    let mut heading = Lane::ZERO;
    let mut lagged: Vec<Lane> = exogenous[..model.inputs].to_vec();
    let keep = Lane::splat(libm::exp(-1.0 / LAG));
    let per_second = Lane::splat(rate_hz / LAG);
    let mut out = Vec::with_capacity(exogenous.len() / width.max(1) * (width + 3 * Effect::ALL.len()));
    for (k, (row, state)) in exogenous.chunks_exact(width.max(1)).zip(states.as_chunks::<3>().0).enumerate() {
        compiled.look(*state, row, None);
        compiled.gradients(&mut gradients);
        let before = if k > 0 { &exogenous[(k - 1) * width..k * width] } else { row };
        let (cos, sin) = turned(&heading);
        // Derivatives by the water's velocity are minus those by the vessel's.
        let along = |d: usize| Lane::ZERO - gradients[0][d];
        let across = |d: usize| Lane::ZERO - gradients[1][d];
        out.extend_from_slice(row);
        for effect in Effect::ALL {
            out.extend((0..3).map(|d| match effect {
                Effect::Lag => per_second * sum(model.inputs, |i| gradients[3 + i][d] * (lagged[i] - row[i])),
                Effect::Delay => sum(model.inputs, |i| gradients[3 + i][d] * (before[i] - row[i])),
                Effect::Current(0) => along(d) * cos - across(d) * sin,
                Effect::Current(_) => along(d) * sin + across(d) * cos,
            }));
        }
        for (lagged, input) in lagged.iter_mut().zip(row) {
            *lagged = keep * *lagged + (Lane::ONE - keep) * *input;
        }
        heading += Lane::splat(1.0 / rate_hz) * state[2];
    }
    out
}

fn sum(count: usize, of: impl Fn(usize) -> Lane) -> Lane {
    let mut sum = Lane::ZERO;
    (0..count).for_each(|i| sum += of(i));
    sum
}

fn turned(heading: &Lane) -> (Lane, Lane) {
    let (mut cos, mut sin) = (Lane::ZERO, Lane::ZERO);
    for lane in 0..LANES {
        (sin[lane], cos[lane]) = libm::sincos(heading[lane]);
    }
    (cos, sin)
}
