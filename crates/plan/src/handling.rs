use std::ops::RangeInclusive;

use maneuver::{Motion, Steady};
use refusal::{Invalid, check_numbers};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::Compiled;
use ship::model::Vessel;

use crate::Mode;

/// How the vessel is handled between informative maneuvers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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

impl Handling {
    /// Each number with its key and range.
    fn numbers(&self) -> [(&'static str, f64, RangeInclusive<f64>); 5] {
        [
            ("turn_rate_rad_s", self.turn_rate_rad_s, 1e-4..=10.0),
            ("crawl_m_s", self.crawl_m_s, 1e-3..=20.0),
            ("acceleration_m_s2", self.acceleration_m_s2, 1e-5..=100.0),
            ("response_s", self.response_s, 1e-3..=3600.0),
            ("lookahead_m", self.lookahead_m, 1e-3..=1e5),
        ]
    }

    /// Refuses meaningless numbers, and those that would make a leg last for days: every leg is simulated to
    /// its end.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self) -> Result<(), Invalid> {
        self.numbers().into_iter().try_for_each(|(key, value, range)| {
            let expected = format!("a number from {} to {}", range.start(), range.end());
            check_numbers([(format!("handling.{key}"), value)], &expected, |value| range.contains(&value))
        })
    }
}

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
        handling.check()?;
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
        let mut own = Self {
            turn_rate_rad_s: None,
            turn_acceleration_rad_s2: None,
            acceleration_m_s2: None,
            braking_m_s2: None,
            coasting_m_s2: -gains(vessel, slowest, &idle(vessel))[0],
            lag_s: vessel.actuators.iter().map(|own| own.lag_s + own.hold_s).fold(0.0, f64::max),
        };
        let least = |known: &mut Option<f64>, new: Option<f64>| {
            *known = [*known, new].into_iter().flatten().reduce(f64::min);
        };
        for speed in speeds {
            let mut steady = Steady::new(vessel, &vessel.nominal);
            let straight = held(vessel, &mut steady, speed, 0.0)?;
            let [gain, loss, turn] = extremes(vessel, speed, &straight);
            least(&mut own.acceleration_m_s2, gain);
            least(&mut own.braking_m_s2, loss);
            least(&mut own.turn_acceleration_rad_s2, turn);
            least(&mut own.turn_rate_rad_s, largest_turn(vessel, &mut steady, speed));
        }
        Ok(own)
    }
}

/// The settings nearest to zero.
fn idle(vessel: &Vessel) -> Vec<f64> {
    let setting = |range: [f64; 2]| 0.0_f64.clamp(range[0], range[1]);
    vessel.actuators.iter().map(|own| own.range.map_or(0.0, setting)).collect()
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
    if vessel.actuators.iter().all(|own| own.rate_per_s.is_none()) {
        return Ok(0.0);
    }
    let mut steady = Steady::new(vessel, &vessel.nominal);
    let straight = held(vessel, &mut steady, speed, 0.0)?;
    let turning = held(vessel, &mut steady, speed, turn)?;
    let settings = straight.iter().zip(&turning).zip(&vessel.actuators);
    let seconds = settings.filter_map(|((a, b), own)| Some((b - a).abs() / own.rate_per_s?));
    Ok(seconds.fold(0.0, f64::max))
}

/// The largest yaw rate that can be held at a speed; `None` if it is not bounded.
fn largest_turn(vessel: &Vessel, steady: &mut Steady, speed: f64) -> Option<f64> {
    let (mut low, mut high) = (0.0, FASTEST_TURN_RAD_S);
    if vessel.actuators.iter().all(|own| own.range.is_none()) || held(vessel, steady, speed, high).is_ok() {
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
    let mut found = [0.0_f64; 4];
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
            for ((most, gain), usual) in found.iter_mut().zip(gained).zip(usual) {
                let boundless = actuator.range.is_none() && (gain - usual).abs() > 0.0;
                *most = if boundless { f64::INFINITY } else { most.max(gain) };
            }
        }
    }
    let [gain, loss, starboard, port] = found;
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
