//! The stages as programs: each parses, reads, calls the other crates and writes.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod cli;
pub mod commands;
mod compiler;
mod design;
mod failure;
pub mod inputs;
pub mod pipeline;
mod pool;
mod ships;
mod simulate;
mod stage;
pub mod umbrella;

#[doc(hidden)]
pub use mimalloc::MiMalloc;

/// A program that calls `$main`. Its allocator returns freed blocks of tables to the system: with that of the C
/// library, memory would grow with the number of runs.
#[macro_export]
macro_rules! program {
    ($main:expr) => {
        #[global_allocator]
        static ALLOCATOR: $crate::MiMalloc = $crate::MiMalloc;

        fn main() -> std::process::ExitCode {
            $main
        }
    };
}
