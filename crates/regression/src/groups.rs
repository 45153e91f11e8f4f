use std::ops::Range;

use numerics::{LANES, Lane};

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
