use crate::{Ambient, Arithmetic, Compiled, GROUPS, LANES, Lane, Model, Number, Numbers, Wide, vectorized};

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
    let initial = initial.map(Wide::from);
    match Number::numbers(exogenous) {
        Numbers::Lanes(lanes) => keep(model, parameters, initial, lanes, [*weather], [states]),
        Numbers::Shared(numbers) => keep(model, parameters, initial, numbers, [*weather], [states]),
    }
}

/// [`simulate`] of [`GROUPS`] times as many runs, which share parameters, start and exogenous signals.
pub fn simulate_groups(
    model: &Model,
    parameters: &[Lane],
    initial: [f64; 3],
    exogenous: &[f64],
    weather: [Weather; GROUPS],
    states: [&mut [Lane]; GROUPS],
) {
    keep(model, parameters, initial.map(Wide::from), exogenous, weather, states);
}

/// Follows the runs and keeps their states.
fn keep<const G: usize, E: Copy + Into<Wide<G>>>(
    model: &Model,
    parameters: &[Lane],
    initial: [Wide<G>; 3],
    exogenous: &[E],
    weather: [Weather; G],
    mut states: [&mut [Lane]; G],
) {
    let parameters: Vec<Wide<G>> = parameters.iter().copied().map(Wide::from).collect();
    let width = model.exogenous().max(1);
    let mut model = Compiled::new(model, &parameters);
    put(&mut states, 0, &initial);
    vectorized!({
        let (mut state, mut heading) = (initial, Wide::ZERO);
        for (k, exogenous) in exogenous.chunks_exact(width).enumerate() {
            let ambient = ambient(&weather, k, &heading);
            heading += Wide(weather.map(|own| Lane::splat(own.turning))) * state[2];
            state = model.step(state, exogenous, ambient);
            put(&mut states, k + 1, &state);
        }
    });
}

/// What acts on the groups at sample `k`.
#[inline(always)]
fn ambient<const G: usize>(weather: &[Weather; G], k: usize, heading: &Wide<G>) -> Ambient<Wide<G>> {
    let (mut current, mut force) = ([Wide::ZERO; 2], [Wide::ZERO; 3]);
    for (group, own) in weather.iter().enumerate() {
        if let Some(components) = own.current.as_chunks::<2>().0.get(k) {
            let components =
                if own.turning == 0.0 { *components } else { turned(components, &heading.0[group]) };
            (0..2).for_each(|i| current[i].0[group] = components[i]);
        }
        if let Some(components) = own.force.as_chunks::<3>().0.get(k) {
            (0..3).for_each(|i| force[i].0[group] = components[i]);
        }
    }
    let any = |signal: fn(&Weather) -> bool| weather.iter().any(signal);
    Ambient {
        current: any(|own| !own.current.is_empty()).then_some(current),
        force: any(|own| !own.force.is_empty()).then_some(force),
    }
}

/// Puts the state of every group at sample `k`.
#[inline(always)]
fn put<const G: usize>(states: &mut [&mut [Lane]; G], k: usize, state: &[Wide<G>; 3]) {
    for (group, states) in states.iter_mut().enumerate() {
        if let Some(row) = states.as_chunks_mut::<3>().0.get_mut(k) {
            (0..3).for_each(|d| row[d] = state[d].0[group]);
        }
    }
}

/// The components north and east along and across a heading. Called: sines and cosines are no vectors.
#[inline(never)]
fn turned(current: &[Lane; 2], heading: &Lane) -> [Lane; 2] {
    let mut out = [Lane::ZERO; 2];
    for lane in 0..LANES {
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

/// [`check_diverged`] of every lane of `states`, (N+1) × 3 row-major. Lanes are looked at one by one where one of them diverged.
pub fn diverged_lanes(states: &[Lane]) -> [Option<Diverged>; LANES] {
    let beyond = vectorized!({
        let mut beyond = Lane::ZERO;
        states.iter().for_each(|state| beyond.mark(*state));
        beyond
    });
    let at = |lane: usize| check_diverged(states.iter().map(|state| state[lane]));
    std::array::from_fn(|lane| if beyond[lane] == 0.0 { None } else { at(lane) })
}

impl Lane {
    /// Becomes 1 in every lane in which `state` is beyond [`DIVERGED`] or not finite.
    #[inline(always)]
    pub fn mark(&mut self, state: Lane) {
        for (mark, state) in self.0.iter_mut().zip(state.0) {
            *mark = if state.abs() <= DIVERGED { *mark } else { 1.0 };
        }
    }
}
