use std::path::Path;

use artifact::{Digest, Provenance, Staged, commit, stage_document};
use logs::chain::{Chain, Failed, Hits, Key};
use rayon::prelude::*;
use vessel::{Generator, Source, Vessel};

use super::csv::text;
use super::file::LogsFile;
use crate::failure::Failure;
use crate::simulate::diverged;
use study::documents::{SimulatedLogsDocument, SimulatedRecording};
use study::trajectories::SIMULATED_LOGS;

/// The hand-written files, for messages.
pub struct Files<'a> {
    /// `vessel.toml`.
    pub vessel: &'a Path,
    /// `dictionary.toml`.
    pub dictionary: &'a Path,
    /// `logs.toml`.
    pub logs: &'a Path,
}

/// Logs to be simulated.
pub struct SimulatedLogs<'a> {
    files: Files<'a>,
    vessel: &'a Vessel,
    generator: &'a Generator,
    config: &'a LogsFile,
    seed: u64,
    parameters: Vec<f64>,
    units: [f64; 3],
}

/// One simulated log, and what there is to know of it.
pub struct Made {
    /// Its file's text.
    pub text: String,
    /// What `simulated.json` says of it.
    pub summary: SimulatedRecording,
    hits: Vec<Hits>,
}

/// What azimuth thrusters make, by the names that `ingest` gives it.
const FORCES: [(&str, &str); 3] = [("tau1", "N"), ("tau2", "N"), ("tau3", "N m")];

impl<'a> SimulatedLogs<'a> {
    /// Checks that the pieces fit each other.
    ///
    /// # Errors
    /// What [`LogsFile::check`] refuses, a vessel without true parameters or without the forces of azimuth thrusters for
    /// inputs, maneuvers whose names are no names of files.
    pub fn new(
        files: Files<'a>,
        vessel: &'a Vessel,
        generator: &'a Generator,
        config: &'a LogsFile,
        seed: u64,
    ) -> Result<Self, Failure> {
        let names: Vec<&str> = generator.maneuvers().iter().map(|m| m.name.as_str()).collect();
        config.check(&names, vessel.sample_rate_hz).map_err(|e| Failure::invalid(files.logs, &e))?;
        let parameters = vessel.parameters(Source::Value).map_err(|e| Failure::invalid(files.vessel, &e))?;
        let units = units(files.vessel, vessel)?;
        let plain = |name: &str| name.chars().all(|c| c.is_ascii_alphanumeric() || "-.".contains(c));
        if let Some(name) = names.iter().find(|name| !plain(name)) {
            let thing = format!("maneuver `{name}`");
            let expected = "letters, digits, - and . alone, for the name of a log";
            return Err(Failure::refuse(
                files.dictionary,
                &thing,
                "another character",
                expected,
                "rename it",
            ));
        }
        Ok(Self { files, vessel, generator, config, seed, parameters, units })
    }

    /// Number of logs.
    pub fn recordings(&self) -> usize {
        self.maneuvers().len() * self.config.repeats as usize
    }

    /// The maneuvers that are run on some day, in the dictionary's order.
    pub fn maneuvers(&self) -> Vec<usize> {
        let names = self.generator.maneuvers().iter().map(|m| m.name.as_str());
        names.enumerate().filter(|(_, name)| !self.config.days_of(name).is_empty()).map(|(i, _)| i).collect()
    }

    /// Simulates all logs: maneuver by maneuver, repeat by repeat.
    ///
    /// # Errors
    /// A maneuver that the model cannot hold, forces that the thrusters cannot make, a motion without bounds.
    pub fn all(&self) -> Result<Vec<Made>, Failure> {
        let repeats = self.config.repeats;
        let each = self.maneuvers().into_iter().flat_map(|index| (0..repeats).map(move |r| (index, r)));
        let each: Vec<(usize, u32)> = each.collect();
        let made: Vec<Result<Made, Failure>> =
            each.into_par_iter().map(|(index, repeat)| self.one(index, repeat)).collect();
        made.into_iter().collect()
    }

    fn one(&self, index: usize, repeat: u32) -> Result<Made, Failure> {
        let (config, name) = (self.config, self.generator.maneuvers()[index].name.as_str());
        let settle = config.settle_s.get(name).map_or(0, |s| self.vessel.samples(*s));
        let rows = settle + config.samples as usize + 2;
        let realized =
            self.generator.realize(index, rows).map_err(|e| Failure::invalid(self.files.dictionary, &e))?;
        let mirrored = config.alternate_sides && repeat % 2 == 1;
        let side = if mirrored { -1.0 } else { 1.0 };
        let forces: Vec<[f64; 3]> = realized
            .inputs
            .chunks_exact(self.vessel.model.inputs)
            .map(|row| [row[0], side * row[1], side * row[2]])
            .collect();
        let days = config.days_of(name);
        let day = &config.day[days[repeat as usize % days.len()]];
        let chain = Chain {
            model: &self.vessel.model,
            parameters: &self.parameters,
            rate_hz: self.vessel.sample_rate_hz,
            units: self.units,
            actuators: &config.thruster,
            gnss: config.gnss,
            compass: config.heading,
            hull: config.hull,
            scatter_std: config.scatter_std,
            course_rad: config.course_rad,
        };
        let key = Key { seed: self.seed, maneuver: name, repeat };
        let recording = chain
            .record(key, &forces, realized.initial, &day.weather(), settle)
            .map_err(|failed| self.failed(name, repeat, failed))?;
        let text = text(&recording, self.vessel.sample_rate_hz);
        let share = |hits: &Hits| hits.speed.max(hits.speed_rate).max(hits.angle_rate) as f64 / rows as f64;
        let summary = SimulatedRecording {
            file: format!("{name}_{:02}.csv", repeat + 1),
            digest: Digest::of_bytes(text.as_bytes()),
            maneuver: name.to_owned(),
            repeat: u64::from(repeat) + 1,
            mirrored,
            day: day.name.clone(),
            heading: recording.truth.poses.first().map_or(0.0, |pose| pose.psi),
            limited: recording.hits.iter().map(share).collect(),
        };
        Ok(Made { text, summary, hits: recording.hits })
    }

