use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use refusal::{Invalid, check_name};
use schemars::JsonSchema;
use serde::Deserialize;
use ship::engine::{Command, Helm, Program, Progress, Seen};
use ship::model::{Actuator, ActuatorState, SampleCommand, Source, Vessel};

use super::generate_spec::GenerateSpec;
use super::spec::ManeuverSpec;
use crate::standard::{Standard, is_turned_away, steps};

/// `dictionary.toml` as written.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DictionaryFile {
    /// Duration of every maneuver that states none \[s\].
    pub duration_s: Option<f64>,
    /// The parameters that turn maneuvers into inputs.
    #[serde(default)]
    pub inputs_from: Source,
    /// By how much written motions may differ from what they are called.
    #[serde(default)]
    pub tolerance: Tolerance,
    /// The maneuvers, in order.
    #[serde(default, rename = "maneuver")]
    pub maneuvers: Vec<ManeuverSpec>,
    /// More maneuvers, by generation.
    pub generate: Option<GenerateSpec>,
}

/// From the text of `dictionary.toml`, compiled here alone: others would have code of their own for every type in it.
impl FromStr for DictionaryFile {
    type Err = toml::de::Error;

    fn from_str(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text)
    }
}

impl DictionaryFile {
    /// The written maneuvers, then the generated ones, with unique names.
    ///
    /// # Errors
    /// An empty dictionary, a duplicate name and meaningless numbers: names the maneuver and the key.
    pub fn expanded(&self) -> Result<Vec<ManeuverSpec>, Invalid> {
        let generated = self.generate.as_ref().map(GenerateSpec::candidates).transpose()?;
        let all: Vec<ManeuverSpec> =
            self.maneuvers.iter().cloned().chain(generated.into_iter().flatten()).collect();
        check_all(&all, self.duration_s)?;
        self.tolerance.check()?;
        Ok(all)
    }

    /// Refuses swings that are too fast for `rate_hz`.
    pub(super) fn check_sampling(&self, rate_hz: f64) -> Result<(), Invalid> {
        self.maneuvers.iter().try_for_each(|maneuver| maneuver.check_sampling(rate_hz))?;
        self.generate.as_ref().map_or(Ok(()), |generate| generate.check_sampling(rate_hz))
    }
}

pub(crate) fn check_all(maneuvers: &[ManeuverSpec], default_s: Option<f64>) -> Result<(), Invalid> {
    if maneuvers.is_empty() {
        return Err(Invalid::new("[[maneuver]]", "none", "at least one maneuver", "add one, or [generate]"));
    }
    let mut names = BTreeSet::new();
    for maneuver in maneuvers {
        check_name("`name` of a [[maneuver]]", &maneuver.name)?;
        if !names.insert(maneuver.name.as_str()) {
            return Err(Invalid::new(
                format!("maneuver `{}`", maneuver.name),
                "a name that is used twice",
                "a name of its own for every maneuver",
                "rename one of them",
            ));
        }
        maneuver.check(default_s)?;
    }
    Ok(())
}

// Commands that reach a ship by way of her actuators.

/// `helm` by way of the actuators of `vessel`, which are at `settings` before its first command; itself where all of them follow at
/// once.
pub(crate) fn actuated(helm: Helm, vessel: &Vessel, settings: &[f64]) -> Helm {
    if vessel.actuators.iter().all(Actuator::is_immediate) {
        return helm;
    }
    let (actuators, settings) = (vessel.actuators.clone().into(), settings.into());
    Helm::new(Actuated { helm, actuators, settings, sample_s: 1.0 / vessel.sample_rate_hz })
}

#[derive(Debug)]
struct Actuated {
    helm: Helm,
    actuators: Arc<[Actuator]>,
    settings: Arc<[f64]>,
    sample_s: f64,
}

impl Program for Actuated {
    fn begin(&self) -> Box<dyn Command> {
        Box::new(Following {
            command: self.helm.begin(),
            actuators: Arc::clone(&self.actuators),
            acting: self.settings.iter().map(|setting| ActuatorState::at(*setting)).collect(),
            commanded: Vec::new(),
            sample_s: self.sample_s,
        })
    }

    fn tracks(&self) -> bool {
        self.helm.tracks()
    }
}

/// Commands while actuators follow them.
struct Following {
    command: Box<dyn Command>,
    actuators: Arc<[Actuator]>,
    acting: Vec<ActuatorState>,
    /// The commands of the last sample.
    commanded: Vec<f64>,
    sample_s: f64,
}

