//! Channels that are wanted, and those that were found.

/// A channel that is wanted of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Needed {
    /// Its name, such as `delta`.
    pub channel: String,
    /// Its unit in the model.
    pub unit: String,
}

/// A column that was given a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// Its name.
    pub column: String,
    /// The channel.
    pub channel: String,
    /// Its unit in the log.
    pub unit: String,
    /// Whether the channel was found by a name that is not its own.
    pub is_channel_guessed: bool,
    /// Whether the name of the column says no unit.
    pub is_unit_guessed: bool,
    /// Whether a model can do without it.
    pub is_optional: bool,
}

/// The unit of numbers up to `largest` whose column says none: angles beyond a turn are in degrees.
pub(super) fn usual_unit(unit: &str, largest: f64) -> &str {
    const TURN: f64 = 2.0 * std::f64::consts::PI + 0.1;
    match unit {
        "rad" if largest > TURN => "deg",
        "rad/s" if largest > TURN => "deg/s",
        "1/s" if largest > 60.0 => "rpm",
        other => other,
    }
}
