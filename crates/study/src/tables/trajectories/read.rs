use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use files::{Column, ColumnSpec, Digest, Error, Provenance, Shard, Table, TableReader};
use refusal::check_name;
use regression::pooled::Recorded;
use ship::engine::{Run, Segment};
use ship::model::DerivedChannel;

use super::{ID, Layout, VERSION, commanded};

/// Reads trajectories block by block; every run is within a block.
pub struct TrajectoryReader {
    table: TableReader,
    path: PathBuf,
    columns: Vec<String>,
    width: usize,
    /// The indices of the file's columns of inputs, disturbances and derived channels among those of the model.
    places: Vec<usize>,
    /// Channels that follow from others, and whether the file has a column of each.
    derived: Vec<(DerivedChannel, bool)>,
    /// Inputs of which the file has what was commanded, and those columns.
    commanded: Vec<(String, String)>,
    truth: bool,
    /// Number of inputs that instruments are simulated with; 0 if the file does not have them.
    instruments: usize,
    rate_hz: f64,
    /// The first row of every run that was read, by design and number.
    known: Mutex<HashMap<String, HashMap<i32, usize>>>,
}

/// Samples per second of the trajectories at `path`, by their first step; `None` of a table that has none.
pub fn rate_of(path: &Path) -> Option<f64> {
    let block = TableReader::open(path, ID, VERSION).ok()?.read_block(0, &["t"]).ok()?;
    let step_s = block.columns[0].value_at(1)? - block.columns[0].value_at(0)?;
    (step_s > 0.0).then_some(1.0 / step_s)
}

impl TrajectoryReader {
    /// Opens `path` and checks its columns and units. Derived channels without a column are computed.
    ///
    /// # Errors
    /// See [`TableReader::open`] and [`TableReader::require`].
    pub fn open(path: &Path, layout: &Layout, rate_hz: f64) -> Result<Self, Error> {
        let table = TableReader::open(path, ID, VERSION)?;
        let there = |name: &str| table.columns().iter().any(|c| c.name == name);
        let with_column =
            |derived_channel: &DerivedChannel| there(&layout.exogenous[derived_channel.variable - 3].0);
        let derived: Vec<(DerivedChannel, bool)> =
            layout.derived.iter().map(|channel| (channel.clone(), with_column(channel))).collect();
        let absent = |place: usize| derived.iter().any(|(channel, t)| !t && channel.variable - 3 == place);
        let places: Vec<usize> = (0..layout.exogenous.len()).filter(|place| !absent(*place)).collect();
        let wanted = layout.required().into_iter().enumerate();
        let wanted = wanted.filter(|(i, _)| *i < 6 || !absent(i - 6));
        let required: Vec<ColumnSpec> = wanted.map(|(_, column)| column).collect();
        table.require(&required)?;
        let mut columns: Vec<String> = required.iter().map(|c| c.name.clone()).collect();
        let truth = ["u", "v", "r"].into_iter().all(there);
        if truth {
            columns.extend(["u", "v", "r"].map(str::to_owned));
        }
        let of_instruments = layout.of_instruments();
        let instruments =
            if of_instruments.iter().all(|column| there(&column.name)) { of_instruments.len() } else { 0 };
        if instruments > 0 {
            table.require(&of_instruments)?;
            columns.extend(of_instruments.into_iter().map(|column| column.name));
        }
        let inputs = layout.exogenous[..layout.inputs].iter().map(|(name, _)| name.clone());
        let commanded = inputs.map(|name| (commanded(&name), name)).filter(|(column, _)| there(column));
        let commanded = commanded.map(|(column, name)| (name, column)).collect();
        let (width, known, path) = (layout.exogenous.len(), Mutex::default(), path.to_owned());
        Ok(Self {
            table,
            path,
            columns,
            width,
            places,
            derived,
            commanded,
            truth,
            instruments,
            rate_hz,
            known,
        })
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.table.blocks()
    }

