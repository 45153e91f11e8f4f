use std::ops::Range;

use numerics::{Arithmetic, LANES, Lane, Number, Numbers, Row, Wide, vectorized};
use refusal::Invalid;

use crate::engine::{Ambient, Compiled, Disturbing, Weather};
use crate::forces::Body;
use crate::model::{DegreeOfFreedom, ForceModel, Model};

/// A speed \[m/s\] or yaw rate \[rad/s\] beyond which a simulation counts as diverged.
pub const DIVERGED: f64 = 1e3;

/// Where a simulation diverged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Diverged {
    /// First sample with a state beyond [`DIVERGED`] or not finite.
    pub sample: usize,
    /// Index of the state: 0 surge, 1 sway, 2 yaw rate.
    pub state: usize,
}

/// Simulates a lane of [`numerics::LANES`] runs of N samples: x(k+1) = x(k) + θᵀφ(x(k) − x_c(k), exogenous(k)).
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
    simulate_numbers(model, parameters, initial, Number::numbers(exogenous), weather, states);
}

/// Compiled in this crate, and not again by every caller.
fn simulate_numbers(
    model: &Model,
    parameters: &[Lane],
    initial: [Lane; 3],
    exogenous: Numbers,
    weather: &Weather,
    states: &mut [Lane],
) {
    let weather = [*weather];
    let mut follow = Follow::new(model, parameters, initial.map(Wide::from));
    match exogenous {
        Numbers::Lanes(lanes) => vectorized!(follow.whole(&lanes, &weather, [states])),
        Numbers::Shared(numbers) => vectorized!(follow.whole(&numbers, &weather, [states])),
    }
}

/// Simulates `G` times as many runs as [`simulate`], of one length and in still water, each with its own
/// exogenous inputs and states.
pub fn simulate_groups<const G: usize>(
    model: &Model,
    parameters: &[Lane],
    initial: [Wide<G>; 3],
    runs: [(&[Lane], &mut [Lane]); G],
) {
    let exogenous = runs.each_ref().map(|(exogenous, _)| *exogenous);
    let states = runs.map(|(_, states)| states);
    let mut follow = Follow::new(model, parameters, initial);
    vectorized!(follow.whole(&exogenous, &[Weather::CALM; G], states));
}

/// The exogenous inputs of `G` times [`numerics::LANES`] runs: N × exogenous, row-major.
#[derive(Clone, Copy, Debug)]
pub enum Driven<'a, const G: usize> {
    /// All runs have the same ones.
    SharedInputs(&'a [f64]),
    /// Each run has its own.
    Own([&'a [Lane]; G]),
}

/// [`numerics::LANES`] runs to be simulated: their disturbances, and buffers for their states, (N+1) × 3.
pub struct Recording<'a> {
    /// Their disturbances.
    pub disturbing: Disturbing,
    /// The true states; empty where they are not needed.
    pub truth: &'a mut [Lane],
    /// The states with measurement noise.
    pub measured: &'a mut [Lane],
}

/// Samples that are drawn, simulated and measured at a time, so that they stay in the L1 cache. An even number.
pub(crate) const AT_ONCE: usize = 32;

/// Simulates and measures `G` times as many runs as [`simulate`], with their disturbances. Returns a number
/// above zero in lanes where a state is beyond [`DIVERGED`] or not finite.
pub fn simulate_disturbed<const G: usize>(
    model: &Model,
    parameters: &[Lane],
    initial: [Wide<G>; 3],
    driven: Driven<G>,
    mut groups: [Recording; G],
) -> [Lane; G] {
    let mut follow = Follow::new(model, parameters, initial);
    let samples = groups.first().map_or(0, |group| group.measured.len() / 3 - 1);
    let mut beyond = [Lane::ZERO; G];
    for first in (0..samples.max(1)).step_by(AT_ONCE) {
        let end = samples.min(first + AT_ONCE);
        let rows = 3 * first..3 * (end + usize::from(end == samples));
        let some = groups.each_mut().map(|Recording { disturbing, measured, .. }| {
            (disturbing.next(end - first), &mut measured[rows.clone()])
        });
        vectorized!(match driven {
            Driven::SharedInputs(exogenous) => follow.block(&exogenous, first..end, some, &mut beyond),
            Driven::Own(exogenous) => follow.block(&exogenous, first..end, some, &mut beyond),
        });
        for Recording { disturbing, truth, measured } in &mut groups {
            let measured = &mut measured[rows.clone()];
            if !truth.is_empty() {
                truth[rows.clone()].copy_from_slice(measured);
            }
            disturbing.measure(measured);
        }
    }
    beyond
}

/// Runs in progress.
pub(crate) struct Follow<'m, const G: usize> {
    model: Compiled<'m, Wide<G>>,
    width: usize,
    pub state: [Wide<G>; 3],
    heading: Wide<G>,
}

impl<'m, const G: usize> Follow<'m, G> {
    /// With the same parameters in every group.
    pub fn new(model: &'m Model, parameters: &[Lane], initial: [Wide<G>; 3]) -> Self {
        let parameters: Vec<Wide<G>> = parameters.iter().copied().map(Wide::from).collect();
        let (width, model) = (model.exogenous().max(1), Compiled::new(model, &parameters));
        Self { model, width, state: initial, heading: Wide::ZERO }
    }

