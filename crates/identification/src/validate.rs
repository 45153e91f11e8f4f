use vessel::{LANES, Lane, Model, check_diverged, simulate};

/// Errors of a free simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FreeRun {
    /// Root mean square over samples 1 to N of the difference in u, v \[m/s\] and r \[rad/s\].
    Rmse([f64; 3]),
    /// The simulation diverged at this sample.
    Diverged(usize),
}

impl FreeRun {
    /// The 2-norm of the three errors, as numbers; `None` where it diverged.
    pub fn norm(&self) -> Option<f64> {
        match self {
            Self::Rmse(rmse) => Some(rmse.iter().map(|e| e * e).sum::<f64>().sqrt()),
            Self::Diverged(_) => None,
        }
    }
}

/// Simulates [`LANES`] models freely over the inputs of a validation run and compares with its states.
///
/// `parameters`: one lane per parameter. `exogenous`: N × exogenous. `reference`: (N+1) × 3 states; the simulation starts
/// at the first. `states` is a buffer for the simulation.
pub fn free_runs(
    model: &Model,
    parameters: &[Lane],
    exogenous: &[Lane],
    reference: &[f64],
    states: &mut Vec<Lane>,
) -> [FreeRun; LANES] {
    states.resize(reference.len(), Lane::ZERO);
    let initial = [0, 1, 2].map(|d| Lane::splat(reference[d]));
    simulate(model, parameters, initial, exogenous, &[], states);
    let mut squares = [Lane::ZERO; 3];
    for (state, truth) in states.chunks_exact(3).zip(reference.chunks_exact(3)).skip(1) {
        for d in 0..3 {
            let error = state[d] - Lane::splat(truth[d]);
            squares[d] += error * error;
        }
    }
    let samples = (reference.len() / 3 - 1) as f64;
    std::array::from_fn(|lane| match check_diverged(states.iter().map(|s| s[lane])) {
        Some(at) => FreeRun::Diverged(at.sample),
        None => FreeRun::Rmse(squares.map(|s| (s[lane] / samples).sqrt())),
    })
}

/// The 2-norm over the parameters of (θ̂ − θ)/θ. `None` where a true value is zero.
pub fn parameter_error(estimate: &[f64], truth: &[f64]) -> Option<f64> {
    if truth.contains(&0.0) {
        return None;
    }
    let relative = estimate.iter().zip(truth).map(|(e, t)| (e - t) / t);
    Some(relative.map(|x| x * x).sum::<f64>().sqrt())
}
