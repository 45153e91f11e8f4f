use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

use chart::Plane;
use refusal::Invalid;
use thiserror::Error;

use crate::series::Sampler;
use crate::{Body, Formula, Frame, Heading, Lever, Method, Series, Thruster, body_velocity};

/// Channels by name, each on its own clock.
pub type Channels = BTreeMap<String, Series>;

/// Channels of motion and their units: velocities over ground in body axes or along x and y, position and heading, or
/// geographic position.
pub const KINEMATIC: [(&str, &str); 10] = [
    ("y_u", "m/s"),
    ("y_v", "m/s"),
    ("y_r", "rad/s"),
    ("v_x", "m/s"),
    ("v_y", "m/s"),
    ("x", "m"),
    ("y", "m"),
    ("psi", "rad"),
    ("latitude_deg", "rad"),
    ("longitude_deg", "rad"),
];

/// Names of the channels that the thrusters' forces are added to.
const FORCES: [&str; 3] = ["tau1", "tau2", "tau3"];

/// The axes and the point that the channels were measured in and about, what is computed from them, and how
/// they are put on one clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Conventions {
    /// Axes of `x` and `y`.
    pub frame: Frame,
    /// The zero and the sense of `psi`.
    pub heading: Heading,
    /// Axes of `y_u`, `y_v`, `y_r`.
    pub body: Body,
    /// From the reference point to the antenna.
    pub lever: Lever,
    /// Length of the parabolas that velocities are taken from, with [`Method::Smoother`], and yaw rates,
    /// where the lever arm needs one and none is measured \[s\].
    pub window_s: f64,
    /// Computed channels; each may use the earlier ones.
    pub derived: Vec<Derived>,
    /// Thrusters, whose forces make up `tau1`, `tau2`, `tau3`.
    pub thrusters: Vec<Propulsor>,
    /// How velocities that are not measured are made from positions.
    pub method: Method,
    /// The common rate \[Hz\].
    pub rate_hz: f64,
    /// Every channel is averaged over this time before it is resampled \[s\].
    pub average_s: Option<f64>,
}

/// A thruster and the channels that drive it.
#[derive(Clone, Debug, PartialEq)]
pub struct Propulsor {
    /// Its position and force; with a table, the force that is added to the table's.
    pub thruster: Thruster,
    /// Channel of its speed \[1/s\].
    pub speed: String,
    /// Channel of its angle, for azimuth thrusters: from forward to starboard \[rad\].
    pub angle: Option<String>,
    /// Its force from speed, and from the pitch in a channel if it has one.
    pub table: Option<(ForceTable, Option<String>)>,
}

impl Propulsor {
    /// The channels of its speed, angle and pitch, if it has them.
    fn channels(&self) -> [Option<&String>; 3] {
        let pitch = self.table.as_ref().and_then(|(_, pitch)| pitch.as_ref());
        [Some(&self.speed), self.angle.as_ref(), pitch]
    }

    /// Its forces at these values of speed, angle and pitch, as far as it has them.
    fn forces(&self, [speed, angle, pitch]: [f64; 3]) -> Result<[f64; 3], Unassembled> {
        let Some((table, channel)) = &self.table else { return Ok(self.thruster.forces(speed, angle)) };
        let outside = |(axis, value, range)| {
            let channel = if axis == Axis::Speed { Some(&self.speed) } else { channel.as_ref() };
            Unassembled::OutsideTable { channel: channel.cloned().unwrap_or_default(), value, range }
        };
        Ok(self.thruster.forces(table.force(speed, pitch).map_err(outside)?, angle))
    }
}

/// A channel computed from others.
#[derive(Clone, Debug, PartialEq)]
pub struct Derived {
    /// Its name.
    pub channel: String,
    /// How it is computed.
    pub formula: Formula,
    /// Its unit.
    pub unit: String,
}

/// Converts measured channels to x north, y east, psi clockwise from north, body x forward, y starboard, z
/// down, moves them to the reference point, and adds the computed channels. A computed channel is on the
/// clock of its first source, the others are interpolated.
///
/// # Errors
/// A missing source; positions that start nowhere on Earth, or at a pole.
pub fn prepare(mut channels: Channels, conventions: &Conventions) -> Result<Channels, Unassembled> {
    let frame = if plane(&mut channels)? { Frame::Ned } else { conventions.frame };
    turn(&mut channels, frame, conventions);
    move_to_reference(&mut channels, conventions);
    for Derived { channel, formula, .. } in &conventions.derived {
        let series = combine(&channels, &formula.channels, |values| formula.evaluate(values))?;
        channels.insert(channel.clone(), series);
    }
    add_forces(&mut channels, conventions)?;
    Ok(channels)
}