impl Command for Following {
    fn command(&mut self, seen: &Seen, inputs: &mut [f64]) {
        self.command.command(seen, inputs);
        self.commanded.clear();
        self.commanded.extend_from_slice(inputs);
        let ends = self.command.ends();
        for (i, (acting, own)) in self.acting.iter_mut().zip(&*self.actuators).enumerate() {
            inputs[i] = acting.follow(own, SampleCommand::of(i, inputs[i], ends), self.sample_s);
        }
    }

    fn commanded(&self) -> Option<&[f64]> {
        Some(&self.commanded)
    }

    fn progress(&self) -> Progress {
        self.command.progress()
    }
}

// What a maneuver is to reach, and what it did.

/// By how much a motion may differ from what it is called.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tolerance {
    /// By how much the mean speed over its second half may be beyond all wanted ones, as a fraction of the greatest.
    pub speed: f64,
    /// The change of heading at its end, as a fraction of all turning that is wanted, to either side.
    pub turn: f64,
    /// The least of these changes of heading that counts \[rad\].
    pub least_turn_rad: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { speed: 0.25, turn: 0.25, least_turn_rad: 0.35 }
    }
}

impl Tolerance {
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        let all = [("speed", self.speed), ("turn", self.turn), ("least_turn_rad", self.least_turn_rad)];
        let named = all.map(|(key, value)| (format!("tolerance.{key}"), value));
        refusal::check_numbers(named, "0 or more, and finite", |value| value >= 0.0 && value.is_finite())
    }
}

/// A quantity that a maneuver is to reach.
#[derive(Clone, Debug, PartialEq)]
pub struct Aim {
    /// What it is: `heading to starboard`.
    pub what: String,
    /// Its unit, in words: `°`, `m/s`.
    pub unit: &'static str,
    /// The value that is wanted.
    pub wanted: f64,
    /// The value that was reached.
    pub reached: f64,
    /// Whether it is what was wanted, within the tolerance.
    pub is_met: bool,
}

impl Aim {
    /// One that is to be reached or passed; angles in rad.
    fn passed(what: impl Into<String>, wanted: f64, reached: f64) -> Self {
        let is_met = reached >= wanted * (1.0 - 1e-9);
        let (what, unit) = (what.into(), "°");
        Self { what, unit, wanted: wanted.to_degrees(), reached: reached.to_degrees(), is_met }
    }

    /// One of a turn to the side of the greatest of `changes`; a ship that turned to the other side reached less than 0.
    fn turned(what: impl Into<String>, wanted: f64, changes: impl Iterator<Item = f64>) -> Self {
        let [own, other] =
            changes.fold([0.0, 0.0], |[own, other]: [f64; 2], psi| [own.max(psi), other.max(-psi)]);
        Self::passed(what, wanted, if is_turned_away(own, other) { -other } else { own })
    }

    /// Whether the ship turned to the other side.
    pub fn is_turned_away(&self) -> bool {
        self.unit == "°" && self.wanted > 0.0 && self.reached < 0.0
    }

    /// A value with its unit.
    pub fn value(&self, x: f64) -> String {
        match self.unit {
            "°" => format!("{x:.1}°"),
            unit => format!("{x:.3} {unit}"),
        }
    }
}

impl fmt::Display for Aim {
    /// `heading to starboard 20.0° (wanted 20.0°)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, wanted, reached, .. } = self;
        write!(f, "{what} {} (wanted {})", self.value(*reached), self.value(*wanted))
    }
}

