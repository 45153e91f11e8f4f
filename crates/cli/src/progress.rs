//! Progress of work longer than a second, on stderr.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::said::on_stderr;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Counts finished units of work: a bar on a terminal, an occasional plain line elsewhere, nothing within the first
/// second or when quiet.
pub struct Progress {
    bar: ProgressBar,
    label: &'static str,
    quiet: bool,
    started: Instant,
    last_line: Mutex<Option<Instant>>,
}

const PATIENCE: Duration = Duration::from_secs(1);
const BETWEEN_LINES: Duration = Duration::from_secs(10);

impl Progress {
    /// Progress over `total` units.
    pub fn new(label: &'static str, total: usize, quiet: bool) -> Self {
        let bar = ProgressBar::with_draw_target(Some(total as u64), ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:40}] {percent} % of {len}, {eta} left") {
            bar.set_style(style);
        }
        bar.set_message(label);
        Self { bar, label, quiet, started: Instant::now(), last_line: Mutex::new(None) }
    }

    /// Announces the duration of `seconds` of one thread's work on all threads, by order of magnitude, if that is
    /// over a minute.
    #[must_use]
    pub fn foretold(self, seconds: f64) -> Self {
        let threads = rayon::current_num_threads();
        let own = seconds / threads as f64;
        if !self.quiet && own > 60.0 {
            on_stderr(format_args!("{}: about {} on {threads} threads", self.label, order_of(own)));
        }
        self
    }

    /// Counts `count` more units as done.
    pub fn advance(&self, count: usize) {
        self.bar.inc(count as u64);
        if self.quiet || self.started.elapsed() < PATIENCE {
            return;
        }
        if !std::io::stderr().is_terminal() {
            self.plain_line();
        } else if self.bar.is_hidden() {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
    }

    fn plain_line(&self) {
        let Ok(mut last) = self.last_line.lock() else { return };
        if last.is_none_or(|at| at.elapsed() >= BETWEEN_LINES) {
            *last = Some(Instant::now());
            let (done, all) = (self.bar.position(), self.bar.length().unwrap_or(0));
            let left =
                self.started.elapsed().as_secs_f64() * (all - done.min(all)) as f64 / done.max(1) as f64;
            on_stderr(format_args!("{}: {done} of {all}, about {} left", self.label, order_of(left)));
        }
    }
}

/// A time that is only known by order of magnitude.
fn order_of(seconds: f64) -> String {
    let units = [(86_400.0, "days"), (3_600.0, "h"), (60.0, "min")];
    let (unit, name) = units.into_iter().find(|(unit, _)| seconds >= 2.0 * unit).unwrap_or((1.0, "s"));
    format!("{:.0} {name}", (seconds / unit).ceil())
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
