use std::iter::repeat_n;

use files::{Column, Error, Labels, PIECE_ROWS, Table, TableSchema, TableWriter};
use logs::RecordedRun;
use ship::engine::{Run, Segment, track};
use trial::campaign::SimulatedRun;

use super::Layout;

/// Approximate rows of a block.
const BLOCK_ROWS: usize = 65_536;

/// Runs of `samples` samples per block: about 65,000 rows.
pub fn rows_per_block(samples: usize) -> usize {
    (BLOCK_ROWS / (samples + 1)).max(1)
}

/// Collects simulated runs into one block of the table.
pub struct BlockBuilder {
    rows: RequiredColumns,
    /// True states, position and heading.
    truth: [Vec<f64>; 6],
    /// The inputs that instruments are simulated with; no column if runs have no others than their own.
    instruments: Vec<Vec<f64>>,
    /// What was commanded, of inputs that follow it.
    commands: Vec<(usize, Vec<f64>)>,
    /// Number of inputs.
    inputs: usize,
}

impl BlockBuilder {
    /// An empty block of runs at `rate_hz`.
    pub fn new(layout: &Layout, rate_hz: f64) -> Self {
        let (inputs, reacting) = (layout.inputs, &layout.reacting);
        let instruments = if reacting.tracks { vec![Vec::new(); inputs] } else { Vec::new() };
        let commands = reacting.followed.iter().map(|i| (*i, Vec::new())).collect();
        let truth = [const { Vec::new() }; 6];
        Self { rows: RequiredColumns::new(layout, rate_hz), truth, instruments, commands, inputs }
    }

    /// Appends a run.
    pub fn push(&mut self, SimulatedRun { run, states, commands }: &SimulatedRun) {
        self.rows.push(run);
        extend(&mut self.truth[..3], states);
        for pose in track(states, self.rows.rate_hz()) {
            self.truth[3].push(pose.x);
            self.truth[4].push(pose.y);
            self.truth[5].push(pose.psi);
        }
        let instrument_exogenous = run.view().instrument_exogenous;
        let width = instrument_exogenous.len() / run.samples().max(1);
        for (i, column) in self.instruments.iter_mut().enumerate() {
            column.extend(instrument_exogenous.iter().skip(i).step_by(width));
            column.push(0.0);
        }
        // What does not react commands its inputs.
        let (commands, width) =
            if commands.is_empty() { (&run.exogenous, width) } else { (commands, self.inputs) };
        for (i, column) in &mut self.commands {
            column.extend(commands.iter().skip(*i).step_by(width));
            column.push(0.0);
        }
    }

    /// The block, with the columns of [`Layout::schema`].
    pub fn table(self) -> Table {
        let present = self.rows.present.clone();
        let mut columns = self.rows.columns();
        columns.extend(self.truth.map(Column::f64));
        let further = self.instruments.into_iter().chain(self.commands.into_iter().map(|(_, values)| values));
        columns.extend(further.map(|values| Column::nullable_f64(values, present.clone())));
        Table { columns }
    }
}

/// Collects measured runs, without true states, into one block of the table. A long run is never in memory as a
/// whole: its columns are written one by one, in chunks.
pub struct MeasuredBlock {
    /// The design that the runs belong to.
    design: String,
    rate_hz: f64,
    runs: Vec<RecordedRun>,
    /// Rows of all runs.
    rows: usize,
}

impl MeasuredBlock {
    /// An empty block of runs of `design` at `rate_hz`.
    pub fn new(design: &str, rate_hz: f64) -> Self {
        Self { design: design.to_owned(), rate_hz, runs: Vec::new(), rows: 0 }
    }

    /// Whether there are enough rows for a block.
    pub fn is_full(&self) -> bool {
        self.rows >= BLOCK_ROWS
    }

    /// Appends a run.
    pub fn push(&mut self, run: &RecordedRun) {
        self.rows += run.samples() + 1;
        // A run that fills the block is written at once; one that waits for others must not keep its recording in
        // memory.
        self.runs.push(if self.is_full() { run.clone() } else { run.detached() });
    }

    /// Appends the block, with the columns of [`Layout::measured`], to a table of `schema`, and empties it.
    ///
    /// # Errors
    /// See [`TableWriter::write`].
    pub fn write(
        &mut self,
        layout: &Layout,
        schema: &TableSchema,
        to: &mut TableWriter,
    ) -> Result<(), Error> {
        let inputs = layout.exogenous.len();
        to.write(schema, self.rows, |i| match i {
            0 => self.texts(|run| vec![(self.design.as_str(), run.samples() + 1)]),
            1 => self.integers(|run| Box::new(repeat_n(run.number, run.samples() + 1))),
            2 => self.integers(|run| Box::new(lengths(run).zip(0..).flat_map(|(rows, i)| repeat_n(i, rows)))),
            3 => {
                self.texts(|run| run.segments.iter().map(|s| s.maneuver.as_str()).zip(lengths(run)).collect())
            }
            4 => self.integers(|run| Box::new(0..=run.samples() as i32)),
            5 => self.numbers(|run| Box::new((0..=run.samples()).map(|k| k as f64 / self.rate_hz))),
            i if i < 6 + inputs => self.absent(move |run| Box::new(run.exogenous(i - 6).chain([f64::NAN]))),
            i if i < 9 + inputs => self.numbers(move |run| Box::new(run.measured(i - 6 - inputs))),
            i => self.absent(move |run| Box::new(run.further(i - 9 - inputs))),
        })?;
        (self.runs, self.rows) = (Vec::new(), 0);
        Ok(())
    }

