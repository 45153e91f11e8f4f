use files::{Column, Labels};
use ship::engine::{Run, Segment};

use super::Layout;

/// The columns of [`Layout::required`], built run by run.
pub(super) struct Rows {
    rate_hz: f64,
    design: Labels,
    /// Run, segment, sample.
    integers: [Vec<i32>; 3],
    maneuver: Labels,
    t: Vec<f64>,
    exogenous: Vec<Vec<f64>>,
    /// Whether a row has inputs: all but a run's last.
    pub(super) present: Vec<bool>,
    measured: [Vec<f64>; 3],
}

impl Rows {
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
    pub(super) fn begin(&mut self, design: &str, run: i32, segments: &[Segment], rows: usize) {
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
pub(super) fn extend(columns: &mut [Vec<f64>], rows: &[f64]) {
    for (i, column) in columns.iter_mut().enumerate() {
        column.extend(rows.iter().skip(i).step_by(3));
    }
}
