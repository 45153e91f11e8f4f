//! A ship that steps: the compiled model, its disturbances and sensors, and runs as recorded.

mod changes;
mod command;
mod commanded;
mod compiled;
mod disturbance;
mod divided;
mod moving;
mod noise;
mod normals;
mod pose;
mod products;
mod refusals;
mod replay;
mod run;
mod ship;
mod side_by_side;
mod simulate;

pub use changes::{Changes, Changing, ChangingCurrent};
pub use command::{Command, Helm, Program, Progress, Seen};
pub use commanded::{Commanded, Driving, simulate_command, simulate_commanded};
pub use compiled::{Ambient, Compiled};
pub use disturbance::{
    Axes, Current, Disturbances, Disturbing, MOST_CURRENT_M_S, Measurement, Weather, Wind, check_currents,
};
pub use divided::Divided;
pub use moving::{Moving, Point, Stepping};
pub use noise::{NormalRows, Streams};
pub use normals::fill_normals;
pub use pose::{Origin, Pose, track};
pub use refusals::{MOST_SAMPLES, refuse_endless};
pub use replay::{Replayed, replay};
pub use run::{Run, RunView, Segment};
pub use ship::Ship;
pub use side_by_side::SideBySide;
pub use simulate::{
    DIVERGED, Diverged, Driven, Recording, check_diverged, check_runaway, diverged_lanes, mark_beyond,
    simulate, simulate_disturbed, simulate_groups, simulate_one,
};
