use std::f64::consts::TAU;

use maneuver::{Motion, Steady};
use refusal::{Invalid, check_bounds};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::Compiled;
use ship::model::Vessel;

use crate::leg::{around, wrap};
use crate::{Grid, Leg, Mode, Phase, Purpose};

/// How the vessel is handled between informative maneuvers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Handling {
    /// Largest yaw rate under autopilot \[rad/s\].
    #[schemars(range(min = 1e-4, max = 10.0))]
    pub turn_rate_rad_s: f64,
    /// Speed of repositioning at rest, in surge and sway \[m/s\].
    #[schemars(range(min = 1e-3, max = 20.0))]
    pub crawl_m_s: f64,
    /// Acceleration along a leg that changes speed \[m/s²\].
    #[schemars(range(min = 1e-5, max = 100.0))]
    pub acceleration_m_s2: f64,
    /// Time constant of keeping position, speed and heading \[s\].
    #[schemars(range(min = 1e-3, max = 3600.0))]
    pub response_s: f64,
    /// Distance ahead at which a line is aimed at \[m\].
    #[schemars(range(min = 1e-3, max = 1e5))]
    pub lookahead_m: f64,
}

/// The stated part of [`Handling`]; the rest follows from the vessel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StatedHandling {
    /// See [`Handling::turn_rate_rad_s`].
    pub turn_rate_rad_s: Option<f64>,
    /// See [`Handling::crawl_m_s`].
    pub crawl_m_s: Option<f64>,
    /// See [`Handling::acceleration_m_s2`].
    pub acceleration_m_s2: Option<f64>,
    /// See [`Handling::response_s`].
    pub response_s: Option<f64>,
    /// See [`Handling::lookahead_m`].
    pub lookahead_m: Option<f64>,
}

/// What the nominal vessel can do at the speeds of its modes under way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ability {
    /// Largest yaw rate that its actuators hold in every mode \[rad/s\]; null where no range bounds it.
    pub turn_rate_rad_s: Option<f64>,
    /// How fast it can begin to turn in every mode \[rad/s²\]; null where no range bounds it.
    pub turn_acceleration_rad_s2: Option<f64>,
    /// How fast it can gain speed in every mode \[m/s²\]; null where no range bounds it.
    pub acceleration_m_s2: Option<f64>,
    /// How fast it can lose speed in every mode \[m/s²\]; null where no range bounds it.
    pub braking_m_s2: Option<f64>,
    /// How fast it loses speed with all inputs as near to zero as their ranges allow, in its slowest mode \[m/s²\].
    pub coasting_m_s2: f64,
    /// Longest lag of its actuators, with the time for which they hold a command \[s\].
    pub lag_s: f64,
}

/// How a vessel of these abilities is handled where nobody says otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DerivedHandling {
    /// Handling.
    pub handling: Handling,
    /// What it follows from.
    pub ability: Ability,
}

/// Nested loops, each faster than the outer one: fractions of the response time for the course, for speeds,
/// for the yaw rate and for model errors.
pub(crate) const COURSE: f64 = 4.0;
pub(crate) const SPEED: f64 = 4.0;
pub(crate) const YAW_RATE: f64 = 8.0;
pub(crate) const MEMORY: f64 = 8.0;
/// Largest fraction of an error that is corrected within a sample.
pub(crate) const MOST_AT_ONCE: f64 = 0.5;

/// Fraction of the largest yaw rate: the rest is a reserve for vessels that turn worse than the nominal one.
const OF_TURN_RATE: f64 = 0.5;
/// Radius of turns where no range of an actuator bounds them \[lengths\].
const TURN_LENGTHS: f64 = 4.0;
/// Distance of the slowest mode within the response time \[lengths\].
const RESPONSE_LENGTHS: f64 = 1.5;
/// A course aimed at a point ahead on a line turns by no more than this fraction of speed over lookahead:
/// 2/(3√3), where it crosses the line at atan(1/√2).
const OF_LOOKAHEAD: f64 = 0.384_900_179_459_750_5;
/// Time per length of a vessel that has no mode under way \[s\].
const AT_REST_LENGTH_S: f64 = 20.0;
/// Fraction of the slowest mode's speed.
const OF_SPEED: f64 = 0.2;
/// Largest yaw rate that is tried \[rad/s\].
const FASTEST_TURN_RAD_S: f64 = 2.0;
/// Bisections for the largest yaw rate.
const HALVINGS: usize = 24;

