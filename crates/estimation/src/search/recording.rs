use std::cmp::Reverse;

use regression::pooled::{Part, PooledRuns};
use ship::engine::RunView;

/// How recordings are cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut {
    /// Samples of a window that is fitted.
    pub window: usize,
    /// Samples from the start of one window to that of the next.
    pub every: usize,
    /// Samples of a window that models are scored on; none: whole runs.
    pub scored: Option<usize>,
}

/// The layout of the windows that models are scored on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Laid {
    /// Consecutive from the start of a run, as in other comparisons of models.
    SideBySide,
    /// One begins at every quarter of another, so that a score hardly depends on where the first begins.
    Overlapping,
    /// The same if windows are scored. If whole runs are, windows of the fitted length, or a shorter run: a ridge
    /// chosen over whole runs is too large, because a few long ones dominate.
    Choosing,
}

/// One recording: left out as a whole.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Its name.
    pub name: String,
    /// Its runs, with consecutive ones joined.
    pub whole: Vec<Part>,
    cut: Cut,
}

impl Recording {
    /// All recordings of `runs`.
    pub fn all(runs: &PooledRuns, cut: Cut) -> Vec<Self> {
        runs.windows(None).into_iter().map(|(name, whole)| Self::new(name, whole, cut)).collect()
    }

    /// The recording with this name and the runs `whole`.
    pub fn new(name: String, whole: Vec<Part>, cut: Cut) -> Self {
        Self { name, whole, cut }
    }

    /// Its windows to score, all of one length; whole runs without a length.
    pub(crate) fn scored(&self, laid: Laid) -> impl Iterator<Item = RunView<'_>> + Clone {
        let Cut { window, scored, .. } = self.cut;
        self.whole.iter().flat_map(move |whole| {
            let samples = whole.samples();
            let unscored = if laid == Laid::Choosing { window.min(samples) } else { samples };
            let length = scored.unwrap_or(unscored).max(1);
            let every = if laid == Laid::SideBySide { length } else { length.div_ceil(4) };
            let starts = (0..=samples.saturating_sub(length)).step_by(every);
            starts
                .filter(move |start| start + length <= samples)
                .map(move |start| whole.view().part(start..start + length))
        })
    }

    /// Its windows to fit, overlapping. The last ones are shorter, so that the end of the recording counts too.
    pub fn overlapping(&self) -> impl Iterator<Item = RunView<'_>> {
        let Cut { window, every, .. } = self.cut;
        self.whole.iter().flat_map(move |whole| {
            let samples = whole.samples();
            // A remainder that is shorter than a step belongs to the windows before it.
            let starts =
                (0..samples).step_by(every).filter(move |start| *start == 0 || start + every <= samples);
            starts.map(move |start| whole.view().part(start..(start + window).min(samples)))
        })
    }

    /// Number of its windows that models are scored on, side by side.
    pub fn windows(&self) -> usize {
        self.scored(Laid::SideBySide).count()
    }

    /// Number of its samples.
    pub fn samples(&self) -> usize {
        self.whole.iter().map(Part::samples).sum()
    }

    /// Number of errors in its windows.
    pub fn errors(&self) -> f64 {
        self.overlapping().map(|window| 3 * window.samples()).sum::<usize>() as f64
    }

    /// The kind of trial: its name up to the first digit or sign, or its maneuver's.
    pub fn kind(&self) -> &str {
        let end = self.name.find(|c: char| !c.is_alphabetic()).unwrap_or(self.name.len());
        &self.name[..end]
    }
}

/// The fold of each of `recordings`, below `count`. Those of one kind are dealt out one to each fold in turn, so that each fold has
/// some of every kind. The longest come first, each to the fold with the fewest samples so far, so that folds are
/// about equally long.
pub fn folds(recordings: &[&Recording], count: usize) -> Vec<usize> {
    let samples = |i: &usize| recordings[*i].samples();
    let kind = |i: &usize| recordings[*i].kind();
    let mut order: Vec<usize> = (0..recordings.len()).collect();
    order.sort_by_key(|i| (kind(i), Reverse(samples(i))));
    let (mut folds, mut samples_by_fold) = (vec![0; recordings.len()], vec![0; count]);
    for of_one_kind in order.chunk_by(|a, b| kind(a) == kind(b)) {
        let mut dealt = vec![0_usize; count];
        for recording in of_one_kind {
            let least = (0..count).min_by_key(|fold| (dealt[*fold], samples_by_fold[*fold]));
            let fold = least.unwrap_or(0);
            dealt[fold] += 1;
            samples_by_fold[fold] += samples(recording);
            folds[*recording] = fold;
        }
    }
    folds
}
