use std::f64::consts::{FRAC_PI_2, TAU};

use schemars::JsonSchema;
use serde::Deserialize;
use ship::engine::{Compiled, NormalRows, Pose, Ship, Streams};
use ship::model::Vessel;

/// One move of the lattice as a script for the autopilot. Positions are north and east of the start node \[m\],
/// headings compass \[rad\].
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// Its purpose.
    pub purpose: Purpose,
    /// Layer of the start node.
    pub from: usize,
    /// Displacement in nodes, east.
    pub di: i32,
    /// Displacement in nodes, north.
    pub dj: i32,
    /// Layer of the end node.
    pub to: usize,
    /// Its phases, in order.
    pub phases: Vec<Phase>,
}

/// The purpose of a leg.
#[derive(Clone, Debug, PartialEq)]
pub enum Purpose {
    /// Transit: name of the action.
    Basic(String),
    /// Using a piece of a maneuver.
    Informative {
        /// Index of the piece.
        piece: usize,
        /// The side.
        side: Side,
    },
}

impl Purpose {
    /// The index of a maneuver's piece.
    pub fn piece(&self) -> Option<usize> {
        if let Self::Informative { piece, .. } = self { Some(*piece) } else { None }
    }

    /// The side of a maneuver.
    pub fn side(&self) -> Option<Side> {
        if let Self::Informative { side, .. } = self { Some(*side) } else { None }
    }
}

refusal::choices! {
    /// Which way a maneuver is run.
    pub enum Side {
        /// As in the dictionary.
        AsDesigned = "as designed",
        /// To the other side.
        Mirrored = "mirrored",
    }
}

/// A part of a leg.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// Along the straight line that ends at `to`, speed changing evenly with distance.
    Line {
        /// End of the line.
        to: [f64; 2],
        /// Heading of the line.
        heading_rad: f64,
        /// Speed at its beginning \[m/s\].
        from_m_s: f64,
        /// Speed at its end \[m/s\].
        to_m_s: f64,
    },
    /// Along an arc.
    Arc {
        /// Its centre.
        centre: [f64; 2],
        /// Its radius \[m\].
        radius_m: f64,
        /// Heading at its end.
        to_rad: f64,
        /// +1 to starboard, −1 to port.
        side: f64,
        /// Speed \[m/s\].
        speed_m_s: f64,
    },
    /// At rest: to a place and heading, turning on the spot.
    Hold {
        /// The place.
        at: [f64; 2],
        /// The heading.
        heading_rad: f64,
    },
    /// The piece's commands.
    Maneuver,
}

impl Leg {
    /// The leg rotated to port by `quarters` quarter turns: without a known current all directions are equivalent.
    pub(crate) fn turned(&self, quarters: usize, grid: &Grid) -> Self {
        let ([dj, di], mut phases) = (turned([self.dj, self.di], quarters), self.phases.clone());
        phases.iter_mut().for_each(|phase| phase.turn(quarters));
        let [from, to] = [self.from, self.to].map(|layer| grid.turned(layer, quarters));
        Self { purpose: self.purpose.clone(), from, di, dj, to, phases }
    }
}

impl Phase {
    fn turn(&mut self, quarters: usize) {
        let by = |heading: &mut f64| *heading = wrap(*heading - quarters as f64 * FRAC_PI_2);
        match self {
            Self::Line { to, heading_rad, .. } => (*to, ()) = (turned(*to, quarters), by(heading_rad)),
            Self::Arc { centre, to_rad, .. } => (*centre, ()) = (turned(*centre, quarters), by(to_rad)),
            Self::Hold { at, heading_rad } => (*at, ()) = (turned(*at, quarters), by(heading_rad)),
            Self::Maneuver => {}
        }
    }
}

/// North and east, rotated to port by quarter turns.
pub(crate) fn turned<T: Copy + std::ops::Neg<Output = T>>([north, east]: [T; 2], quarters: usize) -> [T; 2] {
    match quarters % 4 {
        0 => [north, east],
        1 => [east, -north],
        2 => [-north, -east],
        _ => [-east, north],
    }
}