/// Latitude and longitude to x north and y east on the plane about the first point; `false` if there are none.
fn plane(channels: &mut Channels) -> Result<bool, Unassembled> {
    let (Some(latitude), Some(longitude)) =
        (channels.remove("latitude_deg"), channels.remove("longitude_deg"))
    else {
        return Ok(false);
    };
    let points = || {
        let longitudes = longitude.at(latitude.t.iter());
        latitude.values.iter().zip(longitudes).map(|(lat, lon)| [lat, lon].map(f64::to_degrees))
    };
    let [lat, lon] = points().find(|[_, lon]| lon.is_finite()).unwrap_or_default();
    let plane = Plane::new((lon + 180.0).rem_euclid(360.0) - 180.0, lat).map_err(|_| Unassembled::NoPlane)?;
    let place = |[lat, lon]: [f64; 2]| if lon.is_finite() { plane.to_plane(lon, lat) } else { [f64::NAN; 2] };
    let [mut east, mut north] = [latitude.values.none(), latitude.values.none()];
    for [x, y] in points().map(place) {
        east.push(x);
        north.push(y);
    }
    for (name, values) in [("x", north), ("y", east)] {
        channels.insert(name.to_owned(), latitude.with(values));
    }
    Ok(true)
}

fn turn(channels: &mut Channels, frame: Frame, conventions: &Conventions) {
    if let (Some(x), Some(y)) = (channels.remove("x"), channels.remove("y")) {
        let [north, east] = frame.north_east(x, y);
        channels.extend([("x".to_owned(), north), ("y".to_owned(), east)]);
    }
    let starboard = conventions.body.starboard();
    for (name, series) in
        channels.iter_mut().filter(|(name, _)| ["psi", "y_v", "y_r"].contains(&name.as_str()))
    {
        let taken = std::mem::replace(series, Series::new(&[], &[], 0.0));
        *series = match name.as_str() {
            "psi" => taken.map(|psi| conventions.heading.from_north(psi)),
            _ => taken.map(|value| starboard * value),
        };
    }
    turn_velocities(channels, conventions.frame);
}

/// Rotates velocities along x and y into the ship's axes, with the heading at the times of the first.
fn turn_velocities(channels: &mut Channels, frame: Frame) {
    let Some(psi) = channels.get("psi").cloned() else { return };
    if let (Some(x), Some(y)) = (channels.remove("v_x"), channels.remove("v_y")) {
        let [north, east] = frame.north_east(x, y);
        channels.extend([("y_u".to_owned(), north), ("y_v".to_owned(), east)]);
        pairwise(channels, ["y_u", "y_v"], &psi, body_velocity);
    }
}

fn move_to_reference(channels: &mut Channels, conventions: &Conventions) {
    let lever = conventions.lever;
    if lever.is_zero() {
        return;
    }
    if let Some(psi) = channels.get("psi").cloned() {
        pairwise(channels, ["x", "y"], &psi, |point, psi| lever.position(point, psi));
    }
    let slope = || channels.get("psi").map(|psi| psi.smoothed(conventions.window_s).1);
    if let Some(r) = channels.get("y_r").cloned().or_else(slope) {
        pairwise(channels, ["y_u", "y_v"], &r, |velocity, r| lever.velocity(velocity, r));
    }
}

/// Applies `f` to both channels and `third`, on the clock of the first; both must be there.
fn pairwise(
    channels: &mut Channels,
    names: [&str; 2],
    third: &Series,
    f: impl Fn([f64; 2], f64) -> [f64; 2],
) {
    let [Some(first), Some(second)] = names.map(|name| channels.get(name).cloned()) else { return };
    let [mut changed, mut other] = [first.values.none(), first.values.none()];
    let (seconds, thirds) = (second.at(first.t.iter()), third.at(first.t.iter()));
    for ((a, b), c) in first.values.iter().zip(seconds).zip(thirds) {
        let [a, b] = f([a, b], c);
        changed.push(a);
        other.push(b);
    }
    for (name, values) in names.into_iter().zip([changed, other]) {
        channels.insert(name.to_owned(), first.with(values));
    }
}

