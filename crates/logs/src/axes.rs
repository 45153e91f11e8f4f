//! Velocities that are declared along the ship's axes but were logged along the earth's.

use numerics::statistics::median;
use refusal::Invalid;

use crate::quality::{Derivatives, at_most};
use crate::{Channels, Conventions, Frame, Series, body_velocity};

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

/// Share of the greatest yaw rate up to which a ship does not turn.
const STRAIGHT: f64 = 0.25;

/// Places that are looked at, at most.
const MOST: usize = 20_000;

/// By how much the course over ground lies to starboard of the heading where the ship goes ahead and does not turn \[rad\];
/// `None` where her speed is measured along both axes, where she turns nearly throughout, and where it varies.
pub(crate) fn drift(channels: &Channels, derivatives: &Derivatives) -> Option<f64> {
    let [north, east] = derivatives.over_ground.as_ref()?;
    if channels.contains_key("y_u") && channels.contains_key("y_v") {
        return None;
    }
    let times = at_most(&derivatives.psi)?;
    let times: Vec<f64> = times.iter().step_by(times.len().div_ceil(MOST).max(1)).collect();
    let at = |series: &Series| series.at(times.iter().copied()).collect::<Vec<f64>>();
    let [north, east, psi, rate] = [north, east, &derivatives.psi, &derivatives.r].map(at);
    let all = (0..times.len()).map(|i| {
        let [ahead, aside] = body_velocity([north[i], east[i]], psi[i]);
        (libm::hypot(ahead, aside), rate[i].abs(), libm::atan2(aside, ahead))
    });
    let all: Vec<_> = all.filter(|(speed, rate, _)| speed.is_finite() && rate.is_finite()).collect();
    let most = |of: fn(&(f64, f64, f64)) -> f64| all.iter().map(of).fold(0.0, f64::max);
    let (speed, rate) = (most(|own| own.0), most(|own| own.1));
    let straight: Vec<f64> =
        all.iter().filter(|own| own.0 > 0.5 * speed && own.1 <= STRAIGHT * rate).map(|own| own.2).collect();
    let middle = median(straight.clone())?;
    let spread = median(straight.iter().map(|own| (own - middle).abs()).collect())?;
    let is_ahead = middle.abs() < std::f64::consts::FRAC_PI_2;
    (straight.len() >= MOMENTS.max(all.len() / 10) && is_ahead && middle.abs() > 2.0 * spread)
        .then_some(middle)
}
