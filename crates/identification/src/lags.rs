use vessel::Lane;

use crate::batch::BLOCK;

/// Per degree of freedom Σ ε(k)² and Σ ε(k−1) ε(k) of residuals ε.
pub(crate) struct Lags {
    pub lag0: [Lane; 3],
    pub lag1: [Lane; 3],
}

impl Lags {
    /// Sums over no sample.
    pub(crate) const ZERO: Self = Self { lag0: [Lane::ZERO; 3], lag1: [Lane::ZERO; 3] };

    /// Adds those of the residuals of a block; `edge` came before them, and becomes the last.
    #[inline(always)]
    pub(crate) fn add(&mut self, d: usize, residual: impl Fn(usize) -> Lane, edge: &mut Lane) {
        let (mut lag0, mut lag1, mut before) = (Lane::ZERO, Lane::ZERO, *edge);
        for t in 0..BLOCK {
            let now = residual(t);
            lag0 = now.fused(now, lag0);
            lag1 = before.fused(now, lag1);
            before = now;
        }
        self.lag0[d] += lag0;
        self.lag1[d] += lag1;
        *edge = before;
    }
}
