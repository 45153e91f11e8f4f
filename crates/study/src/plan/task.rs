//! The task in `plan.toml`, as the planner takes it.

use std::collections::BTreeMap;
use std::path::Path;

use chart::route::Timestamp;
use files::{Digest, Error, Provenance};
use plan::voyage::{
    Area, Brief, Daylight, ErrorsFrom, Failing, Slot, Task, Tide, TideRow, Times, current_m_s, utc,
};
use plan::{Approach, DerivedHandling, Deviations, Handling, Tolerance};
use refusal::Invalid;
use ship::engine::{Helm, MOST_CURRENT_M_S};
use ship::model::Vessel;

use super::file::PlanFile;
use crate::documents::ModelDocument;
use crate::written::files::{read_dictionary, read_model};

/// By how much of it the length over all may differ from that between perpendiculars.
const OVER_ALL: f64 = 0.2;

impl PlanFile {
    /// Refuses speeds outside the range of a model's logs.
    fn check_speeds(&self, vessel: &Vessel) -> Result<(), Invalid> {
        let Some([[low, high], ..]) = vessel.motion else { return Ok(()) };
        match self.speed_mode.iter().find(|mode| !(low..=high).contains(&mode.speed_m_s)) {
            None => Ok(()),
            Some(mode) => Err(Invalid::new(
                format!("speed mode `{}`", mode.name),
                format!("{} m/s", mode.speed_m_s),
                format!("{low:.4} to {high:.4} m/s, about what the logs of the model cover"),
                "choose such a speed, or allow it with --allow=beyond-range",
            )),
        }
    }