    /// Steps through all samples.
    #[inline(always)]
    fn whole(&mut self, exogenous: &impl Rows<G>, weather: &[Weather; G], mut states: [&mut [Lane]; G]) {
        let samples = exogenous.rows(self.width);
        self.go(exogenous, 0..samples, weather, &mut states);
        put(&mut states, samples, &self.state);
    }

    /// Steps through `samples` and writes the states, the one after the last if there is space for it. Marks lanes that diverge.
    #[inline(always)]
    fn block(
        &mut self,
        exogenous: &impl Rows<G>,
        samples: Range<usize>,
        some: [(Weather, &mut [Lane]); G],
        beyond: &mut [Lane; G],
    ) {
        let weather = some.each_ref().map(|(weather, _)| *weather);
        let mut states = some.map(|(_, states)| states);
        let count = samples.len();
        self.go(exogenous, samples, &weather, &mut states);
        put(&mut states, count, &self.state);
        for (beyond, states) in beyond.iter_mut().zip(states) {
            for state in states {
                mark_beyond(beyond, *state);
            }
        }
    }

    /// Steps through `samples` and writes the state before each of them; weather and states begin at the first of them.
    #[inline(always)]
    pub fn go(
        &mut self,
        exogenous: &impl Rows<G>,
        samples: Range<usize>,
        weather: &[Weather; G],
        states: &mut [&mut [Lane]; G],
    ) {
        let count = samples.len();
        let simple = |weather: &Weather| weather.turning == 0.0 && weather.force.is_empty();
        let flowing = weather.iter().filter(|group| group.current.len() >= 2 * count).count();
        let still = weather.iter().filter(|group| group.current.is_empty()).count();
        if !weather.iter().all(simple) || flowing.max(still) < G {
            return self.go_in_all_weathers(exogenous, samples, weather, states);
        }
        if still == G {
            for (i, k) in samples.enumerate() {
                put(states, i, &self.state);
                self.model.advance(
                    &mut self.state,
                    exogenous.row(k, self.width),
                    #[inline(always)]
                    |_| [0.0; 2],
                );
            }
            return;
        }
        let mut currents = [[].as_slice(); G];
        for (group, around) in weather.iter().enumerate() {
            currents[group] = &around.current.as_chunks::<2>().0[..count];
        }
        for (i, k) in samples.enumerate() {
            put(states, i, &self.state);
            self.model.advance(
                &mut self.state,
                exogenous.row(k, self.width),
                #[inline(always)]
                |[group, lane]| {
                    let [along, across] = &currents[group][i];
                    [along.0[lane], across.0[lane]]
                },
            );
        }
    }

    /// The general case: a current that turns with the earth, a force, or different kinds of weather.
    #[inline(always)]
    fn go_in_all_weathers(
        &mut self,
        exogenous: &impl Rows<G>,
        samples: Range<usize>,
        weather: &[Weather; G],
        states: &mut [&mut [Lane]; G],
    ) {
        let turning = Wide(weather.each_ref().map(|weather| Lane::splat(weather.turning)));
        for (i, k) in samples.enumerate() {
            put(states, i, &self.state);
            let Ambient { current, force } = ambient(weather, i, &self.heading);
            self.heading += turning * self.state[2];
            let row = exogenous.row(k, self.width);
            let current = current.unwrap_or([Wide::ZERO; 2]);
            self.model.advance(
                &mut self.state,
                row,
                #[inline(always)]
                |place| [current[0].at(place), current[1].at(place)],
            );
            let forced = self.state.iter_mut().zip(force.into_iter().flatten());
            forced.for_each(|(state, force)| *state += force);
        }
    }
}

/// The exogenous inputs of runs, sample by sample.
pub(crate) trait Rows<const G: usize> {
    /// The inputs during one sample.
    type Row: Row<Wide<G>>;
    /// The number of samples.
    fn rows(&self, width: usize) -> usize;
    /// The row of sample `k`.
    fn row(&self, k: usize, width: usize) -> Self::Row;
}

impl<'a, const G: usize, E> Rows<G> for &'a [E]
where
    &'a [E]: Row<Wide<G>>,
{
    type Row = Self;
    #[inline(always)]
    fn rows(&self, width: usize) -> usize {
        self.len() / width
    }
    #[inline(always)]
    fn row(&self, k: usize, width: usize) -> Self {
        &self[width * k..width * (k + 1)]
    }
}

impl<const G: usize> Rows<G> for [&[Lane]; G] {
    type Row = Self;
    #[inline(always)]
    fn rows(&self, width: usize) -> usize {
        self.first().map_or(0, |rows| rows.len() / width)
    }
    #[inline(always)]
    fn row(&self, k: usize, width: usize) -> Self {
        self.map(|rows| &rows[width * k..width * (k + 1)])
    }
}

