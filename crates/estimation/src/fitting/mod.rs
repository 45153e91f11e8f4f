//! Force models fitted to recordings: output error with priors, and the errors of its estimates.
//!
//! A [`Problem`] has recordings cut into windows. Each window is simulated freely, by steps of order 4 with inputs linear
//! between samples. [`Problem::fit`] finds the free parameters θ and the state that each window starts from: they minimise
//! the mean over windows of Huber's function of the window's RMS error, plus what the priors hold against θ. Errors are
//! counted in standard deviations of the measured states. Derivatives are tangents of the steps, eight windows side by
//! side; windows are simulated in parallel and added in order, so that the result has the same bits for any number of
//! threads.
//!
//! Before a trial there is a [`SimulatedRun`]: its information about θ, and after it the most probable θ of a
//! [`MeasuredRun`] whose start and noise are known.

mod criticism;
mod fit;
mod simulated;
mod sums;

use std::ops::Deref;

use numerics::least_squares::Expansion;
use numerics::{LANES, Lane, lanes, statistics};
use refusal::Invalid;
use ship::forces::Forces;
use thiserror::Error;

pub use criticism::Channels;
pub use fit::{Estimates, Fit, Parameter};
pub use simulated::{MeasuredRun, PredictedErrors, RunInformation, SimulatedRun, StateSlopes};

/// How long inputs before a window may act in it, where thrusters follow theirs late \[s\].
const HISTORY_S: f64 = 20.0;

/// As how many samples the first one of a window counts at most.
const MOST: f64 = 1e6;

/// Recordings that a force model is fitted to.
pub struct Problem<'a> {
    pub(crate) forces: &'a Forces,
    pub(crate) recordings: Vec<RecordingView<'a>>,
    pub(crate) settings: Settings,
    pub(crate) groups: Vec<WindowGroup>,
    pub(crate) priors: Vec<Option<Prior>>,
    /// Of u, v \[m/s\], r \[rad/s\].
    pub(crate) deviations: [f64; 3],
    /// Samples of all windows.
    pub(crate) samples: usize,
    pub(crate) width: usize,
    pub(crate) late: bool,
}

impl<'a> Problem<'a> {
    /// `forces` on `recordings`, whose rows have `width` inputs and measured disturbances. Priors are those of the model.
    ///
    /// # Errors
    /// No free number, no sample, or a state that does not vary.
    pub fn new(
        forces: &'a Forces,
        recordings: Vec<RecordingView<'a>>,
        width: usize,
        settings: Settings,
    ) -> Result<Self, Unfit> {
        if forces.parameters().is_empty() {
            return Err(Unfit::NoParameter);
        }
        let deviations = deviations(&recordings)?;
        let thrusters = &forces.description().thruster;
        let late = settings.inputs == Inputs::Linear
            && thrusters.iter().any(|thruster| thruster.lag_s.is_some() || thruster.dead_time_s.is_some());
        let before = if late { settings.samples(HISTORY_S) } else { 0 };
        let windows = windows(&recordings, &settings);
        let groups = WindowGroup::all(&windows, &recordings, width, before);
        let prior = |parameter: &ship::forces::Parameter| {
            parameter.prior.map(|deviation| Prior { mean: parameter.nominal, deviation })
        };
        let priors = forces.parameters().iter().map(prior).collect();
        let samples = windows.iter().map(|window| window.samples).sum();
        Ok(Self { forces, recordings, settings, groups, priors, deviations, samples, width, late })
    }

    /// The same with these priors, one for each free parameter.
    #[must_use]
    pub fn with_priors(self, priors: Vec<Option<Prior>>) -> Self {
        Self { priors, ..self }
    }

    /// Standard deviations of measured u, v \[m/s\] and r \[rad/s\], which errors are counted in.
    pub fn deviations(&self) -> [f64; 3] {
        self.deviations
    }

    /// Whether each row of inputs acts during its whole sample.
    pub fn are_inputs_held(&self) -> bool {
        self.settings.inputs == Inputs::Held
    }

    /// Number of windows.
    pub fn windows(&self) -> usize {
        self.groups.iter().map(|group| group.windows.len()).sum()
    }

