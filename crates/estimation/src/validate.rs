use numerics::{Arithmetic, LANES, Lane, Number, Numbers, Row, Wide, vectorized};
use refusal::listed;
use ship::engine::{Compiled, Weather, diverged_lanes, simulate};
use ship::model::{Model, Vessel};

/// Errors of a free simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FreeRun {
    /// Root mean square over samples 1 to N of the difference in u, v \[m/s\] and r \[rad/s\].
    Rmse([f64; 3]),
    /// The simulation diverged at this sample.
    Diverged(usize),
}

impl FreeRun {
    /// The 2-norm of the three errors, as numbers; `None` if it diverged.
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
    free_runs_over(model, parameters, Number::numbers(exogenous), reference)
}

/// The same, compiled here and not in every crate that calls it.
fn free_runs_over(
    model: &Model,
    parameters: &[Lane],
    exogenous: Numbers,
    reference: &[f64],
) -> [FreeRun; LANES] {
    let parameters: Vec<Wide<1>> = parameters.iter().copied().map(Wide::from).collect();
    let [found] = match exogenous {
        Numbers::Lanes(lanes) => free_runs_of(model, &parameters, lanes, reference),
        Numbers::Shared(numbers) => free_runs_of(model, &parameters, numbers, reference),
    };
    found
}

/// [`free_runs`] of `G` times as many models.
pub(crate) fn free_runs_of<const G: usize, E: Number>(
    model: &Model,
    parameters: &[Wide<G>],
    exogenous: &[E],
    reference: &[f64],
) -> [[FreeRun; LANES]; G]
where
    for<'a> &'a [E]: Row<Wide<G>>,
{
    let mut compiled = Compiled::new(model, parameters);
    let (squares, beyond) =
        vectorized!(squared_errors(&mut compiled, model.exogenous(), exogenous, reference));
    let samples = (reference.len() / 3 - 1) as f64;
    let initial = [0, 1, 2].map(|d| Lane::splat(reference[d]));
    let first_beyond = |group: usize, lane: usize| {
        let own: Vec<Lane> = parameters.iter().map(|p| Lane::splat(p.0[group][lane])).collect();
        let mut states = vec![Lane::ZERO; reference.len()];
        simulate(model, &own, initial, exogenous, &Weather::CALM, &mut states);
        diverged_lanes(&states)[0].map_or(0, |at| at.sample)
    };
    std::array::from_fn(|group| {
        std::array::from_fn(|lane| match beyond[group][lane] > 0.0 {
            true => FreeRun::Diverged(first_beyond(group, lane)),
            false => FreeRun::Rmse(squares.map(|s| (s.0[group][lane] / samples).sqrt())),
        })
    })
}

/// Sums of squared errors of u, v and r, and a positive number if one of them exceeded the bound.
#[inline(always)]
fn squared_errors<const G: usize, E: Number>(
    model: &mut Compiled<Wide<G>>,
    width: usize,
    exogenous: &[E],
    reference: &[f64],
) -> ([Wide<G>; 3], [Lane; G])
where
    for<'a> &'a [E]: Row<Wide<G>>,
{
    let mut state = [0, 1, 2].map(|d| Wide::from(reference[d]));
    let (mut squares, mut beyond) = ([Wide::ZERO; 3], [Lane::ZERO; G]);
    for (exogenous, truth) in exogenous.chunks_exact(width.max(1)).zip(reference[3..].chunks_exact(3)) {
        model.advance(
            &mut state,
            exogenous,
            #[inline(always)]
            |_| [0.0; 2],
        );
        for d in 0..3 {
            let error = state[d] - Wide::from(truth[d]);
            squares[d] += error * error;
            beyond
                .iter_mut()
                .zip(state[d].0)
                .for_each(|(beyond, state)| ship::engine::mark_beyond(beyond, state));
        }
    }
    (squares, beyond)
}

/// The 2-norm over the parameters of (θ̂ − θ)/θ, of θ̂ itself where θ is zero.
pub fn parameter_error(estimate: &[f64], truth: &[f64]) -> f64 {
    let relative = estimate.iter().zip(truth).map(|(e, t)| if *t == 0.0 { *e } else { (e - t) / t });
    relative.map(|x| x * x).sum::<f64>().sqrt()
}

/// Names the parameters of `vessel` whose errors [`parameter_error`] does not relate to their true value.
pub fn not_relative(vessel: &Vessel) -> Option<String> {
    let all = vessel.model.parameter_names().zip(&vessel.value);
    let zero: Vec<String> =
        all.filter(|(_, value)| **value == Some(0.0)).map(|(name, _)| format!("`{name}`")).collect();
    (!zero.is_empty()).then(|| {
        format!(
            "in the parameter error {} with a true value of 0 counts as estimated, not relative to it",
            listed(&zero)
        )
    })
}
