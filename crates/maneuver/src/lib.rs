//! Maneuvers in the terms of a trial, turned into inputs by the model.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod actuated;
mod candidates;
mod dictionary;
mod draw;
mod feedback;
mod generate;
mod generate_spec;
mod input_limit;
mod input_table;
mod kept;
pub mod merit;
mod newton;
mod played;
mod reached;
mod settings;
mod shape;
mod signal;
mod spec;
mod stamps;
mod standard;
mod steady;

pub use dictionary::DictionaryFile;
pub use feedback::{Controller, Executed};
pub use generate::{Generator, Reacting, Realized};
pub use generate_spec::{CandidateKind, Exceeded, GenerateSpec, Limits};
pub use input_limit::InputLimit;
pub use input_table::{InputTable, Resampling};
pub use kept::Kept;
pub use played::PlayedTable;
pub use reached::{Aim, Tolerance, of_motion as aims_of_motion};
pub use shape::Shape;
pub use signal::{Signal, SignalShape};
pub use spec::{Kind, ManeuverSpec};
pub use standard::{
    Board, PullOut, ReverseSpiral, Sensors, Settings, SpiralTest, Standard, Stop, TurningCircle, WRONG_SIGN,
    ZigZagTest,
};
pub use steady::{Motion, Steady};
