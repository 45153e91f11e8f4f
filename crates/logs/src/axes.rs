//! Velocities that are declared along the ship's axes but were logged along the earth's.

use refusal::Invalid;

use crate::quality::{Derivatives, at_most};
use crate::{Channels, Conventions, Frame, body_velocity};

/// Velocities are taken to be along the earth's axes where their distance from the derivative of position
/// there is less than this share of that along the ship's axes …
const NEARER: f64 = 0.5;

/// … and less than this share of the speed.
const NEAR: f64 = 0.3;

/// Fewest moments to judge by.
const MOMENTS: usize = 20;

/// Sums of squares over the moments at which all channels are known \[(m/s)²\].
#[derive(Default)]
struct Squares {
    moments: usize,
    speed: f64,
    /// Of the difference from the derivative of position along the ship's axes; along north and east; along
    /// east and north.
    off: [f64; 3],
    /// Of the measured velocities; their inner and outer products with the derivatives along the ship's axes.
    measured: f64,
    products: [f64; 2],
}

/// The angle by which measured velocities are rotated against the derivative of position along the ship's
/// axes \[rad\], and the share of the squared difference that remains without that rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turned {
    pub(crate) angle: f64,
    pub(crate) left: f64,
}

/// Refuses measured `y_u` and `y_v` that follow the derivative of position along the earth's axes and not
/// along the ship's; else returns by how much they are rotated against it.
pub(crate) fn check_axes(
    channels: &Channels,
    derivatives: &Derivatives,
    conventions: &Conventions,
) -> Result<Option<Turned>, Invalid> {
    let (Some(u), Some(v), Some([north, east])) =
        (channels.get("y_u"), channels.get("y_v"), &derivatives.over_ground)
    else {
        return Ok(None);
    };
    let Some(times) = at_most(u) else { return Ok(None) };
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
        let body = body_velocity([north, east], psi);
        squares.measured += u * u + v * v;
        squares.products[0] += u * body[0] + v * body[1];
        squares.products[1] += v * body[0] - u * body[1];
        let axes = [([u, v], body), ([u, own], [north, east]), ([u, own], [east, north])];
        for (sum, ([a, b], [c, d])) in squares.off.iter_mut().zip(axes) {
            *sum += (a - c) * (a - c) + (b - d) * (b - d);
        }
    }
    squares.check(conventions.frame)?;
    Ok(squares.turned())
}

impl Squares {
    /// `None` where there are too few moments, or no motion.
    fn turned(&self) -> Option<Turned> {
        let [inner, outer] = self.products;
        let (length, off) = (libm::hypot(inner, outer), self.off[0]);
        let left = (self.measured + self.speed - 2.0 * length).max(0.0) / off;
        (self.moments >= MOMENTS && left.is_finite())
            .then(|| Turned { angle: libm::atan2(outer, inner), left })
    }

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
                "velocities along the axes of the earth: they differ from the derivative of position by {earth:.3} m/s \
                 there and by {body:.3} m/s along the ship's axes"
            ),
            "velocities along the ship's axes, forward and sideways",
            format!("call the channels {names}, which are rotated by the heading, or remove them"),
        ))
    }
}