/// `f` of the channels called `names`, on the clock of the first.
fn combine(
    channels: &Channels,
    names: &[String],
    mut f: impl FnMut(&[f64]) -> f64,
) -> Result<Series, Unassembled> {
    let source = |name: &String| channels.get(name).ok_or_else(|| Unassembled::NoChannel(name.clone()));
    let sources: Vec<&Series> = names.iter().map(source).collect::<Result<_, _>>()?;
    let Some(first) = sources.first() else { return Ok(Series::new(&[], &[], 0.0)) };
    let mut samplers: Vec<Sampler> = sources.iter().map(|series| Sampler::new(series)).collect();
    let mut row = vec![0.0; samplers.len()];
    let values = first.t.iter().map(|time| {
        row.iter_mut().zip(&mut samplers).for_each(|(value, sampler)| *value = sampler.at(time));
        f(&row)
    });
    Ok(first.with(first.values.made(values)))
}

fn add_forces(channels: &mut Channels, conventions: &Conventions) -> Result<(), Unassembled> {
    let mut names: Vec<String> = Vec::new();
    let mut place_of = |name: &String| {
        names.iter().position(|known| known == name).unwrap_or_else(|| {
            names.push(name.clone());
            names.len() - 1
        })
    };
    let placed = |thruster| (thruster, Propulsor::channels(thruster).map(|name| name.map(&mut place_of)));
    let thrusters: Vec<(&Propulsor, [Option<usize>; 3])> = conventions.thrusters.iter().map(placed).collect();
    if thrusters.is_empty() {
        return Ok(());
    }
    // A tunnel thruster pushes to starboard; without a pitch channel the table has no pitch.
    let absent = [0.0, FRAC_PI_2, 0.0];
    let mut outside = None;
    for (i, force) in FORCES.into_iter().enumerate() {
        let made = combine(channels, &names, |values| {
            let forces = thrusters.iter().map(|(thruster, places)| {
                let settings = std::array::from_fn(|k| places[k].map_or(absent[k], |place| values[place]));
                thruster.forces(settings)
            });
            let one = |forces: Result<[f64; 3], Unassembled>| match forces {
                Ok(forces) => forces[i],
                Err(error) => {
                    outside.get_or_insert(error);
                    f64::NAN
                }
            };
            forces.map(one).sum()
        })?;
        if let Some(error) = outside {
            return Err(error);
        }
        channels.insert(force.to_owned(), made);
    }
    Ok(())
}

/// Rows beyond which a clock is taken to have jumped: three years at 1 Hz.
pub(crate) const MOST_ROWS: usize = 100_000_000;

/// Why channels could not be put on one clock.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Unassembled {
    /// A channel is missing.
    #[error("no channel `{0}`")]
    NoChannel(String),
    /// A channel has no value at all.
    #[error("no value in channel `{0}`")]
    Empty(String),
    /// Geographic positions that start beyond 89° of latitude, where a plane has no north.
    #[error("positions that start beyond 89 deg of latitude")]
    NoPlane,
    /// There is no time at which all channels are known: they start after others end, or there is a gap everywhere.
    #[error("no two neighbouring samples at which all channels are known")]
    NoOverlap,
    /// A thruster leaves its table.
    #[error("{value} in channel `{channel}`")]
    OutsideTable {
        /// The channel of its speed or pitch.
        channel: String,
        /// The value there.
        value: f64,
        /// The table's range.
        range: [f64; 2],
    },
    /// The clocks span more rows than allowed: one of them jumped, or memory does not suffice.
    #[error("clocks that span {rows} rows")]
    TooLong {
        /// Rows that they span.
        rows: usize,
        /// The most rows allowed.
        most: usize,
    },
}

/// Forces \[N\] at speeds, and at pitches if there are any, interpolated linearly.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceTable {
    speeds: Vec<f64>,
    /// A single unused one where the table has no pitch.
    pitches: Vec<f64>,
    /// Row by row: all speeds at the first pitch, and so on.
    forces: Vec<f64>,
}

