use std::fmt;

use refusal::Invalid;
use ship::engine::{Origin, Pose, Seen, Ship};
use trial::Piece;

use crate::leg::wrap;
use crate::{Autopilot, Fixed, Leg, Phase, Purpose, Side};

/// A sample of a simulated vessel.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Index of the leg.
    pub leg: usize,
    /// Whether an informative maneuver is being run.
    pub informative: bool,
    /// The vessel's pose.
    pub pose: Pose,
    /// u, v \[m/s\], r \[rad/s\].
    pub state: [f64; 3],
    /// Inputs held until the next sample.
    pub inputs: Vec<f64>,
}

/// A vessel's pose on a leg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Index of the leg.
    pub leg: usize,
    /// Its pose.
    pub pose: Pose,
}

/// The trajectory of a vessel along legs.
#[derive(Clone, Debug, PartialEq)]
pub struct Sailed {
    /// Every sample, in order.
    pub samples: Vec<Sample>,
    /// Pose and state at the end of each leg.
    pub ends: Vec<(Pose, [f64; 3])>,
}

/// A borrowed sample.
#[derive(Clone, Copy, Debug)]
pub struct Passing<'s> {
    /// Index of the leg.
    pub leg: usize,
    /// Whether an informative maneuver is being run.
    pub informative: bool,
    /// The vessel's pose.
    pub pose: Pose,
    /// u, v \[m/s\], r \[rad/s\].
    pub state: [f64; 3],
    /// Inputs held until the next sample.
    pub inputs: &'s [f64],
}

impl Sailed {
    /// The poses at all samples.
    pub fn fixes(&self) -> impl Iterator<Item = Fix> + '_ {
        self.samples.iter().map(|sample| Fix { leg: sample.leg, pose: sample.pose })
    }

    /// Simulates `legs`, see [`simulate_legs`].
    ///
    /// # Errors
    /// As [`simulate_legs`].
    pub fn of<'l>(
        legs: impl IntoIterator<Item = ([f64; 2], &'l Leg)>,
        pieces: &[Piece],
        mirror: &[f64],
        ship: &mut Ship,
        autopilot: &mut Autopilot,
    ) -> Result<Self, Invalid> {
        let mut samples = Vec::new();
        let ends = simulate_legs(legs, pieces, mirror, ship, autopilot, |now| samples.push(now.into()))?;
        Ok(Self { samples, ends })
    }
}

impl From<Passing<'_>> for Sample {
    fn from(Passing { leg, informative, pose, state, inputs }: Passing) -> Self {
        Self { leg, informative, pose, state, inputs: inputs.to_vec() }
    }
}

/// Why a vessel does not come to the end of its legs.
#[derive(Clone, Debug, PartialEq)]
pub enum Stopped {
    /// A maneuver that it does not complete in its time.
    Unfinished(Invalid),
    /// It cannot be commanded, or its simulation diverges.
    Lost(Invalid),
}

impl From<Invalid> for Stopped {
    fn from(invalid: Invalid) -> Self {
        Self::Lost(invalid)
    }
}

impl From<Stopped> for Invalid {
    fn from(stopped: Stopped) -> Self {
        let (Stopped::Unfinished(invalid) | Stopped::Lost(invalid)) = stopped;
        invalid
    }
}

/// Pose and state at the end of a leg.
pub type End = (Pose, [f64; 3]);

/// Simulates `legs`, each from its own node (north, east), starting with `ship` as it is. Pieces' inputs are multiplied by
/// `mirror` where they are run to the other side. Calls `record` with every sample and returns the ends of the legs.
///
/// # Errors
/// A maneuver that is not completed; a vessel that cannot be commanded; a simulation that diverges.
pub fn simulate_legs<'l>(
    legs: impl IntoIterator<Item = ([f64; 2], &'l Leg)>,
    pieces: &[Piece],
    mirror: &[f64],
    ship: &mut Ship,
    autopilot: &mut Autopilot,
    record: impl FnMut(Passing),
) -> Result<Vec<End>, Stopped> {
    simulate_with_ends(legs, (pieces, mirror), ship, autopilot, record, |_, _, _| Ok(()))
}

