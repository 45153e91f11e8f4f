use std::fmt;

use refusal::Invalid;
use ship::engine::refuse_endless;
use ship::model::{DerivedChannel, Model, Vessel};

use super::kind::ManeuverKind;
use super::spec::ManeuverSpec;

/// A maneuver whose inputs come from a table. It is played as written, at its own length.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayedTable {
    /// The maneuver.
    pub maneuver: String,
    /// Name of the table's file.
    pub file: String,
    /// Its length.
    pub samples: usize,
    /// The clock of its rows.
    pub pace: Resampling,
    rate_hz: f64,
    /// Samples × inputs, row-major.
    inputs: Vec<f64>,
}

impl PlayedTable {
    /// The table of `maneuver`, read by `read` (name → CSV); `None` for a generated maneuver.
    pub(super) fn of(
        maneuver: &ManeuverSpec,
        vessel: &Vessel,
        read: impl Fn(&str) -> Result<String, Invalid>,
    ) -> Result<Option<Self>, Invalid> {
        let ManeuverKind::Inputs { file, resample, .. } = &maneuver.kind else { return Ok(None) };
        let (width, rate_hz) = (vessel.model.inputs, vessel.sample_rate_hz);
        let named = |e: Invalid| Invalid { thing: format!("{file}: {}", e.thing), ..e };
        let table = InputTable::parse(&read(file)?, &vessel.model).map_err(named)?;
        for (row, inputs) in table.inputs.chunks_exact(width).enumerate() {
            check_range(vessel, inputs, || format!("{file}: row {}", row + 1))?;
        }
        let (inputs, pace) = table.played(width, rate_hz, *resample).map_err(named)?;
        let (samples, maneuver_name) = (inputs.len() / width, maneuver.name.clone());
        let played = Self { maneuver: maneuver_name, file: file.clone(), samples, pace, rate_hz, inputs };
        match maneuver.duration_s {
            Some(s) if vessel.samples(s) != samples => Err(Invalid::new(
                format!("maneuver `{}`, `duration_s`", maneuver.name),
                format!("{s} s"),
                format!("{} s, as long as its table {file}", played.duration_s()),
                "remove it",
            )),
            _ => Ok(Some(played)),
        }
    }

    /// Its duration \[s\].
    pub fn duration_s(&self) -> f64 {
        self.samples as f64 / self.rate_hz
    }

    /// Its inputs in its first `samples` samples.
    pub(super) fn first(&self, samples: usize) -> Result<&[f64], Invalid> {
        let width = self.inputs.len() / self.samples.max(1);
        self.inputs.get(..samples * width).ok_or_else(|| {
            Invalid::new(
                format!("maneuver `{}`, table {}", self.maneuver, self.file),
                format!("{} samples", self.samples),
                format!("at least the {samples} of the request, since a table is not stretched"),
                "lengthen the table, or request fewer",
            )
        })
    }
}

impl fmt::Display for PlayedTable {
    /// How the table is played, for users.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { maneuver, file, rate_hz, .. } = self;
        write!(f, "{maneuver}: {file} is played in {} s, ", self.duration_s())?;
        match self.pace {
            Resampling::Samples => write!(f, "a row per sample of {rate_hz} Hz (it has no column `t`)"),
            Resampling::Stamps => write!(f, "by its column `t`"),
            Resampling::Resampled(table_hz) => {
                // To three figures: stamps are rounded.
                let table_hz = format!("{table_hz:.3}").parse().unwrap_or(table_hz);
                write!(f, "resampled from {table_hz} to {rate_hz} Hz on straight lines")
            }
        }
    }
}

