//! `sweep`: a study over a grid of its values.

use std::process::ExitCode;

fn main() -> ExitCode {
    seatrial::commands::SWEEP.main()
}
