use artifact::{Column, Table};
use vessel::Run;

use super::Layout;

/// Rows after which a block is written.
const BLOCK_ROWS: usize = 65_536;

/// Collects measured runs, of which no truth is known, into one block of the table.
pub struct MeasuredBlock {
    rate_hz: f64,
    design: Labels,
    maneuver: Labels,
    /// Run, segment, sample.
    integers: [Vec<i32>; 3],
    t: Vec<f64>,
    /// Inputs and measured disturbances; NaN at a run's last row.
    exogenous: Vec<Vec<f64>>,
    measured: [Vec<f64>; 3],
    /// Channels that the model does not need; NaN where absent.
    further: Vec<Vec<f64>>,
}

impl MeasuredBlock {
    /// An empty block of runs at `rate_hz` with so many `further` channels.
    pub fn new(layout: &Layout, further: usize, rate_hz: f64) -> Self {
        Self {
            rate_hz,
            design: Labels::default(),
            maneuver: Labels::default(),
            integers: [const { Vec::new() }; 3],
            t: Vec::new(),
            exogenous: vec![Vec::new(); layout.exogenous.len()],
            measured: [const { Vec::new() }; 3],
            further: vec![Vec::new(); further],
        }
    }

    /// Whether there are enough rows for a block.
    pub fn is_full(&self) -> bool {
        self.t.len() >= BLOCK_ROWS
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// Appends a run and its `further` channels, each with N + 1 values.
    pub fn push(&mut self, run: &Run, further: &[Vec<f64>]) {
        let rows = run.samples() + 1;
        self.design.push(&run.design, rows);
        let ends = run.segments.iter().skip(1).map(|next| next.start).chain([rows]);
        for (i, (segment, end)) in run.segments.iter().zip(ends).enumerate() {
            self.maneuver.push(&segment.maneuver, end - segment.start);
            self.integers[1].extend(std::iter::repeat_n(i as i32, end - segment.start));
        }
        self.integers[0].extend(std::iter::repeat_n(run.run, rows));
        self.integers[2].extend(0..rows as i32);
        self.t.extend((0..rows).map(|k| k as f64 / self.rate_hz));
        let width = self.exogenous.len();
        for (i, column) in self.exogenous.iter_mut().enumerate() {
            column.extend(run.exogenous.iter().skip(i).step_by(width));
            column.push(f64::NAN);
        }
        for (i, column) in self.measured.iter_mut().enumerate() {
            column.extend(run.measured.iter().skip(i).step_by(3));
        }
        self.further.iter_mut().zip(further).for_each(|(column, values)| column.extend(values));
    }

    /// The block, with the columns of [`Layout::measured`].
    pub fn table(self) -> Table {
        let optional = |values: Vec<f64>| {
            let present = values.iter().map(|value| value.is_finite()).collect();
            Column::nullable_f64(values, present)
        };
        let [run, segment, sample] = self.integers.map(Column::i32);
        let mut columns =
            vec![self.design.column(), run, segment, self.maneuver.column(), sample, Column::f64(self.t)];
        columns.extend(self.exogenous.into_iter().map(optional));
        columns.extend(self.measured.map(Column::f64));
        columns.extend(self.further.into_iter().map(optional));
        Table { columns }
    }
}

/// A column of text in the making: names in the order of appearance, and the place of each row's.
#[derive(Default)]
struct Labels {
    names: Vec<String>,
    rows: Vec<u32>,
}

impl Labels {
    /// `rows` more rows called `name`.
    fn push(&mut self, name: &str, rows: usize) {
        let place = self.names.iter().position(|known| known == name).unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len() - 1
        });
        self.rows.extend(std::iter::repeat_n(place as u32, rows));
    }

    fn column(self) -> Column {
        Column::text(self.names, self.rows)
    }
}
