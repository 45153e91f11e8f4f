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

    /// Evaluates the terms of `states` (measured or the instruments') at samples `k..k + count`, `count` ≤ [`BLOCK`].
    #[inline(always)]
    pub(crate) fn regressors(&self, states: &[Lane], k: usize, count: usize, block: &mut Regressors) {
        let width = self.model.exogenous();
        for (i, variable) in block.values.iter_mut().enumerate() {
            let (source, stride) = if i < 3 { (&states[i..], 3) } else { (&self.exogenous[i - 3..], width) };
            copy_column(&source[stride * k..], stride, count, variable);
        }
        let terms = self.model.degrees.iter().flat_map(|d| &d.terms);
        for (term, out) in terms.zip(&mut block.terms) {
            term.values(&block.values, out);
        }
    }

    /// Δy of degree of freedom `d` at samples `k..k + count`; zero beyond.
    #[inline(always)]
    pub(crate) fn increments(&self, k: usize, count: usize, d: usize) -> Block {
        let (mut now, mut next) = ([Lane::ZERO; BLOCK], [Lane::ZERO; BLOCK]);
        copy_column(&self.measured[3 * k + d..], 3, count, &mut now);
        copy_column(&self.measured[3 * (k + 1) + d..], 3, count, &mut next);
        for t in 0..BLOCK {
            next[t] = next[t] - now[t];
        }
        next
    }
}

/// Copies `count` entries of a column into a block, and zeros beyond: the terms of zeros are zeros. A whole block is a loop
/// of fixed length without conditions, so that each lane moves as one vector.
#[inline(always)]
fn copy_column(column: &[Lane], stride: usize, count: usize, out: &mut Block) {
    if count == BLOCK {
        for (t, value) in out.iter_mut().enumerate() {
            *value = column[stride * t];
        }
    } else {
        *out = [Lane::ZERO; BLOCK];
        for (value, entry) in out.iter_mut().zip(column.iter().step_by(stride)).take(count) {
            *value = *entry;
        }
    }
}

/// Samples that are evaluated at once.
pub(crate) const BLOCK: usize = 8;
/// A signal at [`BLOCK`] samples.
pub(crate) type Block = [Lane; BLOCK];

/// The terms' values at [`BLOCK`] samples, and the variables that they were evaluated with.
pub(crate) struct Regressors {
    values: Vec<Block>,
    /// One per parameter.
    pub(crate) terms: Vec<Block>,
}

impl Regressors {
    pub(crate) fn new(model: &Model) -> Self {
        let zeros = |count| vec![[Lane::ZERO; BLOCK]; count];
        Self { values: zeros(model.variables.len()), terms: zeros(model.parameters()) }
    }
}

/// Σ_t x(t) y(t), in pairs: short chains of additions, and less rounding.
#[inline(always)]
pub(crate) fn dot(x: &Block, y: &Block) -> Lane {
    let pair = |t: usize| x[t] * y[t] + x[t + 1] * y[t + 1];
    (pair(0) + pair(2)) + (pair(4) + pair(6))
}

/// Σ_t x(t), in pairs.
#[inline(always)]
pub(crate) fn total(x: &Block) -> Lane {
    ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]))
}
