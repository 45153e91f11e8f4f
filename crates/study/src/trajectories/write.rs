use artifact::{Column, Table};
use logs::RecordedRun;
use trial::campaign::SimulatedRun;
use vessel::track;

use super::Layout;
use super::rows::{Rows, append, extend};

/// Rows of a block, or a few more.
const BLOCK_ROWS: usize = 65_536;

/// How many runs of `samples` samples share a block: about 65,000 rows.
pub fn rows_per_block(samples: usize) -> usize {
    (BLOCK_ROWS / (samples + 1)).max(1)
}

/// Collects simulated runs into one block of the table.
pub struct BlockBuilder {
    rows: Rows,
    /// True states, place and heading.
    truth: [Vec<f64>; 6],
}

impl BlockBuilder {
    /// An empty block of runs at `rate_hz`.
    pub fn new(layout: &Layout, rate_hz: f64) -> Self {
        Self { rows: Rows::new(layout, rate_hz), truth: [const { Vec::new() }; 6] }
    }

    /// Appends a run.
    pub fn push(&mut self, SimulatedRun { run, states }: &SimulatedRun) {
        self.rows.push(run);
        extend(&mut self.truth[..3], states);
        for pose in track(states, self.rows.rate_hz()) {
            self.truth[3].push(pose.x);
            self.truth[4].push(pose.y);
            self.truth[5].push(pose.psi);
        }
    }

    /// The block, with the columns of [`Layout::schema`].
    pub fn table(self) -> Table {
        let mut columns = self.rows.columns();
        columns.extend(self.truth.map(Column::f64));
        Table { columns }
    }
}

/// Collects measured runs, of which no truth is known, into one block of the table.
pub struct MeasuredBlock {
    /// The design that the runs belong to.
    design: String,
    rows: Rows,
    /// Channels that the model does not need; NaN where absent.
    further: Vec<Vec<f64>>,
}

impl MeasuredBlock {
    /// An empty block of runs of `design` at `rate_hz` with so many `further` channels.
    pub fn new(design: &str, layout: &Layout, further: usize, rate_hz: f64) -> Self {
        let rows = Rows::new(layout, rate_hz);
        Self { design: design.to_owned(), rows, further: vec![Vec::new(); further] }
    }

    /// Whether there are enough rows for a block.
    pub fn is_full(&self) -> bool {
        self.rows.len() >= BLOCK_ROWS
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.len() == 0
    }

    /// Appends a run. Takes it: a long one is most of the memory.
    pub fn push(&mut self, run: RecordedRun) {
        self.rows.begin(&self.design, run.number, &run.segments, run.samples() + 1);
        self.rows.end(run.exogenous, run.measured);
        self.further.iter_mut().zip(run.further).for_each(|(column, values)| append(column, values));
    }

    /// The block, with the columns of [`Layout::measured`].
    pub fn table(self) -> Table {
        let optional = |values: Vec<f64>| {
            let present = values.iter().map(|value| value.is_finite()).collect();
            Column::nullable_f64(values, present)
        };
        let mut columns = self.rows.columns();
        columns.extend(self.further.into_iter().map(optional));
        Table { columns }
    }
}
