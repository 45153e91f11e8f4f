//! `moments`: what each maneuver tells about the parameters.

use std::process::ExitCode;

fn main() -> ExitCode {
    seatrial::commands::MOMENTS.main()
}
