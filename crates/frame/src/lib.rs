//! What every stage's program does alike: its command line, what it may use, how it tells how far it is, how it ends, and how
//! work in blocks is split, put in order and written.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod beside;
mod changed;
pub mod choice;
pub mod cli;
pub mod compiler;
pub mod failure;
pub mod inputs;
mod interrupted;
pub mod limits;
pub mod manual;
pub mod ordered;
pub mod pool;
pub mod progress;
pub mod said;
pub mod sharded;
pub mod stage;
pub mod verify;
