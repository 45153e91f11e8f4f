use model::Model;
use numerics::Lane;

use super::scores::blocks;
use super::sums::{Linear, linearize};
use crate::additional::{AdditionalUnknowns, UnknownCurrent, UnknownWind};
use crate::sensitivity::{Flow, Levels, Recordings, Slopes, slopes};

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
    /// The water that the vessel moves in.
    pub current: UnknownCurrent,
    /// The wind.
    pub wind: UnknownWind,
    /// Time between two samples \[s\].
    pub interval_s: f64,
}

/// Number of ambient unknowns: along and across the vessel at the start, the current \[m/s\], its change and the
/// effect of the wind per sample \[m/s\].
pub const AMBIENT: usize = 6;

impl From<InitialState> for Unknown {
    fn from(initial: InitialState) -> Self {
        Self::new(initial, AdditionalUnknowns::default(), 0.0)
    }
}

impl Unknown {
    /// The unknowns of runs sampled every `interval_s` \[s\].
    pub fn new(initial: InitialState, additional: AdditionalUnknowns, interval_s: f64) -> Self {
        Self { initial, current: additional.current, wind: additional.wind, interval_s }
    }

    /// The unknowns that are estimated: the parameters of `model`, the initial state's offsets, those of water and
    /// wind.
    pub(super) fn free(self, model: &Model) -> Vec<usize> {
        let parameters = model.parameters();
        (0..parameters).chain(self.own().map(|i| parameters + i)).collect()
    }

    /// The estimated ones of those after the parameters: the initial state's offsets, and [`Self::ambient`].
    pub(crate) fn own(self) -> impl Iterator<Item = usize> {
        let offsets = if self.initial == InitialState::Known { 0..0 } else { 0..3 };
        offsets.chain(self.ambient().map(|i| 3 + i))
    }

    /// The estimated ones of the [`AMBIENT`] ambient unknowns.
    pub fn ambient(self) -> impl Iterator<Item = usize> {
        let current = match self.current {
            UnknownCurrent::None => 0..0,
            UnknownCurrent::Earth | UnknownCurrent::Body => 0..2,
            UnknownCurrent::Drifting => 0..4,
        };
        current.chain(if self.wind == UnknownWind::None { 0..0 } else { 4..6 })
    }

    /// Whether sample 0 counts.
    pub(super) fn start_counts(self) -> bool {
        self.initial == InitialState::Estimated
    }

    /// Water and wind as constant disturbances.
    pub(super) fn levels(self) -> Option<Levels> {
        let turning = if self.current == UnknownCurrent::Body { 0.0 } else { self.interval_s };
        let lasting = Flow::Markov { std: 0.0, factor: 1.0, turning };
        let any = self.ambient().next();
        any.map(|_| Levels { measurement: [0.0; 3], current: lasting, force: None, drift: None })
    }

    /// Number of states of the vessel, its water and its wind.
    fn states(self) -> usize {
        match self.ambient().last() {
            None => 3,
            Some(0..2) => 5,
            Some(_) => 9,
        }
    }

    /// Free simulations linearised, see [`linearize`].
    pub(crate) fn linearize(self, recordings: &Recordings, unknowns: &[Lane], free: &[usize]) -> Vec<Linear> {
        let (levels, counts) = (self.levels(), self.start_counts());
        match self.states() {
            3 => linearize::<3>(recordings, unknowns, free, None, &[], counts),
            5 => linearize::<5>(recordings, unknowns, free, levels.as_ref(), &[], counts),
            _ => linearize::<9>(recordings, unknowns, free, levels.as_ref(), &[], counts),
        }
    }

    /// Whether [`Self::slopes`] is available: only for the vessel's states alone.
    pub(super) fn has_slopes(self) -> bool {
        self.states() == 3
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
        let (levels, counts) = (self.levels(), self.start_counts());
        match self.states() {
            3 => blocks::<3>(recordings, unknowns, free, None, &[], counts),
            5 => blocks::<5>(recordings, unknowns, free, levels.as_ref(), &[], counts),
            _ => blocks::<9>(recordings, unknowns, free, levels.as_ref(), &[], counts),
        }
    }
}
