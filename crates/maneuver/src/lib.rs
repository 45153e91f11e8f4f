//! Maneuvers in the terms of a trial, turned into inputs by the model.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod dictionary;
mod feedback;
mod generate;
mod kind;
mod limits;
pub mod merit;
mod played;
mod signal;
mod spec;
mod standard;
mod steady;

pub use dictionary::{CandidateKind, DictionaryFile, GenerateSpec};
pub use feedback::{Controller, Executed};
pub use generate::{Generator, Reacting, Realized};
pub use kind::ManeuverKind;
pub use limits::{
    Aim, Exceeded, InputLimit, Kept, Limits, StatedLimits, Tolerance, of_motion as aims_of_motion,
};
pub use played::{InputTable, PlayedTable, Resampling};
pub use signal::{Shape, Signal, SignalShape};
pub use spec::ManeuverSpec;
pub use standard::{
    Board, PullOut, ReverseSpiral, Sensors, Settings, SpiralTest, Standard, Stop, TurningCircle, WRONG_SIGN,
    ZigZagTest,
};
pub use steady::{Motion, Steady};