/// The same, with a call at the end of each leg.
pub(crate) fn simulate_with_ends<'l, 's, 'a>(
    legs: impl IntoIterator<Item = ([f64; 2], &'l Leg)>,
    (pieces, mirror): (&[Piece], &[f64]),
    ship: &mut Ship<'s>,
    autopilot: &mut Autopilot<'a>,
    mut record: impl FnMut(Passing),
    mut ended: impl FnMut(usize, &Ship<'s>, &Autopilot<'a>) -> Result<(), Stopped>,
) -> Result<Vec<End>, Stopped> {
    let mut ends = Vec::new();
    let seen = autopilot.see(Fixed::from(&*ship), false);
    let mut way = Way { ship, autopilot, seen, record: &mut record, inputs: Vec::new(), samples: 0 };
    for (index, (node, leg)) in legs.into_iter().enumerate() {
        for phase in &leg.phases {
            match (phase, &leg.purpose) {
                (Phase::Maneuver, Purpose::Informative { piece, side }) => {
                    let signs = if *side == Side::Mirrored { mirror } else { &[] };
                    way.run(index, &pieces[*piece], signs)?;
                }
                _ => way.follow(phase, node, index)?,
            }
        }
        ends.push((way.ship.pose, way.ship.state));
        ended(index, way.ship, way.autopilot)?;
    }
    Ok(ends)
}

/// Longest turn or line: numbers that lead to longer ones are meaningless, and would exhaust the memory.
const LONGEST_PHASE: usize = 20_000;

/// A vessel in progress.
struct Way<'w, 's, 'a> {
    ship: &'w mut Ship<'s>,
    autopilot: &'w mut Autopilot<'a>,
    /// The ship as the autopilot sees it.
    seen: Fixed,
    record: &'w mut dyn FnMut(Passing),
    inputs: Vec<f64>,
    /// So many of the voyage are simulated.
    samples: usize,
}

impl<'s> Way<'_, 's, '_> {
    /// Runs a piece, to the other side if there are `signs` of its inputs.
    fn run(&mut self, leg: usize, piece: &Piece, signs: &[f64]) -> Result<(), Stopped> {
        let (mut command, origin) = (piece.begin(), Origin::from(self.seen.pose));
        let side = if signs.is_empty() { 1.0 } else { -1.0 };
        self.inputs.resize(piece.inputs.len() / piece.samples, 0.0);
        let mut samples = 0;
        while !piece.is_over(&*command, samples, self.ship.sample_s()).map_err(Stopped::Unfinished)? {
            let ([u, v, r], pose) = (self.seen.state, origin.sees(self.seen.pose));
            let state = [u, side * v, side * r];
            let pose = Pose { x: pose.x, y: side * pose.y, psi: side * pose.psi };
            let seen = Seen { state, own: state, pose };
            command.command(&seen, &mut self.inputs);
            let mirror = |inputs: &mut [f64]| inputs.iter_mut().zip(signs).for_each(|(u, sign)| *u *= sign);
            mirror(&mut self.inputs);
            let mut ends = command.ends().map(|ends| ends.map(<[f64]>::to_vec));
            ends.iter_mut().flatten().for_each(|end| mirror(end));
            self.advance(leg, true, |ship, inputs| {
                ship.command(inputs, ends.as_ref().map(|ends| ends.each_ref().map(Vec::as_slice)))
            })?;
            samples += 1;
        }
        Ok(())
    }

