use maneuver::{Motion, Steady};
use refusal::Invalid;
use ship::engine::{Compiled, Pose, Streams};
use ship::model::Vessel;

use crate::handling::{COURSE, MEMORY, MOST_AT_ONCE, SPEED, YAW_RATE};
use crate::leg::wrap;
use crate::{Fixed, Handling, Navigation, Phase, Sensors};

/// Steers a vessel along the phases of legs: line-of-sight guidance of the course over the ground under way,
/// position keeping at rest. Commands are accelerations, which [`Inversion`] converts to inputs.
#[derive(Clone, Debug)]
pub struct Autopilot<'a> {
    inversion: Inversion<'a>,
    handling: Handling,
    sample_s: f64,
    /// North and east components of the current that it accounts for \[m/s\].
    pub known_current_m_s: [f64; 2],
    /// How it measures the ship; exactly without it.
    navigation: Option<Navigation>,
    /// What it sees of the ship, unless that is exact.
    seen: Option<Fixed>,
}

/// Time over which noisy measurements are smoothed, as a fraction of the response time.
const SMOOTHED: f64 = 0.25;
/// How many standard deviations of its estimate a ship at rest may seem to be off, besides what it may be.
const SEEMS: f64 = 1.0;
/// Speeds below this fraction of the crawl speed count as being at rest.
const AT_REST: f64 = 0.1;
/// The commanded motion over the ground, in body axes.
#[derive(Clone, Copy, Debug)]
struct Command {
    u: f64,
    /// The commanded change of u \[m/s²\].
    acceleration: f64,
    v: Option<f64>,
    r: f64,
}

impl<'a> Autopilot<'a> {
    /// An autopilot whose model has these `parameters`.
    pub fn new(vessel: &'a Vessel, parameters: &[f64], handling: Handling) -> Self {
        let inversion = Inversion::new(vessel, parameters, handling.response_s / MEMORY);
        let sample_s = 1.0 / vessel.sample_rate_hz;
        let (navigation, seen) = (None, None);
        Self { inversion, handling, sample_s, known_current_m_s: [0.0; 2], navigation, seen }
    }

    /// The same with noisy sensors: run `run` of `streams`.
    #[must_use]
    pub fn with_sensors(mut self, sensors: Sensors, streams: Streams, run: u32) -> Self {
        let memory = SMOOTHED * self.handling.response_s / self.sample_s;
        self.navigation = Navigation::new(sensors, memory, streams, run);
        if let Some(navigation) = &self.navigation {
            self.inversion.limit_belief(navigation.most_believed());
        }
        self
    }

    /// What it sees of a ship that is `truly` there; `anew` if the ship has been put there.
    pub fn see(&mut self, truly: Fixed, anew: bool) -> Fixed {
        let Some(navigation) = &mut self.navigation else { return truly };
        if anew {
            (self.seen, ()) = (None, navigation.restart());
        }
        *self.seen.get_or_insert_with(|| navigation.estimate(truly))
    }

    /// Inputs for the next sample on `phase`, whose positions are relative to `node` (north, east); `start`
    /// is the pose at the beginning of the phase, `seen` the ship as it sees it.
    ///
    /// # Errors
    /// A vessel without the required inputs.
    pub fn steer(&mut self, phase: &Phase, node: [f64; 2], at: Pose, fix: &Fixed) -> Result<&[f64], Invalid> {
        let (command, sample_s) = (self.command(phase, node, at, fix), self.sample_s);
        let part = |of: f64| (of * sample_s / self.handling.response_s).min(MOST_AT_ONCE);
        let [u, v, r] = fix.state;
        let gains = Gains {
            u: command.acceleration * sample_s + part(SPEED) * (command.u - u),
            v: part(SPEED) * (command.v.unwrap_or(0.0) - v),
            sway: command.v.is_some(),
            r: part(YAW_RATE) * (command.r - r),
        };
        let current = self.known_current(fix.pose);
        self.inversion.inputs(fix.state, current, &gains)
    }

