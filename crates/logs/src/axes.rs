//! Velocities that are said to be along the ship's axes and are along those of the earth.

use refusal::Invalid;

use crate::quality::{Derivatives, at_most};
use crate::{Channels, Conventions, Frame, body_velocity};

/// Velocities are along the axes of the earth where they are less than this share as far off the derivative of position
/// there as along the ship's …
const NEARER: f64 = 0.5;

/// … and less than this share of the speed.
const NEAR: f64 = 0.3;

/// Fewest moments to judge by.
const MOMENTS: usize = 20;

/// Sums of squares over the moments at which all is known \[(m/s)²\].
#[derive(Default)]
struct Squares {
    moments: usize,
    speed: f64,
    /// Off the derivative of position along the ship's axes; along north and east; along east and north.
    off: [f64; 3],
}

/// Refuses measured `y_u` and `y_v` that follow the derivative of position in the axes of the earth and not in the ship's.
pub(crate) fn check_axes(
    channels: &Channels,
    derivatives: &Derivatives,
    conventions: &Conventions,
) -> Result<(), Invalid> {
    let (Some(u), Some(v), Some([north, east])) =
        (channels.get("y_u"), channels.get("y_v"), &derivatives.over_ground)
    else {
        return Ok(());
    };
    let Some(times) = at_most(u) else { return Ok(()) };
    let starboard = conventions.body.starboard();
    let measured = u.at(times.iter()).zip(v.at(times.iter()));
    let rates = north.at(times.iter()).zip(east.at(times.iter())).zip(derivatives.psi.at(times.iter()));
    let mut squares = Squares::default();
    for ((u, v), ((north, east), psi)) in measured.zip(rates) {
        if ![u, v, north, east, psi].iter().all(|value| value.is_finite()) {
            continue;
        }
        let own = starboard * v;
        squares.moments += 1;
        squares.speed += north * north + east * east;
        let axes = [
            ([u, v], body_velocity([north, east], psi)),
            ([u, own], [north, east]),
            ([u, own], [east, north]),
        ];
        for (sum, ([a, b], [c, d])) in squares.off.iter_mut().zip(axes) {
            *sum += (a - c) * (a - c) + (b - d) * (b - d);
        }
    }
    squares.check(conventions.frame)
}

impl Squares {
    fn check(&self, frame: Frame) -> Result<(), Invalid> {
        let mean = |sum: f64| (sum / self.moments.max(1) as f64).sqrt();
        let (speed, [body, first, second]) = (mean(self.speed), self.off.map(mean));
        let earth = first.min(second);
        if self.moments < MOMENTS || earth >= NEARER * body || earth >= NEAR * speed {
            return Ok(());
        }
        let along_x = (first <= second) == (frame == Frame::Ned);
        let names = if along_x { "`v_x` and `v_y`" } else { "`v_y` and `v_x`" };
        Err(Invalid::new(
            "channels `y_u` and `y_v`",
            format!(
                "velocities along the axes of the earth: {earth:.3} m/s off the derivative of position there, \
                 {body:.3} m/s off it along the ship's axes"
            ),
            "velocities along the ship's axes, forward and sideways",
            format!("call the channels {names}, which are turned by the heading, or leave them out"),
        ))
    }
}
