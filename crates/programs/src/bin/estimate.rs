//! `estimate`: parameters of every run.

use std::process::ExitCode;

fn main() -> ExitCode {
    seatrial::commands::ESTIMATE.main()
}