    /// Observes the step from `seen` to where the ship `truly` is, under `inputs`, including open-loop ones; returns
    /// what it sees then.
    pub fn observe(&mut self, seen: Fixed, inputs: &[f64], truly: Fixed) -> Fixed {
        let current = self.known_current(seen.pose);
        let next = match &mut self.navigation {
            None => truly,
            Some(navigation) => {
                let state = self.inversion.predicted(seen.state, inputs, current);
                navigation.predict(seen, state, self.sample_s);
                let next = navigation.estimate(truly);
                self.seen = Some(next);
                next
            }
        };
        self.inversion.observe(seen.state, inputs, current, next.state);
        next
    }

    /// Along and across the vessel.
    fn known_current(&self, pose: Pose) -> [f64; 2] {
        let [north, east] = self.known_current_m_s;
        if [north, east] == [0.0; 2] {
            return [0.0; 2];
        }
        let (sin, cos) = libm::sincos(pose.psi);
        [north * cos + east * sin, east * cos - north * sin]
    }

    /// Whether `phase` is complete; if it `is_late`, position errors are ignored.
    pub fn is_done(&self, phase: &Phase, node: [f64; 2], seen: &Fixed, is_late: bool) -> bool {
        let ahead = seen.state[0] * self.sample_s / 2.0;
        match *phase {
            Phase::Line { to, heading_rad, .. } => {
                let left = along(offset(node, to, seen.pose), libm::sincos(heading_rad));
                left <= ahead.max(0.0) || is_late
            }
            Phase::Arc { to_rad, side, .. } => {
                side * wrap(to_rad - course(phase, node, seen.pose)) <= 0.0 || is_late
            }
            Phase::Hold { at, heading_rad } => {
                let [north, east] = offset(node, at, seen.pose);
                let (h, unsure) = (&self.handling, self.unsure());
                let there = libm::hypot(north, east) <= h.crawl_m_s * h.response_s / 20.0 + unsure.position_m;
                let turned = wrap(heading_rad - seen.pose.psi).abs() <= 0.01 + unsure.heading_rad;
                let [u, v, r] = seen.state;
                let at_rest = libm::hypot(u, v) <= AT_REST * h.crawl_m_s + unsure.speed_m_s
                    && r.abs() <= AT_REST * h.turn_rate_rad_s + unsure.yaw_rate_rad_s;
                (there && turned && at_rest) || is_late
            }
            Phase::Maneuver => true,
        }
    }

    /// How far off a ship may seem that is where it should be.
    fn unsure(&self) -> Sensors {
        self.navigation.as_ref().map_or(Sensors::default(), Navigation::smoothed).times(SEEMS)
    }