/// Refuses inputs beyond the vessel's range, which `what` requires.
pub(super) fn check_range(vessel: &Vessel, inputs: &[f64], what: impl Fn() -> String) -> Result<(), Invalid> {
    vessel.check_helm(inputs, &what)?;
    let Some((i, [low, high])) = vessel.beyond_range(inputs) else { return Ok(()) };
    let variable = &vessel.model.input_variables()[i];
    let (from, remedy) = match vessel.motion {
        None => ("its `range` in the vessel's file", "correct the range"),
        Some(_) => ("about what the logs of the model cover", "allow more with --allow=beyond-range"),
    };
    if inputs[i] < low && vessel.model.is_ahead_only(i) {
        return Err(Invalid::new(
            what(),
            format!("{} = {} {}", variable.name, inputs[i], variable.unit),
            format!("a setting from {low} to {high}: the propeller's thrust law holds ahead only"),
            "leave it out, or give the propeller coefficients `astern`",
        ));
    }
    Err(Invalid::new(
        what(),
        format!("{} = {} {}", variable.name, inputs[i], variable.unit),
        format!("a setting from {low} to {high}, {from}"),
        format!("lower speeds and yaw rates, or {remedy}"),
    ))
}

/// Tolerance, as a fraction of a step, for differences between steps and between stamps and samples: stamps are rounded.
const ROUNDED: f64 = 0.1;

/// The time of every row of a table, evenly spaced.
#[derive(Clone, Debug, PartialEq)]
pub struct Stamps {
    /// From the first row on \[s\].
    seconds: Vec<f64>,
    /// Their lines in the file.
    lines: Vec<u64>,
}

impl Stamps {
    /// Stamps with their lines.
    pub(super) fn new(stamps: &[(u64, f64)]) -> Result<Self, Invalid> {
        let steps = || stamps.windows(2).map(|pair| (pair[1].0, pair[1].1 - pair[0].1));
        let mut sorted: Vec<f64> = steps().map(|(_, step)| step).collect();
        sorted.sort_by(f64::total_cmp);
        let usual = sorted.get(sorted.len() / 2).copied().unwrap_or(1.0);
        for (line, step) in steps() {
            if step <= 0.0 {
                let given = if step == 0.0 { "the time of the row before".to_owned() } else { back(step) };
                return Err(refused(line, given, "later times row by row", "correct or remove the row"));
            }
            if (step - usual).abs() > ROUNDED * usual {
                let (given, expected) =
                    (format!("{step} s after the row before"), format!("{usual} s, as mostly"));
                return Err(refused(
                    line,
                    given,
                    &expected,
                    "add the rows that are missing, or correct the times",
                ));
            }
        }
        let first = stamps.first().map_or(0.0, |(_, t)| *t);
        Ok(Self {
            seconds: stamps.iter().map(|(_, t)| t - first).collect(),
            lines: stamps.iter().map(|(line, _)| *line).collect(),
        })
    }

    /// Rows per second; `None` for a single row.
    pub(super) fn rate_hz(&self) -> Option<f64> {
        let last = self.seconds.last().filter(|last| **last > 0.0)?;
        Some((self.seconds.len() - 1) as f64 / last)
    }

    /// Refuses rows that are not the samples of `rate_hz`.
    fn check_rate(&self, rate_hz: f64) -> Result<(), Invalid> {
        let off = |(k, t): &(usize, &f64)| (*t * rate_hz - *k as f64).abs() > ROUNDED;
        let Some((k, t)) = self.seconds.iter().enumerate().find(off) else { return Ok(()) };
        let expected = format!("{} s, a row per sample of the vessel's {rate_hz} Hz", k as f64 / rate_hz);
        let given = format!("{t} s after the first row");
        Err(refused(
            self.lines[k],
            given,
            &expected,
            "add `resample = true` to the maneuver, or correct the times",
        ))
    }

