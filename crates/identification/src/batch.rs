use vessel::{LANES, Lane, Model};

/// [`LANES`] runs of N samples side by side. All row-major.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    /// The model structure.
    pub model: &'a Model,
    /// Measured states u, v \[m/s\], r \[rad/s\]: (N+1) × 3.
    pub measured: &'a [Lane],
    /// States that the instruments are formed with: (N+1) × 3. Of a nominal simulation for instrumental variables, the
    /// measured ones themselves for least squares.
    pub instrument_states: &'a [Lane],
    /// Inputs and measured disturbances: N × exogenous.
    pub exogenous: &'a [Lane],
    /// Per run, the first sample of each segment, ascending from 0.
    pub segments: [&'a [usize]; LANES],
}

impl Batch<'_> {
    /// Number of regression pairs N.
    pub fn samples(&self) -> usize {
        self.measured.len() / 3 - 1
    }

    /// Writes the variables of the terms at sample `k`: `states` (measured or the instruments'), then exogenous.
    #[inline(always)]
    pub(crate) fn variables(&self, states: &[Lane], k: usize, values: &mut [Lane]) {
        let width = values.len() - 3;
        values[..3].copy_from_slice(&states[3 * k..3 * k + 3]);
        values[3..].copy_from_slice(&self.exogenous[k * width..(k + 1) * width]);
    }

    /// Δy of degree of freedom `d` at sample `k`.
    #[inline(always)]
    pub(crate) fn increment(&self, k: usize, d: usize) -> Lane {
        self.measured[3 * (k + 1) + d] - self.measured[3 * k + d]
    }
}

/// Evaluates the terms of every degree of freedom in order: one lane per parameter.
#[inline(always)]
pub(crate) fn regressors(model: &Model, values: &[Lane], out: &mut [Lane]) {
    let mut next = 0;
    for degree in &model.degrees {
        for term in &degree.terms {
            out[next] = term.value(values);
            next += 1;
        }
    }
}
