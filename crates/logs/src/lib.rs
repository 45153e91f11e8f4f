//! Measured channels to a vessel's trajectories: units, clocks, kinematics, sub-experiments, quality.
//!
//! Knows no files. Axes: earth x north, y east, heading `psi` clockwise from north; body x forward, y starboard, z down
//! (NED and FRD). Numbers are in SI units and radians once [`unit()`] has converted them.
//!
//! A [`Setup`] says how the logs were made; a [`Plan`] decides which channels a vessel needs. [`sources`]
//! finds the files of each recording by their names, [`read_csv`], [`read_nmea`] and [`read_bag`] read their
//! columns, [`Log`] puts these on a clock, and [`record`] makes runs of the logs of a recording and assesses
//! their data.
//!
//! A recording is a set of [`Series`], one per channel, each with a clock of its own. [`assemble`] turns it
//! into channels on one clock; [`Segmentation`] cuts them into sub-experiments; [`consistency`] and
//! [`noise_std`] measure their quality.
//!
//! In the other direction, [`Allocation`] turns forces into thruster settings, and [`chain`] into what a
//! ship's instruments would have logged.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod allocation;
mod angle;
mod assemble;
mod attitude;
mod axes;
pub mod bag;
pub mod chain;
mod clock;
mod columns;
mod contradiction;
mod csv;
mod encoding;
mod foreign_format;
mod foreign_text;
mod fraction;
mod frame;
mod gate;
mod grid;
pub mod guess;
mod joined;
mod kinematics;
mod lever;
mod lines;
mod log;
mod log_error;
mod nmea;
mod numbering;
mod omission;
mod pace;
mod pattern;
mod plan;
mod position;
mod positions;
mod prepare;
mod quality;
mod record;
mod rescaled;
mod rollover;
mod row;
mod samples;
mod segment;
mod series;
mod setup;
mod smoother;
mod source;
mod spans;
mod spread;
mod stamp;
mod suspicion;
mod table;
mod thruster;
mod topics;
mod totals;
mod unassembled;
mod unit;

pub use crate::bag::{DatabaseFile, Topic};
pub use allocation::{Allocation, Unreachable};
pub use angle::Unwrapping;
pub use assemble::{Assembled, assemble};
pub use clock::{Backwards, NonMonotonic, Order, Repeated, TimeUnit, order};
pub use columns::{Apart, Cells, ClockNotes, Columns, Content, Wanted, places};
pub use csv::read_csv;
pub use foreign_format::{SNIFFED, foreign_format};
pub use fraction::Fractions;
pub use frame::{Body, Frame, Heading};
pub use grid::{Grid, Section, sections};
pub use kinematics::{Method, body_velocity, euler};
pub use lever::Lever;
pub use log::{Log, RowSummary};
pub use log_error::LogError;
pub use nmea::{Accepted, Spoken, SpokenField, has_sentences, read_nmea, sentence_census};
pub use numbering::{Labels, Numbering};
pub use omission::{Omission, Omissions, Reason};
pub use pattern::{Pattern, Template};
pub use plan::{BLOCK, Exogenous, Plan};
pub use position::{LoggedPosition, LoggedPositions, Since};
pub use positions::read_positions;
pub use prepare::{Channels, Conventions, Derived, KINEMATIC, Propulsor, prepare};
pub use quality::{ChannelSummary, MotionSummary, State, consistency, lag, noise_std};
pub use record::{Recorded, RecordedRun, RecordingSummary, record};
pub use rollover::begins_anew;
pub use samples::{Samples, Store, Values};
pub use segment::{Cut, Interval, Part, Segmentation, SpeedClasses, check_intervals};
pub use series::Series;
pub use setup::{ChannelSpec, Checksums, FileSpec, Format, QuaternionSpec, Setup, TimeSpec};
pub use ship::model::{Formula, Malformed};
pub use smoother::{local_quadratic, window_samples};
pub use source::{Kind, Naming, Source};
pub use stamp::{Moments, NoStamp, Stamps};
pub use suspicion::{WarningKind, WarningSummary};
pub use table::{Axis, ForceTable};
pub use thruster::{Law, Setting, Thruster};
pub use topics::{LOG_TIME, PUBLISH_TIME, bag_census, database_census, read_bag, read_database};
pub use totals::{ManeuverCount, Totals};
pub use unassembled::Unassembled;
pub use unit::{UNITS, Unit, factor, shaft_factor, unit};
