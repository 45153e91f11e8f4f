//! `validate`: how far the estimated models can be trusted.

use std::process::ExitCode;

fn main() -> ExitCode {
    seatrial::commands::VALIDATE.main()
}
