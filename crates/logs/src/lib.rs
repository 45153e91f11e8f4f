//! Measured channels to a vessel's trajectories: units, clocks, kinematics, sub-experiments, quality.
//!
//! Knows no files. Axes: earth x north, y east, heading `psi` clockwise from north; body x forward, y starboard, z down
//! (NED and FRD). Numbers are in SI units and radians once [`unit()`] has converted them.
//!
//! A [`Setup`] says how the logs were made; a [`Plan`] decides which channels a vessel needs. [`sources`] finds the files of
//! each recording by their names, [`read_csv`], [`read_nmea`] and [`read_bag`] read their columns, [`Log`] puts these on a
//! clock, and [`record`] makes runs of the logs of a recording and assesses their data.
//!
//! A recording is a set of [`Series`], one per channel, each with a clock of its own. [`assemble`] turns it into channels on
//! one clock; [`Segmentation`] cuts them into sub-experiments; [`consistency`] and [`noise_std`] measure their quality.
//!
//! In the other direction, [`Allocation`] turns forces into thruster settings, and [`chain`] into what a
//! ship's instruments would have logged.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod assemble;
mod axes;
mod bag;
pub mod by_motion;
pub mod chain;
mod clock;
mod columns;
mod csv;
mod encoding;
mod foreign_format;
mod frame;
mod gate;
pub mod guess;
mod joined;
mod log;
mod nmea;
mod plan;
mod positions;
mod prepare;
mod quality;
mod record;
mod samples;
mod segment;
mod series;
mod setup;
mod source;
mod stamp;
mod suspicion;
mod thruster;
mod topics;

pub use assemble::{Assembled, Grid, Section, assemble, sections};
pub use bag::{DatabaseFile, Topic, bag_census, database_census};
pub use clock::{Backwards, NonMonotonic, Order, Repeated, TimeUnit, begins_anew, order};
pub use columns::{Apart, Cells, ClockNotes, Columns, Content, Fractions, WantedColumn, places};
pub use csv::read_csv;
pub use encoding::LogError;
pub use foreign_format::{SNIFFED, foreign_format};
pub use frame::{
    Body, Frame, Heading, Lever, Method, UNITS, Unit, body_velocity, euler, factor, shaft_factor, unit,
};
pub use log::{Log, RowSummary};
pub use nmea::{Accepted, Spoken, SpokenField, has_sentences, read_nmea, sentence_census};
pub use plan::{BLOCK, Exogenous, Plan};
pub use positions::{LoggedPosition, LoggedPositions, Since, read_positions};
pub use prepare::{
    Axis, Channels, Conventions, Derived, ForceTable, KINEMATIC, Propulsor, Unassembled, prepare,
};
pub use quality::{ChannelSummary, MotionSummary, State, consistency, lag, noise_std};
pub use record::{ManeuverCount, Recorded, RecordedRun, RecordingSummary, Totals, record};
pub use samples::{Labels, Numbering, Samples, Store, Values};
pub use segment::{Cut, Interval, Segmentation, SpeedClasses, SubExperiment, check_intervals};
pub use series::{Series, Unwrapping, local_quadratic, window_samples};
pub use setup::{ChannelSpec, Checksums, FileSpec, Format, QuaternionSpec, Setup, TimeSpec};
pub use ship::model::{Formula, Malformed};
pub use source::{ManeuverKind, Naming, Pattern, Source, Template};
pub use stamp::{Moments, NoStamp, Stamps};
pub use suspicion::{Omission, Omissions, Reason, WarningKind, WarningSummary};
pub use thruster::{Allocation, Law, Setting, Thruster, Unreachable};
pub use topics::{LOG_TIME, PUBLISH_TIME, read_bag, read_database};