    /// The time after which a phase is late and given up: its position error then remains, and is reported \[s\].
    pub fn patience_s(&self, phase: &Phase, node: [f64; 2], start: Pose) -> f64 {
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

    fn command(&self, phase: &Phase, node: [f64; 2], start: Pose, seen: &Fixed) -> Command {
        let h = &self.handling;
        match *phase {
            Phase::Line { to, heading_rad, from_m_s, to_m_s } => {
                let (sin, cos) = libm::sincos(heading_rad);
                let [north, east] = offset(node, to, seen.pose);
                let whole = along(offset(node, to, start), (sin, cos));
                let left = along([north, east], (sin, cos));
                let part = if whole > 0.0 { (1.0 - left / whole).clamp(0.0, 1.0) } else { 1.0 };
                let squares = to_m_s.powi(2) - from_m_s.powi(2);
                let speed = (from_m_s.powi(2) + part * squares).max(0.0).sqrt().max(h.crawl_m_s);
                let acceleration = if whole > 0.0 { squares / (2.0 * whole) } else { 0.0 };
                let across = north * sin - east * cos;
                let aim = heading_rad - libm::atan(across / h.lookahead_m);
                Command { u: speed, acceleration, v: None, r: self.towards(aim, 0.0, seen) }
            }
            Phase::Arc { centre, radius_m, side, speed_m_s, .. } => {
                let [north, east] = offset(node, centre, seen.pose);
                let across = side * (radius_m - libm::hypot(north, east));
                // Outside the arc (negative for starboard) the aim is turned inwards.
                let aim = course(phase, node, seen.pose) - libm::atan(across / h.lookahead_m);
                let r = self.towards(aim, side * speed_m_s / radius_m, seen);
                Command { u: speed_m_s, acceleration: 0.0, v: None, r }
            }
            Phase::Hold { at, heading_rad } => {
                let [north, east] = offset(node, at, seen.pose);
                let (sin, cos) = libm::sincos(seen.pose.psi);
                let limit = |x: f64| (x / h.response_s).clamp(-h.crawl_m_s, h.crawl_m_s);
                let v = Some(limit(east * cos - north * sin));
                let r = self.yaw(wrap(heading_rad - seen.pose.psi), 0.0);
                Command { u: limit(north * cos + east * sin), acceleration: 0.0, v, r }
            }
            Phase::Maneuver => Command { u: seen.state[0], acceleration: 0.0, v: None, r: 0.0 },
        }
    }

    /// The yaw rate that turns the course over the ground towards `aim_rad` on a path that turns by `turn_rad_s`.
    fn towards(&self, aim_rad: f64, turn_rad_s: f64, seen: &Fixed) -> f64 {
        let [u, v, _] = seen.state;
        let course = seen.pose.psi + libm::atan2(v, u.max(self.handling.crawl_m_s));
        self.yaw(wrap(aim_rad - course), turn_rad_s)
    }

    fn yaw(&self, off_rad: f64, turn_rad_s: f64) -> f64 {
        let h = &self.handling;
        let limit = h.turn_rate_rad_s.max(turn_rad_s.abs() * 1.2);
        (turn_rad_s + COURSE * off_rad / h.response_s).clamp(-limit, limit)
    }
}

/// North and east from the vessel to `place`, which is relative to `node`.
fn offset(node: [f64; 2], place: [f64; 2], pose: Pose) -> [f64; 2] {
    [node[0] + place[0] - pose.x, node[1] + place[1] - pose.y]
}

/// The component of a displacement, north and east, along a heading of this sine and cosine.
fn along([north, east]: [f64; 2], (sin, cos): (f64, f64)) -> f64 {
    north * cos + east * sin
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

/// Most steps of Newton's method per sample; a model that is linear in its inputs needs one.
const STEPS: usize = 5;
/// Residuals below this fraction of a metre per second (or radian) in a sample count as zero.
const SMALL: f64 = 1e-9;
/// Largest fraction of an observed model error that is learnt within a sample.
const MOST_BELIEVED: f64 = 0.3;

/// Inputs for commanded accelerations, by a model of the vessel and its observed errors: dynamic inversion
/// with a disturbance observer. Errors of parameters and unknown currents are not distinguished: both appear
/// as increments of u, v and r that the model does not explain.
#[derive(Clone, Debug)]
struct Inversion<'a> {
    vessel: &'a Vessel,
    model: Compiled<'a, f64>,
    steady: Steady<'a>,
    /// Inputs, then measured disturbances and derived channels.
    exogenous: Vec<f64>,
    gradients: Vec<[f64; 3]>,
    /// The last command to the actuators; empty before the first one.
    last: Vec<f64>,
    /// State and current of the model's current point.
    looked: Option<([f64; 3], [f64; 2])>,
    /// Increments of u, v, r in a sample that the model does not explain.
    pub unexplained: [f64; 3],
    /// Fraction of a new observation of u, v, r that is learnt.
    believed: [f64; 3],
}

/// Commanded increments in a sample; sway may be left to the drift of the turn.
#[derive(Clone, Copy, Debug)]
struct Gains {
    pub u: f64,
    pub v: f64,
    /// Whether sway is commanded even if inputs have to leave their couplings for it.
    pub sway: bool,
    pub r: f64,
}

impl<'a> Inversion<'a> {
    /// With `parameters`; model errors are learnt with time constant `memory_s`.
    pub fn new(vessel: &'a Vessel, parameters: &[f64], memory_s: f64) -> Self {
        Self {
            vessel,
            model: Compiled::new(&vessel.model, parameters),
            steady: Steady::new(vessel, parameters),
            exogenous: vec![0.0; vessel.model.exogenous()],
            gradients: vec![[0.0; 3]; vessel.model.variables.len()],
            last: Vec::new(),
            looked: None,
            unexplained: [0.0; 3],
            believed: [(1.0 / (memory_s * vessel.sample_rate_hz)).min(MOST_BELIEVED); 3],
        }
    }