    fn follow(&mut self, phase: &Phase, node: [f64; 2], leg: usize) -> Result<(), Invalid> {
        let start = self.seen.pose;
        let patience_s = self.autopilot.patience_s(phase, node, start);
        let mut elapsed_s = 0.0;
        while !self.autopilot.is_done(phase, node, &self.seen, elapsed_s > patience_s) {
            if elapsed_s > LONGEST_PHASE as f64 * self.ship.sample_s() {
                let expected = format!("at most {LONGEST_PHASE} samples of a turn or a line");
                let remedy = "correct `cell_m`, the speeds or `handling`";
                let elapsed = format!("over {elapsed_s:.0} s");
                return Err(Invalid::new("leg under way", elapsed, expected, remedy));
            }
            let inputs = self.autopilot.steer(phase, node, start, &self.seen)?;
            self.inputs.clear();
            self.inputs.extend_from_slice(inputs);
            self.advance(leg, false, Ship::reach)?;
            elapsed_s += self.ship.sample_s();
        }
        Ok(())
    }

    /// Advances by a sample with the inputs that `set` computes.
    fn advance(
        &mut self,
        leg: usize,
        informative: bool,
        set: impl for<'i> FnOnce(&'i mut Ship<'s>, &[f64]) -> &'i [f64],
    ) -> Result<(), Invalid> {
        let Self { ship, autopilot, seen, record, inputs, samples } = self;
        *samples += 1;
        let (pose, state) = (ship.pose, ship.state);
        let actual = set(ship, inputs);
        inputs.copy_from_slice(actual);
        *seen = autopilot.observe(*seen, inputs, Fixed::from(&**ship));
        record(Passing { leg, informative, pose, state, inputs });
        if ship.state.iter().all(|s| s.abs() <= ship::engine::DIVERGED) {
            return Ok(());
        }
        let what = if informative { "in a maneuver" } else { "under the autopilot" };
        let seconds = *samples as f64 * ship.sample_s();
        let diverged = format!("a simulation that diverges: {:.3?} after {seconds:.1} s", ship.state);
        let remedy = "shorten the maneuver, or check the signs of the parameters in vessel.toml";
        Err(Invalid::new(format!("model {what}, leg {}", leg + 1), diverged, "speeds within bounds", remedy))
    }
}

/// The distance from its node, and from a settled state there, within which a leg must end. It is the same
/// for all nodes, so legs that end within it from anywhere within it can be chained: errors do not grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Distance from the node \[m\].
    pub distance_m: f64,
    /// Difference from the level's heading \[rad\].
    pub heading_rad: f64,
    /// Difference from the mode's speed \[m/s\].
    pub surge_m_s: f64,
    /// Sway speed over the ground \[m/s\].
    pub sway_m_s: f64,
    /// Yaw rate \[rad/s\].
    pub yaw_rate_rad_s: f64,
}

/// A vessel near a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Astray {
    /// Its position relative to the node (north, east), and its heading.
    pub pose: Pose,
    /// u, v \[m/s\], r \[rad/s\].
    pub state: [f64; 3],
}

impl Astray {
    /// A vessel relative to `node`.
    pub fn of(pose: Pose, state: [f64; 3], [north, east]: [f64; 2]) -> Self {
        Self { pose: Pose { x: pose.x - north, y: pose.y - east, ..pose }, state }
    }

    /// Distance from the node \[m\].
    pub fn distance_m(&self) -> f64 {
        libm::hypot(self.pose.x, self.pose.y)
    }
}

/// Quantities that have a tolerance.
const QUANTITIES: [&str; 5] = ["position", "heading", "speed", "sway", "yaw rate"];

/// The used fractions of a tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Used {
    /// Of position, heading, speed, sway and yaw rate: 1 is the whole tolerance.
    Parts([f64; 5]),
    /// Of a vessel that does not complete its maneuver.
    Unfinished,
    /// Of a vessel that is lost.
    Lost,
}

impl Used {
    /// Nothing of it.
    pub const NONE: Self = Self::Parts([0.0; 5]);

    /// The largest fraction; infinite where there is none.
    pub fn part(&self) -> f64 {
        match self {
            Self::Parts(parts) => parts.iter().copied().fold(0.0, f64::max),
            Self::Unfinished | Self::Lost => f64::INFINITY,
        }
    }

