//! Limits of a search.

use std::time::{Duration, Instant};

use crate::said::on_stderr;
use lattice::{Engine, Options, Progress};
use trial::voyage::Watch;

/// Limits of a search.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Which engine to use.
    pub engine: Engine,
    /// Memory it may take \[bytes\].
    pub memory_bytes: u64,
    /// Time it may take.
    pub time: Option<Duration>,
    /// Whether to tell no progress.
    pub quiet: bool,
}

impl Limits {
    /// As options of the search.
    pub(super) fn options(&self) -> Options {
        Options { engine: self.engine, memory_bytes: self.memory_bytes, ..Options::default() }
    }

    /// A watch that stops the search when its time is over, and tells progress every few seconds.
    pub(super) fn watch(&self) -> Watch {
        let (limits, started) = (*self, Instant::now());
        let mut told = started;
        Box::new(move |progress: Progress| {
            if !limits.quiet && told.elapsed() > Duration::from_secs(2) {
                told = Instant::now();
                let best = progress.best.map_or("none yet".to_owned(), |b| b.primary.to_string());
                let bound = progress.lower_bound.primary;
                let seconds = started.elapsed().as_secs_f64();
                on_stderr(format_args!("plan: {seconds:.0} s, best {best}, at least {bound}"));
            }
            limits.time.is_none_or(|time| started.elapsed() < time)
        })
    }
}