/// North and east, as along and across a heading, to starboard.
pub(crate) fn turned_back([north, east]: [f64; 2], heading_rad: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(heading_rad);
    [north * cos + east * sin, east * cos - north * sin]
}

/// The lattice at sea: nodes, heading levels, and the speeds that a vessel may have at a node.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Nodes eastward.
    pub nx: usize,
    /// Nodes northward.
    pub ny: usize,
    /// Heading levels H; level h points h · 360°/H counter-clockwise from east.
    pub headings: usize,
    /// Distance of neighbouring nodes \[m\].
    pub cell_m: f64,
    /// East and north of node (0, 0) \[m\].
    pub origin_m: [f64; 2],
    /// Speed modes, slowest first.
    pub modes: Vec<Mode>,
}

/// A speed that the vessel holds at a node.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mode {
    /// Its name.
    pub name: String,
    /// Surge speed over the ground \[m/s\]; 0: at rest.
    pub speed_m_s: f64,
}

impl Grid {
    /// Number of layers: heading levels of every mode.
    pub fn layers(&self) -> usize {
        self.headings * self.modes.len()
    }

    /// The layer of a heading level in a mode.
    pub fn layer(&self, level: usize, mode: usize) -> usize {
        mode * self.headings + level
    }

    /// Heading level and mode of a layer.
    pub fn level_and_mode(&self, layer: usize) -> (usize, usize) {
        (layer % self.headings, layer / self.headings)
    }

    /// The layer that results from `layer` by quarter turns to port.
    pub(crate) fn turned(&self, layer: usize, quarters: usize) -> usize {
        let (level, mode) = self.level_and_mode(layer);
        self.layer((level + quarters * self.headings / 4) % self.headings, mode)
    }

    /// Compass heading of a level \[rad\], in (−π, π].
    pub fn heading_rad(&self, level: usize) -> f64 {
        wrap(FRAC_PI_2 - TAU * level as f64 / self.headings as f64)
    }

    /// The level nearest to a compass heading \[rad\].
    pub fn nearest_level(&self, heading_rad: f64) -> usize {
        let turns = (FRAC_PI_2 - heading_rad) / TAU;
        (turns * self.headings as f64).round().rem_euclid(self.headings as f64) as usize
    }

    /// The mode whose speed is nearest to `speed_m_s`; `None` without modes.
    pub fn nearest_mode(&self, speed_m_s: f64) -> Option<usize> {
        let off = |m: &usize| (self.modes[*m].speed_m_s - speed_m_s).abs();
        (0..self.modes.len()).min_by(|a, b| off(a).total_cmp(&off(b)))
    }

    /// North and east of a node displaced by (di, dj) \[m\].
    pub fn displacement(&self, di: i32, dj: i32) -> [f64; 2] {
        [self.cell_m * f64::from(dj), self.cell_m * f64::from(di)]
    }

    /// The pose at a node.
    pub fn pose(&self, i: usize, j: usize, level: usize) -> Pose {
        Pose {
            x: self.origin_m[1] + self.cell_m * j as f64,
            y: self.origin_m[0] + self.cell_m * i as f64,
            psi: self.heading_rad(level),
        }
    }

    /// The shortest step from node to node that points along a level, to within a quarter of the levels' spacing.
    pub fn step_along(&self, level: usize) -> (i32, i32) {
        let (sin, cos) = libm::sincos(TAU * level as f64 / self.headings as f64);
        let off = |(di, dj): (i32, i32)| {
            let angle = libm::atan2(f64::from(dj), f64::from(di));
            wrap(angle - libm::atan2(sin, cos)).abs()
        };
        let tolerance = TAU / self.headings as f64 / 4.0;
        (1..=8)
            .find_map(|reach| {
                ring(reach).filter(|s| off(*s) <= tolerance).min_by(|a, b| off(*a).total_cmp(&off(*b)))
            })
            .unwrap_or((1, 0))
    }
}

