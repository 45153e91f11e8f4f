//! Simulates the logs of a ship's instruments: from forces to thruster commands, thrusters with limits, a
//! ship in current and wind, sensors with noise and resolution.
//!
//! A [`Chain`] is the ship with its thrusters and sensors; [`Chain::record`] simulates one sub-experiment, a
//! [`Logbook`] all those of a [`Schedule`]. Every random number is keyed by (seed, maneuver, repeat,
//! channel), so that recordings do not depend on each other.

mod actuator;
mod logbook;
mod motion;
mod recording;
mod sensor;
mod text;
mod weather;
mod wind;

pub use actuator::{Actuator, Hits, Logged};
pub use logbook::{Day, Entry, Fault, Logbook, NoLogs, Schedule, force_factors};
pub use motion::{Pace, advance};
pub use recording::{Chain, Commanded, Failed, Key, Recording, Truth};
pub use sensor::{Compass, Gnss, quantised};
pub use weather::{Drift, GaussMarkov, Weather};
pub use wind::{Hull, Wind};

use refusal::{Invalid, check_numbers};

fn finite<const N: usize>(numbers: [(&str, f64); N]) -> Result<(), Invalid> {
    check_numbers(numbers, "a finite number", |_| true)
}

fn from_zero<const N: usize>(numbers: [(&str, f64); N]) -> Result<(), Invalid> {
    check_numbers(numbers, "a number from 0 on", |value| value >= 0.0)
}

fn above_zero<const N: usize>(numbers: [(&str, f64); N]) -> Result<(), Invalid> {
    check_numbers(numbers, "a number above 0", |value| value > 0.0)
}
