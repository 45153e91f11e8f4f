//! Measured velocities that contradict position and heading in time, size or direction.

use std::f64::consts::TAU;
use std::ops::Range;

use numerics::statistics::median;
use refusal::Invalid;

use crate::columns::cell_of;
use crate::quality::{Derivatives, at_most, correlations};
use crate::suspicion::{Oddity, WarningKind};
use crate::{
    Cells, ChannelSpec, Channels, Conventions, Frame, MotionSummary, QuaternionSpec, Samples, Series,
    body_velocity, unit,
};

/// From where on a contradiction is a warning, and from where on the recording is doubtful, so that estimates
/// refuse it by default.
struct AxisBounds {
    warned: f64,
    broken: f64,
}

/// In seconds, and in samples of the common rate: the larger one counts.
const LAG_S: AxisBounds = AxisBounds { warned: 0.25, broken: 2.0 };
const LAG_SAMPLES: AxisBounds = AxisBounds { warned: 0.75, broken: 2.0 };

/// Distance of the slope from 1.
const GAIN: AxisBounds = AxisBounds { warned: 0.2, broken: 0.5 };

/// Rotation of the velocities against the derivative of position \[rad\] …
const TURN: AxisBounds = AxisBounds { warned: 0.0175, broken: 0.0873 };

/// … where without it less than this share of the squared difference remains.
const LEFT: f64 = 0.5;

/// The course over ground against the heading where the ship does not turn \[rad\].
const DRIFT: f64 = 0.0873;

/// The contradictions within a recording.
pub(crate) struct Contradictions {
    /// Warnings, by channel.
    pub(crate) warnings: Vec<(String, Oddity)>,
    /// Why estimates refuse the recording by default, in words.
    pub(crate) broken: Vec<String>,
}

impl Contradictions {
    /// Compares measured velocities with position and heading, on a common clock of `rate_hz`.
    pub(crate) fn of(motion: &[Option<MotionSummary>; 3], turned: Option<Turned>, rate_hz: f64) -> Self {
        let mut checked = Self { warnings: Vec::new(), broken: Vec::new() };
        for (channel, of, motion) in [("y_u", "position"), ("y_v", "position"), ("y_r", "heading")]
            .into_iter()
            .zip(motion)
            .filter_map(|((channel, of), motion)| Some((channel, of, motion.as_ref()?)))
        {
            checked.lag(channel, of, motion, rate_hz);
            checked.gain(channel, of, motion);
        }
        checked.turn(turned);
        checked
    }

    fn note(&mut self, channel: &'static str, kind: WarningKind, text: String, is_broken: bool) {
        if is_broken {
            self.broken.push(format!("`{channel}` {text}"));
        }
        self.warnings.push((channel.to_owned(), (kind, 1, text)));
    }

    /// Notes that channels cover different times, that the course lies `drift` \[rad\] off the heading, and channels whose unit
    /// changes.
    pub(crate) fn also(
        &mut self,
        uncovered: Option<(String, Oddity)>,
        drift: Option<f64>,
        changed: Vec<(String, Oddity)>,
    ) {
        if let Some(drift) = drift.filter(|drift| drift.abs() > DRIFT) {
            let text = format!(
                "differs by {:.1} deg from the course over ground where the ship does not turn: a variation that is missing or \
                 applied twice, a rotated sensor, or a current and wind?",
                -drift.to_degrees()
            );
            self.note("psi", WarningKind::Bias, text, false);
        }
        self.broken.extend(changed.iter().map(|(channel, (_, _, text))| format!("`{channel}` {text}")));
        self.warnings.extend(uncovered.into_iter().chain(changed));
    }

