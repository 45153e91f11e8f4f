//! The commands to a ship, sample by sample.

use std::fmt::Debug;
use std::sync::Arc;

use crate::engine::{Origin, Pose};

/// The helmsman's view at the beginning of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// u, v \[m/s\], r \[rad/s\], as the logged sensors measure them.
    pub state: [f64; 3],
    /// The same by sensors of the helmsman's own, without noise.
    pub own: [f64; 3],
    /// Position and heading relative to the pose where the commands began.
    pub pose: Pose,
}

/// How far commands have come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// They wait for this before they may end.
    Waiting(&'static str),
    /// They may end at any time, and go on until then.
    Open,
    /// They have ended.
    Done,
}

/// A running sequence of commands: the one way into a ship.
pub trait Command: Send {
    /// Sets the inputs of the sample that begins with `seen`.
    fn command(&mut self, seen: &Seen, inputs: &mut [f64]);

    /// What was commanded in the last sample, where actuators followed it to the inputs that were set.
    fn commanded(&self) -> Option<&[f64]> {
        None
    }

    /// The inputs at the beginning and the end of the last sample, where they changed within it. Those set are their
    /// mean.
    fn ends(&self) -> Option<[&[f64]; 2]> {
        None
    }

    /// How far they have come after the last sample.
    fn progress(&self) -> Progress {
        Progress::Open
    }
}

/// A program of commands, which each run begins anew.
pub trait Program: Debug + Send + Sync {
    /// Begins its commands.
    fn begin(&self) -> Box<dyn Command>;

    /// Whether it tracks a motion at every sample, so that its inputs follow all that it sees.
    fn tracks(&self) -> bool {
        false
    }
}

/// A shared program.
#[derive(Clone, Debug)]
pub struct Helm(Arc<dyn Program>);

impl Helm {
    /// Wraps a program.
    pub fn new(program: impl Program + 'static) -> Self {
        Self(Arc::new(program))
    }

    /// Commands inputs, N × inputs, row-major, regardless of the ship. The last ones are held.
    pub fn table(inputs: &[f64]) -> Self {
        Self::new(Table(inputs.into()))
    }

    /// Several programs in sequence, each for so many samples.
    pub fn sequence(parts: Vec<(Self, usize)>) -> Self {
        Self::new(Sequence(parts.into()))
    }

    /// Begins its commands.
    pub fn begin(&self) -> Box<dyn Command> {
        self.0.begin()
    }

    /// See [`Program::tracks`].
    pub fn tracks(&self) -> bool {
        self.0.tracks()
    }
}

impl PartialEq for Helm {
    /// Whether both are the same program, not whether their commands are equal.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

#[derive(Debug)]
struct Table(Arc<[f64]>);

impl Program for Table {
    fn begin(&self) -> Box<dyn Command> {
        Box::new(Played { rows: Arc::clone(&self.0), next: 0 })
    }
}

/// A table while it runs.
struct Played {
    rows: Arc<[f64]>,
    next: usize,
}

impl Command for Played {
    fn command(&mut self, _: &Seen, inputs: &mut [f64]) {
        if let Some(row) = self.rows.chunks_exact(inputs.len().max(1)).nth(self.next) {
            inputs.copy_from_slice(row);
        }
        self.next += 1;
    }
}

#[derive(Debug)]
struct Sequence(Arc<[(Helm, usize)]>);

impl Program for Sequence {
    fn begin(&self) -> Box<dyn Command> {
        Box::new(InTurn { parts: Arc::clone(&self.0), next: 0, now: None, left: 0 })
    }
}

/// Programs in sequence, each with the pose where it began as its origin.
struct InTurn {
    parts: Arc<[(Helm, usize)]>,
    next: usize,
    now: Option<(Box<dyn Command>, Origin)>,
    left: usize,
}

impl Command for InTurn {
    fn command(&mut self, seen: &Seen, inputs: &mut [f64]) {
        while self.left == 0 {
            let Some((helm, samples)) = self.parts.get(self.next) else { break };
            (self.now, self.left) = (Some((helm.begin(), seen.pose.into())), *samples);
            self.next += 1;
        }
        self.left = self.left.saturating_sub(1);
        if let Some((command, from)) = &mut self.now {
            command.command(&Seen { pose: from.sees(seen.pose), ..*seen }, inputs);
        }
    }

    fn commanded(&self) -> Option<&[f64]> {
        self.now.as_ref().and_then(|(command, _)| command.commanded())
    }

    fn ends(&self) -> Option<[&[f64]; 2]> {
        self.now.as_ref().and_then(|(command, _)| command.ends())
    }
}
