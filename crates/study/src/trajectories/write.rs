use artifact::{Column, Table};
use vessel::track;

use super::Layout;

/// How many runs of `samples` samples share a block: about 65,000 rows.
pub fn rows_per_block(samples: usize) -> usize {
    (65_536 / (samples + 1)).max(1)
}

/// A run to be written. All row-major.
pub struct NewRun<'a> {
    /// Its design.
    pub design: &'a str,
    /// Its number.
    pub run: u32,
    /// Maneuver and first sample of each segment.
    pub segments: &'a [(usize, usize)],
    /// Inputs and measured disturbances, N × exogenous.
    pub exogenous: &'a [f64],
    /// Measured states, (N+1) × 3.
    pub measured: &'a [f64],
    /// True states, (N+1) × 3.
    pub states: &'a [f64],
}

/// Collects runs into one block of the table.
pub struct BlockBuilder<'a> {
    layout: &'a Layout,
    maneuvers: &'a [String],
    rate_hz: f64,
    designs: Vec<String>,
    design: Vec<u32>,
    integers: [Vec<i32>; 3],
    maneuver: Vec<u32>,
    t: Vec<f64>,
    exogenous: Vec<Vec<f64>>,
    present: Vec<bool>,
    floats: [Vec<f64>; 9],
}

impl<'a> BlockBuilder<'a> {
    /// An empty block; `maneuvers` are the names that segments refer to.
    pub fn new(layout: &'a Layout, maneuvers: &'a [String], rate_hz: f64) -> Self {
        Self {
            layout,
            maneuvers,
            rate_hz,
            designs: Vec::new(),
            design: Vec::new(),
            integers: [const { Vec::new() }; 3],
            maneuver: Vec::new(),
            t: Vec::new(),
            exogenous: vec![Vec::new(); layout.exogenous.len()],
            present: Vec::new(),
            floats: [const { Vec::new() }; 9],
        }
    }

    /// Appends a run.
    pub fn push(&mut self, run: &NewRun) {
        let rows = run.measured.len() / 3;
        let code = self.design_code(run.design);
        self.design.extend(std::iter::repeat_n(code, rows));
        let mut segment = 0;
        for k in 0..rows {
            if run.segments.get(segment + 1).is_some_and(|(_, start)| *start == k && k + 1 < rows) {
                segment += 1;
            }
            self.integers[0].push(run.run as i32);
            self.integers[1].push(segment as i32);
            self.integers[2].push(k as i32);
            self.maneuver.push(run.segments[segment].0 as u32);
            self.t.push(k as f64 / self.rate_hz);
            self.present.push(k + 1 < rows);
        }
        let width = self.exogenous.len();
        for (i, column) in self.exogenous.iter_mut().enumerate() {
            column.extend(run.exogenous.iter().skip(i).step_by(width));
            column.push(0.0);
        }
        for i in 0..3 {
            self.floats[i].extend(run.measured.iter().skip(i).step_by(3));
            self.floats[3 + i].extend(run.states.iter().skip(i).step_by(3));
        }
        for pose in track(run.states, self.rate_hz) {
            self.floats[6].push(pose.x);
            self.floats[7].push(pose.y);
            self.floats[8].push(pose.psi);
        }
    }

    fn design_code(&mut self, design: &str) -> u32 {
        match self.designs.iter().position(|d| d == design) {
            Some(code) => code as u32,
            None => {
                self.designs.push(design.to_owned());
                self.designs.len() as u32 - 1
            }
        }
    }

    /// The block, with the columns of [`Layout::schema`].
    pub fn table(self) -> Table {
        debug_assert_eq!(self.layout.exogenous.len(), self.exogenous.len());
        let [run, segment, sample] = self.integers.map(Column::i32);
        let mut columns = vec![
            Column::text(self.designs, self.design),
            run,
            segment,
            Column::text(self.maneuvers.to_vec(), self.maneuver),
            sample,
            Column::f64(self.t),
        ];
        let present = &self.present;
        columns
            .extend(self.exogenous.into_iter().map(|values| Column::nullable_f64(values, present.clone())));
        columns.extend(self.floats.map(Column::f64));
        Table { columns }
    }
}
