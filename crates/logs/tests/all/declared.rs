//! How the channels of the tests' logs are declared.

use logs::{Body, Conventions, Frame, Heading, Lever, Method};

/// North, east, down; nothing is derived or averaged.
pub fn conventions(method: Method, rate_hz: f64) -> Conventions {
    Conventions {
        frame: Frame::Ned,
        heading: Heading::NorthClockwise,
        body: Body::Frd,
        lever: Lever::default(),
        window_s: 1.0,
        derived: Vec::new(),
        thrusters: Vec::new(),
        method,
        rate_hz,
        average_s: None,
    }
}
