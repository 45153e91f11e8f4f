//! `ingest`: measured logs to trajectories.

use std::process::ExitCode;

fn main() -> ExitCode {
    seatrial::commands::INGEST.main()
}
