//! `seatrial`: every stage in one program.

use std::process::ExitCode;

fn main() -> ExitCode {
    seatrial::umbrella::main()
}
