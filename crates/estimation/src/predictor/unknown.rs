use numerics::Lane;
use ship::model::Model;

use super::scores::blocks;
use super::sums::{Linear, linearize};
use crate::estimator::{AdditionalUnknowns, UnknownCurrent};
use crate::sensitivity::{Flow, NoiseModel, Recordings, Slopes, slopes};

/// The start of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InitialState {
    /// At the recording's start, which is known.
    Known,
    /// Near it: its offset is estimated, and the first measurement counts.
    Estimated,
}

impl InitialState {
    /// The name in files.
    pub fn name(self) -> &'static str {
        ["known", "estimated"][self as usize]
    }
}

/// The unknowns of free simulations in addition to the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unknown {
    /// Where they start.
    pub initial: InitialState,
    /// The time between two samples \[s\] if a current is unknown, which is constant over ground: two unknowns \[m/s\],
    /// along and across the vessel at the start.
    pub current: Option<f64>,
}

impl From<InitialState> for Unknown {
    fn from(initial: InitialState) -> Self {
        Self { initial, current: None }
    }
}

impl Unknown {
    /// The unknowns of runs sampled every `interval_s` \[s\].
    pub fn new(initial: InitialState, additional: AdditionalUnknowns, interval_s: f64) -> Self {
        let current = (additional.current == UnknownCurrent::Earth).then_some(interval_s);
        Self { initial, current }
    }

    /// The unknowns that are estimated: the parameters of `model`, the initial state's offsets, the current.
    pub(super) fn free(self, model: &Model) -> Vec<usize> {
        let parameters = model.parameters();
        (0..parameters).chain(self.own().map(|i| parameters + i)).collect()
    }

    /// The estimated ones of those after the parameters: the initial state's offsets, and the current.
    pub(crate) fn own(self) -> impl Iterator<Item = usize> {
        let offsets = if self.initial == InitialState::Known { 0..0 } else { 0..3 };
        offsets.chain(if self.current.is_none() { 3..3 } else { 3..5 })
    }

    /// Whether sample 0 counts.
    pub(super) fn start_counts(self) -> bool {
        self.initial == InitialState::Estimated
    }

    /// The current as a constant disturbance.
    fn levels(self) -> Option<NoiseModel> {
        let lasting = |turning| Flow::Markov { std: 0.0, factor: 1.0, turning };
        let of = |current| NoiseModel { measurement: [0.0; 3], current, force: None, drift: None };
        self.current.map(lasting).map(of)
    }

    /// Free simulations linearised, see [`linearize`].
    pub(crate) fn linearize(self, recordings: &Recordings, unknowns: &[Lane], free: &[usize]) -> Vec<Linear> {
        let counts = self.start_counts();
        match self.levels() {
            None => linearize::<3>(recordings, unknowns, free, None, &[], counts),
            levels => linearize::<5>(recordings, unknowns, free, levels.as_ref(), &[], counts),
        }
    }

    /// Whether [`Self::slopes`] is available: only for the vessel's states alone.
    pub(super) fn has_slopes(self) -> bool {
        self.current.is_none()
    }

    /// The squared errors of free simulations and their slopes, see [`slopes`].
    pub(super) fn slopes(
        self,
        recordings: &Recordings,
        unknowns: &[Lane],
        free: &[usize],
        weights: impl Fn(usize, [f64; 3]) -> [f64; 3],
        path: &mut Vec<[Lane; 3]>,
    ) -> Vec<Slopes> {
        slopes(recordings, unknowns, free, self.start_counts(), weights, path)
    }

    /// Sums of free simulations over blocks of samples, see [`blocks`].
    pub(crate) fn blocks(
        self,
        recordings: &Recordings,
        unknowns: &[Lane],
        free: &[usize],
    ) -> Vec<Vec<Linear>> {
        let counts = self.start_counts();
        match self.levels() {
            None => blocks::<3>(recordings, unknowns, free, None, &[], counts),
            levels => blocks::<5>(recordings, unknowns, free, levels.as_ref(), &[], counts),
        }
    }
}