impl StatedHandling {
    /// Completes the stated values from `derived`, and checks them against the vessel's ability.
    ///
    /// # Errors
    /// Meaningless numbers, or values beyond the vessel's ability: names the key.
    pub fn completed(&self, derived: &DerivedHandling) -> Result<Handling, Invalid> {
        let usual = derived.handling;
        let handling = Handling {
            turn_rate_rad_s: self.turn_rate_rad_s.unwrap_or(usual.turn_rate_rad_s),
            crawl_m_s: self.crawl_m_s.unwrap_or(usual.crawl_m_s),
            acceleration_m_s2: self.acceleration_m_s2.unwrap_or(usual.acceleration_m_s2),
            response_s: self.response_s.unwrap_or(usual.response_s),
            lookahead_m: self.lookahead_m.unwrap_or(usual.lookahead_m),
        };
        // Also what follows from the vessel: a leg must not last for days, since every leg is simulated to its end.
        check_bounds(&handling)
            .map_err(|e| Invalid { thing: e.thing.replacen('`', "`handling.", 1), ..e })?;
        let Ability { turn_rate_rad_s, acceleration_m_s2, braking_m_s2, .. } = derived.ability;
        let most = [acceleration_m_s2, braking_m_s2].into_iter().flatten().reduce(f64::min);
        beyond("turn_rate_rad_s", "rad/s", handling.turn_rate_rad_s, turn_rate_rad_s)?;
        beyond("acceleration_m_s2", "m/s^2", handling.acceleration_m_s2, most)?;
        Ok(handling)
    }
}

/// Refuses values beyond the vessel's ability.
fn beyond(key: &str, unit: &str, value: f64, most: Option<f64>) -> Result<(), Invalid> {
    match most.filter(|most| value > *most) {
        None => Ok(()),
        Some(most) => Err(Invalid::new(
            format!("`handling.{key}`"),
            format!("{value} {unit}"),
            format!(
                "at most {most:.3} {unit}, which the nominal vessel does within the `range` of its inputs"
            ),
            "lower it, or leave it out",
        )),
    }
}

impl DerivedHandling {
    /// For the nominal `vessel`, which is `length_m` long, at the speeds of `modes`.
    ///
    /// # Errors
    /// A vessel that cannot be steered in a mode under way.
    pub fn of(vessel: &Vessel, modes: &[Mode], length_m: f64) -> Result<Self, Invalid> {
        let under_way = modes.iter().map(|mode| mode.speed_m_s).filter(|speed| *speed > 0.0);
        let slowest = under_way.clone().reduce(f64::min).unwrap_or(length_m / AT_REST_LENGTH_S);
        let fastest = under_way.clone().reduce(f64::max).unwrap_or(slowest);
        let ability = Ability::of(vessel, under_way, slowest)?;
        let turn_rate_rad_s =
            ability.turn_rate_rad_s.map_or(slowest / (TURN_LENGTHS * length_m), |most| OF_TURN_RATE * most);
        let reversed = ability.turn_acceleration_rad_s2.map_or(0.0, |most| turn_rate_rad_s / most);
        let samples_s = YAW_RATE / (MOST_AT_ONCE * vessel.sample_rate_hz);
        let slow = [
            RESPONSE_LENGTHS * length_m / slowest,
            YAW_RATE * reversed,
            YAW_RATE * ability.lag_s,
            COURSE * laid_s(vessel, slowest, turn_rate_rad_s)?,
        ];
        let response_s = slow.into_iter().fold(samples_s, f64::max);
        let able = [ability.acceleration_m_s2, ability.braking_m_s2].into_iter().flatten();
        // With a thrust that must stay near that of the mode there is no coasting.
        let coasts = idle(vessel).iter().all(|setting| *setting == 0.0);
        let coasting_m_s2 = if coasts { ability.coasting_m_s2 } else { f64::INFINITY };
        let acceleration_m_s2 = able.map(|most| 0.5 * most).fold(coasting_m_s2, f64::min);
        let handling = Handling {
            turn_rate_rad_s,
            crawl_m_s: OF_SPEED * slowest,
            acceleration_m_s2,
            response_s,
            // Errors across a line decay without overshoot in the fastest mode, and faster in others: neither
            // the response nor the yaw rate is too slow for it.
            lookahead_m: fastest * response_s.max(OF_LOOKAHEAD / turn_rate_rad_s),
        };
        Ok(Self { handling, ability })
    }
}