    /// Number of rows, and of those in the largest block.
    pub fn rows(&self) -> (usize, usize) {
        let largest = (0..self.blocks()).map(|i| self.table.block_rows(i)).max();
        (self.table.rows(), largest.unwrap_or(0))
    }

    /// Whether the file has the true states, and with them the state that a run starts from.
    pub fn true_states(&self) -> bool {
        self.truth
    }

    /// The provenance of the trajectories.
    pub fn provenance(&self) -> &Provenance {
        self.table.provenance()
    }

    /// Digest of the file.
    pub fn digest(&self) -> Digest {
        self.table.digest()
    }

    /// Refuses one shard of several.
    ///
    /// # Errors
    /// Names the shard.
    pub fn whole(&self) -> Result<(), Error> {
        match &self.table.provenance().shard {
            None => Ok(()),
            Some(shard) => Err(refuse_shard(&self.path, shard)),
        }
    }

    /// All runs.
    ///
    /// # Errors
    /// See [`TrajectoryReader::runs`].
    pub fn all(&self) -> Result<Vec<Run>, Error> {
        let mut runs = Vec::new();
        for block in 0..self.blocks() {
            runs.extend(self.runs(block)?);
        }
        Ok(runs)
    }

    /// Number of runs, if they are as long as those of the first block.
    ///
    /// # Errors
    /// See [`TrajectoryReader::runs`].
    pub fn expected_runs(&self) -> Result<f64, Error> {
        let (rows, of_first) = (self.table.rows(), self.table.block_rows(0));
        Ok(self.runs(0)?.len() as f64 * rows as f64 / of_first.max(1) as f64)
    }

    /// North, east \[m\] and heading \[rad\] of the rows of block `i`, where the file has columns `x`, `y` and `psi` in these units, without
    /// gaps.
    ///
    /// # Errors
    /// A damaged block.
    pub fn poses(&self, i: usize) -> Result<Option<Vec<[f64; 3]>>, Error> {
        const NAMES: [&str; 3] = ["x", "y", "psi"];
        let is_there = |(name, unit): (&str, &str)| {
            self.table.columns().iter().any(|column| column.name == name && column.unit == unit)
        };
        if !NAMES.into_iter().zip(["m", "m", "rad"]).all(is_there) {
            return Ok(None);
        }
        let table = self.table.read_block(i, &NAMES)?;
        let values: Option<Vec<&[f64]>> =
            table.columns.iter().map(|column| column.as_f64().filter(|_| column.nulls() == 0)).collect();
        let rows = |values: Vec<&[f64]>| {
            let row = |r: usize| [values[0][r], values[1][r], values[2][r]];
            (0..values[0].len()).map(row).collect()
        };
        Ok(values.map(rows))
    }

    /// What was commanded in the rows of block `i`, by input; nothing of inputs without such a column.
    ///
    /// # Errors
    /// A damaged block.
    pub fn commands(&self, i: usize) -> Result<Vec<(String, Vec<f64>)>, Error> {
        let columns: Vec<&str> = self.commanded.iter().map(|(_, column)| column.as_str()).collect();
        if columns.is_empty() {
            return Ok(Vec::new());
        }
        let table = self.table.read_block(i, &columns)?;
        let command = |((name, _), column): (&(String, String), &Column)| {
            Some((name.clone(), column.as_f64()?.to_vec()))
        };
        Ok(self.commanded.iter().zip(&table.columns).filter_map(command).collect())
    }

    /// The runs of block `i`.
    ///
    /// # Errors
    /// A run that crosses the end of a block or has the number of another, samples out of order, an absent value,
    /// another sampling rate.
    pub fn runs(&self, i: usize) -> Result<Vec<Run>, Error> {
        let names: Vec<&str> = self.columns.iter().map(String::as_str).collect();
        let table = self.table.read_block(i, &names)?;
        let block = TableBlock::new(&table, self)?;
        let first_row: usize = (0..i).map(|b| self.table.block_rows(b)).sum();
        let mut runs = Vec::new();
        let mut start = 0;
        while start < block.rows() {
            let end = block.end_of_run(start);
            let run = block.run(start, end, first_row)?;
            self.refuse_doubled(&run, first_row + start)?;
            runs.push(run);
            start = end;
        }
        Ok(runs)
    }
}