    fn lag(&mut self, channel: &'static str, of: &str, motion: &MotionSummary, rate_hz: f64) {
        let at_least = |s: f64, samples: f64| s.max(samples / rate_hz);
        let Some(lag_s) = motion.lag_s.filter(|lag| lag.abs() > at_least(LAG_S.warned, LAG_SAMPLES.warned))
        else {
            return;
        };
        let when = if lag_s > 0.0 { "after" } else { "before" };
        let text = format!(
            "comes {:.2} s {when} the derivative of {of}: compare the clocks, or set `delay_s`",
            lag_s.abs()
        );
        let is_broken = lag_s.abs() > at_least(LAG_S.broken, LAG_SAMPLES.broken);
        self.note(channel, WarningKind::Lag, text, is_broken);
    }

    fn gain(&mut self, channel: &'static str, of: &str, motion: &MotionSummary) {
        let Some(gain) = motion.gain.filter(|gain| (gain - 1.0).abs() > GAIN.warned) else { return };
        let text = format!("is {gain:.3} times the derivative of {of}: check the units and scales of both");
        self.note(channel, WarningKind::Gain, text, (gain - 1.0).abs() > GAIN.broken);
    }

    fn turn(&mut self, turned: Option<Turned>) {
        let Some(Turned { angle, .. }) =
            turned.filter(|turned| turned.angle.abs() > TURN.warned && turned.left < LEFT)
        else {
            return;
        };
        let text = format!(
            "differs by {:.1} deg throughout from what `y_u`, `y_v` and position imply: a magnetic heading, \
             or a rotated sensor?",
            angle.to_degrees()
        );
        self.note("psi", WarningKind::Bias, text, angle.abs() > TURN.broken);
    }
}

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
    /// Of the difference from the derivative of position along the ship's axes; along north and east; along east and north.
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
        let sway = starboard * v;
        squares.moments += 1;
        squares.speed += north * north + east * east;
        let body = body_velocity([north, east], psi);
        squares.measured += u * u + v * v;
        squares.products[0] += u * body[0] + v * body[1];
        squares.products[1] += v * body[0] - u * body[1];
        let axes = [([u, v], body), ([u, sway], [north, east]), ([u, sway], [east, north])];
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
    let (speed, rate) = (most(|moment| moment.0), most(|moment| moment.1));
    let straight: Vec<f64> = all
        .iter()
        .filter(|moment| moment.0 > 0.5 * speed && moment.1 <= STRAIGHT * rate)
        .map(|moment| moment.2)
        .collect();
    let middle = median(straight.clone())?;
    let spread = median(straight.iter().map(|angle| (angle - middle).abs()).collect())?;
    let is_ahead = middle.abs() < std::f64::consts::FRAC_PI_2;
    (straight.len() >= MOMENTS.max(all.len() / 10) && is_ahead && middle.abs() > 2.0 * spread)
        .then_some(middle)
}

/// Heading, roll and pitch \[rad\] of the quaternion in `cells` (w, x, y, z), as far as `spec` names channels for them:
/// rotations about the vertical, the forward and the transverse axis, in this order. `line` says on which line a row stands.
pub(crate) fn angles(
    spec: &QuaternionSpec,
    cells: [Cells; 4],
    line: impl Fn(usize) -> String,
) -> Result<Vec<Cells>, Invalid> {
    let [w, x, y, z] = cells.map(|cells| {
        let Cells::Numbers(numbers) = cells else { unreachable!("quaternions are read as numbers") };
        numbers
    });
    let [mut heading, mut roll, mut pitch] = [w.none(), w.none(), w.none()];
    let rows = w.iter().zip(x.iter()).zip(y.iter().zip(z.iter()));
    for (row, ((w, x), (y, z))) in rows.enumerate() {
        let q = [w, x, y, z];
        check(spec, q, || line(row))?;
        let norm = (w * w + x * x + y * y + z * z).sqrt();
        let [yaw, own_roll, own_pitch] = of_unit(q.map(|part| part / norm));
        heading.push(yaw);
        roll.push(own_roll);
        pitch.push(own_pitch);
    }
    let roll = spec.roll.is_some().then_some(roll);
    let pitch = spec.pitch.is_some().then_some(pitch);
    Ok([Some(heading), roll, pitch].into_iter().flatten().map(Cells::Numbers).collect())
}

