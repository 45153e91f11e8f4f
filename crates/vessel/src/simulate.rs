use crate::{Ambient, Compiled, Lane, Model, Number, Numbers};

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

impl Weather<'_> {
    /// Still water, no force.
    pub const CALM: Self = Self { current: &[], turning: 0.0, force: &[] };
}

/// Simulates [`crate::LANES`] runs of N samples side by side: x(k+1) = x(k) + θᵀφ(x(k) − x_c(k), exogenous(k)).
///
/// `parameters`: one lane per parameter. `initial`: u, v, r. `exogenous`: N × (inputs and measured disturbances).
/// `states`: filled with (N+1) × 3. All row-major.
pub fn simulate(
    model: &Model,
    parameters: &[Lane],
    initial: [Lane; 3],
    exogenous: &[impl Number],
    weather: &Weather,
    states: &mut [Lane],
) {
    match Number::numbers(exogenous) {
        Numbers::Lanes(lanes) => keep(model, parameters, initial, lanes, weather, states),
        Numbers::Shared(numbers) => keep(model, parameters, initial, numbers, weather, states),
    }
}

/// Follows the runs and keeps their states.
fn keep(
    model: &Model,
    parameters: &[Lane],
    initial: [Lane; 3],
    exogenous: &[impl Number],
    weather: &Weather,
    states: &mut [Lane],
) {
    states[..3].copy_from_slice(&initial);
    let mut rows = states[3..].chunks_exact_mut(3);
    follow(
        model,
        parameters,
        initial,
        exogenous,
        weather,
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
    weather: &Weather,
    mut each: impl FnMut(&[Lane; 3]),
) {
    let (mut model, width) = (Compiled::new(model, parameters), model.exogenous());
    let Weather { current, turning, force } = *weather;
    // Compiled for every instruction set that pulp picks from. Lanes are only added and multiplied, never fused, so that
    // all give the same bits.
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            let (mut state, mut heading) = (initial, Lane::ZERO);
            let (mut currents, mut forces) = (current.chunks_exact(2), force.chunks_exact(3));
            for exogenous in exogenous.chunks_exact(width.max(1)) {
                let current = currents.next().map(|own| match turning == 0.0 {
                    true => [own[0], own[1]],
                    false => turned(own, &heading),
                });
                let force = forces.next().map(|own| [own[0], own[1], own[2]]);
                heading += Lane::splat(turning) * state[2];
                state = model.step(state, exogenous, Ambient { current, force });
                each(&state);
            }
        },
    );
}

/// The components north and east along and across a heading. Called: sines and cosines are no vectors.
#[inline(never)]
fn turned(current: &[Lane], heading: &Lane) -> [Lane; 2] {
    let mut out = [Lane::ZERO; 2];
    for lane in 0..crate::LANES {
        let (sin, cos) = libm::sincos(heading[lane]);
        out[0][lane] = cos * current[0][lane] + sin * current[1][lane];
        out[1][lane] = cos * current[1][lane] - sin * current[0][lane];
    }
    out
}

/// Simulates one run in still water. Shapes as in [`simulate`], one number per entry; returns (N+1) × 3 states.
pub fn simulate_one(model: &Model, parameters: &[f64], initial: [f64; 3], exogenous: &[f64]) -> Vec<f64> {
    let width = model.exogenous().max(1);
    let mut model = Compiled::new(model, parameters);
    let mut states = Vec::with_capacity(3 * (exogenous.len() / width + 1));
    states.extend(initial);
    let mut state = initial;
    for exogenous in exogenous.chunks_exact(width) {
        state = model.step(state, exogenous, Ambient::default());
        states.extend(state);
    }
    states
}

/// First sample at which one run's `states`, (N+1) × 3 row-major, are beyond [`DIVERGED`] or not finite.
pub fn check_diverged(mut states: impl Iterator<Item = f64>) -> Option<Diverged> {
    let beyond = |state: f64| state.is_nan() || state.abs() > DIVERGED;
    states.position(beyond).map(|i| Diverged { sample: i / 3, state: i % 3 })
}
