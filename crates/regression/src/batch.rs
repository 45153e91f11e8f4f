use std::ops::Range;

use numerics::{LANES, Lane, Number, Numbers};
use ship::model::Model;

/// [`LANES`] runs of N samples side by side. All row-major. Data shared by the runs (`X` = `f64`) is one number per
/// entry instead of a lane; the results have the same bits.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a, X = Lane> {
    /// The model structure.
    pub model: &'a Model,
    /// Measured states u, v \[m/s\], r \[rad/s\]: (N+1) × 3.
    pub measured: &'a [Lane],
    /// The states that the instruments are evaluated at: (N+1) × 3. For instrumental variables those of a nominal
    /// simulation, for least squares the measured ones.
    pub instrument_states: &'a [X],
    /// Inputs and measured disturbances: N × exogenous.
    pub exogenous: &'a [X],
    /// Those that the instruments are evaluated with: N × exogenous. For least squares the above.
    pub instrument_exogenous: &'a [X],
    /// Per run, the first sample of each segment, ascending from 0.
    pub segments: [&'a [usize]; LANES],
}

/// A batch with its number type erased, so that passes are compiled here and not in every crate and test that calls
/// them.
#[derive(Clone, Copy, Debug)]
pub(crate) enum AnyBatch<'a> {
    Lanes(Batch<'a, Lane>),
    Shared(Batch<'a, f64>),
}

/// The result of a pass over a batch of either kind, [`numerics::vectorized!`].
macro_rules! over_batch {
    ($any:expr, |$batch:ident| $pass:expr) => {
        match $any {
            $crate::batch::AnyBatch::Lanes($batch) => numerics::vectorized!($pass),
            $crate::batch::AnyBatch::Shared($batch) => numerics::vectorized!($pass),
        }
    };
}
pub(crate) use over_batch;

impl<'a> AnyBatch<'a> {
    /// The model structure.
    pub(crate) fn model(&self) -> &'a Model {
        match self {
            Self::Lanes(batch) => batch.model,
            Self::Shared(batch) => batch.model,
        }
    }
}

impl<'a, X: Number> Batch<'a, X> {
    /// This batch with its number type erased.
    pub(crate) fn any(&self) -> AnyBatch<'a> {
        let numbers =
            [self.instrument_states, self.exogenous, self.instrument_exogenous].map(|own| X::numbers(own));
        match numbers {
            [Numbers::Lanes(states), Numbers::Lanes(own), Numbers::Lanes(instruments)] => {
                AnyBatch::Lanes(self.of([states, own, instruments]))
            }
            [Numbers::Shared(states), Numbers::Shared(own), Numbers::Shared(instruments)] => {
                AnyBatch::Shared(self.of([states, own, instruments]))
            }
            _ => unreachable!("all are made of X"),
        }
    }

    /// This batch with its data as numbers of another type.
    fn of<Y>(&self, [instrument_states, exogenous, instrument_exogenous]: [&'a [Y]; 3]) -> Batch<'a, Y> {
        let Self { model, measured, segments, .. } = *self;
        Batch { model, measured, instrument_states, exogenous, instrument_exogenous, segments }
    }
}

impl<X> Batch<'_, X> {
    /// Number of regression pairs N.
    pub fn samples(&self) -> usize {
        self.measured.len() / 3 - 1
    }
}

/// Splits `range` into blocks of `N` samples: (first, count).
pub(crate) fn parts<const N: usize>(range: Range<usize>) -> impl Iterator<Item = (usize, usize)> {
    let end = range.end;
    range.step_by(N).map(move |k| (k, N.min(end - k)))
}

/// A group of samples that shares its intercepts: its first sample, and a constant per signal.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub start: usize,
    pub constants: Vec<f64>,
}

/// The groups of every run.
pub(crate) type Groups<'a> = [&'a [Group]; LANES];

/// The groups' constants that hold at each of `N` samples, lane by lane.
pub(crate) struct Constants<'a, const N: usize> {
    groups: Groups<'a>,
    signals: Vec<[Lane; N]>,
    next: [usize; LANES],
    /// The next sample at which a constant changes.
    changes: usize,
}

impl<'a, const N: usize> Constants<'a, N> {
    pub(crate) fn new(groups: Groups<'a>, signals: usize) -> Self {
        Self { groups, signals: vec![[Lane::ZERO; N]; signals], next: [0; LANES], changes: 0 }
    }

    /// The constants of the samples from `k` on; called with ascending `k`.
    pub(crate) fn at(&mut self, k: usize) -> &[[Lane; N]] {
        if self.changes < k + N {
            self.changes = usize::MAX;
            (0..LANES).for_each(|lane| self.enter(k, lane));
        }
        &self.signals
    }

    /// The constants at the first of the samples `range`, and the end of their validity: after a multiple of `N`
    /// samples, or at the end of `range`, and zero beyond.
    pub(crate) fn over(&mut self, range: Range<usize>) -> (usize, &[[Lane; N]]) {
        self.at(range.start);
        if range.len() < N {
            self.signals.iter_mut().for_each(|signal| signal[range.len()..].fill(Lane::ZERO));
            return (range.end, &self.signals);
        }
        let whole = |samples: usize| samples / N * N;
        let same = whole(self.changes - range.start).max(N);
        (range.start + same.min(whole(range.len())), &self.signals)
    }

    fn enter(&mut self, k: usize, lane: usize) {
        let groups = self.groups[lane];
        // A group that began among the last samples applies to all of these.
        if let Some(i) = self.next[lane].checked_sub(1) {
            self.hold(lane, 0, &groups[i]);
        }
        while let Some(group) = groups.get(self.next[lane]).filter(|g| g.start < k + N) {
            self.hold(lane, group.start - k, group);
            self.next[lane] += 1;
            if group.start > k {
                self.changes = self.changes.min(k + N);
            }
        }
        if let Some(group) = groups.get(self.next[lane]) {
            self.changes = self.changes.min(group.start);
        }
    }

    /// Applies `group` to `lane` from sample `from` of these on.
    fn hold(&mut self, lane: usize, from: usize, group: &Group) {
        for (signal, value) in self.signals.iter_mut().zip(&group.constants) {
            signal[from..].iter_mut().for_each(|at| at[lane] = *value);
        }
    }
}