/// The disturbances of the groups at sample `k`.
#[inline(always)]
fn ambient<const G: usize>(weather: &[Weather; G], k: usize, heading: &Wide<G>) -> Ambient<Wide<G>> {
    let (mut current, mut force) = ([Wide::ZERO; 2], [Wide::ZERO; 3]);
    let (mut flowing, mut forced) = (false, false);
    for (group, around) in weather.iter().enumerate() {
        flowing |= !around.current.is_empty();
        forced |= !around.force.is_empty();
        if let Some(components) = around.current.as_chunks::<2>().0.get(k) {
            let components =
                if around.turning == 0.0 { *components } else { turned(components, &heading.0[group]) };
            (0..2).for_each(|i| current[i].0[group] = components[i]);
        }
        if let Some(components) = around.force.as_chunks::<3>().0.get(k) {
            (0..3).for_each(|i| force[i].0[group] = components[i]);
        }
    }
    Ambient { current: flowing.then_some(current), force: forced.then_some(force) }
}

/// Writes the state of every group at sample `k`.
#[inline(always)]
fn put<const G: usize>(states: &mut [&mut [Lane]; G], k: usize, state: &[Wide<G>; 3]) {
    for (group, states) in states.iter_mut().enumerate() {
        if let Some(row) = states.as_chunks_mut::<3>().0.get_mut(k) {
            (0..3).for_each(|d| row[d] = state[d].0[group]);
        }
    }
}

/// The components north and east along and across a heading. Not inlined: sines and cosines are not vectorized.
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
    let mut states = Vec::with_capacity(3 * (exogenous.len() / width + 1));
    states.extend(initial);
    let (mut state, mut model) = (initial, Compiled::new(model, parameters));
    for exogenous in exogenous.chunks_exact(width) {
        state = model.step(state, exogenous, Ambient::default());
        states.extend(state);
    }
    states
}

/// First sample at which one run's `states`, (N+1) × 3 row-major, are beyond [`DIVERGED`] or not finite.
pub fn check_diverged(states: impl Iterator<Item = f64>) -> Option<Diverged> {
    check_bounded(states, DIVERGED)
}

/// How many times as fast as at its beginning a ship may become in a maneuver whose orders do not speed her up.
const RUNAWAY: f64 = 10.0;

/// [`check_diverged`] of a maneuver that begins at `speed_m_s` and whose orders turn or stop the ship.
pub fn check_runaway(states: &[f64], speed_m_s: f64) -> Option<Diverged> {
    check_bounded(states.iter().copied(), (RUNAWAY * speed_m_s.max(1.0)).min(DIVERGED))
}

fn check_bounded(mut states: impl Iterator<Item = f64>, most: f64) -> Option<Diverged> {
    let beyond = |state: f64| state.is_nan() || state.abs() > most;
    states.position(beyond).map(|i| Diverged { sample: i / 3, state: i % 3 })
}

/// [`check_diverged`] for every lane of `states`, (N+1) × 3 row-major. Single lanes are checked only if one of them diverged.
pub fn diverged_lanes(states: &[Lane]) -> [Option<Diverged>; LANES] {
    let beyond = vectorized!({
        let mut beyond = Lane::ZERO;
        states.iter().for_each(|state| mark_beyond(&mut beyond, *state));
        beyond
    });
    let at = |lane: usize| check_diverged(states.iter().map(|state| state[lane]));
    std::array::from_fn(|lane| if beyond[lane] == 0.0 { None } else { at(lane) })
}

/// Sets `mark` to 1 in every lane in which `state` is beyond [`DIVERGED`] or not finite.
#[inline(always)]
pub fn mark_beyond(mark: &mut Lane, state: Lane) {
    for (mark, state) in mark.0.iter_mut().zip(state.0) {
        *mark = if state.abs() <= DIVERGED { *mark } else { 1.0 };
    }
}

impl Diverged {
    /// The refusal of a vessel whose motion in `what`, with so many samples a second, diverges.
    pub fn invalid(self, what: impl Into<String>, rate_hz: f64) -> Invalid {
        let state = DegreeOfFreedom::ALL[self.state.min(2)].state();
        let (sample, seconds) = (self.sample, self.sample as f64 / rate_hz);
        Invalid::new(
            what,
            format!(
                "a simulation that diverges: {state} leaves every bound at sample {sample}, after {seconds:.1} s"
            ),
            "bounded motion",
            "check the signs of the terms; make the damping stronger (per sample between -1 and 0 for a linear one), or the inputs or the sampling interval smaller",
        )
    }
}

/// Most samples of a simulated run.
pub const MOST_SAMPLES: usize = 1 << 22;

/// Refuses runs of more than [`MOST_SAMPLES`] samples, which `thing` requests.
///
/// # Errors
/// States both numbers.
pub fn refuse_endless(thing: impl Into<String>, samples: usize) -> Result<(), Invalid> {
    if samples <= MOST_SAMPLES {
        return Ok(());
    }
    let (given, expected) = (format!("{samples} samples"), format!("at most {MOST_SAMPLES} samples"));
    Err(Invalid::new(thing, given, expected, "shorten it"))
}

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
