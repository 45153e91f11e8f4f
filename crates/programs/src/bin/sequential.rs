//! `sequential`: trials designed in rounds.

use std::process::ExitCode;

fn main() -> ExitCode {
    seatrial::commands::SEQUENTIAL.main()
}
