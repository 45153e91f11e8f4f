//! The kind and levels of the noise of runs that do not state it, by restricted likelihood.
//!
//! The model is linearised about a causal path: first the free simulation, then the filtered states. Errors and
//! sensitivities are columns of one linear filter, so the likelihood of the part that no parameter explains does not
//! depend on the parameters. Noise and parameters are found alternately until the parameters converge.

mod likelihood;
mod search;
mod turns;

use numerics::lanes::lane;
use numerics::{LANES, Lane};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::sensitivity::{Drift, Flow, ForceNoise, NoiseModel};

pub(crate) use turns::{ENOUGH, Earlier, Kinds};
pub(super) use turns::{Noise, Turns};

const MOST: usize = 9;
const LEAST: f64 = 1e-3;
/// A process with this time or more counts as constant \[s\].
pub(super) const LASTING: f64 = 1e5;
const NONE: f64 = 1e-12;

/// What disturbs runs besides white noise of u, v and r.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseKind {
    /// A current that is new at every sample.
    White,
    /// A current in earth axes that drifts.
    Current,
    /// A force in surge, sway and yaw that drifts, over one time.
    Forces,
    /// The same over a time of each.
    ForcesEach,
    /// Forces over one time, and a drifting current.
    ForcesAndCurrent,
    /// Drift of each sensor, over one time.
    Sensors,
}

impl NoiseKind {
    /// All of them: those that others begin at come before these.
    pub const ALL: [Self; 6] =
        [Self::White, Self::Current, Self::Forces, Self::Sensors, Self::ForcesEach, Self::ForcesAndCurrent];

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::White => "white noise",
            Self::Current => "a drifting current",
            Self::Forces => "drifting forces",
            Self::ForcesEach => "drifting forces, each over its own time",
            Self::ForcesAndCurrent => "drifting forces and a drifting current",
            Self::Sensors => "drifting sensors",
        }
    }

    /// Number of levels to find, three of them those of white noise.
    pub fn levels(self) -> usize {
        [4, 5, 7, 9, 9, 7][self as usize]
    }

    /// Number of states of a filter, see [`NoiseModel::states`].
    pub(crate) fn states(self) -> usize {
        [3, 5, 6, 6, 8, 7][self as usize]
    }

    fn is_time(self, level: usize) -> bool {
        let times: &[usize] = [&[][..], &[4], &[6], &[6, 7, 8], &[6, 8], &[6]][self as usize];
        times.contains(&level)
    }
}

/// Logarithms of levels: noise of u, v, r; forces or sensors three, and their times \[s\]; the current and its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Guess {
    pub kind: NoiseKind,
    logs: [f64; MOST],
}

impl Guess {
    /// From levels, in their order.
    pub fn new(kind: NoiseKind, levels: &[f64]) -> Self {
        let log = |i: usize| levels.get(i).map_or(0.0, |level| libm::log(level.max(NONE)));
        Self { kind, logs: std::array::from_fn(log) }
    }

    pub fn level(&self, i: usize) -> f64 {
        libm::exp(self.logs[i])
    }

    /// Standard deviations of the noise in u, v, r.
    pub fn measurement(&self) -> [f64; 3] {
        [0, 1, 2].map(|d| self.level(d))
    }

    fn three(&self) -> [f64; 3] {
        [3, 4, 5].map(|i| self.level(i))
    }

    /// Standard deviation of the current, and the time over which it drifts; `None` if it is new at every sample.
    pub fn current(&self) -> (f64, Option<f64>) {
        match self.kind {
            NoiseKind::White => (self.level(3), None),
            NoiseKind::Current => (self.level(3), Some(self.level(4))),
            NoiseKind::ForcesAndCurrent => (self.level(7), Some(self.level(8))),
            _ => (0.0, None),
        }
    }

    /// Standard deviations of forces \[increment per sample\], and the times over which each drifts \[s\].
    pub fn forces(&self) -> Option<([f64; 3], [f64; 3])> {
        let times = match self.kind {
            NoiseKind::Forces | NoiseKind::ForcesAndCurrent => [self.level(6); 3],
            NoiseKind::ForcesEach => [6, 7, 8].map(|i| self.level(i)),
            _ => return None,
        };
        Some((self.three(), times))
    }

    /// Standard deviations of the sensors' drift, and its time \[s\].
    pub fn sensors(&self) -> Option<([f64; 3], f64)> {
        (self.kind == NoiseKind::Sensors).then(|| (self.three(), self.level(6)))
    }

    /// With changed logarithms, within the range of levels: noise is not below `floor`.
    pub fn changed(mut self, by: impl Fn(usize) -> f64, rate_hz: f64, floor: [f64; 3]) -> Self {
        for i in 0..self.kind.levels() {
            let log = self.logs[i] + by(i);
            self.logs[i] = match self.kind.is_time(i) {
                true => log.clamp(libm::log(LEAST / rate_hz), libm::log(LASTING)),
                false => log.clamp(libm::log(floor.get(i).copied().unwrap_or(NONE)), libm::log(LASTING)),
            };
        }
        self
    }

    /// The disturbances of runs.
    pub fn levels(&self, rate_hz: f64) -> NoiseModel {
        side_by_side(&[*self; LANES], rate_hz).map(|lane| lane[0])
    }
}

/// The disturbances of runs in lanes, each its own, all of one kind.
pub(super) fn side_by_side(guesses: &[Guess; LANES], rate_hz: f64) -> NoiseModel<Lane> {
    let level = |i: usize| lane(LANES, |run| guesses[run].level(i));
    let factor = |i: usize| lane(LANES, |run| libm::exp(-1.0 / (rate_hz * guesses[run].level(i))));
    let flow =
        |i: usize| Flow::Markov { std: level(i), factor: factor(i + 1), turning: Lane::splat(1.0 / rate_hz) };
    let gusts = |times: [usize; 3]| Some(ForceNoise { std: [3, 4, 5].map(level), factor: times.map(factor) });
    let (current, force, drift) = match guesses[0].kind {
        NoiseKind::White => (Flow::White { std: level(3) }, None, None),
        NoiseKind::Current => (flow(3), None, None),
        NoiseKind::Forces => (Flow::Still, gusts([6; 3]), None),
        NoiseKind::ForcesEach => (Flow::Still, gusts([6, 7, 8]), None),
        NoiseKind::ForcesAndCurrent => (flow(7), gusts([6; 3]), None),
        NoiseKind::Sensors => {
            (Flow::Still, None, Some(Drift { std: [3, 4, 5].map(level), factor: factor(6) }))
        }
    };
    NoiseModel { measurement: [0, 1, 2].map(level), current, force, drift }
}
