//! What a ship's instruments would have logged: forces to thruster commands, thrusters with limits, a ship in current and
//! wind, sensors with noise and resolution.
//!
//! A [`Chain`] is the ship with its thrusters and sensors; [`Chain::record`] sails one sub-experiment, a [`Logbook`] all
//! those of a [`Schedule`]. Every random number is keyed by (seed, maneuver, repeat, channel), so that a recording depends
//! on no other.

mod actuator;
mod logbook;
mod motion;
mod recording;
mod sensor;
mod text;
mod weather;
mod wind;

pub use actuator::{Actuator, Hits};
pub use logbook::{Day, Entry, FORCES, Logbook, LogbookError, Schedule, force_factors};
pub use motion::{Pace, advance};
pub use recording::{Chain, Failed, Key, Recording, Truth};
pub use sensor::{Compass, Gnss, quantised};
pub use weather::{Drift, GaussMarkov, Weather};
pub use wind::{Hull, Wind};

use vessel::Invalid;

/// Refuses the first of `numbers` (key, value) that is not finite or below `least`.
fn check(least: f64, numbers: &[(&str, f64)]) -> Result<(), Invalid> {
    match numbers.iter().find(|(_, value)| !(value.is_finite() && *value >= least)) {
        None => Ok(()),
        Some((key, value)) => Err(Invalid::new(
            format!("`{key}`"),
            value.to_string(),
            if least == f64::MIN {
                "a finite number".to_owned()
            } else {
                format!("a number from {least} on")
            },
            "correct it",
        )),
    }
}

/// Refuses the first of `numbers` (key, value) that is not finite and above 0.
fn check_positive(numbers: &[(&str, f64)]) -> Result<(), Invalid> {
    match numbers.iter().find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
        None => Ok(()),
        Some((key, value)) => {
            Err(Invalid::new(format!("`{key}`"), value.to_string(), "a number above 0", "correct it"))
        }
    }
}