    /// The task for `vessel`.
    ///
    /// # Errors
    /// Invalid numbers, or ones beyond the vessel's limits: names the key.
    pub fn task(&self, vessel: &Vessel) -> Result<Task, Invalid> {
        self.check()?;
        self.check_speeds(vessel)?;
        vessel.check_length(self.hull.length_m, "`hull.length_m`", Some(OVER_ALL))?;
        let derived = DerivedHandling::of(vessel, &self.speed_mode, self.hull.length_m)?;
        let handling = self.handling.completed(&derived)?;
        let approach = self.approach(&handling);
        self.check_sensors(&approach.tolerance)?;
        let area = self.area.area()?;
        let departure = self.departure.as_deref().map(|at| second("departure", at)).transpose()?;
        let bounds = self.slot(&area, departure)?;
        let until = |(key, at_s): (&'static str, f64)| Some(Slot { key, lasts_s: at_s - departure? as f64 });
        Ok(Task {
            slot: bounds[1].and_then(until),
            times: Times { table: Vec::new(), bounds },
            area,
            cell_m: self.cell_m,
            headings: self.headings,
            raster_per_cell: self.raster_per_cell,
            uncharted: self.uncharted,
            hull: self.hull,
            safety: self.safety,
            deviations: kept(vessel, Deviations::Box(self.safety.parameter_error)),
            sensors: self.sensors.into(),
            measurement: self.measurement,
            errors_from: None,
            changes: self.changes(),
            known_current_m_s: self.known_current.map_or([0.0; 2], |known_current| {
                current_m_s(known_current.speed_m_s, known_current.towards_deg)
            }),
            handling,
            derived,
            approach,
            modes: self.speed_mode.clone(),
            speed_limits: self.speed_limit.clone(),
            maneuvers: self.maneuver.clone(),
            informative_s: self.informative_s,
            departure,
            start: self.start.clone(),
            goal: self.goal.clone(),
            cost: self.cost,
            tide: None,
            on_node: false,
            failing: Failing { abort: self.abort, drift_s: self.abort_drift_s, room_m: self.abort_room_m },
            crossing_rad: self.traffic.crossing_deg.to_radians(),
        })
    }
}

/// `deviations` of `vessel`: numbers of a ship with forces stay within their bounds.
fn kept(vessel: &Vessel, deviations: Deviations) -> Deviations {
    let bounds = Some(&vessel.model).filter(|model| !model.has_regressors()).and_then(|model| model.bounds());
    deviations.within(bounds)
}

/// A time of day with its offset, the value of `key`, as seconds since 1970 in UTC.
pub fn second(key: &str, text: &str) -> Result<i64, Invalid> {
    let refused = |_| {
        let expected = "date, time and offset, such as 2026-06-01T08:00:00Z or 2026-06-01T11:00:00+03:00";
        Invalid::new(format!("`{key}`"), format!("`{text}`"), expected, "write it so")
    };
    text.parse::<Timestamp>().map(Timestamp::as_second).map_err(refused)
}

/// Default tolerances of a settled vessel: fraction of the allowed yaw rate, and speed \[m/s\].
const YAW_RATE: f64 = 0.15;
const SPEED_M_S: f64 = 0.1;

impl PlanFile {
    /// The approach to a maneuver, with tolerances in metres and radians.
    fn approach(&self, handling: &Handling) -> Approach {
        let approach = self.approach;
        let known = self.known_current.map_or(0.0, |current| current.speed_m_s);
        let crabbing_m_s = known + self.safety.unknown_current_m_s;
        let speed_m_s = approach.tolerance_m_s.unwrap_or(SPEED_M_S);
        Approach {
            run_in_s: approach.run_in_s,
            tolerance: Tolerance {
                distance_m: approach.tolerance_cells * self.cell_m,
                heading_rad: approach.tolerance_deg.to_radians(),
                surge_m_s: speed_m_s,
                sway_m_s: speed_m_s + crabbing_m_s,
                yaw_rate_rad_s: approach.tolerance_rad_s.unwrap_or(YAW_RATE * handling.turn_rate_rad_s),
            },
        }
    }
}

// The table of tides that `plan.toml` names.

/// Columns of a table: time and height, and the stream if known.
const COLUMNS: [&str; 4] = ["time", "level_m", "stream_m_s", "towards_deg"];
/// Upper bound on a plausible tide level \[m\].
const MOST_LEVEL_M: f64 = 30.0;

/// `task` in the tide that `config` names, if it names one; the table's file is relative to `config_file`, and its digest is
/// noted.
///
/// # Errors
/// A table that cannot be read, is invalid, or does not cover the trial; a trial without departure or end.
pub fn in_tide(
    config_file: &Path,
    config: &PlanFile,
    task: Task,
    provenance: &mut Provenance,
) -> Result<Task, Error> {
    let Some(spec) = &config.tide else { return Ok(task) };
    let of_config = |invalid| Error::invalid(config_file, invalid);
    let Some(departure) = task.departure else {
        let remedy = "say when the trial begins, such as departure = \"2026-06-01T08:00:00Z\"";
        let expected = "a time, since there is a [tide]";
        return Err(Error::refuse(config_file, "`departure`", "none", expected, remedy));
    };
    let until = second("tide.until", &spec.until).map_err(of_config)?;
    if until <= departure {
        let expected = format!("a time after the departure, {}", utc(departure as f64));
        let given = utc(until as f64);
        return Err(Error::refuse(config_file, "`tide.until`", given, expected, "correct it"));
    }
    let path = config_file.parent().unwrap_or(Path::new("")).join(&spec.file);
    let bytes = files::read(&path)?;
    provenance.inputs.insert("tide".to_owned(), Digest::of_bytes(&bytes));
    let table = table(&bytes).map_err(|invalid| Error::invalid(&path, invalid))?;
    let tide = Tide::worst(&table, departure as f64, (until - departure) as f64).ok_or_else(|| {
        let [first, last] = [table.first(), table.last()].map(|row| utc(row.map_or(0.0, |row| row.at_s)));
        let expected = format!("one that covers {} to {}", utc(departure as f64), utc(until as f64));
        let remedy = "take a longer table, or another `departure` or `until`";
        Error::refuse(&path, "table", format!("{first} to {last}"), expected, remedy)
    })?;
    let times = Times { table, bounds: task.times.bounds };
    Ok(Task { times, ..task.with_tide(tide) })
}

/// The rows of a table, whose times ascend.
fn table(bytes: &[u8]) -> Result<Vec<TideRow>, Invalid> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes);
    let header = reader.headers().map_err(no_table)?.clone();
    let place = |name: &str| header.iter().position(|column| column.trim_start_matches('\u{feff}') == name);
    let needed = |name: &str| {
        place(name).ok_or_else(|| {
            let given = header.iter().collect::<Vec<_>>().join(", ");
            let expected = "columns time, level_m, and stream_m_s, towards_deg where the stream is known";
            Invalid::new(format!("column `{name}`"), given, expected, "name the columns so in the first line")
        })
    };
    let stream = place(COLUMNS[2]).is_some() || place(COLUMNS[3]).is_some();
    let places = [Some(needed(COLUMNS[0])?), Some(needed(COLUMNS[1])?)].into_iter().chain(if stream {
        [Some(needed(COLUMNS[2])?), Some(needed(COLUMNS[3])?)]
    } else {
        [None, None]
    });
    let places: Vec<Option<usize>> = places.collect();
    let mut rows: Vec<TideRow> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(no_table)?;
        let line = record.position().map_or(0, csv::Position::line);
        let row = row(&record, &places, line)?;
        if rows.last().is_some_and(|last| last.at_s >= row.at_s) {
            let (found, expected) = (utc(row.at_s), "a later time than in the line before");
            return Err(Invalid::new(format!("line {line}, `time`"), found, expected, "sort the table"));
        }
        rows.push(row);
    }
    Ok(rows)
}

