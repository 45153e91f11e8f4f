//! `export`: a model for other tools.

use std::process::ExitCode;

fn main() -> ExitCode {
    seatrial::commands::EXPORT.main()
}
