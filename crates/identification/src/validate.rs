use vessel::{DIVERGED, LANES, Lane, Model, Number, Weather, check_diverged, follow, simulate};

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
            Self::Rmse(rmse) => Some(rmse_norm(*rmse)),
            Self::Diverged(_) => None,
        }
    }
}

/// The 2-norm of RMSE in u, v, r, as numbers.
pub fn rmse_norm(rmse: [f64; 3]) -> f64 {
    rmse.iter().map(|e| e * e).sum::<f64>().sqrt()
}

/// Simulates [`LANES`] models freely over the inputs of a validation run and compares with its states.
///
/// `parameters`: one lane per parameter. `exogenous`: N × exogenous. `reference`: (N+1) × 3 states; the simulation starts
/// at the first.
pub fn free_runs(
    model: &Model,
    parameters: &[Lane],
    exogenous: &[impl Number],
    reference: &[f64],
) -> [FreeRun; LANES] {
    let initial = [0, 1, 2].map(|d| Lane::splat(reference[d]));
    let samples = (reference.len() / 3 - 1) as f64;
    let (mut squares, mut beyond) = ([Lane::ZERO; 3], Lane::ZERO);
    let mut truths = reference[3..].chunks_exact(3);
    follow(
        model,
        parameters,
        initial,
        exogenous,
        &Weather::CALM,
        #[inline(always)]
        |state| {
            let Some(truth) = truths.next() else { return };
            for d in 0..3 {
                let error = state[d] - Lane::splat(truth[d]);
                squares[d] += error * error;
                for lane in 0..LANES {
                    beyond[lane] = if state[d][lane].abs() <= DIVERGED { beyond[lane] } else { 1.0 };
                }
            }
        },
    );
    let first_beyond = |lane: usize| {
        let own: Vec<Lane> = parameters.iter().map(|p| Lane::splat(p[lane])).collect();
        let mut states = vec![Lane::ZERO; reference.len()];
        simulate(model, &own, initial, exogenous, &Weather::CALM, &mut states);
        check_diverged(states.iter().map(|s| s[0])).map_or(0, |at| at.sample)
    };
    std::array::from_fn(|lane| match beyond[lane] > 0.0 {
        true => FreeRun::Diverged(first_beyond(lane)),
        false => FreeRun::Rmse(squares.map(|s| (s[lane] / samples).sqrt())),
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