/// The refusal of `file` as one shard of several.
pub fn refuse_shard(file: &Path, shard: &Shard) -> Error {
    let given = format!("shard {shard}");
    crate::refuse(file, "file", &given, "the whole table", "put all shards together with --gather first")
}

/// The columns of a block.
struct TableBlock<'a> {
    reader: &'a TrajectoryReader,
    design: &'a Column,
    run: &'a [i32],
    segment: &'a [i32],
    maneuver: &'a Column,
    sample: &'a [i32],
    t: &'a [f64],
    exogenous: &'a [Column],
    states: Vec<&'a [f64]>,
    instruments: Vec<&'a [f64]>,
}

impl<'a> TableBlock<'a> {
    fn new(table: &'a Table, reader: &'a TrajectoryReader) -> Result<Self, Error> {
        let columns = &table.columns;
        for (name, column) in [("design", &columns[0]), ("maneuver", &columns[3])] {
            let labels = column.text_codes().map_or(&[][..], |(labels, _)| labels);
            let held = labels.iter().try_for_each(|label| check_name(format!("column `{name}`"), label));
            held.map_err(|e| crate::invalid(&reader.path, &e))?;
        }
        let i32s = |i: usize| columns[i].as_i32().ok_or_else(|| reader.wrong_kind(i));
        let f64s = |i: usize| columns[i].as_f64().ok_or_else(|| reader.wrong_kind(i));
        let instruments = columns.len() - reader.instruments;
        Ok(Self {
            reader,
            design: &columns[0],
            run: i32s(1)?,
            segment: i32s(2)?,
            maneuver: &columns[3],
            sample: i32s(4)?,
            t: f64s(5)?,
            exogenous: &columns[6..6 + reader.places.len()],
            states: (6 + reader.places.len()..instruments).map(f64s).collect::<Result<_, _>>()?,
            instruments: (instruments..columns.len()).map(f64s).collect::<Result<_, _>>()?,
        })
    }

    fn rows(&self) -> usize {
        self.run.len()
    }

    /// One past the last row of the run that starts at `start`.
    fn end_of_run(&self, start: usize) -> usize {
        let same = |row: &usize| {
            self.run[*row] == self.run[start]
                && self.sample[*row] != 0
                && self.design.text_at(*row) == self.design.text_at(start)
        };
        (start + 1..self.rows()).find(|row| !same(row)).unwrap_or(self.rows())
    }

    fn run(&self, start: usize, end: usize, first_row: usize) -> Result<Run, Error> {
        let label =
            || format!("design {}, run {}", self.design.text_at(start).unwrap_or(""), self.run[start]);
        let row = |r: usize| format!("row {} ({})", first_row + r, label());
        if let Some(r) = (start..end).find(|r| self.sample[*r] != (*r - start) as i32) {
            return Err(self.reader.refuse(
                &format!("column `sample`, {}", row(r)),
                &self.sample[r].to_string(),
                &(r - start).to_string(),
                "number each run's samples from 0 without gaps and keep a run within one row group",
            ));
        }
        if end - start < 2 {
            return Err(self.reader.refuse(
                &row(start),
                "a run of one row",
                "at least one sample and a last state",
                "remove it",
            ));
        }
        self.check_rate(start, end, &row)?;
        for (column, name) in self.exogenous.iter().zip(&self.reader.columns[6..]) {
            if let Some(r) = (start..end - 1).find(|r| column.is_null(*r)) {
                return Err(self.reader.refuse(
                    &format!("column `{name}`, {}", row(r)),
                    "no value",
                    "a value at every sample but the run's last",
                    "fill it in or remove the run",
                ));
            }
        }
        self.check_magnitudes(start, end, &row)?;
        let exogenous = self.exogenous_rows(start, end);
        self.check_derived(&exogenous, &|k| row(start + k))?;
        let initial = if self.reader.truth { 3 } else { 0 };
        Ok(Run {
            design: self.design.text_at(start).unwrap_or("").to_owned(),
            run: self.run[start],
            segments: self.segments(start, end),
            instrument_exogenous: self.instrument_rows(start, &exogenous),
            exogenous,
            measured: (start..end).flat_map(|r| (0..3).map(move |i| self.states[i][r])).collect(),
            initial: [0, 1, 2].map(|i| self.states[initial + i][start]),
        })
    }

