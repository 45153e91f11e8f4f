//! `simulate`: trajectories from a vessel and its maneuvers.

use std::process::ExitCode;

fn main() -> ExitCode {
    seatrial::commands::SIMULATE.main()
}