    /// `rows` (N × `width`) linearly interpolated at samples of `rate_hz` from the first time to the last.
    fn resampled(&self, rows: &[f64], width: usize, rate_hz: f64) -> Result<Vec<f64>, Invalid> {
        let last = self.seconds.last().copied().unwrap_or(0.0);
        // The number of samples may be slightly below an integer in binary fractions.
        let samples = (last * rate_hz + 1e-6).floor() as usize + 1;
        refuse_endless("column `t`", samples)?;
        let mut after = 0;
        let sample = |k: usize| {
            let t = (k as f64 / rate_hz).min(last);
            while after + 1 < self.seconds.len() && self.seconds[after] < t {
                after += 1;
            }
            let before = after.saturating_sub(1);
            let step = self.seconds[after] - self.seconds[before];
            let share = if step > 0.0 { (t - self.seconds[before]) / step } else { 1.0 };
            let [from, to] = [before, after].map(|row| &rows[row * width..(row + 1) * width]);
            from.iter()
                .zip(to)
                .map(|(a, b)| if share == 1.0 { *b } else { a + share * (b - a) })
                .collect::<Vec<_>>()
        };
        Ok((0..samples).flat_map(sample).collect())
    }
}

fn back(step: f64) -> String {
    format!("{} s before the row before", -step)
}

fn refused(line: u64, found: String, expected: &str, remedy: &str) -> Invalid {
    Invalid::new(format!("line {line}, column `t`"), found, expected, remedy)
}

/// A table of inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct InputTable {
    /// N × inputs, row-major.
    pub inputs: Vec<f64>,
    stamps: Option<Stamps>,
}

/// The clock by which the rows of a table are played.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resampling {
    /// The vessel's sample rate: the table has no column `t`.
    Samples,
    /// Its column `t`, a row per sample.
    Stamps,
    /// Its column `t` with so many rows per second, interpolated linearly.
    Resampled(f64),
}

impl InputTable {
    /// Reads the inputs of `model` from CSV text, a column per input, a row per sample or with its time in a
    /// column `t` \[s\]; further columns are ignored.
    ///
    /// # Errors
    /// Missing columns (all named), a cell that is not a finite number (line and column named), no row; a
    /// measured disturbance or a derived channel that differs from its value in simulated trials; times that
    /// are not evenly spaced, or under another name.
    pub fn parse(text: &str, model: &Model) -> Result<Self, Invalid> {
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let header = reader.headers().map_err(not_csv)?.clone();
        let place = |name: &str| header.iter().position(|h| h.trim_start_matches('\u{feff}') == name);
        let channels = channels(model, place)?;
        let time = time(&header, model)?;
        let (mut inputs, mut stamps) = (Vec::new(), Vec::new());
        let (mut read_row, mut expected) = (vec![0.0; model.exogenous()], vec![0.0; model.exogenous()]);
        for record in reader.records() {
            let record = record.map_err(not_csv)?;
            let line = record.position().map_or(0, csv::Position::line);
            let cell = |place: usize, name: &str| {
                finite(&record[place]).ok_or_else(|| bad_cell(line, name, &record[place]))
            };
            for (channel, place, name) in &channels {
                read_row[*channel] = cell(*place, name)?;
            }
            expected[..model.inputs].copy_from_slice(&read_row[..model.inputs]);
            model.complete(&mut expected);
            for (channel, _, name) in &channels {
                let (cells, expected) = (read_row[*channel], expected[*channel]);
                if !DerivedChannel::agrees(cells, expected) {
                    return Err(another(line, name, cells, expected));
                }
            }
            if let Some(place) = time {
                stamps.push((line, cell(place, TIME)?));
            }
            inputs.extend_from_slice(&read_row[..model.inputs]);
        }
        if inputs.is_empty() {
            return Err(Invalid::new("rows", "none", "a row per sample", "add rows"));
        }
        let stamps = time.map(|_| Stamps::new(&stamps)).transpose()?;
        Ok(Self { inputs, stamps })
    }