    /// The larger fractions of two vessels, quantity by quantity.
    #[must_use]
    pub fn or_more(self, other: Self) -> Self {
        match (self, other) {
            (Self::Parts(parts), Self::Parts(others)) => {
                Self::Parts(std::array::from_fn(|k| parts[k].max(others[k])))
            }
            (Self::Lost, _) | (_, Self::Lost) => Self::Lost,
            _ => Self::Unfinished,
        }
    }
}

impl From<Stopped> for Used {
    fn from(stopped: Stopped) -> Self {
        match stopped {
            Stopped::Unfinished(_) => Self::Unfinished,
            Stopped::Lost(_) => Self::Lost,
        }
    }
}

/// Names every quantity that exceeds its tolerance, or the largest where none does.
impl fmt::Display for Used {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = match self {
            Self::Parts(parts) => parts,
            Self::Unfinished => return f.write_str("not done within its `duration_s` in the dictionary"),
            Self::Lost => return f.write_str("motion out of all bounds"),
        };
        let least = self.part().min(1.0);
        let is_said = |part: f64| part > 1.0 || part == least;
        let said = QUANTITIES.iter().zip(parts).filter(|(_, part)| is_said(**part));
        let said: Vec<String> = said.map(|(quantity, part)| format!("{quantity} {part:.1}")).collect();
        let whose = if said.len() > 1 { "their tolerances" } else { "its tolerance" };
        write!(f, "{} times {whose}", said.join(" and "))
    }
}

/// Fraction of the tolerance in which sampled vessels must end near their node, and from which they begin;
/// and of the offsets in heading, speed and yaw rate at the beginning.
const NEAR: f64 = 0.25;
const BEGUN: f64 = 0.5;

impl Tolerance {
    /// The stricter tolerance for the ends of sampled vessels, so that vessels that were not sampled still keep the whole one.
    #[must_use]
    pub fn ended(&self) -> Self {
        Self { distance_m: NEAR * self.distance_m, ..*self }
    }

    /// The tolerance for the beginnings of sampled vessels.
    #[must_use]
    pub fn begun(&self) -> Self {
        let Self { heading_rad, surge_m_s, yaw_rate_rad_s, .. } = *self;
        Self {
            heading_rad: BEGUN * heading_rad,
            surge_m_s: BEGUN * surge_m_s,
            yaw_rate_rad_s: BEGUN * yaw_rate_rad_s,
            ..self.ended()
        }
    }

    /// The used fractions of a vessel under way at `speed_m_s`, wherever it is.
    pub fn used_in_motion(&self, state: [f64; 3], speed_m_s: f64) -> Used {
        self.used(&Astray { pose: Pose::default(), state }, 0.0, speed_m_s)
    }

    /// The used fractions of a vessel at a node of `heading_rad` and `speed_m_s`.
    pub fn used(&self, vessel: &Astray, heading_rad: f64, speed_m_s: f64) -> Used {
        let [_, _, heading, surge, sway, yaw_rate] = self.off(vessel, heading_rad, speed_m_s).map(f64::abs);
        Used::Parts([vessel.distance_m() / self.distance_m, heading, surge, sway, yaw_rate])
    }

    /// The same with signs, and the position as north and east, for searches that compare vessels: north, east, heading, surge,
    /// sway, yaw rate.
    pub(crate) fn off(&self, vessel: &Astray, heading_rad: f64, speed_m_s: f64) -> [f64; 6] {
        let (Pose { x, y, psi }, [u, v, r]) = (vessel.pose, vessel.state);
        let [north, east] = [x, y].map(|metres| metres / self.distance_m);
        let heading = wrap(psi - heading_rad) / self.heading_rad;
        let surge = (u - speed_m_s) / self.surge_m_s;
        [north, east, heading, surge, v / self.sway_m_s, r / self.yaw_rate_rad_s]
    }
}