impl Ability {
    fn of(vessel: &Vessel, speeds: impl Iterator<Item = f64>, slowest: f64) -> Result<Self, Invalid> {
        let mut ability = Self {
            turn_rate_rad_s: None,
            turn_acceleration_rad_s2: None,
            acceleration_m_s2: None,
            braking_m_s2: None,
            coasting_m_s2: -gains(vessel, slowest, &idle(vessel))[0],
            lag_s: vessel.actuators.iter().map(|one| one.lag_s + one.hold_s).fold(0.0, f64::max),
        };
        let least = |known: &mut Option<f64>, new: Option<f64>| {
            *known = [*known, new].into_iter().flatten().reduce(f64::min);
        };
        for speed in speeds {
            let mut steady = Steady::new(vessel, &vessel.nominal);
            let straight = held(vessel, &mut steady, speed, 0.0)?;
            let [gain, loss, turn] = extremes(vessel, speed, &straight);
            least(&mut ability.acceleration_m_s2, gain);
            least(&mut ability.braking_m_s2, loss);
            least(&mut ability.turn_acceleration_rad_s2, turn);
            least(&mut ability.turn_rate_rad_s, largest_turn(vessel, &mut steady, speed));
        }
        Ok(ability)
    }
}

/// The settings nearest to zero.
pub(crate) fn idle(vessel: &Vessel) -> Vec<f64> {
    let setting = |range: [f64; 2]| 0.0_f64.clamp(range[0], range[1]);
    vessel.actuators.iter().map(|actuator| actuator.range.map_or(0.0, setting)).collect()
}

/// The inputs that hold a speed and a yaw rate within the actuators' ranges.
fn held(vessel: &Vessel, steady: &mut Steady, speed: f64, turn: f64) -> Result<Vec<f64>, Invalid> {
    let mut unknowns = vec![0.0; vessel.model.inputs + 1];
    steady.solve(Motion { u: speed, v: None, r: turn }, &mut unknowns)?;
    unknowns.truncate(vessel.model.inputs);
    match vessel.beyond_range(&unknowns) {
        None => Ok(unknowns),
        Some((input, [low, high])) => {
            let name = &vessel.model.input_variables()[input].name;
            Err(Invalid::new(
                format!("speed of {speed} m/s straight ahead"),
                format!("`{name}` = {:.4}", unknowns[input]),
                format!("{low} to {high}, its `range`"),
                "correct the [[speed_mode]], or the range in vessel.toml",
            ))
        }
    }
}

/// The time that the slowest actuator needs to initiate a turn.
fn laid_s(vessel: &Vessel, speed: f64, turn: f64) -> Result<f64, Invalid> {
    if vessel.actuators.iter().all(|actuator| actuator.rate_per_s.is_none()) {
        return Ok(0.0);
    }
    let mut steady = Steady::new(vessel, &vessel.nominal);
    let straight = held(vessel, &mut steady, speed, 0.0)?;
    let turning = held(vessel, &mut steady, speed, turn)?;
    let settings = straight.iter().zip(&turning).zip(&vessel.actuators);
    let seconds = settings.filter_map(|((a, b), actuator)| Some((b - a).abs() / actuator.rate_per_s?));
    Ok(seconds.fold(0.0, f64::max))
}

/// The largest yaw rate that can be held at a speed; `None` if it is not bounded.
fn largest_turn(vessel: &Vessel, steady: &mut Steady, speed: f64) -> Option<f64> {
    let (mut low, mut high) = (0.0, FASTEST_TURN_RAD_S);
    let is_boundless = vessel.actuators.iter().all(|actuator| actuator.range.is_none());
    if is_boundless || held(vessel, steady, speed, high).is_ok() {
        return None;
    }
    for _ in 0..HALVINGS {
        let centre = 0.5 * (low + high);
        match held(vessel, steady, speed, centre) {
            Ok(_) => low = centre,
            Err(_) => high = centre,
        }
    }
    Some(low)
}