fn row(record: &csv::StringRecord, places: &[Option<usize>], line: u64) -> Result<TideRow, Invalid> {
    let cell = |column: usize| places[column].map(|place| record.get(place).unwrap_or(""));
    let number = |column: usize, least: f64, most: f64| {
        let Some(text) = cell(column) else { return Ok(0.0) };
        let value = text.parse::<f64>().ok().filter(|value| (least..=most).contains(value));
        value.ok_or_else(|| {
            let expected = format!("a number from {least} to {most}");
            let thing = format!("line {line}, `{}`", COLUMNS[column]);
            Invalid::new(thing, format!("`{text}`"), expected, "correct it")
        })
    };
    let at_s = second(&format!("line {line}, time"), cell(0).unwrap_or(""))? as f64;
    let level_m = number(1, -MOST_LEVEL_M, MOST_LEVEL_M)?;
    let (speed, towards_deg) = (number(2, 0.0, MOST_CURRENT_M_S)?, number(3, 0.0, 360.0)?);
    Ok(TideRow { at_s, level_m, stream_m_s: current_m_s(speed, towards_deg) })
}

fn no_table(error: csv::Error) -> Invalid {
    Invalid::new("table", error.to_string(), "rows of as many cells as the first line", "export it again")
}

impl PlanFile {
    /// The keys and times \[s since 1970, UTC\] that the slot of a trial that begins at `departure` begins and ends with, where
    /// `[slot]` has them.
    pub(super) fn slot(
        &self,
        area: &Area,
        departure: Option<i64>,
    ) -> Result<[Option<(&'static str, f64)>; 2], Invalid> {
        let Some(spec) = &self.slot else { return Ok([None; 2]) };
        let time = |key: &str, text: &Option<String>| {
            text.as_ref().map(|text| second(key, text)).transpose().map(|at| at.map(|at| at as f64))
        };
        let (from, until) = (time("slot.from", &spec.from)?, time("slot.until", &spec.until)?);
        if from.is_none() && until.is_none() && !spec.daylight {
            let expected = "`from`, `until` or `daylight = true`";
            return Err(Invalid::new("`slot`", "none of its keys", expected, "add one, or leave it out"));
        }
        if let (Some(from), Some(until)) = (from, until)
            && until <= from
        {
            let expected = format!("a time after `slot.from`, {}", utc(from));
            return Err(Invalid::new("`slot.until`", utc(until), expected, "correct one of them"));
        }
        let Some(departure) = departure.map(|at| at as f64) else {
            let remedy = "say when the trial begins, such as departure = \"2026-06-01T08:00:00Z\"";
            return Err(Invalid::new("`departure`", "none", "a time, since there is a [slot]", remedy));
        };
        let bounds = [("slot.from", from), ("slot.until", until)];
        let day = if spec.daylight { daylight(area, departure)? } else { None };
        let [begins, ends] = [0, 1].map(|k: usize| {
            let sun = day.map(|day| ("slot.daylight", day[k]));
            [bounds[k].1.map(|at| (bounds[k].0, at)), sun].into_iter().flatten()
        });
        let begins = begins.max_by(|a, b| a.1.total_cmp(&b.1));
        let ends = ends.min_by(|a, b| a.1.total_cmp(&b.1));
        let outside = |expected: String| {
            let remedy = "take another departure, or another slot";
            Err(Invalid::new("`departure`", utc(departure), expected, remedy))
        };
        match (begins, ends) {
            (Some((key, at)), _) if departure < at => outside(format!("{} or later, by `{key}`", utc(at))),
            (_, Some((key, at))) if departure >= at => outside(format!("before {}, by `{key}`", utc(at))),
            _ => Ok([begins, ends]),
        }
    }
}

/// Sunrise and sunset at the centre of the area, to the second within the day; `None` if the sun does not set.
fn daylight(area: &Area, departure: f64) -> Result<Option<[f64; 2]>, Invalid> {
    let [longitude_deg, latitude_deg] = area.centre_deg();
    match Daylight::of([longitude_deg, latitude_deg], departure) {
        Daylight::Between([rise, set]) => Ok(Some([rise.ceil(), set.floor()])),
        Daylight::Always => Ok(None),
        Daylight::Never => {
            let given = format!("no sunrise at latitude {latitude_deg:.1} on the day of {}", utc(departure));
            let remedy = "take another day, or leave `daylight` out";
            Err(Invalid::new("`slot.daylight`", given, "a day with sun", remedy))
        }
    }
}

// The vessels that a plan has to hold for, where the covariance of a model or the priors of its numbers state them.

/// `task` with the vessels within `safety.standard_errors` of the model at `model`, which `vessel` is of; as it is
/// without that key. Of a `vessel.toml` with forces the priors of its numbers count. `config` is at `file`.
///
/// # Errors
/// A `vessel.toml` of terms per sample, or whose numbers have no priors; a model without a covariance, or with one that is
/// not positive.
pub fn uncertain(
    [file, model]: [&Path; 2],
    config: &PlanFile,
    vessel: &Vessel,
    task: Task,
) -> Result<Task, Error> {
    let Some(errors) = config.safety.standard_errors else { return Ok(task) };
    let (deviations, from) = match (read_model(model)?, vessel.model.has_regressors()) {
        (Some(document), _) => {
            let lacking = || lacking([file, model], errors, "which has none");
            (covariant(model, vessel, &document, errors)?.ok_or_else(lacking)?, ErrorsFrom::Covariance)
        }
        (None, false) => (by_priors(model, vessel, errors)?, ErrorsFrom::Priors),
        (None, true) => return Err(lacking([file, model], errors, "which is no model.json")),
    };
    Ok(Task { deviations: kept(vessel, deviations), errors_from: Some(from), ..task })
}

fn lacking([file, model]: [&Path; 2], errors: f64, found: &str) -> Error {
    let given = format!("{errors} and {}, {found}", model.display());
    let remedy = "give a model.json of `estimate --fit together`, or state `parameter_error`";
    Error::invalid(file, Invalid::new("`safety.standard_errors`", given, "a model with a covariance", remedy))
}

/// Within so many standard errors of the covariance of a model; `None` without one.
fn covariant(
    model: &Path,
    vessel: &Vessel,
    document: &ModelDocument,
    errors: f64,
) -> Result<Option<Deviations>, Error> {
    let Some(covariance) = document.errors_of_parameters() else { return Ok(None) };
    let place = |name: &str| covariance.names.iter().position(|row| row == name);
    let places: Vec<Option<usize>> = vessel.model.parameter_names().map(place).collect();
    let entry = |a: &Option<usize>, b: &Option<usize>| match (a, b) {
        (Some(a), Some(b)) => covariance.entries[a * covariance.names.len() + b],
        _ => 0.0,
    };
    let row = |a: &Option<usize>| places.iter().map(|b| entry(a, b)).collect();
    let rows: Vec<Vec<f64>> = places.iter().map(row).collect();
    let names: Vec<&str> = vessel.model.parameter_names().collect();
    let deviations = Deviations::ellipsoid(&rows, errors).map_err(|refused| {
        let found = format!("{}: {}", names[refused.parameter], refused.found);
        let remedy = "estimate the model again from more recordings, or state `parameter_error`";
        Error::invalid(model, Invalid::new("`data.covariance`", found, "a positive definite matrix", remedy))
    })?;
    Ok(Some(deviations))
}

/// Within so many standard deviations of the priors of a ship with forces.
fn by_priors(path: &Path, vessel: &Vessel, errors: f64) -> Result<Deviations, Error> {
    let priors = vessel.model.prior_deviations().into_iter();
    let deviations = vessel.model.parameter_names().zip(priors).map(|(name, prior)| {
        prior.ok_or_else(|| {
            let expected = "a `prior`, which `safety.standard_errors` of plan.toml counts in";
            let remedy = "state one, fix the number, or take `safety.parameter_error`";
            Error::refuse(path, format!("parameter `{name}`"), "no prior", expected, remedy)
        })
    });
    Ok(Deviations::independent(&deviations.collect::<Result<Vec<f64>, _>>()?, errors))
}

/// The commands of the maneuvers that `brief` names and that depend on the ship's motion, by name, as `dictionary.toml` at `path`
/// states them; none without that file.
///
/// # Errors
/// A dictionary that is refused, or another one than the runs are of.
pub fn programs(
    path: Option<&Path>,
    brief: &Brief,
    provenance: &mut Provenance,
) -> Result<BTreeMap<String, Helm>, Error> {
    let Some(path) = path else { return Ok(BTreeMap::new()) };
    let generator = read_dictionary(path, &brief.vessel, provenance)?;
    // A task that names none is refused where its pieces are cut.
    let named = brief.named().unwrap_or_default();
    let runs = named.iter().filter_map(|maneuver| brief.run(&maneuver.name));
    let mut programs = BTreeMap::new();
    for run in runs {
        let name = &run.segments[0].maneuver;
        let index = generator.maneuvers().iter().position(|maneuver| maneuver.name == *name);
        let program = index.map_or(Ok(None), |index| generator.program(index, run.samples()));
        if let Some(helm) = program.map_err(|e| crate::invalid(path, &e))? {
            programs.insert(name.clone(), helm);
        }
    }
    Ok(programs)
}