    /// The inputs at `rate_hz`: a row per sample, or linearly interpolated if it is to `resample`.
    ///
    /// # Errors
    /// Times that are not those of the samples; resampling without times.
    pub fn played(
        self,
        width: usize,
        rate_hz: f64,
        resample: bool,
    ) -> Result<(Vec<f64>, Resampling), Invalid> {
        match (self.stamps, resample) {
            (None, false) => Ok((self.inputs, Resampling::Samples)),
            (None, true) => Err(Invalid::new(
                "header",
                "no column `t`",
                "the time of every row for `resample` [s]",
                "add it, or remove `resample` where rows are the vessel's samples",
            )),
            (Some(stamps), false) => stamps.check_rate(rate_hz).map(|()| (self.inputs, Resampling::Stamps)),
            (Some(stamps), true) => {
                let inputs = stamps.resampled(&self.inputs, width, rate_hz)?;
                Ok((inputs, Resampling::Resampled(stamps.rate_hz().unwrap_or(rate_hz))))
            }
        }
    }
}

/// The column of times.
const TIME: &str = "t";

/// For every channel with a column: the index of the channel, that of the column, its name.
fn channels(
    model: &Model,
    place: impl Fn(&str) -> Option<usize>,
) -> Result<Vec<(usize, usize, &str)>, Invalid> {
    let wanted = model.input_names();
    let missing: Vec<&str> = wanted.iter().filter(|w| place(w).is_none()).copied().collect();
    if !missing.is_empty() {
        return Err(Invalid::new(
            "header",
            format!("no column {}", missing.join(", ")),
            format!("a column per input: {}", wanted.join(", ")),
            "add the columns (separated by commas)",
        ));
    }
    let channels = model.variables[3..].iter().map(|v| v.name.as_str()).enumerate();
    Ok(channels.filter_map(|(channel, name)| Some((channel, place(name)?, name))).collect())
}

/// The column of the times, if the table has any.
fn time(header: &csv::StringRecord, model: &Model) -> Result<Option<usize>, Invalid> {
    let names = header.iter().map(|name| name.trim_start_matches('\u{feff}'));
    let is_channel = |name: &str| model.variables[3..].iter().any(|variable| variable.name == name);
    let others: Vec<(usize, &str)> = names.enumerate().filter(|(_, name)| !is_channel(name)).collect();
    if let Some((place, _)) = others.iter().find(|(_, name)| *name == TIME) {
        return Ok(Some(*place));
    }
    let is_time = |name: &str| {
        let name = name.to_lowercase();
        let starts = ["time", "t [", "t (", "stamp", "second"];
        starts.iter().any(|start| name.starts_with(start))
            || [TIME, "t_s", "t_ms", "t_us", "t_ns"].contains(&&*name)
    };
    match others.into_iter().find(|(_, name)| is_time(name)) {
        None => Ok(None),
        Some((_, name)) => Err(Invalid::new(
            "header",
            format!("column `{}`", refusal::foreign(name)),
            "the time of every row as `t`, in seconds, or no time where rows are the vessel's samples",
            "rename it, or remove it",
        )),
    }
}

fn finite(cell: &str) -> Option<f64> {
    cell.parse::<f64>().ok().filter(|x| x.is_finite())
}

fn not_csv(error: csv::Error) -> Invalid {
    Invalid::new(
        "table",
        error.to_string(),
        "CSV with a header and as many cells in every row",
        "correct the file",
    )
}

fn bad_cell(line: u64, column: &str, cell: &str) -> Invalid {
    let given = if cell.is_empty() { "nothing".to_owned() } else { format!("`{cell}`") };
    Invalid::new(format!("line {line}, column `{column}`"), given, "a finite number", "correct the cell")
}

/// The refusal of a column that simulated trials would not follow.
fn another(line: u64, column: &str, found: f64, expected: f64) -> Invalid {
    Invalid::new(
        format!("line {line}, column `{column}`"),
        found.to_string(),
        format!("{expected}, as the vessel's file has it in simulated trials"),
        "remove the column, or correct the definition in the vessel's file",
    )
}
