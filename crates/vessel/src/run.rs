/// One run, as recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Its design.
    pub design: String,
    /// Its number.
    pub run: i32,
    /// Its segments, in order.
    pub segments: Vec<Segment>,
    /// Inputs and measured disturbances, N × exogenous, row-major.
    pub exogenous: Vec<f64>,
    /// Measured states, (N+1) × 3, row-major.
    pub measured: Vec<f64>,
    /// State that simulations of the run start from: the true one where the file has it, else the measured one.
    pub initial: [f64; 3],
}

/// One maneuver inside a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Name of the maneuver.
    pub maneuver: String,
    /// First sample.
    pub start: usize,
}

impl Run {
    /// Number of regression pairs N.
    pub fn samples(&self) -> usize {
        self.measured.len() / 3 - 1
    }

    /// First samples of the segments.
    pub fn starts(&self) -> Vec<usize> {
        self.segments.iter().map(|s| s.start).collect()
    }
}
