use numerics::{LANES, Lane};
use pulp::{Simd, WithSimd};

/// Rows that are multiplied at once: as many as fit the caches.
const ROWS: usize = 48;
/// Rows and columns of a tile, whose sums stay in registers.
const TILE: usize = 4;

/// Σ x xᵀ over rows of many signals. It is summed in tiles, so that each loaded number is used four times.
pub(crate) struct Gram {
    signals: usize,
    /// The last rows of each signal.
    rows: Vec<f64>,
    filled: usize,
    /// Columns × columns, of which only tiles on and above the diagonal are summed.
    sums: Vec<f64>,
}

impl Gram {
    pub fn new(signals: usize) -> Self {
        let columns = signals.next_multiple_of(TILE);
        Self {
            signals,
            rows: vec![0.0; columns * ROWS * LANES],
            filled: 0,
            sums: vec![0.0; columns * columns],
        }
    }

    /// Signal `i` in this row.
    #[inline(always)]
    pub fn set(&mut self, i: usize, value: Lane) {
        let first = (i * ROWS + self.filled) * LANES;
        self.rows[first..first + LANES].copy_from_slice(&value.0);
    }

    /// Moves to the next row, after every signal was set.
    #[inline(always)]
    pub fn advance(&mut self) {
        self.filled += 1;
        if self.filled == ROWS {
            self.multiply();
        }
    }

    #[inline(never)]
    fn multiply(&mut self) {
        self.filled = 0;
        let columns = self.signals.next_multiple_of(TILE);
        numerics::dispatch(Multiply { rows: &self.rows, columns, sums: &mut self.sums });
    }

    /// The sums over all rows and lanes: signals × signals.
    pub fn finish(mut self) -> Vec<f64> {
        for signal in self.rows.chunks_exact_mut(ROWS * LANES) {
            signal[self.filled * LANES..].fill(0.0);
        }
        self.multiply();
        let (n, columns) = (self.signals, self.signals.next_multiple_of(TILE));
        let upper = |k: usize| (k / n).min(k % n) * columns + (k / n).max(k % n);
        (0..n * n).map(|k| self.sums[upper(k)]).collect()
    }
}

/// Adds the products of all rows to the sums.
struct Multiply<'a> {
    rows: &'a [f64],
    columns: usize,
    sums: &'a mut [f64],
}

impl WithSimd for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let signal = |i: usize| S::as_simd_f64s(&self.rows[i * ROWS * LANES..(i + 1) * ROWS * LANES]).0;
        for i in (0..self.columns).step_by(TILE) {
            let own = [signal(i), signal(i + 1), signal(i + 2), signal(i + 3)];
            for j in (i..self.columns).step_by(TILE) {
                let others = [signal(j), signal(j + 1), signal(j + 2), signal(j + 3)];
                let tile = tile(simd, own, others);
                for (a, row) in tile.iter().enumerate() {
                    for (b, sum) in row.iter().enumerate() {
                        self.sums[(i + a) * self.columns + j + b] += sum;
                    }
                }
            }
        }
    }
}

/// Products of four signals with four. Every lane has its own sum regardless of the width of the processor's vectors,
/// so that the bits are the same everywhere.
#[inline(always)]
fn tile<S: Simd>(simd: S, own: [&[S::f64s]; TILE], others: [&[S::f64s]; TILE]) -> [[f64; TILE]; TILE] {
    let vectors = own[0].len() / ROWS;
    let mut tile = [[0.0; TILE]; TILE];
    for vector in 0..vectors {
        let mut sums = [[simd.splat_f64s(0.0); TILE]; TILE];
        for row in 0..ROWS {
            let at = row * vectors + vector;
            let others = [others[0][at], others[1][at], others[2][at], others[3][at]];
            for (sums, own) in sums.iter_mut().zip(own) {
                for (sum, other) in sums.iter_mut().zip(others) {
                    *sum = simd.add_f64s(*sum, simd.mul_f64s(own[at], other));
                }
            }
        }
        for (out, sums) in tile.iter_mut().zip(&sums) {
            for (out, sum) in out.iter_mut().zip(sums) {
                let lanes: &[f64] = pulp::bytemuck::cast_slice(std::slice::from_ref(sum));
                lanes.iter().for_each(|lane| *out += lane);
            }
        }
    }
    tile
}
