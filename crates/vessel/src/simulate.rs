use crate::program::Program;
use crate::{Lane, Model, Number, Numbers};

/// A speed \[m/s\] or yaw rate \[rad/s\] beyond which a simulation counts as diverged.
pub const DIVERGED: f64 = 1e3;

/// Where a simulation left every bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Diverged {
    /// First sample with a state beyond [`DIVERGED`] or not finite.
    pub sample: usize,
    /// Index of the state: 0 surge, 1 sway, 2 yaw rate.
    pub state: usize,
}

/// Simulates [`crate::LANES`] runs of N samples side by side: x(k+1) = x(k) + θᵀφ(x(k) − x_c(k), exogenous(k)).
///
/// `parameters`: one lane per parameter. `initial`: u, v, r. `exogenous`: N × (inputs and measured disturbances).
/// `current`: N × 2 surge and sway components in body axes \[m/s\], or empty for still water. `states`: filled with
/// (N+1) × 3. All row-major.
pub fn simulate(
    model: &Model,
    parameters: &[Lane],
    initial: [Lane; 3],
    exogenous: &[impl Number],
    current: &[Lane],
    states: &mut [Lane],
) {
    simulate_numbers(model, parameters, initial, Number::numbers(exogenous), current, states);
}

fn simulate_numbers(
    model: &Model,
    parameters: &[Lane],
    initial: [Lane; 3],
    exogenous: Numbers,
    current: &[Lane],
    states: &mut [Lane],
) {
    match exogenous {
        Numbers::Lanes(lanes) => keep(model, parameters, initial, lanes, current, states),
        Numbers::Shared(numbers) => keep(model, parameters, initial, numbers, current, states),
    }
}

/// Follows the runs and keeps their states.
fn keep(
    model: &Model,
    parameters: &[Lane],
    initial: [Lane; 3],
    exogenous: &[impl Number],
    current: &[Lane],
    states: &mut [Lane],
) {
    states[..3].copy_from_slice(&initial);
    let mut rows = states[3..].chunks_exact_mut(3);
    follow(
        model,
        parameters,
        initial,
        exogenous,
        current,
        #[inline(always)]
        |state| {
            if let Some(row) = rows.next() {
                row.copy_from_slice(state);
            }
        },
    );
}

/// [`simulate`] that calls `each` with the states after every sample, 1 to N, instead of keeping them.
pub fn follow(
    model: &Model,
    parameters: &[Lane],
    initial: [Lane; 3],
    exogenous: &[impl Number],
    current: &[Lane],
    each: impl FnMut(&[Lane; 3]),
) {
    let program = Program::new(model, parameters);
    let width = model.exogenous();
    pulp::Arch::new().dispatch(Simulation { program, width, initial, exogenous, current, each });
}

/// [`follow`] compiled for every instruction set that pulp picks from. Lanes are only added and multiplied, never fused,
/// so that all give the same bits.
struct Simulation<'a, X, F> {
    program: Program,
    width: usize,
    initial: [Lane; 3],
    exogenous: &'a [X],
    current: &'a [Lane],
    each: F,
}

impl<X: Number, F: FnMut(&[Lane; 3])> pulp::WithSimd for Simulation<'_, X, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) {
        let mut state = self.initial;
        let mut current = self.current.chunks_exact(2);
        for exogenous in self.exogenous.chunks_exact(self.width.max(1)) {
            let mut relative = state;
            if let Some(current) = current.next() {
                relative[0] = state[0] - current[0];
                relative[1] = state[1] - current[1];
            }
            let increments = self.program.increments(relative, exogenous);
            for (state, increment) in state.iter_mut().zip(increments) {
                *state += increment;
            }
            (self.each)(&state);
        }
    }
}

/// What acts on [`crate::LANES`] runs besides their inputs.
#[derive(Clone, Copy, Debug)]
pub struct Weather<'a> {
    /// Current \[m/s\], N × 2, or empty for still water.
    pub current: &'a [Lane],
    /// Sampling interval \[s\] where the current's components are the earth's and the heading starts at zero; 0 where they
    /// are the vessel's.
    pub turning: f64,
    /// What is added to the states after each sample, N × 3, or empty.
    pub force: &'a [Lane],
}

/// [`simulate`] in a current of either axes and under forces.
pub fn simulate_in(
    model: &Model,
    parameters: &[Lane],
    initial: [Lane; 3],
    exogenous: &[impl Number],
    weather: &Weather,
    states: &mut [Lane],
) {
    let mut program = Program::new(model, parameters);
    let width = model.exogenous().max(1);
    let mut state = initial;
    let mut heading = Lane::ZERO;
    let mut currents = weather.current.chunks_exact(2);
    let mut forces = weather.force.chunks_exact(3);
    states[..3].copy_from_slice(&initial);
    for (exogenous, row) in exogenous.chunks_exact(width).zip(states[3..].chunks_exact_mut(3)) {
        let mut relative = state;
        if let Some(current) = currents.next() {
            let [along, across] = turned(current, heading);
            relative[0] = state[0] - along;
            relative[1] = state[1] - across;
        }
        heading += Lane::splat(weather.turning) * state[2];
        let increments = program.increments(relative, exogenous);
        state.iter_mut().zip(increments).for_each(|(state, increment)| *state += increment);
        if let Some(force) = forces.next() {
            state.iter_mut().zip(force).for_each(|(state, force)| *state += *force);
        }
        row.copy_from_slice(&state);
    }
}

/// The components north and east along and across a heading.
fn turned(current: &[Lane], heading: Lane) -> [Lane; 2] {
    let mut out = [Lane::ZERO; 2];
    for lane in 0..crate::LANES {
        let (sin, cos) = heading[lane].sin_cos();
        out[0][lane] = cos * current[0][lane] + sin * current[1][lane];
        out[1][lane] = cos * current[1][lane] - sin * current[0][lane];
    }
    out
}

/// Simulates one run in still water. Shapes as in [`simulate`], one number per entry; returns (N+1) × 3 states.
pub fn simulate_one(model: &Model, parameters: &[f64], initial: [f64; 3], exogenous: &[f64]) -> Vec<f64> {
    let lanes = |values: &[f64]| values.iter().map(|v| Lane::splat(*v)).collect::<Vec<_>>();
    let samples = exogenous.len() / model.exogenous().max(1);
    let mut states = vec![Lane::ZERO; 3 * (samples + 1)];
    simulate(model, &lanes(parameters), initial.map(Lane::splat), exogenous, &[], &mut states);
    states.iter().map(|lane| lane[0]).collect()
}

/// First sample at which one run's `states`, (N+1) × 3 row-major, are beyond [`DIVERGED`] or not finite.
pub fn check_diverged(mut states: impl Iterator<Item = f64>) -> Option<Diverged> {
    let beyond = |state: f64| state.is_nan() || state.abs() > DIVERGED;
    states.position(beyond).map(|i| Diverged { sample: i / 3, state: i % 3 })
}