/// Refuses quaternions that are not the rotation of a ship; one with a missing component is missing.
fn check(spec: &QuaternionSpec, [w, x, y, z]: [f64; 4], line: impl Fn() -> String) -> Result<(), Invalid> {
    let length = libm::sqrt(w * w + x * x + y * y + z * z);
    let called = || cell_of(line(), &spec.columns().map(String::as_str).join("`, `"));
    if (length - 1.0).abs() > spec.tolerance {
        return Err(Invalid::new(
            called(),
            format!("a quaternion of length {length:.4}"),
            format!("length 1, give or take {}", spec.tolerance),
            "correct or empty the row, check the columns, or raise the quaternion's `tolerance`",
        ));
    }
    // Compares the ship's vertical with the earth's.
    if 1.0 - 2.0 * (x * x + y * y) < 0.0 {
        return Err(Invalid::new(
            called(),
            "a quaternion that puts the ship upside down",
            "one from forward, starboard, down to north, east, down, or from forward, port, up to east, north, up",
            "check the order of the columns w, x, y, z and the axes",
        ));
    }
    Ok(())
}

/// Yaw, roll and pitch of a unit quaternion.
fn of_unit([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    let yaw = libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
    let roll = libm::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y));
    // Rounding may exceed a right angle slightly.
    let pitch = libm::asin((2.0 * (w * y - z * x)).clamp(-1.0, 1.0));
    [yaw, roll, pitch]
}

// Channels whose unit changes within a recording: their size changes by the ratio of two units at a moment, and the motion
// does not.

/// Ratios of units by what is measured, with their names, the larger number first.
const RATIOS: [(&str, f64, &str); 7] = [
    ("rad", 360.0 / TAU, "deg and rad"),
    ("rad/s", 360.0 / TAU, "deg/s and rad/s"),
    ("rad/s", 60.0, "deg/min and deg/s"),
    ("1/s", 60.0, "rpm and rps"),
    ("1/s", TAU, "rad/s and rps"),
    ("m/s", 3600.0 / 1852.0, "kn and m/s"),
    ("m/s", 3.6, "km/h and m/s"),
];

/// Values that are compared at most, and the fewest on either side.
const MOST_COMPARED: usize = 2000;
const FEWEST: usize = 8;

/// Correlation from which an angle and the turning belong together.
const CORRELATED: f64 = 0.5;