    /// As how many samples the first one counts: as often as noise, by third differences, is below errors of `rms`.
    pub(crate) fn first(&self, rms: [f64; 3]) -> [f64; 3] {
        let third = |rows: &[[f64; 3]], d: usize| rows[3][d] - rows[0][d] - 3.0 * (rows[2][d] - rows[1][d]);
        [0, 1, 2].map(|d: usize| {
            let all = self.recordings.iter().flat_map(|run| run.measured.as_chunks::<3>().0.windows(4));
            let squares: Vec<f64> = all.map(|row| third(row, d).powi(2)).collect();
            let noise = statistics::mean(&squares).unwrap_or(0.0) / 20.0;
            let error = (rms[d] * self.deviations[d]).powi(2);
            (error / noise.max(f64::MIN_POSITIVE)).clamp(1.0, MOST)
        })
    }

    /// What the square of a prior's standardised distance costs: the weight over half the numbers at 1 Hz.
    pub(crate) fn prior_cost(&self) -> f64 {
        let numbers = 3.0 * self.samples as f64 * self.settings.sample_s;
        self.settings.prior_weight / (0.5 * numbers).max(1.0)
    }
}

fn deviations(recordings: &[RecordingView]) -> Result<[f64; 3], Unfit> {
    if recordings.iter().all(|recording| recording.samples() == 0) {
        return Err(Unfit::NoSample);
    }
    let mut deviations = [0.0; 3];
    for (d, name) in ["u", "v", "r"].into_iter().enumerate() {
        let rows = recordings.iter().flat_map(|run| run.measured.as_chunks::<3>().0.iter().skip(1));
        let all: Vec<f64> = rows.map(|row| row[d]).collect();
        let mean = statistics::mean(&all).unwrap_or(0.0);
        let square = all.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / all.len() as f64;
        deviations[d] = square.sqrt();
        if !(deviations[d] > 0.0 && deviations[d].is_finite()) {
            return Err(Unfit::Constant(name));
        }
    }
    Ok(deviations)
}

/// What is known of a parameter before the fit, in its own system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// Its most probable value.
    pub mean: f64,
    /// Its standard deviation.
    pub deviation: f64,
}

/// Where the simulation of a window starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Starts {
    /// At a state of its own that is found with θ; the first measured sample then is one of many.
    #[default]
    Unknown,
    /// At the first measured sample, which counts as exact.
    Measured,
}

/// What inputs do between samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Inputs {
    /// Those of logs: they are linear between samples, and thrusters follow them late.
    #[default]
    Linear,
    /// Those of simulated runs: each row acts during its whole sample, as it is.
    Held,
}

/// How force models are fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// From one sample to the next \[s\].
    pub sample_s: f64,
    /// Longest window \[s\]; recordings are cut into equal ones.
    pub window_s: f64,
    /// RMS error of a window, in standard deviations, from which on it counts by its modulus, not its square.
    pub knee: f64,
    /// Weight of the priors: 1 as if half the measured numbers at 1 Hz were one.
    pub prior_weight: f64,
    /// Where windows start.
    pub starts: Starts,
    /// What inputs do between samples.
    pub inputs: Inputs,
    /// Length of the pieces that count as independent where standard errors are computed \[s\].
    pub piece_s: f64,
    /// Most steps of the search.
    pub most_steps: usize,
}

impl Settings {
    /// The usual ones for samples `sample_s` seconds apart.
    pub fn new(sample_s: f64) -> Self {
        Self {
            sample_s,
            window_s: 100.0,
            knee: 0.2,
            prior_weight: 1.0,
            starts: Starts::Unknown,
            inputs: Inputs::Linear,
            piece_s: 25.0,
            most_steps: 60,
        }
    }

    pub(crate) fn samples(&self, seconds: f64) -> usize {
        (seconds / self.sample_s).round().max(1.0) as usize
    }
}

/// A recording, or a part of one without gaps: N samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordingView<'a> {
    /// Its name.
    pub name: &'a str,
    /// Inputs and measured disturbances, in the order of the ship's channels: N rows.
    pub inputs: &'a [f64],
    /// Measured u, v \[m/s\] and r \[rad/s\]: N + 1 rows.
    pub measured: &'a [f64],
}

