use vessel::Lane;

use crate::batch::{BLOCK, Block, accumulate};

/// Σ over samples of the product of every two signals, [`BLOCK`] samples at a time.
pub(crate) struct Products {
    blocks: Vec<Block<Lane>>,
    filled: usize,
    /// The upper triangle, row by row.
    sums: Vec<Lane>,
}

impl Products {
    pub(crate) fn new(signals: usize) -> Self {
        Self {
            blocks: vec![[Lane::ZERO; BLOCK]; signals],
            filled: 0,
            sums: vec![Lane::ZERO; signals * (signals + 1) / 2],
        }
    }

    /// Signal `i` at this sample.
    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, value: Lane) {
        self.blocks[i][self.filled] = value;
    }

    /// Goes to the next sample: every signal was set at this one.
    #[inline(always)]
    pub(crate) fn advance(&mut self) {
        self.filled += 1;
        if self.filled == BLOCK {
            self.add();
        }
    }

    #[inline(always)]
    fn add(&mut self) {
        self.filled = 0;
        let mut rest = &mut self.sums[..];
        for (i, own) in self.blocks.iter().enumerate() {
            let (row, after) = std::mem::take(&mut rest).split_at_mut(self.blocks.len() - i);
            rest = after;
            accumulate(
                &self.blocks[i..],
                row,
                #[inline(always)]
                |t, other| own[t] * other,
            );
        }
    }

    /// The sums over all samples.
    pub(crate) fn finish(mut self) -> Sums {
        for signal in &mut self.blocks {
            signal[self.filled..].fill(Lane::ZERO);
        }
        pulp::Arch::new().dispatch(Rest(&mut self));
        Sums { signals: self.blocks.len(), upper: self.sums }
    }
}

/// The last block, compiled like the others.
struct Rest<'a>(&'a mut Products);

impl pulp::WithSimd for Rest<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        self.0.add();
    }
}

/// What [`Products`] came to.
pub(crate) struct Sums {
    signals: usize,
    upper: Vec<Lane>,
}

impl Sums {
    /// Σ of signal `i` times signal `j`.
    pub(crate) fn at(&self, i: usize, j: usize) -> Lane {
        let (i, j) = (i.min(j), i.max(j));
        self.upper[i * self.signals - i * (i + 1) / 2 + j]
    }

    /// All of them: signals × signals.
    pub(crate) fn square(&self) -> Vec<Lane> {
        let n = self.signals;
        (0..n * n).map(|k| self.at(k / n, k % n)).collect()
    }
}
