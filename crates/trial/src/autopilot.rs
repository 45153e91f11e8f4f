use serde::Deserialize;
use vessel::{Invalid, Motion, Pose, Steady, Vessel, check_numbers};

use crate::grid::wrap;
use crate::{Phase, Ship};

/// How the vessel is handled between informative maneuvers.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Handling {
    /// Largest yaw rate under autopilot \[rad/s\].
    pub turn_rate_rad_s: f64,
    /// Speed of repositioning at rest, in surge and sway \[m/s\].
    pub crawl_m_s: f64,
    /// Acceleration along a leg that changes speed \[m/s²\].
    pub acceleration_m_s2: f64,
    /// Time constant of keeping position, speed and heading \[s\].
    pub response_s: f64,
    /// Distance ahead at which a line is aimed at \[m\].
    pub lookahead_m: f64,
}

impl Handling {
    /// Refuses numbers without meaning, and those with which a leg would last for days: every leg is simulated to its end.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self) -> Result<(), Invalid> {
        let keys = [
            ("turn_rate_rad_s", self.turn_rate_rad_s, 1e-4..=10.0),
            ("crawl_m_s", self.crawl_m_s, 1e-3..=20.0),
            ("acceleration_m_s2", self.acceleration_m_s2, 1e-5..=100.0),
            ("response_s", self.response_s, 1e-3..=3600.0),
            ("lookahead_m", self.lookahead_m, 1e-3..=1e5),
        ];
        keys.into_iter().try_for_each(|(key, value, range)| {
            let expected = format!("a number from {} to {}", range.start(), range.end());
            check_numbers([(format!("handling.{key}"), value)], &expected, |value| range.contains(&value))
        })
    }
}

/// Steers a vessel along the phases of legs: line-of-sight guidance under way, position keeping at rest; each command
/// becomes the inputs that hold it steady.
#[derive(Clone, Debug)]
pub struct Autopilot<'a> {
    steady: Steady<'a>,
    inputs: usize,
    handling: Handling,
    /// North and east components of the current that it reckons with \[m/s\].
    pub known_current_m_s: [f64; 2],
    unknowns: Vec<f64>,
}

/// Speeds below this part of those that are used at rest count as being at rest.
const AT_REST: f64 = 0.1;

/// What the vessel is asked to do over the ground, in its own axes.
#[derive(Clone, Copy, Debug)]
struct Command {
    u: f64,
    v: Option<f64>,
    r: f64,
}

impl<'a> Autopilot<'a> {
    /// An autopilot that knows the vessel by `parameters`.
    pub fn new(vessel: &'a Vessel, parameters: &[f64], handling: Handling) -> Self {
        let (steady, inputs) = (Steady::new(vessel, parameters), vessel.model.inputs);
        Self { steady, inputs, handling, known_current_m_s: [0.0; 2], unknowns: vec![0.0; inputs + 1] }
    }

    /// Inputs for the next sample on `phase`, whose positions are relative to `node` (north, east); `start` is where the
    /// vessel was when the phase began.
    ///
    /// # Errors
    /// A command that no inputs hold.
    pub fn steer(
        &mut self,
        phase: &Phase,
        node: [f64; 2],
        start: Pose,
        ship: &Ship,
    ) -> Result<&[f64], Invalid> {
        let command = self.command(phase, node, start, ship);
        let [north, east] = self.known_current_m_s;
        let (sin, cos) = libm::sincos(ship.pose.psi);
        let motion = Motion {
            u: command.u - (north * cos + east * sin),
            v: command.v.map(|v| v - (east * cos - north * sin)),
            r: command.r,
        };
        self.hold(motion)
    }

    fn hold(&mut self, motion: Motion) -> Result<&[f64], Invalid> {
        // From the last solution if that leads somewhere, else afresh.
        let last = self.unknowns.clone();
        if self.steady.solve(motion, &mut self.unknowns).is_err() {
            self.unknowns.fill(0.0);
            if let Err(refusal) = self.steady.solve(motion, &mut self.unknowns) {
                self.unknowns = last;
                return Err(refusal);
            }
        }
        Ok(&self.unknowns[..self.inputs])
    }

    /// Whether `phase` is done, `elapsed_s` after it began.
    pub fn is_done(&self, phase: &Phase, node: [f64; 2], start: Pose, ship: &Ship, elapsed_s: f64) -> bool {
        let ahead = ship.state[0] * ship.sample_s() / 2.0;
        match *phase {
            Phase::Line { to, heading_rad, .. } => {
                let left = left_on_line(node, to, heading_rad, ship.pose);
                left <= ahead.max(0.0) || elapsed_s > self.patience_s(phase, node, start)
            }
            Phase::Arc { to_rad, side, .. } => {
                side * wrap(to_rad - course(phase, node, ship.pose)) <= 0.0
                    || elapsed_s > self.patience_s(phase, node, start)
            }
            Phase::Hold { at, heading_rad } => {
                let [north, east] = offset(node, at, ship.pose);
                let there =
                    libm::hypot(north, east) <= self.handling.crawl_m_s * self.handling.response_s / 20.0;
                let turned = wrap(heading_rad - ship.pose.psi).abs() <= 0.01;
                let [u, v, r] = ship.state;
                let h = &self.handling;
                let at_rest =
                    libm::hypot(u, v) <= AT_REST * h.crawl_m_s && r.abs() <= AT_REST * h.turn_rate_rad_s;
                (there && turned && at_rest) || elapsed_s > self.patience_s(phase, node, start)
            }
            Phase::Maneuver => true,
        }
    }

