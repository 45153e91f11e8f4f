//! The channels that a ship's forces depend on, and their units.

use refusal::{Invalid, foreign};

/// An input or measured disturbance, in the order of a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Between which it stays, if that is known.
    pub range: Option<[f64; 2]>,
}

/// A channel as a component uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driven {
    /// Its place in a row.
    pub channel: usize,
    /// What its unit is in that of the component.
    pub factor: f64,
}

/// What a component expects of a channel: units, with what each is in the first one.
pub(crate) type Units = [(&'static str, f64)];

/// Revolutions per second.
pub(crate) const REVOLUTIONS: &Units = &[
    ("1/s", 1.0),
    ("rps", 1.0),
    ("Hz", 1.0),
    ("rpm", 1.0 / 60.0),
    ("1/min", 1.0 / 60.0),
    ("rad/s", 0.5 * std::f64::consts::FRAC_1_PI),
];
/// Angles.
pub(crate) const ANGLES: &Units =
    &[("rad", 1.0), ("deg", std::f64::consts::PI / 180.0), ("°", std::f64::consts::PI / 180.0)];
/// Forces.
pub(crate) const FORCES: &Units = &[("N", 1.0), ("kN", 1e3)];
/// Speeds.
pub(crate) const SPEEDS: &Units = &[("m/s", 1.0), ("kn", 1852.0 / 3600.0)];

/// The channel `name` that the key `key` of `owner` needs, in one of `units`; in any without them.
///
/// # Errors
/// No such channel, or another unit.
pub(crate) fn driven(
    channels: &[Channel],
    owner: &str,
    key: &str,
    name: &str,
    units: &Units,
) -> Result<Driven, Invalid> {
    let Some(channel) = channels.iter().position(|own| own.name == name) else {
        let known = channels.iter().map(|own| own.name.as_str());
        return Err(Invalid::unknown(format!("`{key}` of `{}`", foreign(owner)), name, known));
    };
    let unit = channels[channel].unit.as_str();
    if units.is_empty() {
        return Ok(Driven { channel, factor: 1.0 });
    }
    let factor = units.iter().find(|(own, _)| *own == unit).map(|(_, factor)| *factor);
    let factor = factor.ok_or_else(|| {
        let expected: Vec<&str> = units.iter().map(|(own, _)| *own).collect();
        let found = format!("channel `{}` in `{}`", foreign(name), foreign(unit));
        let thing = format!("`{key}` of `{}`", foreign(owner));
        Invalid::new(thing, found, expected.join(", "), "state the channel in one of these units")
    })?;
    Ok(Driven { channel, factor })
}