    /// Refuses numbers whose powers and sums overflow.
    fn check_magnitudes(&self, start: usize, end: usize, row: &dyn Fn(usize) -> String) -> Result<(), Error> {
        const MOST: f64 = 1e30;
        let exogenous = self.exogenous.iter().filter_map(Column::as_f64).map(|c| &c[start..end - 1]);
        let states = self.states.iter().map(|column| &column[start..end]);
        let instruments = self.instruments.iter().map(|column| &column[start..end - 1]);
        for (i, column) in exogenous.chain(states).chain(instruments).enumerate() {
            // Checks all values, which is faster than stopping early.
            if column.iter().fold(true, |kept, value| kept & (value.abs() <= MOST)) {
                continue;
            }
            let r = column.iter().position(|value| value.is_nan() || value.abs() > MOST).unwrap_or_default();
            let thing = format!("column `{}`, {}", self.reader.columns[6 + i], row(start + r));
            let expected = format!("magnitudes up to {MOST:e}");
            return Err(self.reader.refuse(
                &thing,
                &format!("{:e}", column[r]),
                &expected,
                "correct the value",
            ));
        }
        Ok(())
    }

    /// Refuses derived channels that differ from their definition: the file was made with another one.
    fn check_derived(&self, rows: &[f64], row: &dyn Fn(usize) -> String) -> Result<(), Error> {
        for (channel, _) in self.reader.derived.iter().filter(|(_, there)| *there) {
            let column = channel.variable - 3;
            let name = self.reader.places.iter().position(|place| *place == column).unwrap_or_default();
            for (k, values) in rows.chunks_exact(self.reader.width).enumerate() {
                let (found, expected) = (values[column], channel.value(values));
                if !DerivedChannel::agrees(found, expected) {
                    return Err(self.reader.refuse(
                        &format!("column `{}`, {}", self.reader.columns[6 + name], row(k)),
                        &found.to_string(),
                        &format!("{expected}, by the formula `{}` of the vessel's file", channel.text),
                        "make the trajectories again with the same vessel's file",
                    ));
                }
            }
        }
        Ok(())
    }

    fn check_rate(&self, start: usize, end: usize, row: &dyn Fn(usize) -> String) -> Result<(), Error> {
        let step = 1.0 / self.reader.rate_hz;
        let off = |r: &usize| ((self.t[r + 1] - self.t[*r]) / step - 1.0).abs() > 1e-3;
        match (start..end - 1).find(off) {
            None => Ok(()),
            Some(r) => Err(self.reader.refuse(
                &format!("column `t`, {}", row(r)),
                &format!("a step of {} s", self.t[r + 1] - self.t[r]),
                &format!("{step} s, the vessel's sampling interval"),
                "resample the trajectories or correct `sample_rate_hz`",
            )),
        }
    }

    fn segments(&self, start: usize, end: usize) -> Vec<Segment> {
        let begins = |r: &usize| *r == start || self.segment[*r] != self.segment[*r - 1];
        let segment = |r: usize| Segment {
            maneuver: self.maneuver.text_at(r).unwrap_or("").to_owned(),
            start: r - start,
        };
        (start..end - 1).filter(begins).map(segment).collect()
    }

