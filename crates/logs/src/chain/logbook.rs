use std::collections::BTreeMap;
use std::fmt::Write;

use maneuver::Generator;
use rayon::prelude::*;
use refusal::Invalid;
use schemars::JsonSchema;
use serde::Deserialize;
use ship::engine::Helm;
use ship::model::Vessel;

use super::{Chain, Commanded, Drift, Failed, Hits, Key, Recording, Weather, Wind};
use crate::factor;

/// The forces of azimuth thrusters, by their names in [`crate::Plan`].
const FORCES: [(&str, &str); 3] = [("tau1", "N"), ("tau2", "N"), ("tau3", "N m")];

/// Which maneuvers are recorded, how often, and on which days.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// Samples per sub-experiment that velocities from differences are to have; two rows more are logged.
    pub samples: u32,
    /// Sub-experiments per maneuver.
    pub repeats: u32,
    /// Whether every other repeat is run to the other side.
    pub alternate_sides: bool,
    /// Maneuver → how long it runs before logging begins \[s\].
    pub settle_s: BTreeMap<String, f64>,
    /// The days; the repeats of a maneuver on several days are dealt out in turn.
    pub days: Vec<Day>,
}

/// A day at sea.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Day {
    /// Its name.
    pub name: String,
    /// What was run.
    pub maneuvers: Vec<String>,
    /// The current.
    #[serde(default)]
    pub current: Drift,
    /// The wind, if it acts on the ship.
    pub wind: Option<Wind>,
}

impl Day {
    /// The disturbances of the day.
    pub fn weather(&self) -> Weather {
        Weather { current: self.current, wind: self.wind }
    }
}

/// A ship that carries out maneuvers day by day, and logs them.
#[derive(Clone, Debug)]
pub struct Logbook<'a> {
    chain: Chain<'a>,
    generator: &'a Generator,
    schedule: Schedule,
    seed: u64,
}

/// A simulated log and the truth about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The log as CSV.
    pub text: String,
    /// Its maneuver.
    pub maneuver: String,
    /// Its number among the maneuver's, from 1.
    pub repeat: u32,
    /// Whether it is run to the other side.
    pub mirrored: bool,
    /// The day.
    pub day: String,
    /// Heading at the start of the log \[rad\].
    pub heading: f64,
    /// Share of the samples at which each thruster could not follow its command.
    pub limited: Vec<f64>,
    /// How often it could not.
    pub hits: Vec<Hits>,
}

/// Why logs could not be made.
#[derive(Clone, Debug, PartialEq)]
pub struct NoLogs {
    /// What is at fault.
    pub fault: Fault,
    /// What is wrong with it.
    pub what: Invalid,
}

/// The part of the configuration that is at fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The vessel.
    Vessel,
    /// Its maneuvers.
    Maneuvers,
    /// Its thrusters.
    Thrusters,
}

impl Fault {
    fn is(self, what: Invalid) -> NoLogs {
        NoLogs { fault: self, what }
    }
}

/// The factors from N and N m to the inputs of `vessel`.
///
/// # Errors
/// Other inputs than the forces of azimuth thrusters.
pub fn force_factors(vessel: &Vessel) -> Result<[f64; 3], NoLogs> {
    let inputs = vessel.model.input_variables();
    let fits = inputs.len() == 3 && inputs.iter().zip(FORCES).all(|(input, (name, _))| input.name == name);
    let factors = inputs.iter().zip(FORCES).map(|(input, (_, unit))| factor(unit, &input.unit));
    match factors.collect::<Option<Vec<f64>>>().as_deref() {
        Some([surge, sway, yaw]) if fits => Ok([*surge, *sway, *yaw]),
        _ => {
            let listed: Vec<String> = inputs.iter().map(|i| format!("{} [{}]", i.name, i.unit)).collect();
            let expected = "tau1 [N], tau2 [N], tau3 [N m], the forces of azimuth thrusters";
            let remedy = "simulate another vessel";
            Err(Fault::Vessel.is(Invalid::new("[[input]]", listed.join(", "), expected, remedy)))
        }
    }
}

impl<'a> Logbook<'a> {
    /// Runs the maneuvers of `generator` on `chain` as `schedule` says.
    ///
    /// # Errors
    /// Maneuvers whose names cannot be file names, or that are commanded by sensors which are not logged.
    pub fn new(
        chain: Chain<'a>,
        generator: &'a Generator,
        schedule: Schedule,
        seed: u64,
    ) -> Result<Self, NoLogs> {
        let book = Self { chain, generator, schedule, seed };
        let refuse = |index: usize, found: &str, expected: &str, remedy: &str| {
            let thing = format!("maneuver `{}`", generator.maneuvers()[index].name);
            Err(Fault::Maneuvers.is(Invalid::new(thing, found, expected, remedy)))
        };
        let plain = |name: &str| name.chars().all(|c| c.is_ascii_alphanumeric() || "-.".contains(c));
        for (index, maneuver) in generator.maneuvers().iter().enumerate() {
            if !plain(&maneuver.name) {
                let expected = "letters, digits, - and . alone, for the name of a log";
                return refuse(index, "another character", expected, "rename it");
            }
        }
        let logged = |index: &usize| generator.maneuvers()[*index].reads_logged_sensors();
        match book.maneuvers().into_iter().find(logged) {
            Some(index) => refuse(
                index,
                "commands by the logged sensors",
                "commands by sensors of the helmsman's own, since these logs have neither speed nor rate of turn",
                "use `sensors = \"own\"`",
            ),
            None => Ok(book),
        }
    }

