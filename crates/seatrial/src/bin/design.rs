//! `design`: how long to run each maneuver.

use std::process::ExitCode;

use seatrial::cli::{run, run_from};
use seatrial::design::refine::{Refine, refine};
use seatrial::design::{Arguments, stage};

fn main() -> ExitCode {
    // Beside the flags, which stay as they are: a program of its own.
    if std::env::args_os().nth(1).is_some_and(|word| word == "refine") {
        return run_from(std::env::args_os().skip(1), |a: &Refine| &a.common, refine);
    }
    run(|a: &Arguments| &a.common, stage)
}