    /// How long a phase may take before it is given up: a position error then stays, and is reported \[s\].
    fn patience_s(&self, phase: &Phase, node: [f64; 2], start: Pose) -> f64 {
        let h = &self.handling;
        match *phase {
            Phase::Line { to, from_m_s, to_m_s, .. } => {
                let [north, east] = offset(node, to, start);
                let speed = ((from_m_s + to_m_s) / 2.0).max(h.crawl_m_s);
                2.0 * libm::hypot(north, east) / speed + 5.0 * h.response_s
            }
            Phase::Arc { radius_m, speed_m_s, .. } => {
                std::f64::consts::TAU * radius_m / speed_m_s.max(h.crawl_m_s) + 5.0 * h.response_s
            }
            Phase::Hold { at, heading_rad } => {
                let [north, east] = offset(node, at, start);
                let turn = wrap(heading_rad - start.psi).abs() / h.turn_rate_rad_s;
                libm::hypot(north, east) / h.crawl_m_s + turn + 5.0 * h.response_s
            }
            Phase::Maneuver => 0.0,
        }
    }

    fn command(&self, phase: &Phase, node: [f64; 2], start: Pose, ship: &Ship) -> Command {
        let h = &self.handling;
        match *phase {
            Phase::Line { to, heading_rad, from_m_s, to_m_s } => {
                let whole = left_on_line(node, to, heading_rad, start);
                let left = left_on_line(node, to, heading_rad, ship.pose);
                let part = if whole > 0.0 { (1.0 - left / whole).clamp(0.0, 1.0) } else { 1.0 };
                let speed = (from_m_s.powi(2) + part * (to_m_s.powi(2) - from_m_s.powi(2))).max(0.0).sqrt();
                let [north, east] = offset(node, to, ship.pose);
                let across = north * libm::sin(heading_rad) - east * libm::cos(heading_rad);
                let aim = heading_rad - libm::atan(across / h.lookahead_m);
                self.under_way(speed.max(h.crawl_m_s), aim, 0.0, ship)
            }
            Phase::Arc { centre, radius_m, side, speed_m_s, .. } => {
                let [north, east] = offset(node, centre, ship.pose);
                let across = side * (radius_m - libm::hypot(north, east));
                // Outside the arc (negative for starboard) the aim is turned inwards.
                let aim = course(phase, node, ship.pose) - libm::atan(across / h.lookahead_m);
                self.under_way(speed_m_s, aim, side * speed_m_s / radius_m, ship)
            }
            Phase::Hold { at, heading_rad } => {
                let [north, east] = offset(node, at, ship.pose);
                let (sin, cos) = libm::sincos(ship.pose.psi);
                let limit = |x: f64| (x / h.response_s).clamp(-h.crawl_m_s, h.crawl_m_s);
                let u = urged(limit(north * cos + east * sin), ship.state[0]);
                let v = Some(urged(limit(east * cos - north * sin), ship.state[1]));
                Command { u, v, r: self.yaw(heading_rad, 0.0, ship) }
            }
            Phase::Maneuver => Command { u: ship.state[0], v: None, r: 0.0 },
        }
    }

    fn under_way(&self, u: f64, aim_rad: f64, turn_rad_s: f64, ship: &Ship) -> Command {
        let u = urged(u, ship.state[0]);
        Command { u, v: None, r: self.yaw(aim_rad, turn_rad_s, ship) }
    }

    fn yaw(&self, heading_rad: f64, turn_rad_s: f64, ship: &Ship) -> f64 {
        let h = &self.handling;
        let wanted = turn_rad_s + 4.0 * wrap(heading_rad - ship.pose.psi) / h.response_s;
        let limit = h.turn_rate_rad_s.max(turn_rad_s.abs() * 1.2);
        wanted.clamp(-limit, limit)
    }
}

/// A speed to ask for so that `wanted` is reached in about a third of the time that the inputs which hold it take.
fn urged(wanted: f64, actual: f64) -> f64 {
    wanted + 2.0 * (wanted - actual)
}

/// North and east from the vessel to `place`, which is relative to `node`.
fn offset(node: [f64; 2], place: [f64; 2], pose: Pose) -> [f64; 2] {
    [node[0] + place[0] - pose.x, node[1] + place[1] - pose.y]
}

/// Distance left along a line.
fn left_on_line(node: [f64; 2], to: [f64; 2], heading_rad: f64, pose: Pose) -> f64 {
    let [north, east] = offset(node, to, pose);
    north * libm::cos(heading_rad) + east * libm::sin(heading_rad)
}

/// Course of an arc abeam of the vessel \[rad\].
fn course(phase: &Phase, node: [f64; 2], pose: Pose) -> f64 {
    match *phase {
        Phase::Arc { centre, side, .. } => {
            let [north, east] = offset(node, centre, pose);
            // The centre lies abeam: 90° to starboard of the course on a starboard arc.
            wrap(libm::atan2(east, north) - side * std::f64::consts::FRAC_PI_2)
        }
        _ => pose.psi,
    }
}
