//! `plan`: one trajectory that uses every maneuver as often as the design wants.

use std::process::ExitCode;

fn main() -> ExitCode {
    seatrial::commands::PLAN.main()
}