impl RecordingView<'_> {
    /// Number of samples N.
    pub fn samples(&self) -> usize {
        (self.measured.len() / 3).saturating_sub(1)
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Window {
    pub recording: usize,
    pub first: usize,
    pub samples: usize,
}

/// All recordings in equal windows of at most the length that is set, longest first and otherwise in order.
fn windows(recordings: &[RecordingView], settings: &Settings) -> Vec<Window> {
    let most = settings.samples(settings.window_s);
    let mut all = Vec::new();
    for (recording, cut) in recordings.iter().enumerate() {
        let samples = cut.samples();
        let count = samples.div_ceil(most);
        for i in 0..count {
            let [first, end] = [i, i + 1].map(|i| i * samples / count);
            all.push(Window { recording, first, samples: end - first });
        }
    }
    all.sort_by_key(|window| std::cmp::Reverse(window.samples));
    all
}

/// Up to [`LANES`] windows side by side.
pub(crate) struct WindowGroup {
    pub windows: Vec<Window>,
    pub samples: usize,
    pub before: usize,
    /// Rows of inputs: `before`, then one for each sample, and the one after it.
    pub inputs: Vec<Lane>,
    pub measured: Vec<Lane>,
}

impl WindowGroup {
    /// Of `windows`, with rows of `width` inputs. Where a recording has no row, its nearest one counts.
    pub fn new(windows: &[Window], recordings: &[RecordingView], width: usize, before: usize) -> Self {
        let samples = windows.iter().map(|window| window.samples).max().unwrap_or(0);
        let lane = |of: &dyn Fn(&Window) -> f64| lanes::lane(windows.len(), |i| of(&windows[i]));
        let input = |k: usize, i: usize| {
            lane(&|window| {
                let recording = &recordings[window.recording];
                let row = (window.first + k).saturating_sub(before).min(recording.samples() - 1);
                recording.inputs[row * width + i]
            })
        };
        let state = |k: usize, d: usize| {
            lane(&|window| {
                recordings[window.recording].measured[3 * (window.first + k.min(window.samples)) + d]
            })
        };
        let rows = before + samples + 1;
        Self {
            samples,
            before,
            inputs: (0..rows * width).map(|at| input(at / width, at % width)).collect(),
            measured: (0..3 * (samples + 1)).map(|at| state(at / 3, at % 3)).collect(),
            windows: windows.to_vec(),
        }
    }

    /// All `windows` in groups.
    pub fn all(windows: &[Window], recordings: &[RecordingView], width: usize, before: usize) -> Vec<Self> {
        windows.chunks(LANES).map(|chunk| Self::new(chunk, recordings, width, before)).collect()
    }
}

#[derive(Clone, Copy)]
struct Pass<'p> {
    problem: &'p Problem<'p>,
    /// As how many samples the first one of u, v, r counts where windows have starts of their own; else none.
    pub first: Option<[f64; 3]>,
}

impl<'p> Pass<'p> {
    pub fn new(problem: &'p Problem<'p>, first: Option<[f64; 3]>) -> Self {
        Self { problem, first }
    }

    /// Unknowns of a window: θ and its start.
    pub fn unknowns(&self) -> usize {
        self.forces.parameters().len() + if self.first.is_some() { 3 } else { 0 }
    }

    /// What errors of u, v and r are multiplied by in sample `k`.
    #[inline(always)]
    pub fn scales(&self, k: usize) -> [f64; 3] {
        let scales = self.deviations.map(|deviation| 1.0 / deviation);
        match (k, self.first) {
            (0, Some(first)) => [0, 1, 2].map(|d| scales[d] * first[d].sqrt()),
            (0, None) => [0.0; 3],
            _ => scales,
        }
    }
}

impl<'p> Deref for Pass<'p> {
    type Target = Problem<'p>;

    fn deref(&self) -> &Problem<'p> {
        self.problem
    }
}

/// Why there is no fit.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Unfit {
    /// Every number is known, fixed or tied.
    #[error("no number of the model is free")]
    NoParameter,
    /// No recording has two samples.
    #[error("no recording has two samples")]
    NoSample,
    /// A state is constant, so that its errors have no scale.
    #[error("`{0}` does not vary in the recordings")]
    Constant(&'static str),
    /// With the numbers before the fit a simulation leaves every bound.
    #[error("with the numbers before the fit, the simulation of `{recording}` from {first_s} s on diverges")]
    Diverged {
        /// The recording.
        recording: String,
        /// Where the window begins in it \[s\].
        first_s: f64,
    },
    /// The cost of the numbers that a search begins with is not finite, though every window's is.
    #[error("the cost of the numbers that the search begins with is not finite")]
    Boundless,
    /// The state that a window starts from cannot be found: how motion depends on it grows beyond every number.
    #[error(
        "in `{recording}`, the state at {first_s} s cannot be found: the motion of its window depends on it beyond all numbers"
    )]
    Start {
        /// The recording.
        recording: String,
        /// Where the window begins in it \[s\].
        first_s: f64,
    },
    /// Neither the recordings nor a prior determine a parameter.
    #[error("nothing in the recordings determines `{0}`, and it has no prior")]
    Undetermined(String),
    /// A term cannot be tried.
    #[error("a term to be tried is refused: {0}")]
    Candidate(String),
    /// The search did not end, and recordings fit better with something turned over.
    #[error("no minimum after {0} steps; the recordings fit better if {1}")]
    WrongSign(usize, String),
    /// The search did not end.
    #[error("no minimum after {0} steps")]
    Unfinished(usize),
}

