use refusal::Invalid;
use ship::model::{DerivedChannel, Model};

use super::stamps::Stamps;

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
        let (mut found, mut expected) = (vec![0.0; model.exogenous()], vec![0.0; model.exogenous()]);
        for record in reader.records() {
            let record = record.map_err(not_csv)?;
            let line = record.position().map_or(0, csv::Position::line);
            let cell = |place: usize, name: &str| {
                finite(&record[place]).ok_or_else(|| bad_cell(line, name, &record[place]))
            };
            for (channel, place, name) in &channels {
                found[*channel] = cell(*place, name)?;
            }
            expected[..model.inputs].copy_from_slice(&found[..model.inputs]);
            model.complete(&mut expected);
            for (channel, _, name) in &channels {
                let (found, expected) = (found[*channel], expected[*channel]);
                if !DerivedChannel::agrees(found, expected) {
                    return Err(another(line, name, found, expected));
                }
            }
            if let Some(place) = time {
                stamps.push((line, cell(place, TIME)?));
            }
            inputs.extend_from_slice(&found[..model.inputs]);
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
///
/// # Errors
/// A column whose name suggests times: its rows must not be played without them.
fn time(header: &csv::StringRecord, model: &Model) -> Result<Option<usize>, Invalid> {
    let names = header.iter().map(|name| name.trim_start_matches('\u{feff}'));
    let own = |name: &str| model.variables[3..].iter().any(|variable| variable.name == name);
    let others: Vec<(usize, &str)> = names.enumerate().filter(|(_, name)| !own(name)).collect();
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
    let found = if cell.is_empty() { "nothing".to_owned() } else { format!("`{cell}`") };
    Invalid::new(format!("line {line}, column `{column}`"), found, "a finite number", "correct the cell")
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