    /// Limits what is learnt of each of u, v, r from an observation.
    pub fn limit_belief(&mut self, most: [f64; 3]) {
        self.believed.iter_mut().zip(most).for_each(|(believed, most)| *believed = believed.min(most));
    }

    /// The inputs that produce `wanted` at `state`, in a known current of body components `current`.
    ///
    /// # Errors
    /// A vessel without the inputs to command surge, yaw and, where wanted, sway.
    pub fn inputs(&mut self, state: [f64; 3], current: [f64; 2], wanted: &Gains) -> Result<&[f64], Invalid> {
        if self.last.is_empty() {
            self.begin(state, current, wanted.sway)?;
        }
        let (free, count) = self.free(wanted.sway);
        let free = &free[..count];
        for _ in 0..STEPS {
            let missing = self.missing(state, current, wanted, free);
            if missing.iter().all(|missing| missing.abs() <= SMALL) {
                break;
            }
            let rows = self.linearised(missing, wanted.sway, free);
            if !self.corrected(free, solved(rows)) {
                break;
            }
        }
        Ok(&self.last)
    }

    /// Begins with inputs that hold the present motion; fails if the inputs do not command it.
    fn begin(&mut self, state: [f64; 3], current: [f64; 2], sway: bool) -> Result<(), Invalid> {
        let inputs = self.vessel.model.inputs;
        let mut unknowns = vec![0.0; inputs + 1];
        let motion = Motion { u: state[0] - current[0], v: sway.then_some(0.0), r: 0.0 };
        self.steady.solve(motion, &mut unknowns)?;
        unknowns.truncate(inputs);
        self.last = unknowns;
        Ok(())
    }

    /// The free inputs, and their number: at most three.
    fn free(&self, sway: bool) -> ([usize; 3], usize) {
        let leads = |i: &usize| sway || self.vessel.couplings[*i].is_none();
        let mut free = [0; 3];
        let places = free.iter_mut().zip((0..self.vessel.model.inputs).filter(leads));
        let count = places.map(|(place, input)| *place = input).count();
        (free, count)
    }

    /// Increments of u, v and r that the inputs do not produce yet; sway is left out where two inputs command the vessel.
    fn missing(&mut self, state: [f64; 3], current: [f64; 2], wanted: &Gains, free: &[usize]) -> [f64; 3] {
        self.look(state, current, None);
        let increments = self.model.increments();
        let gains = [wanted.u, wanted.v, wanted.r];
        let missing = [0, 1, 2].map(|d| gains[d] - increments[d] - self.unexplained[d]);
        [missing[0], if free.len() == 3 { missing[1] } else { 0.0 }, missing[2]]
    }

    /// Rows \[slopes by the free inputs | missing increments\] of surge, sway and yaw at the current point.
    fn linearised(&mut self, missing: [f64; 3], alone: bool, free: &[usize]) -> [[f64; 4]; 3] {
        self.model.exogenous_gradients(&mut self.gradients);
        self.vessel.model.by_sources(&self.exogenous, &mut self.gradients);
        let mut rows = [[0.0; 4]; 3];
        for d in (0..3).filter(|d| *d != 1 || free.len() == 3) {
            for (slope, leader) in rows[d].iter_mut().zip(free) {
                *slope = self.slope(d, *leader, alone);
            }
            rows[d][3] = missing[d];
        }
        rows
    }