    fn failed(&self, name: &str, repeat: u32, failed: Failed) -> Failure {
        match failed {
            Failed::Diverged(at) => {
                diverged(self.files.vessel, &format!("model in log {} of maneuver `{name}`", repeat + 1), at)
            }
            Failed::Unreachable { sample, what } => {
                let (force, unit) = FORCES[what.force.min(2)];
                Failure::refuse(
                    self.files.logs,
                    "[[thruster]]",
                    &format!(
                        "thrusters that make {force} = {:.4} {unit} where maneuver `{name}` needs {:.4} at sample {sample}",
                        what.made, what.wanted
                    ),
                    "thrusters that can make surge, sway and yaw together",
                    "add a thruster elsewhere, or couple the inputs with `follows`",
                )
            }
        }
    }

    /// What `simulated.json` says.
    pub fn document(&self, made: &[Made]) -> SimulatedLogsDocument {
        SimulatedLogsDocument {
            label: SIMULATED_LOGS.to_owned(),
            vessel: self.vessel.name.clone(),
            sample_rate_hz: self.vessel.sample_rate_hz,
            samples: u64::from(self.config.samples),
            recordings: made.iter().map(|made| made.summary.clone()).collect(),
            statements: self.statements(made),
        }
    }

    /// Which limits were hit, thruster by thruster.
    fn statements(&self, made: &[Made]) -> Vec<String> {
        let kinds = ["highest speed", "fastest change of speed", "fastest turn"];
        let counts = |hits: &Hits| [hits.speed, hits.speed_rate, hits.angle_rate];
        let mut statements = Vec::new();
        for thruster in 0..self.config.thruster.len() {
            for (i, kind) in kinds.into_iter().enumerate() {
                let each = || made.iter().map(|made| counts(&made.hits[thruster])[i]);
                let (samples, logs) = (each().sum::<usize>(), each().filter(|count| *count > 0).count());
                if logs > 0 {
                    statements.push(format!(
                        "thruster {} was held at its {kind} at {samples} samples of {logs} logs",
                        thruster + 1
                    ));
                }
            }
        }
        statements
    }
}

/// What N and N m are multiplied by to be the vessel's inputs.
fn units(path: &Path, vessel: &Vessel) -> Result<[f64; 3], Failure> {
    let inputs = &vessel.model.variables[3..3 + vessel.model.inputs];
    let fits = inputs.len() == 3 && inputs.iter().zip(FORCES).all(|(input, (name, _))| input.name == name);
    let factors = inputs.iter().zip(FORCES).map(|(input, (_, unit))| logs::factor(unit, &input.unit));
    match factors.collect::<Option<Vec<f64>>>().as_deref() {
        Some([surge, sway, yaw]) if fits => Ok([*surge, *sway, *yaw]),
        _ => {
            let found: Vec<String> = inputs.iter().map(|i| format!("{} [{}]", i.name, i.unit)).collect();
            let expected = "tau1 [N], tau2 [N], tau3 [N m], the forces of azimuth thrusters";
            Err(Failure::refuse(path, "[[input]]", &found.join(", "), expected, "simulate another vessel"))
        }
    }
}

/// Writes the logs and, beside them, `out`: all or nothing.
///
/// # Errors
/// Output that fails.
pub fn publish(
    out: &Path,
    made: &[Made],
    document: &SimulatedLogsDocument,
    provenance: &Provenance,
) -> Result<(), Failure> {
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
    let missing = folder.filter(|folder| !folder.is_dir());
    if let Some(folder) = missing {
        std::fs::create_dir(folder).map_err(|e| artifact::Error::io(folder, "create", e))?;
    }
    let staged = || -> Result<(), Failure> {
        let mut files = Vec::with_capacity(made.len() + 1);
        for made in made {
            let path = crate::cli::beside(out, &made.summary.file);
            files.push(Staged::bytes(path, made.text.as_bytes())?);
        }
        files.push(stage_document(out, provenance, document)?);
        Ok(commit(files)?)
    };
    staged().inspect_err(|_| {
        if let Some(folder) = missing {
            // Only an empty folder goes; the failure itself is reported.
            let _ = std::fs::remove_dir(folder);
        }
    })
}
