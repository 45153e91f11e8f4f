//! `design`: how long to run each maneuver.

use clap::Subcommand;

use crate::cli::Common;
use crate::design::refine::{Refine, refine};
use crate::design::{self, stage};
use crate::failure::Failure;
use crate::stage::{Either, Summary, Task};

/// The shares of a design, or a subcommand.
pub type Arguments = Either<design::Arguments, Study>;

/// What `design` does besides shares.
#[derive(Subcommand)]
pub enum Study {
    /// Makes the input signals of a design's experiment better for an output-error estimate, within limits of inputs and motion
    Refine(Refine),
}

impl Task for design::Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn run(&self) -> Result<Summary, Failure> {
        stage(self)
    }
}

impl Task for Study {
    fn common(&self) -> &Common {
        let Self::Refine(a) = self;
        &a.common
    }

    fn run(&self) -> Result<Summary, Failure> {
        let Self::Refine(a) = self;
        refine(a)
    }
}