    /// The maneuvers that are run on some day, in the order of the dictionary.
    pub fn maneuvers(&self) -> Vec<usize> {
        let maneuvers = self.generator.maneuvers();
        (0..maneuvers.len()).filter(|i| self.days_of(&maneuvers[*i].name).next().is_some()).collect()
    }

    fn days_of(&self, maneuver: &str) -> impl Iterator<Item = &Day> {
        self.schedule.days.iter().filter(move |day| day.maneuvers.iter().any(|name| name == maneuver))
    }

    /// Simulates all logs: maneuver by maneuver, repeat by repeat.
    ///
    /// # Errors
    /// A maneuver that the model cannot hold, forces that the thrusters cannot produce, a motion without
    /// bounds.
    pub fn entries(&self) -> Result<Vec<Entry>, NoLogs> {
        let repeats = 0..self.schedule.repeats;
        let each = self.maneuvers().into_iter().flat_map(|index| repeats.clone().map(move |r| (index, r)));
        let each: Vec<(usize, u32)> = each.collect();
        // Collected before searching for a failure, so that the first in order is reported.
        let made: Vec<_> = each.into_par_iter().map(|(index, repeat)| self.entry(index, repeat)).collect();
        made.into_iter().collect()
    }

    fn entry(&self, index: usize, repeat: u32) -> Result<Entry, NoLogs> {
        let (chain, schedule) = (&self.chain, &self.schedule);
        let name = self.generator.maneuvers()[index].name.as_str();
        let settle = schedule.settle_s.get(name).map_or(0, |s| (s * chain.rate_hz).round() as usize);
        let rows = settle + schedule.samples as usize + 2;
        let realized = self.generator.realize(index, rows).map_err(|e| Fault::Maneuvers.is(e))?;
        let mirrored = schedule.alternate_sides && repeat % 2 == 1;
        let commanded = Commanded {
            helm: realized.helm.unwrap_or_else(|| Helm::table(&realized.inputs)),
            is_mirrored: mirrored,
            initial: realized.initial,
            samples: rows,
        };
        let days: Vec<&Day> = self.days_of(name).collect();
        let day = days[repeat as usize % days.len()];
        let key = Key { seed: self.seed, maneuver: name, repeat };
        let recording = chain
            .record(key, &commanded, &day.weather(), settle)
            .map_err(|failed| no_logs(failed, name, repeat + 1, chain.rate_hz))?;
        let share = |hits: &Hits| hits.speed.max(hits.speed_rate).max(hits.angle_rate) as f64 / rows as f64;
        Ok(Entry {
            text: recording.csv(chain.rate_hz),
            maneuver: name.to_owned(),
            repeat: repeat + 1,
            mirrored,
            day: day.name.clone(),
            heading: recording.truth.poses.first().map_or(0.0, |pose| pose.psi),
            limited: recording.hits.iter().map(share).collect(),
            hits: recording.hits,
        })
    }
}

fn no_logs(failed: Failed, maneuver: &str, repeat: u32, rate_hz: f64) -> NoLogs {
    match failed {
        Failed::Diverged(at) => {
            Fault::Vessel.is(at.invalid(format!("model in log {repeat} of maneuver `{maneuver}`"), rate_hz))
        }
        Failed::Unreachable { sample, what } => {
            let (force, unit) = FORCES[what.force.min(2)];
            let times = format!(
                "thrusters that produce {force} = {:.4} {unit} where maneuver `{maneuver}` needs {:.4} at sample {sample}",
                what.made, what.wanted
            );
            let expected = "thrusters that can produce surge, sway and yaw together";
            let remedy = "add a thruster elsewhere, or couple the inputs with `follows`";
            Fault::Thrusters.is(Invalid::new("[[thruster]]", times, expected, remedy))
        }
    }
}

impl Recording {
    /// As CSV: time, north, east, heading, and speed and angle of every thruster; rows without a fix have no
    /// position. The header says that the log is simulated.
    pub fn csv(&self, rate_hz: f64) -> String {
        let mut out = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut out, rate_hz);
        out
    }

    fn write(&self, out: &mut String, rate_hz: f64) -> std::fmt::Result {
        out.push_str("simulated t [s],north [m],east [m],heading [deg]");
        for i in 1..=self.settings.first().map_or(0, Vec::len) {
            write!(out, ",thruster {i} [rpm],thruster {i} [deg]")?;
        }
        out.push('\n');
        for (k, heading) in self.heading.iter().enumerate() {
            write!(out, "{:.6},", k as f64 / rate_hz)?;
            match self.fixes[k] {
                Some([north, east]) => write!(out, "{north:.6},{east:.6}")?,
                None => out.push(','),
            }
            write!(out, ",{:.6}", heading.to_degrees())?;
            for setting in &self.settings[k] {
                write!(out, ",{:.4},{:.5}", 60.0 * setting.n, setting.alpha.to_degrees())?;
            }
            out.push('\n');
        }
        Ok(())
    }
}