/// Displacements that differ from (i, j) by no more than `reach` in either component.
pub(crate) fn around(i: i32, j: i32, reach: i32) -> impl Iterator<Item = (i32, i32)> {
    (i - reach..=i + reach).flat_map(move |di| (j - reach..=j + reach).map(move |dj| (di, dj)))
}

/// Displacements whose larger component is `reach`.
fn ring(reach: i32) -> impl Iterator<Item = (i32, i32)> {
    around(0, 0, reach).filter(move |(di, dj)| di.abs().max(dj.abs()) == reach)
}

/// An angle in (−π, π].
pub(crate) fn wrap(angle: f64) -> f64 {
    let turned = angle.rem_euclid(TAU);
    if turned > TAU / 2.0 { turned - TAU } else { turned }
}

/// Standard deviations of a ship's measurements, independent from sample to sample; 0 if exact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensors {
    /// Position, north and east each \[m\].
    pub position_m: f64,
    /// Heading \[rad\].
    pub heading_rad: f64,
    /// u and v \[m/s\].
    pub speed_m_s: f64,
    /// r \[rad/s\].
    pub yaw_rate_rad_s: f64,
}

/// A ship's position and motion: true, measured or estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fixed {
    /// Position and heading.
    pub pose: Pose,
    /// u, v \[m/s\], r \[rad/s\].
    pub state: [f64; 3],
}

/// Quantities that are measured: position, heading, u, v, r.
const MEASURED: usize = 6;

/// Measures a ship, and estimates where it is from noisy measurements and what its model predicts: an observer with
/// constant gains. Exact quantities are taken as measured.
#[derive(Clone, Debug)]
pub struct Navigation {
    sensors: Sensors,
    /// The fraction of a difference from the prediction that is believed, where a quantity is noisy.
    gain: f64,
    noise: NormalRows<MEASURED>,
    /// The prediction for the next sample.
    predicted: Option<Fixed>,
}

impl From<&Ship<'_>> for Fixed {
    fn from(ship: &Ship) -> Self {
        Self { pose: ship.pose, state: ship.state }
    }
}

impl Sensors {
    /// Whether everything is measured exactly.
    pub fn are_exact(&self) -> bool {
        *self == Self::default()
    }

    /// Each `part` times as large.
    pub(crate) fn times(self, part: f64) -> Self {
        Self {
            position_m: part * self.position_m,
            heading_rad: part * self.heading_rad,
            speed_m_s: part * self.speed_m_s,
            yaw_rate_rad_s: part * self.yaw_rate_rad_s,
        }
    }

    fn deviations(&self) -> [f64; MEASURED] {
        let Self { position_m, heading_rad, speed_m_s, yaw_rate_rad_s } = *self;
        [position_m, position_m, heading_rad, speed_m_s, speed_m_s, yaw_rate_rad_s]
    }
}

impl Navigation {
    /// Of run `run` of `streams`, smoothing over `memory` samples; `None` for exact sensors.
    pub fn new(sensors: Sensors, memory: f64, streams: Streams, run: u32) -> Option<Self> {
        let gain = 1.0 / memory.max(1.0);
        let noise = NormalRows::new(streams, run);
        (!sensors.are_exact()).then_some(Self { sensors, gain, noise, predicted: None })
    }

    /// The standard deviations that remain after smoothing: σ √(K / (2 − K)) for a gain of K.
    pub fn smoothed(&self) -> Sensors {
        let part = (self.gain / (2.0 - self.gain)).sqrt();
        self.sensors.times(part)
    }

    /// The fraction of what an estimate of u, v, r gains on its prediction that may count as a lasting error of the model:
    /// with as much as the gain K both estimates are still damped, by K / 2 at the frequency K.
    pub fn most_believed(&self) -> [f64; 3] {
        let Sensors { speed_m_s, yaw_rate_rad_s, .. } = self.sensors;
        [speed_m_s, speed_m_s, yaw_rate_rad_s].map(|noise| if noise > 0.0 { self.gain } else { 1.0 })
    }