/// The largest increase and decrease of speed and the largest yaw acceleration, in the weaker direction, that
/// an input can produce while the vessel goes straight ahead \[per s\]; `None` where no range bounds it.
fn extremes(vessel: &Vessel, speed: f64, straight: &[f64]) -> [Option<f64>; 3] {
    let mut limits = [0.0_f64; 4];
    for (input, actuator) in vessel.actuators.iter().enumerate() {
        let changed = |setting: f64| {
            let mut inputs = straight.to_vec();
            inputs[input] = setting;
            let [u, _, r] = gains(vessel, speed, &inputs);
            [u, -u, r, -r]
        };
        let usual = changed(straight[input]);
        let ends = actuator.range.unwrap_or([-1.0, 1.0].map(|step| straight[input] + step));
        for gained in ends.map(changed) {
            for ((most, gain), usual) in limits.iter_mut().zip(gained).zip(usual) {
                let boundless = actuator.range.is_none() && (gain - usual).abs() > 0.0;
                *most = if boundless { f64::INFINITY } else { most.max(gain) };
            }
        }
    }
    let [gain, loss, starboard, port] = limits;
    [gain, loss, starboard.min(port)].map(|most| Some(most).filter(|most| most.is_finite() && *most > 0.0))
}

/// Increments of u, v and r per second, straight ahead.
fn gains(vessel: &Vessel, speed: f64, inputs: &[f64]) -> [f64; 3] {
    let mut exogenous = vec![0.0; vessel.model.exogenous()];
    exogenous[..inputs.len()].copy_from_slice(inputs);
    vessel.model.complete(&mut exogenous);
    let mut model = Compiled::new(&vessel.model, &vessel.nominal);
    model.look([speed, 0.0, 0.0], &exogenous, None);
    model.increments().map(|gain| gain * vessel.sample_rate_hz)
}

/// Names of the basic moves.
pub const BASIC_MOVES: [&str; 5] = ["straight", "faster", "slower", "turn-port", "turn-starboard"];

/// How many nodes beyond its shortest end a move is tried.
const FARTHER: usize = 5;
/// Most ends of a turn that are tried, nearest first.
const TURNS: usize = 24;

/// The basic moves from a heading level and mode: straight ahead, turns (on the spot at rest, arcs under
/// way), changes of speed. Each move has several legs, shortest first: a vessel that does not settle by the
/// end of one may settle by the end of a longer one.
///
/// Their names are [`BASIC_MOVES`]. At rest a vessel moves ahead at the crawl speed.
pub fn basic_moves(grid: &Grid, handling: &Handling, level: usize, mode: usize) -> Vec<Vec<Leg>> {
    let slower = mode.checked_sub(1);
    let faster = Some(mode + 1).filter(|mode| *mode < grid.modes.len());
    let modes = [Some(mode), faster, slower].into_iter().flatten();
    let mut moves: Vec<Vec<Leg>> = modes.map(|to| straights(grid, handling, level, mode, to)).collect();
    for side in [-1.0, 1.0] {
        // Levels count counter-clockwise, to port.
        let to = (level as i64 - side as i64).rem_euclid(grid.headings as i64) as usize;
        moves.push(match grid.modes[mode].speed_m_s {
            0.0 => vec![turn_on_the_spot(grid, level, to, mode, side)],
            _ => arcs(grid, handling, level, to, mode, side),
        });
    }
    moves
}

fn turn_name(side: f64) -> &'static str {
    if side > 0.0 { "turn-starboard" } else { "turn-port" }
}

/// A basic move between two layers.
fn basic(name: &str, [from, to]: [usize; 2], (di, dj): (i32, i32), phases: Vec<Phase>) -> Leg {
    Leg { purpose: Purpose::Basic(name.to_owned()), from, di, dj, to, phases }
}

fn turn_on_the_spot(grid: &Grid, level: usize, to: usize, mode: usize, side: f64) -> Leg {
    let phases = vec![Phase::Hold { at: [0.0, 0.0], heading_rad: grid.heading_rad(to) }];
    basic(turn_name(side), [level, to].map(|level| grid.layer(level, mode)), (0, 0), phases)
}

