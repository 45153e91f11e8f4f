//! `report`: a study on one page.

use std::process::ExitCode;

fn main() -> ExitCode {
    seatrial::commands::REPORT.main()
}