    /// Slope of degree of freedom `d` by input `leader`, with the inputs that follow it.
    fn slope(&self, d: usize, leader: usize, alone: bool) -> f64 {
        let direct = self.gradients[3 + leader][d];
        let follows = |(i, coupling): (usize, &Option<(usize, f64)>)| match coupling {
            Some((of, factor)) if *of == leader && !alone => Some(factor * self.gradients[3 + i][d]),
            _ => None,
        };
        direct + self.vessel.couplings.iter().enumerate().filter_map(follows).sum::<f64>()
    }

    /// Changes the inputs as far as their ranges allow; returns whether anything changed.
    fn corrected(&mut self, free: &[usize], changes: [f64; 3]) -> bool {
        let mut changed = false;
        for (i, change) in free.iter().zip(changes) {
            let before = self.last[*i];
            let (range, wanted) = (self.vessel.actuators[*i].range, before + change);
            let after = range.map_or(wanted, |[low, high]| wanted.clamp(low, high));
            changed |= (after - before).abs() > 1e-12 * after.abs();
            self.last[*i] = after;
        }
        if free.len() < self.last.len() {
            for (i, coupling) in self.vessel.couplings.iter().enumerate() {
                if let Some((leader, factor)) = coupling {
                    self.last[i] = factor * self.last[*leader];
                }
            }
        }
        changed
    }

    /// Sets the point of the model, unless it is there already.
    fn look(&mut self, state: [f64; 3], current: [f64; 2], inputs: Option<&[f64]>) {
        let inputs = inputs.unwrap_or(&self.last);
        if self.looked == Some((state, current)) && self.exogenous[..inputs.len()] == *inputs {
            return;
        }
        self.looked = Some((state, current));
        self.exogenous.iter_mut().zip(inputs).for_each(|(to, from)| *to = *from);
        self.vessel.model.complete(&mut self.exogenous);
        self.model.look(state, &self.exogenous, Some(current));
    }

    /// The motion a sample after `before`, under `inputs`, with what was learnt so far.
    pub fn predicted(&mut self, before: [f64; 3], inputs: &[f64], current: [f64; 2]) -> [f64; 3] {
        self.look(before, current, Some(inputs));
        let increments = self.model.increments();
        [0, 1, 2].map(|d| before[d] + increments[d] + self.unexplained[d])
    }

    /// Learns from a sample: `before` became `after` under `inputs`.
    pub fn observe(&mut self, before: [f64; 3], inputs: &[f64], current: [f64; 2], after: [f64; 3]) {
        self.look(before, current, Some(inputs));
        let increments = self.model.increments();
        for d in 0..3 {
            let new = after[d] - before[d] - increments[d] - self.unexplained[d];
            self.unexplained[d] += self.believed[d] * new;
        }
    }
}

/// Solves rows \[A | b\] by elimination; unknowns without a slope are not changed.
fn solved(mut rows: [[f64; 4]; 3]) -> [f64; 3] {
    let mut used = [false; 3];
    let mut pivots = [None; 3];
    for column in 0..3 {
        let open = (0..3).filter(|row| !used[*row]);
        let best = open.max_by(|a, b| rows[*a][column].abs().total_cmp(&rows[*b][column].abs()));
        let Some(row) = best.filter(|row| rows[*row][column].abs() > 1e-15) else { continue };
        used[row] = true;
        pivots[column] = Some(row);
        let pivot = rows[row];
        for other in (0..3).filter(|other| *other != row) {
            let factor = rows[other][column] / pivot[column];
            rows[other].iter_mut().zip(pivot).for_each(|(to, from)| *to -= factor * from);
        }
    }
    [0, 1, 2].map(|column| pivots[column].map_or(0.0, |row: usize| rows[row][3] / rows[row][column]))
}
