//! The criteria of IMO MSC.137(76).

/// The greatest first overshoot in a 10°/10° zig-zag \[°\], for a ship that covers her length in `seconds`.
pub(super) fn overshoot_10_first(seconds: f64) -> f64 {
    match seconds {
        _ if seconds < 10.0 => 10.0,
        _ if seconds >= 30.0 => 20.0,
        _ => 5.0 + 0.5 * seconds,
    }
}

/// The greatest second one \[°\].
pub(super) fn overshoot_10_second(seconds: f64) -> f64 {
    match seconds {
        _ if seconds < 10.0 => 25.0,
        _ if seconds >= 30.0 => 40.0,
        _ => 17.5 + 0.75 * seconds,
    }
}

/// The greatest first overshoot in a 20°/20° zig-zag \[°\].
pub(super) const OVERSHOOT_20: f64 = 25.0;
/// Of a turning circle \[ship lengths\].
pub(super) const ADVANCE: f64 = 4.5;
/// Of a turning circle \[ship lengths\].
pub(super) const TACTICAL_DIAMETER: f64 = 5.0;
/// Track run with 10° of helm until the heading has changed by 10° \[ship lengths\].
pub(super) const INITIAL_TURNING: f64 = 2.5;
/// Track reach of a full astern stop \[ship lengths\]; it says nothing of stops with less, nor of inertial ones.
pub(super) const STOPPING: f64 = 15.0;
