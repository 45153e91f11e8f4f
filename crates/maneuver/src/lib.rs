//! Maneuvers in the terms of a trial, turned into inputs by the model.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod dictionary;
mod draw;
mod feedback;
mod generate;
mod generate_spec;
pub mod merit;
mod played;
mod signal;
mod spec;
mod standard;
mod steady;

pub use dictionary::{Aim, DictionaryFile, Tolerance, of_motion as aims_of_motion};
pub use feedback::{Controller, Executed, Kept};
pub use generate::{Generator, Reacting, Realized};
pub use generate_spec::{CandidateKind, Exceeded, GenerateSpec, InputLimit, Limits};
pub use played::{InputTable, PlayedTable, Resampling};
pub use signal::{Shape, Signal, SignalShape};
pub use spec::{Kind, ManeuverSpec};
pub use standard::{
    Board, PullOut, ReverseSpiral, Sensors, Settings, SpiralTest, Standard, Stop, TurningCircle, WRONG_SIGN,
    ZigZagTest,
};
pub use steady::{Motion, Steady};
