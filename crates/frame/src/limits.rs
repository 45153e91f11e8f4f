//! Limits of a search: its engine, memory and time, and how it tells how far it is.

use std::time::{Duration, Instant};

use crate::said::on_stderr;
use lattice::{Engine, Options, Progress};
use trial::voyage::Watch;

/// Share of the time after which a search ends, so that there is some to check its plan.
const SEARCHED: f64 = 0.7;

/// Limits of a search.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Which engine to use.
    pub engine: Engine,
    /// Memory it may take \[bytes\].
    pub memory_bytes: u64,
    /// When it began, and when all phases together are to be over.
    pub started: Instant,
    /// Time it may take.
    pub time: Option<Duration>,
    /// Whether to tell no progress.
    pub quiet: bool,
}

impl Limits {
    /// As options of the search.
    pub fn options(&self) -> Options {
        Options { engine: self.engine, memory_bytes: self.memory_bytes, ..Options::default() }
    }

    /// Whether there is time left.
    pub fn go_on(&self) -> bool {
        self.time.is_none_or(|time| self.started.elapsed() < time)
    }

    /// Limits of a search that leaves time to check what it finds.
    pub fn before_check(&self) -> Self {
        Self { time: self.time.map(|time| time.mul_f64(SEARCHED)), ..*self }
    }

    /// A watch that stops the search when its time is over, and tells progress every few seconds.
    pub fn watch(&self) -> Watch {
        let limits = *self;
        let mut told = Instant::now();
        Box::new(move |progress: Progress| {
            if !limits.quiet && told.elapsed() > Duration::from_secs(2) {
                told = Instant::now();
                let best = progress.best.map_or("none yet".to_owned(), |b| b.primary.to_string());
                let bound = progress.lower_bound.primary;
                let seconds = limits.started.elapsed().as_secs_f64();
                on_stderr(format_args!("plan: {seconds:.0} s, best {best}, at least {bound}"));
            }
            limits.go_on()
        })
    }
}
