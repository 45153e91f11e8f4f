use std::collections::HashMap;

use artifact::{Column, Table};
use trial::campaign::SimulatedRun;
use vessel::track;

use super::Layout;

/// How many runs of `samples` samples share a block: about 65,000 rows.
pub fn rows_per_block(samples: usize) -> usize {
    (65_536 / (samples + 1)).max(1)
}

/// Collects runs into one block of the table.
pub struct BlockBuilder<'a> {
    layout: &'a Layout,
    rate_hz: f64,
    design: Labels,
    integers: [Vec<i32>; 3],
    maneuver: Labels,
    t: Vec<f64>,
    exogenous: Vec<Vec<f64>>,
    present: Vec<bool>,
    floats: [Vec<f64>; 9],
}

impl<'a> BlockBuilder<'a> {
    /// An empty block of runs at `rate_hz`.
    pub fn new(layout: &'a Layout, rate_hz: f64) -> Self {
        Self {
            layout,
            rate_hz,
            design: Labels::default(),
            integers: [const { Vec::new() }; 3],
            maneuver: Labels::default(),
            t: Vec::new(),
            exogenous: vec![Vec::new(); layout.exogenous.len()],
            present: Vec::new(),
            floats: [const { Vec::new() }; 9],
        }
    }

    /// Appends a run.
    pub fn push(&mut self, SimulatedRun { run, states }: &SimulatedRun) {
        let rows = run.measured.len() / 3;
        self.design.push(&run.design, rows);
        let ends = run.segments.iter().skip(1).map(|next| next.start).chain([rows]);
        for (i, (segment, end)) in run.segments.iter().zip(ends).enumerate() {
            self.maneuver.push(&segment.maneuver, end - segment.start);
            self.integers[1].extend(std::iter::repeat_n(i as i32, end - segment.start));
        }
        self.integers[0].extend(std::iter::repeat_n(run.run, rows));
        self.integers[2].extend(0..rows as i32);
        self.t.extend((0..rows).map(|k| k as f64 / self.rate_hz));
        self.present.extend((0..rows).map(|k| k + 1 < rows));
        let width = self.exogenous.len();
        for (i, column) in self.exogenous.iter_mut().enumerate() {
            column.extend(run.exogenous.iter().skip(i).step_by(width));
            column.push(0.0);
        }
        for i in 0..3 {
            self.floats[i].extend(run.measured.iter().skip(i).step_by(3));
            self.floats[3 + i].extend(states.iter().skip(i).step_by(3));
        }
        for pose in track(states, self.rate_hz) {
            self.floats[6].push(pose.x);
            self.floats[7].push(pose.y);
            self.floats[8].push(pose.psi);
        }
    }

    /// The block, with the columns of [`Layout::schema`].
    pub fn table(self) -> Table {
        debug_assert_eq!(self.layout.exogenous.len(), self.exogenous.len());
        let [run, segment, sample] = self.integers.map(Column::i32);
        let mut columns =
            vec![self.design.column(), run, segment, self.maneuver.column(), sample, Column::f64(self.t)];
        let present = &self.present;
        columns
            .extend(self.exogenous.into_iter().map(|values| Column::nullable_f64(values, present.clone())));
        columns.extend(self.floats.map(Column::f64));
        Table { columns }
    }
}

/// A text column in the making.
#[derive(Default)]
struct Labels {
    known: HashMap<String, u32>,
    labels: Vec<String>,
    rows: Vec<u32>,
}

impl Labels {
    /// `rows` more rows of `label`.
    fn push(&mut self, label: &str, rows: usize) {
        let code = self.known.get(label).copied().unwrap_or_else(|| {
            let new = self.labels.len() as u32;
            self.labels.push(label.to_owned());
            self.known.insert(label.to_owned(), new);
            new
        });
        self.rows.extend(std::iter::repeat_n(code, rows));
    }

    fn column(self) -> Column {
        Column::text(self.labels, self.rows)
    }
}