impl ForceTable {
    /// A table over `speeds` alone, or over `pitches` too: then with a row of `forces` for each.
    ///
    /// # Errors
    /// Speeds or pitches that do not increase, or forces that are not numbers or not one for each point.
    pub fn new(speeds: Vec<f64>, pitches: Option<Vec<f64>>, forces: Vec<Vec<f64>>) -> Result<Self, Invalid> {
        let axes = [("speed", Some(&speeds)), ("pitch", pitches.as_ref())];
        for (name, places) in axes.into_iter().filter_map(|(name, places)| Some((name, places?))) {
            let rising = places.windows(2).all(|pair| pair[0] < pair[1]);
            if places.len() < 2 || !rising || places.iter().any(|place| !place.is_finite()) {
                let twice = format!("{places:?}");
                let expected = "at least two numbers that increase";
                return Err(Invalid::new(format!("`{name}` of a table"), twice, expected, "correct them"));
            }
        }
        let pitches = pitches.unwrap_or_else(|| vec![0.0]);
        let whole = forces.len() == pitches.len() && forces.iter().all(|row| row.len() == speeds.len());
        if !whole || forces.iter().flatten().any(|force| !force.is_finite()) {
            let lengths: Vec<usize> = forces.iter().map(Vec::len).collect();
            let expected = format!(
                "{} rows of {} numbers: a row per pitch, a force per speed",
                pitches.len(),
                speeds.len()
            );
            let shape = format!("rows of {lengths:?} numbers");
            return Err(Invalid::new("forces of a table", shape, expected, "correct them"));
        }
        Ok(Self { speeds, pitches, forces: forces.concat() })
    }

    /// The force at a speed and a pitch, which a table without pitches ignores; NaN where either is NaN.
    ///
    /// # Errors
    /// The value outside of the table, and the table's range.
    pub fn force(&self, speed: f64, pitch: f64) -> Result<f64, (Axis, f64, [f64; 2])> {
        let pitched = self.pitches.len() > 1;
        if speed.is_nan() || pitched && pitch.is_nan() {
            return Ok(f64::NAN);
        }
        let (n, along) = place(&self.speeds, speed).map_err(|range| (Axis::Speed, speed, range))?;
        let row = |p: usize| {
            let row = &self.forces[p * self.speeds.len()..];
            row[n] + along * (row[n + 1] - row[n])
        };
        if !pitched {
            return Ok(row(0));
        }
        let (p, across) = place(&self.pitches, pitch).map_err(|range| (Axis::Pitch, pitch, range))?;
        let (low, high) = (row(p), row(p + 1));
        Ok(low + across * (high - low))
    }
}

/// An axis of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The speed.
    Speed,
    /// The pitch.
    Pitch,
}

/// The interval of `places` that contains `at`, and the fraction along it; the whole range where `at` lies outside.
fn place(places: &[f64], at: f64) -> Result<(usize, f64), [f64; 2]> {
    let (first, last) = (places[0], places[places.len() - 1]);
    if !(first..=last).contains(&at) {
        return Err([first, last]);
    }
    let i = (places.partition_point(|place| *place <= at) - 1).min(places.len() - 2);
    Ok((i, (at - places[i]) / (places[i + 1] - places[i])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_plane_is_met_everywhere_and_nothing_outside() {
        let plane = |n: f64, p: f64| 3.0 + 2.0 * n - 0.5 * p;
        let (speeds, pitches) = (vec![-2.0, 0.5, 4.0], vec![-10.0, 0.0, 20.0]);
        let forces = pitches.iter().map(|p| speeds.iter().map(|n| plane(*n, *p)).collect()).collect();
        let table = ForceTable::new(speeds.clone(), Some(pitches), forces).unwrap();
        for (n, p) in [(-2.0, -10.0), (4.0, 20.0), (0.5, 0.0), (1.3, 7.0), (-0.2, -3.0)] {
            assert!((table.force(n, p).unwrap() - plane(n, p)).abs() < 1e-12);
        }
        assert_eq!(table.force(4.1, 0.0), Err((Axis::Speed, 4.1, [-2.0, 4.0])));
        assert_eq!(table.force(0.0, -11.0), Err((Axis::Pitch, -11.0, [-10.0, 20.0])));
        assert!(table.force(f64::NAN, 0.0).unwrap().is_nan());
        let line = ForceTable::new(speeds, None, vec![vec![-8.0, 0.0, 7.0]]).unwrap();
        assert_eq!([line.force(4.0, 0.0), line.force(-1.0, f64::NAN)], [Ok(7.0), Ok(-4.8)]);
    }
}
