//! `monte-carlo`: a campaign's runs, estimated and scored in memory.

use std::process::ExitCode;

fn main() -> ExitCode {
    seatrial::commands::MONTE_CARLO.main()
}
