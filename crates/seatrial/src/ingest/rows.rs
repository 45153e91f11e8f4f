//! Runs as rows of the table of trajectories.

use artifact::{Column, ColumnSpec, Kind, Table, TableSchema};
use logs::Assembled;

use super::channels::Plan;
use super::segments::RunPart;
use study::trajectories::{ID, VERSION};

/// Rows after which a block is written.
const BLOCK_ROWS: usize = 65_536;

/// The columns: what every stage needs, then channels that may be absent. Truth is not known.
pub fn schema(plan: &Plan) -> TableSchema {
    let mut columns = plan.layout().required();
    columns.extend(plan.further.iter().map(|(name, unit)| ColumnSpec::new(name, unit, Kind::F64, true)));
    TableSchema { id: ID, version: VERSION, columns }
}

/// Collects runs into one block of the table.
pub struct RowsBuilder<'a> {
    plan: &'a Plan,
    design: &'a str,
    /// Run, segment, sample.
    integers: [Vec<i32>; 3],
    names: Vec<String>,
    maneuver: Vec<u32>,
    t: Vec<f64>,
    /// Inputs and measured disturbances, then measured states, then further channels; NaN where absent.
    floats: Vec<Vec<f64>>,
}

impl<'a> RowsBuilder<'a> {
    /// An empty block.
    pub fn new(plan: &'a Plan, design: &'a str) -> Self {
        let width = plan.exogenous.len() + 3 + plan.further.len();
        Self {
            plan,
            design,
            integers: [const { Vec::new() }; 3],
            names: Vec::new(),
            maneuver: Vec::new(),
            t: Vec::new(),
            floats: vec![Vec::new(); width],
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

    /// Appends run number `number` of the recording `made`: its samples, and a last row without inputs.
    pub fn push(&mut self, number: u32, made: &Assembled, run: &RunPart) {
        let rows = run.start..run.start + run.samples + 1;
        let mut segment = 0;
        for k in 0..rows.len() {
            if run.segments.get(segment + 1).is_some_and(|(_, start)| *start == k) {
                segment += 1;
            }
            let code = self.code(&run.segments[segment].0);
            self.maneuver.push(code);
            for (column, value) in self.integers.iter_mut().zip([number as i32, segment as i32, k as i32]) {
                column.push(value);
            }
            self.t.push(k as f64 / made.grid.rate_hz);
        }
        let (exogenous, others) = self.floats.split_at_mut(self.plan.exogenous.len());
        for (column, (values, (_, _, factor))) in
            exogenous.iter_mut().zip(made.exogenous.iter().zip(&self.plan.exogenous))
        {
            column.extend(values[rows.start..rows.end - 1].iter().map(|value| factor * value));
            column.push(f64::NAN);
        }
        for (column, values) in others.iter_mut().zip(made.measured.iter().chain(&made.further)) {
            column.extend(&values[rows.clone()]);
        }
    }

    fn code(&mut self, name: &str) -> u32 {
        if let Some(code) = self.names.iter().position(|known| known == name) {
            return code as u32;
        }
        self.names.push(name.to_owned());
        self.names.len() as u32 - 1
    }

    /// The block, with the columns of [`schema`].
    pub fn table(self) -> Table {
        let states = self.plan.exogenous.len()..self.plan.exogenous.len() + 3;
        let [run, segment, sample] = self.integers.map(Column::i32);
        let rows = self.t.len();
        let mut columns = vec![
            Column::text(vec![self.design.to_owned()], vec![0; rows]),
            run,
            segment,
            Column::text(self.names, self.maneuver),
            sample,
            Column::f64(self.t),
        ];
        for (i, values) in self.floats.into_iter().enumerate() {
            columns.push(if states.contains(&i) {
                Column::f64(values)
            } else {
                let present = values.iter().map(|value| value.is_finite()).collect();
                Column::nullable_f64(values, present)
            });
        }
        Table { columns }
    }
}