impl Unfit {
    /// What is invalid, and the remedy.
    pub fn invalid(&self) -> Invalid {
        let (thing, expected, remedy) = match self {
            Self::NoParameter => {
                ("the model", "at least one free number", "write some as tables with `nominal` and `prior`")
            }
            Self::NoSample => ("the recordings", "two samples or more", "give longer runs"),
            Self::Constant(_) => ("the recordings", "u, v and r that vary", "give runs with maneuvers"),
            Self::Diverged { .. } => {
                ("the model", "numbers that the ship can be simulated with", "correct `nominal` or `prime`")
            }
            Self::Boundless => ("the model", "a finite one", "begin from numbers nearer to their priors"),
            Self::Start { .. } => {
                let expected = "windows over which motion stays finite";
                (
                    "the recordings",
                    expected,
                    "take shorter windows (`--fitted-window-s`), or correct the model's numbers",
                )
            }
            Self::Undetermined(_) => ("the model", "information about each", "add a `prior`, or fix it"),
            Self::Candidate(_) => {
                ("the model", "channels that terms can name", "rename the channel in vessel.toml")
            }
            Self::WrongSign(..) => {
                ("the fit", "signs as the ship has them", "check these columns and places, and correct them")
            }
            Self::Unfinished(_) => (
                "the fit",
                "a minimum",
                "give each number a prior, or a narrower one, or begin from better numbers",
            ),
        };
        Invalid::new(thing, self.to_string(), expected, remedy)
    }
}

/// Squares of the distances of θ from its priors, in their deviations.
fn distance(theta: &[f64], priors: &[Option<Prior>]) -> f64 {
    let square = |(value, prior): (&f64, &Option<Prior>)| {
        prior.map_or(0.0, |prior| ((value - prior.mean) / prior.deviation).powi(2))
    };
    theta.iter().zip(priors).map(square).sum()
}

/// What each prior adds to the second and first derivative of half the cost, with squares times `weight`.
fn prior_gradient(theta: &[f64], priors: &[Option<Prior>], weight: f64) -> Vec<[f64; 2]> {
    let pull = |(value, prior): (&f64, &Option<Prior>)| {
        let Some(prior) = prior else { return [0.0; 2] };
        let pull = weight / (prior.deviation * prior.deviation);
        [pull, pull * (value - prior.mean)]
    };
    theta.iter().zip(priors).map(pull).collect()
}

/// Adds what the priors hold against θ, squares times `weight`.
fn add_priors(to: &mut Expansion, theta: &[f64], priors: &[Option<Prior>], weight: f64) {
    for (i, (value, prior)) in theta.iter().zip(priors).enumerate() {
        if let Some(prior) = prior {
            to.add_prior(i, value - prior.mean, weight / (prior.deviation * prior.deviation));
        }
    }
}

/// Which of θ lie at a bound that the cost pushes them to.
fn at_bound(forces: &Forces, theta: &[f64], gradient: &[f64]) -> Vec<bool> {
    let limited = |((value, gradient), parameter): ((&f64, &f64), &ship::forces::Parameter)| {
        let [low, high] = parameter.bounds;
        (*value <= low && *gradient > 0.0) || (*value >= high && *gradient < 0.0)
    };
    theta.iter().zip(gradient).zip(forces.parameters()).map(limited).collect()
}

/// The rows and columns at `places` of the n × n matrix `whole`.
fn block(whole: &[f64], n: usize, places: &[usize]) -> Vec<f64> {
    let m = places.len();
    (0..m * m).map(|k| whole[places[k / m] * n + places[k % m]]).collect()
}