/// One step ahead, or as many as a change of speed needs, and longer ones.
fn straights(grid: &Grid, handling: &Handling, level: usize, from: usize, to: usize) -> Vec<Leg> {
    let (di, dj) = grid.step_along(level);
    let [north, east] = grid.displacement(di, dj);
    let (v0, v1) = (grid.modes[from].speed_m_s, grid.modes[to].speed_m_s);
    let needed = (v1 * v1 - v0 * v0).abs() / (2.0 * handling.acceleration_m_s2);
    let steps = (needed / libm::hypot(north, east)).ceil().max(1.0) as usize;
    (steps..=steps + FARTHER).map(|steps| straight(grid, level, [from, to], steps as i32)).collect()
}

/// `steps` steps ahead, from one mode to another.
fn straight(grid: &Grid, level: usize, [from, to]: [usize; 2], steps: i32) -> Leg {
    let (di, dj) = grid.step_along(level);
    let (v0, v1) = (grid.modes[from].speed_m_s, grid.modes[to].speed_m_s);
    let end = grid.displacement(steps * di, steps * dj);
    let heading_rad = grid.heading_rad(level);
    let ahead = (v0 != 0.0 || v1 != 0.0).then(|| line(end, v0, v1));
    let hold = (v1 == 0.0).then_some(Phase::Hold { at: end, heading_rad });
    let name = match to.cmp(&from) {
        std::cmp::Ordering::Equal => "straight",
        std::cmp::Ordering::Greater => "faster",
        std::cmp::Ordering::Less => "slower",
    };
    let layers = [from, to].map(|mode| grid.layer(level, mode));
    basic(name, layers, (steps * di, steps * dj), ahead.into_iter().chain(hold).collect())
}

/// From the node along the course to `to`.
fn line(to: [f64; 2], from_m_s: f64, to_m_s: f64) -> Phase {
    Phase::Line { to, heading_rad: libm::atan2(to[1], to[0]), from_m_s, to_m_s }
}

/// Straight–arc–straight from one level to the next, ending on nodes and within the yaw rate: the shortest first.
fn arcs(grid: &Grid, handling: &Handling, level: usize, to: usize, mode: usize, side: f64) -> Vec<Leg> {
    let speed = grid.modes[mode].speed_m_s;
    let (a, b) = (grid.heading_rad(level), grid.heading_rad(to));
    let turn = TAU / grid.headings as f64;
    let tangent = speed / handling.turn_rate_rad_s * libm::tan(turn / 2.0);
    // A move longer than the lattice is useless.
    let most = grid.nx.max(grid.ny) as f64;
    let reach = (3.0 + FARTHER as f64 + (2.0 * tangent / grid.cell_m).ceil()).min(most) as i32;
    let mut ends: Vec<(f64, i32, i32, f64)> = around(0, 0, reach)
        .filter_map(|(di, dj)| {
            let [north, east] = grid.displacement(di, dj);
            // North, east = p (cos a, sin a) + q (cos b, sin b).
            let det = libm::cos(a) * libm::sin(b) - libm::sin(a) * libm::cos(b);
            let p = (north * libm::sin(b) - east * libm::cos(b)) / det;
            let q = (libm::cos(a) * east - libm::sin(a) * north) / det;
            (p >= tangent - 1e-9 && q >= tangent - 1e-9).then_some((p + q, di, dj, p))
        })
        .collect();
    ends.sort_by(|x, y| x.0.total_cmp(&y.0));
    ends.truncate(TURNS);
    let radius_m = tangent / libm::tan(turn / 2.0);
    let along =
        |to: [f64; 2], heading_rad: f64| Phase::Line { to, heading_rad, from_m_s: speed, to_m_s: speed };
    let leg = |(_, di, dj, p): (f64, i32, i32, f64)| {
        let begin = [(p - tangent) * libm::cos(a), (p - tangent) * libm::sin(a)];
        let centre = [begin[0] - side * radius_m * libm::sin(a), begin[1] + side * radius_m * libm::cos(a)];
        let before = (p - tangent > 1e-6).then(|| along(begin, a));
        let arc = Phase::Arc { centre, radius_m, to_rad: wrap(b), side, speed_m_s: speed };
        let phases = before.into_iter().chain([arc, along(grid.displacement(di, dj), b)]).collect();
        basic(turn_name(side), [level, to].map(|level| grid.layer(level, mode)), (di, dj), phases)
    };
    ends.into_iter().map(leg).collect()
}