    fn integers<'a>(
        &'a self,
        of: impl Fn(&'a RecordedRun) -> Box<dyn Iterator<Item = i32> + 'a> + 'a,
    ) -> Chunks<'a> {
        Box::new(chunks(self.runs.iter().flat_map(of)).map(Column::i32))
    }

    fn numbers<'a>(
        &'a self,
        of: impl Fn(&'a RecordedRun) -> Box<dyn Iterator<Item = f64> + 'a> + 'a,
    ) -> Chunks<'a> {
        Box::new(chunks(self.runs.iter().flat_map(of)).map(Column::f64))
    }

    /// Numbers, absent if NaN.
    fn absent<'a>(
        &'a self,
        of: impl Fn(&'a RecordedRun) -> Box<dyn Iterator<Item = f64> + 'a> + 'a,
    ) -> Chunks<'a> {
        Box::new(chunks(self.runs.iter().flat_map(of)).map(|values| {
            let present = values.iter().map(|value| value.is_finite()).collect();
            Column::nullable_f64(values, present)
        }))
    }

    /// Texts, each for a number of rows.
    fn texts<'a>(&'a self, of: impl Fn(&'a RecordedRun) -> Vec<(&'a str, usize)> + 'a) -> Chunks<'a> {
        let texts = self.runs.iter().flat_map(of).flat_map(|(text, rows)| repeat_n(text, rows));
        Box::new(chunks(texts).map(|texts| {
            let mut labels = Labels::default();
            texts.into_iter().for_each(|text| labels.push(text, 1));
            labels.column()
        }))
    }
}

/// Chunks of a column.
type Chunks<'a> = Box<dyn Iterator<Item = Column> + 'a>;

/// Rows of each segment; the last has the run's last row too.
fn lengths(run: &RecordedRun) -> impl Iterator<Item = usize> {
    let ends = run.segments.iter().skip(1).map(|next| next.start).chain([run.samples() + 1]);
    run.segments.iter().zip(ends).map(|(segment, end)| end - segment.start)
}

fn chunks<T>(mut values: impl Iterator<Item = T>) -> impl Iterator<Item = Vec<T>> {
    std::iter::from_fn(move || {
        let chunk: Vec<T> = values.by_ref().take(PIECE_ROWS).collect();
        (!chunk.is_empty()).then_some(chunk)
    })
}

/// The columns of [`Layout::required`], built run by run.
struct RequiredColumns {
    rate_hz: f64,
    design: Labels,
    /// Run, segment, sample.
    integers: [Vec<i32>; 3],
    maneuver: Labels,
    t: Vec<f64>,
    exogenous: Vec<Vec<f64>>,
    /// Whether a row has inputs: all but a run's last.
    present: Vec<bool>,
    measured: [Vec<f64>; 3],
}

impl RequiredColumns {
    /// No rows yet of runs at `rate_hz`.
    pub(super) fn new(layout: &Layout, rate_hz: f64) -> Self {
        Self {
            rate_hz,
            design: Labels::default(),
            integers: [const { Vec::new() }; 3],
            maneuver: Labels::default(),
            t: Vec::new(),
            exogenous: vec![Vec::new(); layout.exogenous.len()],
            present: Vec::new(),
            measured: [const { Vec::new() }; 3],
        }
    }

    /// Samples per second.
    pub(super) fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Begins a run of `rows` rows, N + 1, whose values follow.
    fn begin(&mut self, design: &str, run: i32, segments: &[Segment], rows: usize) {
        self.design.push(design, rows);
        let ends = segments.iter().skip(1).map(|next| next.start).chain([rows]);
        for (i, (segment, end)) in segments.iter().zip(ends).enumerate() {
            self.maneuver.push(&segment.maneuver, end - segment.start);
            self.integers[1].extend(std::iter::repeat_n(i as i32, end - segment.start));
        }
        self.integers[0].extend(std::iter::repeat_n(run, rows));
        self.integers[2].extend(0..rows as i32);
        self.t.extend((0..rows).map(|k| k as f64 / self.rate_hz));
        self.present.extend((0..rows).map(|k| k + 1 < rows));
    }

    /// Appends a run.
    pub(super) fn push(&mut self, run: &Run) {
        self.begin(&run.design, run.run, &run.segments, run.samples() + 1);
        let width = self.exogenous.len();
        for (i, column) in self.exogenous.iter_mut().enumerate() {
            column.extend(run.exogenous.iter().skip(i).step_by(width));
            column.push(0.0);
        }
        extend(&mut self.measured, &run.measured);
    }

    pub(super) fn columns(self) -> Vec<Column> {
        let [run, segment, sample] = self.integers.map(Column::i32);
        let mut columns =
            vec![self.design.column(), run, segment, self.maneuver.column(), sample, Column::f64(self.t)];
        let present = &self.present;
        columns
            .extend(self.exogenous.into_iter().map(|values| Column::nullable_f64(values, present.clone())));
        columns.extend(self.measured.map(Column::f64));
        columns
    }
}

/// Appends rows of three values to three columns.
fn extend(columns: &mut [Vec<f64>], rows: &[f64]) {
    for (i, column) in columns.iter_mut().enumerate() {
        column.extend(rows.iter().skip(i).step_by(3));
    }
}