    fn exogenous_rows(&self, start: usize, end: usize) -> Vec<f64> {
        let columns: Vec<&[f64]> = self.exogenous.iter().filter_map(Column::as_f64).collect();
        let TrajectoryReader { width, places, derived, .. } = self.reader;
        if places.len() == *width {
            return (start..end - 1).flat_map(|r| columns.iter().map(move |c| c[r])).collect();
        }
        let mut rows = vec![0.0; width * (end - 1 - start)];
        for (r, row) in (start..end - 1).zip(rows.chunks_exact_mut(*width)) {
            columns.iter().zip(places).for_each(|(column, place)| row[*place] = column[r]);
            // In order of dependency.
            for (channel, _) in derived.iter().filter(|(_, there)| !there) {
                row[channel.variable - 3] = channel.value(row);
            }
        }
        rows
    }
}

impl TableBlock<'_> {
    /// What instruments of a run with these `recorded` inputs and disturbances are simulated with; empty if that are its own.
    fn instrument_rows(&self, start: usize, recorded: &[f64]) -> Vec<f64> {
        if self.instruments.is_empty() {
            return Vec::new();
        }
        let (mut rows, width) = (recorded.to_vec(), self.reader.width);
        for (r, row) in rows.chunks_exact_mut(width).enumerate() {
            let values = self.instruments.iter().map(|column| column[start + r]);
            row.iter_mut().zip(values).for_each(|(to, value)| *to = value);
            for (channel, _) in &self.reader.derived {
                row[channel.variable - 3] = channel.value(row);
            }
        }
        if rows == recorded { Vec::new() } else { rows }
    }
}

impl TrajectoryReader {
    /// Refuses `run`, which begins at `row`, if another of its design has its number.
    fn refuse_doubled(&self, run: &Run, row: usize) -> Result<(), Error> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let of_design = match known.get_mut(&run.design) {
            Some(runs) => runs,
            None => known.entry(run.design.clone()).or_default(),
        };
        let other = *of_design.entry(run.run).or_insert(row);
        if other == row {
            return Ok(());
        }
        Err(self.refuse(
            &format!("design {}, run {}", run.design, run.run),
            &format!("it twice, from rows {} and {} on", other.min(row), other.max(row)),
            "one run of a design and number",
            "number the runs anew, or remove one of them",
        ))
    }

    fn refuse(&self, thing: &str, found: &str, expected: &str, remedy: &str) -> Error {
        crate::refuse(&self.path, thing, found, expected, remedy)
    }

    fn wrong_kind(&self, column: usize) -> Error {
        self.refuse(
            &format!("column `{}`", self.columns[column]),
            "another type",
            "the type of its schema",
            "write it again",
        )
    }
}

/// The runs of trajectories for several passes: few are held in memory, many are read again.
pub enum KeptRuns {
    /// In memory.
    Held(Vec<Run>),
    /// In their file.
    InFile(Box<TrajectoryReader>),
}

/// Maximum bytes of runs that are held in memory.
const HELD: f64 = 1e8;

impl KeptRuns {
    /// The runs of `reader`, held in memory if they take less than `most` bytes and not more than some 100 MB.
    ///
    /// # Errors
    /// See [`TrajectoryReader::runs`].
    pub fn new(reader: TrajectoryReader, layout: &Layout, most: f64) -> Result<Self, Error> {
        let (rows, _) = reader.rows();
        let few = rows as f64 * layout.run_bytes() <= HELD.min(most);
        if few { reader.all().map(Self::Held) } else { Ok(Self::InFile(Box::new(reader))) }
    }
}

impl Recorded for KeptRuns {
    type Error = Error;

    fn blocks(&self) -> usize {
        match self {
            Self::Held(_) => 1,
            Self::InFile(reader) => reader.blocks(),
        }
    }

    fn block(&self, i: usize) -> Result<Cow<'_, [Run]>, Error> {
        match self {
            Self::Held(runs) => Ok(Cow::Borrowed(runs)),
            Self::InFile(reader) => reader.runs(i).map(Cow::Owned),
        }
    }

    fn held(&self) -> bool {
        matches!(self, Self::Held(_))
    }
}
