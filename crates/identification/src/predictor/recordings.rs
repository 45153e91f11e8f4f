use vessel::{LANES, Lane, Model};

/// [`LANES`] recordings side by side, all row-major, of N samples; shorter ones are filled up with anything.
#[derive(Clone, Copy, Debug)]
pub struct Recordings<'a> {
    /// The model structure.
    pub model: &'a Model,
    /// Measured states u, v \[m/s\], r \[rad/s\]: (N+1) × 3.
    pub measured: &'a [Lane],
    /// Inputs and measured disturbances: N × exogenous.
    pub exogenous: &'a [Lane],
    /// State that each starts from.
    pub initial: [Lane; 3],
    /// Samples of each recording; what comes later counts for nothing.
    pub samples: [usize; LANES],
}

impl Recordings<'_> {
    /// The longest recording's samples N.
    pub fn longest(&self) -> usize {
        self.measured.len() / 3 - 1
    }

    /// Number of unknowns: parameters (surge, sway, yaw), three intercepts, three offsets of the initial state.
    pub fn unknowns(&self) -> usize {
        self.model.parameters() + 6
    }

    /// 1 for recordings that last to sample `k`, 0 for others.
    #[inline(always)]
    pub(crate) fn lasting(&self, k: usize) -> Lane {
        Lane(std::array::from_fn(|lane| if k <= self.samples[lane] { 1.0 } else { 0.0 }))
    }
}
