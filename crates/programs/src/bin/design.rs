//! `design`: how long to run each maneuver.

use std::process::ExitCode;

fn main() -> ExitCode {
    seatrial::commands::DESIGN.main()
}