/// The oddity of the channel of `spec`, if its unit changes.
pub(crate) fn rescaled(
    spec: &ChannelSpec,
    channels: &Channels,
    derivatives: Option<&Derivatives>,
) -> Option<Oddity> {
    let (series, si) = (channels.get(&spec.channel)?, unit(&spec.unit)?.si);
    let turning = || derivatives.map(|derivatives| &derivatives.r);
    let motion = match (si, spec.channel.as_str()) {
        ("rad", "psi" | "roll" | "pitch" | "wind_from" | "latitude_deg" | "longitude_deg") => return None,
        ("rad", _) => Some(channels.get("y_r").or_else(turning)?),
        ("rad/s", "y_r") => Some(turning()?),
        ("1/s", _) => Some(channels.get("y_u")?),
        ("m/s", "y_u") => None,
        _ => return None,
    };
    let every = series.t.len().div_ceil(MOST_COMPARED).max(1);
    let (times, values): (Vec<f64>, Vec<f64>) =
        series.t.iter().zip(series.values.iter()).step_by(every).unzip();
    let known = |value: f64| if value.is_finite() { value } else { 0.0 };
    let motion: Option<Vec<f64>> = motion.map(|signal| signal.at(times.iter().copied()).map(known).collect());
    let (k, size) = split(&values)?;
    let is_near = |size: f64, ratio: f64, most: f64| libm::log(size / ratio).abs() < libm::log(most);
    let fits = |(of, ratio, _): &&(&str, f64, &str)| {
        let ratio = if size > 1.0 { *ratio } else { 1.0 / ratio };
        let value = |i: usize| if i < k { values[i] } else { ratio * values[i] };
        let mut steps: Vec<f64> = (1..values.len()).map(|i| (value(i) - value(i - 1)).abs()).collect();
        let step = steps[k - 1];
        steps.sort_by(f64::total_cmp);
        let usual = steps[steps.len() * 9 / 10];
        let goes_on = step <= 4.0 * usual + 0.02 * values[k - 1].abs();
        let belongs = |motion: &[f64], part: Range<usize>| {
            let [changed, other] =
                [values.as_slice(), motion].map(|all| Samples::from(all[part.clone()].to_vec()));
            si == "1/s"
                || correlations(&changed, &other, part.len() / 4)
                    .iter()
                    .any(|correlation| correlation.abs() >= CORRELATED)
        };
        let stays = |motion: &Vec<f64>| {
            let [before, after] = [&motion[..k], &motion[k..]].map(mean_square);
            let is_same = is_near((before / after).sqrt(), 1.0, 2.0);
            is_same && belongs(motion, 0..k) && belongs(motion, k..values.len())
        };
        *of == si
            && goes_on
            && is_near(size, ratio, 2.0)
            && motion.as_ref().map_or_else(
                // A ship cannot lose half of her speed from one value to the next.
                || is_near(size, ratio, 1.3) && (values[k] - values[k - 1]).abs() > 8.0 * usual,
                stays,
            )
    };
    let (_, ratio, units) = RATIOS.iter().find(fits)?;
    let how = if size > 1.0 { "smaller" } else { "larger" };
    let text = format!(
        "is {ratio:.3} times {how} from {:.1} s of the recording on, and the motion goes on as before: its unit may change there \
         ({units}); cut the log there, and ingest each part with its own `unit`",
        times[k]
    );
    Some((WarningKind::Unit, 1, text))
}

fn mean_square(of: &[f64]) -> f64 {
    of.iter().map(|value| value * value).sum::<f64>() / of.len() as f64
}

/// The index from which on `values` have another size, and the ratio of the sizes before and after: by the likelihood of
/// normal values.
fn split(values: &[f64]) -> Option<(usize, f64)> {
    let cost = |k: &usize| {
        let [before, after] = [&values[..*k], &values[*k..]].map(mean_square);
        *k as f64 * libm::log(before) + (values.len() - k) as f64 * libm::log(after)
    };
    let inner = FEWEST..values.len().saturating_sub(FEWEST);
    let all = inner.map(|k| (cost(&k), k)).filter(|(cost, _)| cost.is_finite());
    let (_, k) = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((k, (mean_square(&values[..k]) / mean_square(&values[k..])).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The product of rotations about z, y and x by these angles.
    fn turned(yaw: f64, pitch: f64, roll: f64) -> [f64; 4] {
        let product = |[a, b, c, d]: [f64; 4], [e, f, g, h]: [f64; 4]| {
            [
                a * e - b * f - c * g - d * h,
                a * f + b * e + c * h - d * g,
                a * g - b * h + c * e + d * f,
                a * h + b * g - c * f + d * e,
            ]
        };
        let half = |angle: f64| (libm::sin(0.5 * angle), libm::cos(0.5 * angle));
        let ((sz, cz), (sy, cy), (sx, cx)) = (half(yaw), half(pitch), half(roll));
        product(product([cz, 0.0, 0.0, sz], [cy, 0.0, sy, 0.0]), [cx, sx, 0.0, 0.0])
    }

    #[test]
    fn law_the_angles_that_a_quaternion_was_made_of_come_back() {
        for (yaw, pitch, roll) in [(0.3, 0.1, -0.2), (3.1, -1.2, 0.7), (-2.0, 0.0, 1.5), (0.0, 1.5, 0.0)] {
            let angles = of_unit(turned(yaw, pitch, roll));
            for (angles, expected) in angles.into_iter().zip([yaw, roll, pitch]) {
                assert!((angles - expected).abs() < 1e-12, "{angles} {expected}");
            }
        }
    }
}
