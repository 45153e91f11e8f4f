//! A ship that steps: the compiled model, its disturbances and sensors, and runs as recorded.

mod command;
mod compiled;
mod disturbance;
mod force_step;
mod noise;
mod products;
mod rate_error;
mod run;
mod ship;
mod simulate;

pub use command::{
    Command, Commanded, Driving, Helm, Origin, Pose, Program, Progress, Seen, Spoken, simulate_command,
    simulate_commanded, track,
};
pub use compiled::{Ambient, Compiled};
pub use disturbance::{
    Axes, Current, Disturbances, Disturbing, MOST_CURRENT_M_S, Measurement, Weather, Wind,
};
pub use force_step::{Moving, Point, Stepping};
pub use noise::{NormalRows, Streams, fill_normals};
pub use rate_error::Divided;
pub use run::{Run, RunView, Segment, SideBySide};
pub use ship::{Changes, Changing, ChangingCurrent, Ship};
pub use simulate::{
    DIVERGED, Diverged, Driven, MOST_SAMPLES, Recording, Replayed, check_diverged, check_runaway,
    diverged_lanes, mark_beyond, refuse_endless, replay, simulate, simulate_disturbed, simulate_groups,
    simulate_one,
};
