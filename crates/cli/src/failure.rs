//! Failures of a stage that writes nothing: one line and an exit code.

use std::convert::Infallible;
use std::fmt::Display;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use estimation::pooled::PoolError;
use estimation::runs::RunError;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use refusal::Invalid;
use regression::pooled::LostInstruments;
use thiserror::Error;

/// Why nothing was written. The message is one line.
#[derive(Debug, Error)]
pub enum Failure {
    /// Input, output or numerics failed.
    #[error("{0}")]
    Failed(String),
    /// The command line is invalid.
    #[error("{0}")]
    Usage(String),
    /// An input file was refused.
    #[error("{0}")]
    Refused(String),
    /// There is no result: not identifiable, did not converge.
    #[error("{0}")]
    NoAnswer(String),
}

impl Failure {
    /// 1 failed, 2 usage, 3 input refused, 4 no answer.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Failed(_) => 1,
            Self::Usage(_) => 2,
            Self::Refused(_) => 3,
            Self::NoAnswer(_) => 4,
        }
    }

    /// A refusal of `file`.
    pub fn refuse(file: &Path, thing: &str, found: &str, expected: &str, remedy: &str) -> Self {
        files::Error::refuse(file, thing, found, expected, remedy).into()
    }

    /// A run of `file` cannot be estimated.
    pub fn of_run(error: &RunError, vessel_file: &Path, file: &Path) -> Self {
        let diverged = matches!(error, RunError::Diverged(_) | RunError::Forces(_));
        Self::invalid(if diverged { vessel_file } else { file }, &error.invalid())
    }

    /// There are no instruments for runs of `file`.
    fn lost(file: &Path, lost: &LostInstruments) -> Self {
        Self::NoAnswer(format!(
            "{}: {lost}: found no instruments, expected a nominal model that follows the data; cut shorter parts with \
             --part-s, name another --nominal, or use --estimator ls",
            file.display()
        ))
    }

    /// The runs of `file` give no pooled estimate.
    pub fn of_pool<E>(error: PoolError<E>, file: &Path) -> Self
    where
        Self: From<E>,
    {
        match error {
            PoolError::Unread(error) => error.into(),
            PoolError::Lost(instruments) => Self::lost(file, &instruments),
            PoolError::Bounded(reasons) => Self::NoAnswer(format!(
                "{}: pooled estimate: found no room for an estimate ({}), expected a parameter that the data determine; widen \
                 the `bounds`, or fix some of these parameters",
                file.display(),
                reasons.join("; ")
            )),
            PoolError::Unfound(unfound) if unfound.recordings.is_empty() => Self::NoAnswer(format!(
                "{}: pooled estimate: found that {unfound}, expected one; leave out terms that these runs do not move",
                file.display()
            )),
            PoolError::Unfound(unfound) => Self::NoAnswer(format!(
                "{}: pooled estimate: found that {unfound}, expected a model that follows all; name recordings that belong to \
                 another ship or load with --leave-out, cut shorter parts with --part-s, or correct the structure",
                file.display()
            )),
            PoolError::Incomplete(reasons) => Self::NoAnswer(format!(
                "{}: pooled estimate: found degrees of freedom that are not identifiable ({}), without which no search can \
                 simulate, expected all three; add runs that vary these terms, fix them, or use --estimator auto",
                file.display(),
                reasons.join("; ")
            )),
            PoolError::NotIdentifiable(reasons) => Self::NoAnswer(format!(
                "{}: pooled estimate: found no degree of freedom that is identifiable ({}), expected one; add runs that vary \
                 these terms, or name a --prior for `ls`, `iv` or `auto`",
                file.display(),
                reasons.join("; ")
            )),
        }
    }

    /// Something in `file` is invalid.
    pub fn invalid(file: &Path, invalid: &Invalid) -> Self {
        files::Error::invalid(file, invalid.clone()).into()
    }
}

impl From<files::Error> for Failure {
    fn from(error: files::Error) -> Self {
        match error {
            files::Error::Refused { .. } => Self::Refused(error.to_string()),
            files::Error::Io { .. } => Self::Failed(error.to_string()),
        }
    }
}

impl From<Infallible> for Failure {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

/// A line on stdout.
pub fn on_stdout(line: impl Display) -> Result<(), Failure> {
    printed(writeln!(io::stdout().lock(), "{line}"))
}

/// What became of something printed on stdout. A closed pipe has a reader that wants no more, which is no failure.
pub fn printed(done: io::Result<()>) -> Result<(), Failure> {
    match done.and_then(|()| io::stdout().flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::Failed(format!(
            "stdout: write: found {error}, expected room for what is printed; print elsewhere (files of --out are written)"
        ))),
        _ => Ok(()),
    }
}

/// A line on stderr, which nothing depends on.
pub fn on_stderr(line: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}

/// Counts finished units of work: a bar on a terminal, an occasional plain line elsewhere, nothing within the first
/// second or when quiet.
pub struct WorkProgress {
    bar: ProgressBar,
    label: &'static str,
    quiet: bool,
    started: Instant,
    last_line: Mutex<Option<Instant>>,
}

const PATIENCE: Duration = Duration::from_secs(1);
const BETWEEN_LINES: Duration = Duration::from_secs(10);

impl WorkProgress {
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
        let wall_s = seconds / threads as f64;
        if !self.quiet && wall_s > 60.0 {
            on_stderr(format_args!("{}: about {} on {threads} threads", self.label, order_of(wall_s)));
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

impl Drop for WorkProgress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