    /// The estimate of a ship that is `truly` there, from its next measurement.
    pub fn estimate(&mut self, truly: Fixed) -> Fixed {
        let deviations = self.sensors.deviations();
        let noise = self.noise.next().unwrap_or_default();
        let measured: [f64; MEASURED] = std::array::from_fn(|i| deviations[i] * noise[i]);
        let numbers = |of: &Fixed| {
            let [u, v, r] = of.state;
            [of.pose.x, of.pose.y, of.pose.psi, u, v, r]
        };
        let (truth, predicted) = (numbers(&truly), numbers(&self.predicted.unwrap_or(truly)));
        let component = |i: usize| {
            let off = truth[i] + measured[i] - predicted[i];
            let off = if i == 2 { wrap(off) } else { off };
            predicted[i] + if deviations[i] > 0.0 { self.gain * off } else { off }
        };
        let [x, y, psi, u, v, r] = std::array::from_fn(component);
        Fixed { pose: Pose { x, y, psi }, state: [u, v, r] }
    }

    /// Predicts the next sample from an estimate of this one, and the motion that a model predicts.
    pub fn predict(&mut self, from: Fixed, state: [f64; 3], sample_s: f64) {
        let (Pose { x, y, psi }, [u, v, r]) = (from.pose, from.state);
        let (sin, cos) = libm::sincos(psi);
        let [north, east] = [u * cos - v * sin, u * sin + v * cos].map(|speed| speed * sample_s);
        let pose = Pose { x: x + north, y: y + east, psi: psi + r * sample_s };
        self.predicted = Some(Fixed { pose, state });
    }

    /// Forgets the prediction: the ship is put elsewhere.
    pub fn restart(&mut self) {
        self.predicted = None;
    }
}

/// The signs of the inputs that mirror the vessel's motion about its centre plane: u, −v, −r under `signs` · inputs
/// is the mirrored motion of u, v, r under inputs. `None` where the model is not symmetric.
///
/// All signs are tried by evaluating the nominal model at a few points.
pub fn mirror(vessel: &Vessel) -> Option<Vec<f64>> {
    let inputs = vessel.model.inputs;
    if inputs > 12 {
        return None;
    }
    let signs = |bits: u32| {
        (0..inputs).map(move |i| if bits >> i & 1 == 1 { -1.0 } else { 1.0 }).collect::<Vec<f64>>()
    };
    (0..1_u32 << inputs).map(signs).find(|signs| (1..=5).all(|point| is_mirrored(vessel, signs, point)))
}

fn is_mirrored(vessel: &Vessel, signs: &[f64], point: u32) -> bool {
    let value = |i: usize| libm::sin(f64::from(point) * 0.7 + i as f64 * 1.3);
    let count = vessel.model.exogenous();
    let mut inputs: Vec<f64> = (0..count).map(|i| if i < signs.len() { value(i + 3) } else { 0.0 }).collect();
    let mut mirrored: Vec<f64> =
        inputs.iter().enumerate().map(|(i, u)| signs.get(i).unwrap_or(&1.0) * u).collect();
    vessel.model.complete(&mut inputs);
    vessel.model.complete(&mut mirrored);
    let [u, v, r] = [0, 1, 2].map(value);
    let (a, b) = (increments(vessel, [u, v, r], &inputs), increments(vessel, [u, -v, -r], &mirrored));
    let close = |x: f64, y: f64| (x - y).abs() <= 1e-9 * (x.abs() + y.abs());
    close(a[0], b[0]) && close(a[1], -b[1]) && close(a[2], -b[2])
}

fn increments(vessel: &Vessel, states: [f64; 3], exogenous: &[f64]) -> [f64; 3] {
    let mut model = Compiled::new(&vessel.model, &vessel.nominal);
    model.look(states, exogenous, None);
    model.increments()
}