/// The aims of a standard maneuver, with what `states`, (N+1) × 3, reach of them.
pub(crate) fn of_standard(standard: Standard, states: &[f64], rate_hz: f64) -> Vec<Aim> {
    let headings = headings(states, rate_hz);
    let after = |seconds: f64| ((seconds * rate_hz).round() as usize).min(headings.len() - 1);
    match standard {
        Standard::ZigZagTest(test) => {
            let from = after(test.hold_s);
            let side = test.to.sign();
            let changed = |k: usize| side * (headings[k] - headings[from]);
            let first = (from..headings.len()).find(|k| changed(*k) >= test.heading_rad * (1.0 - 1e-9));
            let [to, back] = if side > 0.0 { ["starboard", "port"] } else { ["port", "starboard"] };
            let changes = (from..headings.len()).map(changed);
            let one = Aim::turned(format!("heading to {to}"), test.heading_rad, changes);
            let from = first.unwrap_or(headings.len() - 1);
            let two = (from..headings.len()).map(|k| -changed(k)).fold(0.0, f64::max);
            vec![one, Aim::passed(format!("then to {back}"), test.heading_rad, two)]
        }
        Standard::TurningCircle(turn) => {
            let from = headings[after(turn.hold_s)];
            let changes = headings.iter().map(|psi| turn.to.sign() * (psi - from));
            vec![Aim::turned(format!("turn to {}", turn.to), turn.turn_rad, changes)]
        }
        Standard::ReverseSpiral(spiral) => {
            // The second half of each step; of all steps the one that is furthest from its yaw rate.
            let rates = steps(spiral.steps, false).enumerate().map(|(step, part)| {
                let wanted = spiral.to.sign() * part * spiral.yaw_rate_rad_s;
                let half = |halves: f64| after((step as f64 + 0.5 * halves) * spiral.dwell_s);
                let rates = &states.as_chunks::<3>().0[half(1.0)..half(2.0).max(half(1.0) + 1)];
                (wanted, rates.iter().map(|state| state[2]).sum::<f64>() / rates.len() as f64)
            });
            let off = |(wanted, reached): &(f64, f64)| (wanted - reached).abs();
            let worst = rates.max_by(|a, b| off(a).total_cmp(&off(b)));
            let aim = |(wanted, reached): (f64, f64)| Aim {
                what: "yaw rate of the worst step".to_owned(),
                unit: "°/s",
                wanted: wanted.to_degrees(),
                reached: reached.to_degrees(),
                is_met: (wanted - reached).abs() <= 0.1 * spiral.yaw_rate_rad_s,
            };
            worst.map(aim).into_iter().collect()
        }
        Standard::Stop(stop) => {
            let speeds = states.iter().step_by(3).skip(after(stop.hold_s));
            let reached = speeds.copied().fold(f64::INFINITY, f64::min);
            let (what, unit, wanted) = ("least speed".to_owned(), "m/s", stop.end_m_s());
            vec![Aim { what, unit, wanted, reached, is_met: reached <= wanted + 1e-3 * stop.speed_m_s }]
        }
        Standard::PullOut(_) | Standard::SpiralTest(_) => Vec::new(),
    }
}

/// The aims of a motion, `wanted` u and r of every sample, with what `states`, (N+1) × 3, reach of them. A ship may lag behind
/// speeds that change, so that only those beyond all that are wanted count.
pub fn of_motion(wanted: &[[f64; 2]], states: &[f64], rate_hz: f64, tolerance: &Tolerance) -> Vec<Aim> {
    let half = wanted.len() / 2;
    let count = (wanted.len() - half).max(1) as f64;
    let mean = wanted[half..].iter().map(|[u, _]| u).sum::<f64>() / count;
    let reached = states.iter().step_by(3).skip(half).take(wanted.len() - half).sum::<f64>() / count;
    let speeds = || wanted.iter().map(|[u, _]| *u).chain(states.first().copied());
    let (low, high) = (speeds().fold(f64::INFINITY, f64::min), speeds().fold(f64::NEG_INFINITY, f64::max));
    let slack = tolerance.speed * low.abs().max(high.abs());
    let turned = |of: &dyn Fn(f64) -> f64| wanted.iter().map(|[_, rate]| of(*rate)).sum::<f64>() / rate_hz;
    let (turn, all) = (turned(&|r| r), turned(&f64::abs));
    let heading = headings(states, rate_hz).last().copied().unwrap_or(0.0);
    vec![
        Aim {
            what: "mean speed of the second half".to_owned(),
            unit: "m/s",
            wanted: mean,
            reached,
            is_met: (low - slack..=high + slack).contains(&reached),
        },
        Aim {
            what: "change of heading".to_owned(),
            unit: "°",
            wanted: turn.to_degrees(),
            reached: heading.to_degrees(),
            is_met: (turn - heading).abs() <= (tolerance.turn * all).max(tolerance.least_turn_rad),
        },
    ]
}

/// Headings at the samples, from 0 \[rad\].
fn headings(states: &[f64], rate_hz: f64) -> Vec<f64> {
    let mut heading = 0.0;
    let next = |state: &[f64; 3]| {
        heading += state[2] / rate_hz;
        heading - state[2] / rate_hz
    };
    states.as_chunks::<3>().0.iter().map(next).collect()
}
