//! Limits of a search: its memory and time, and its progress reports.

use std::time::{Duration, Instant};

use clap::Args;
use files::PROGRAM_BYTES;

use crate::cli::{Common, budget};
use crate::failure::Failure;
use crate::said::on_stderr;
use plan::lattice::{Options, Progress};
use plan::voyage::Watch;

/// Share of the time for a search, so that the rest is left to check its plan.
const SEARCHED: f64 = 0.7;
/// The same if there is nothing to check.
const FOUND: f64 = 0.95;

/// The flags.
#[derive(Args)]
pub struct LimitFlags {
    /// Stop after this time, all phases counted, with a plan that is found in a moment and its gap, if there is one
    #[arg(long, value_name = "SECONDS")]
    time_limit_s: Option<f64>,
}

impl LimitFlags {
    /// The limits of the flags, starting now.
    ///
    /// # Errors
    /// An invalid time.
    pub fn limits(&self, common: &Common) -> Result<Limits, Failure> {
        let time = match self.time_limit_s {
            Some(s) if !(s.is_finite() && s > 0.0 && s < 1e9) => {
                let message = format!("--time-limit-s: found {s}, expected seconds above 0; correct it");
                return Err(Failure::Usage(message));
            }
            time => time.map(Duration::from_secs_f64),
        };
        Ok(Limits { memory_bytes: memory_bytes(common), started: Instant::now(), time, quiet: common.quiet })
    }
}

/// Memory of chart, lattice, search and check, without the program: by default no more than a fixed limit even if
/// more is available, since a search uses all that it may have, and a plan should not depend on the machine.
fn memory_bytes(common: &Common) -> u64 {
    let usual = common.memory_mib.map_or(Options::default().memory_bytes as f64, |_| f64::INFINITY);
    (budget().bytes().min(usual) as u64).saturating_sub(PROGRAM_BYTES)
}

/// Limits of a search.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Memory it may take \[bytes\].
    pub memory_bytes: u64,
    /// The start of all phases, for their common time limit.
    pub started: Instant,
    /// Time it may take.
    pub time: Option<Duration>,
    /// Whether to report no progress.
    pub quiet: bool,
}

impl Limits {
    /// As options of the search.
    pub fn options(&self) -> Options {
        Options { memory_bytes: self.memory_bytes, ..Options::default() }
    }

    /// Whether there is time left.
    pub fn keep_going(&self) -> bool {
        self.time.is_none_or(|time| self.started.elapsed() < time)
    }

    /// Limits of a search that leaves time to check what it finds.
    pub fn before_check(&self) -> Self {
        Self { time: self.time.map(|time| time.mul_f64(SEARCHED)), ..*self }
    }

    /// Limits of a search that leaves time to free its memory and to write its result.
    pub fn before_writing(&self) -> Self {
        Self { time: self.time.map(|time| time.mul_f64(FOUND)), ..*self }
    }

    /// A watch that stops the search when its time is over, and reports progress every few seconds.
    pub fn watch(&self) -> Watch {
        let limits = *self;
        let mut reported = Instant::now();
        Box::new(move |progress: Progress| {
            if !limits.quiet && reported.elapsed() > Duration::from_secs(2) {
                reported = Instant::now();
                let bound = progress.lower_bound.primary;
                let seconds = limits.started.elapsed().as_secs_f64();
                on_stderr(format_args!("plan: {seconds:.0} s, at least {bound}"));
            }
            limits.keep_going()
        })
    }
}
