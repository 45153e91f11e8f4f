use vessel::RunView;

use crate::pooled::{Part, PooledRuns};

/// How recordings are cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut {
    /// Samples of a window that is fitted.
    pub window: usize,
    /// Samples from the start of one to that of the next.
    pub every: usize,
    /// Samples of a window that models are scored on; none: whole runs.
    pub scored: Option<usize>,
}

/// One recording: left out as a whole.
#[derive(Clone, Debug)]
pub(super) struct Recording {
    pub name: String,
    /// Runs that follow each other are one.
    pub whole: Vec<Part>,
    pub scored: Vec<Part>,
    cut: Cut,
}

impl Recording {
    /// All of `runs`.
    pub fn all(runs: &PooledRuns, cut: Cut) -> Vec<Self> {
        let scored = runs.windows(cut.scored);
        let of = |((name, whole), (_, scored)): ((String, Vec<Part>), (String, Vec<Part>))| Self {
            name,
            whole,
            scored,
            cut,
        };
        runs.windows(None).into_iter().zip(scored).map(of).collect()
    }

    /// Its windows to fit, overlapping, each with the number of the stretch of a window's length that it begins in. The last
    /// ones are shorter, so that the recording's end counts too.
    pub fn overlapping(&self) -> impl Iterator<Item = (usize, RunView<'_>)> {
        let Cut { window, every, .. } = self.cut;
        let mut before = 0;
        self.whole.iter().flat_map(move |whole| {
            let samples = whole.samples();
            // A remainder that is shorter than a step belongs to the windows before it.
            let starts =
                (0..samples).step_by(every).filter(move |start| *start == 0 || start + every <= samples);
            let first = before;
            before += samples.div_ceil(window);
            let cut = move |start| whole.view().part(start..(start + window).min(samples));
            starts.map(move |start| (first + start / window, cut(start)))
        })
    }

    /// Number of errors in its windows.
    pub fn errors(&self) -> f64 {
        self.overlapping().map(|(_, window)| 3 * window.samples()).sum::<usize>() as f64
    }

    /// What kind of trial it is: its name up to the first digit or sign, or its maneuver's.
    pub fn kind(&self) -> &str {
        let end = self.name.find(|c: char| !c.is_alphabetic()).unwrap_or(self.name.len());
        &self.name[..end]
    }
}
