use std::marker::PhantomData;

use numerics::lanes::{BLOCK, Block, part, parts, put};
use numerics::{LANES, Lane};
use pulp::{Simd, WithSimd};

use super::Unknowns;

/// Columns whose products with as many others are summed at once.
const TILE: usize = 5;
type Tile = [[Lane; TILE]; TILE];

/// Σ over samples of the products of signals, [`BLOCK`] samples at a time; in columns as unknowns are.
pub(crate) struct Products<X> {
    signals: usize,
    columns: Vec<Block<Lane>>,
    filled: usize,
    sums: ProductSums<X>,
}

impl<X: Unknowns> Products<X> {
    pub(crate) fn new(signals: usize) -> Self {
        let sums = ProductSums::none(signals);
        Self { signals, columns: vec![[Lane::ZERO; BLOCK]; sums.columns], filled: 0, sums }
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, c: usize, value: Lane) {
        self.columns[c][self.filled] = value;
    }

    /// The first columns at this sample: w₀x₀ + w₁x₁ + w₂x₂ of every one in `from`.
    #[inline(always)]
    pub(crate) fn weigh<const N: usize>(&mut self, from: &[[Lane; N]], weights: [Lane; 3]) {
        let row = self.filled % BLOCK;
        numerics::dispatch_narrow(Weigh { weights, columns: from, blocks: &mut self.columns, row });
    }

    /// The same: entry `entry` of every one in `from`, times `factor`.
    #[inline(always)]
    pub(crate) fn scale<const N: usize>(&mut self, from: &[[Lane; N]], entry: usize, factor: Lane) {
        let row = self.filled % BLOCK;
        numerics::dispatch_narrow(Scale { factor, entry, columns: from, blocks: &mut self.columns, row });
    }

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
        if X::PER_COLUMN == 1 {
            let columns = self.columns.as_chunks().0;
            numerics::dispatch_narrow(Tiles { tiles: &mut self.sums.tiles, columns });
            return;
        }
        let mut rest = &mut self.sums.rows[..];
        for i in 0..self.signals {
            let others = &self.columns[i / X::PER_COLUMN..];
            let block = &others[0];
            let (row, after) = std::mem::take(&mut rest).split_at_mut(others.len());
            rest = after;
            accumulate(
                others,
                row,
                #[inline(always)]
                |t, other, sum| X::of_column(block[t], i).lane().fused(other, sum),
            );
        }
    }

    pub(crate) fn finish(mut self) -> ProductSums<X> {
        for signal in &mut self.columns {
            signal[self.filled..].fill(Lane::ZERO);
        }
        numerics::vectorized!(narrow: self.add());
        self.sums
    }
}

/// Accumulates every block by `f`(t, value, sum); several at a time, so that no addition waits for another.
#[inline(always)]
fn accumulate(blocks: &[Block<Lane>], sums: &mut [Lane], f: impl Fn(usize, Lane, Lane) -> Lane + Copy) {
    let (fours, rest) = blocks.as_chunks::<4>();
    let (some, sums) = sums.split_at_mut(4 * fours.len());
    for (four, sums) in fours.iter().zip(some.as_chunks_mut().0) {
        add_sums(four, sums, f);
    }
    for (one, sum) in rest.as_chunks::<1>().0.iter().zip(sums.as_chunks_mut().0) {
        add_sums(one, sum, f);
    }
}

#[allow(clippy::needless_range_loop)] // What iterators make of arrays is not always inlined, and then has no vectors.
#[inline(always)]
fn add_sums<const C: usize>(
    blocks: &[Block<Lane>; C],
    sums: &mut [Lane; C],
    f: impl Fn(usize, Lane, Lane) -> Lane,
) {
    let mut block_sums = [Lane::ZERO; C];
    for t in 0..BLOCK {
        for i in 0..C {
            block_sums[i] = f(t, blocks[i][t], block_sums[i]);
        }
    }
    for i in 0..C {
        sums[i] += block_sums[i];
    }
}

struct Tiles<'a> {
    tiles: &'a mut [Tile],
    columns: &'a [[Block<Lane>; TILE]],
}

impl WithSimd for Tiles<'_> {
    type Output = ();

    /// Every sum has a register: 32 that hold all lanes are enough for a tile, 16 for two rows.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut tiles = self.tiles.iter_mut();
        for (i, one) in self.columns.iter().enumerate() {
            if let Some(tile) = tiles.next() {
                add_tile::<S, true>(simd, tile, one, one);
            }
            for (other, tile) in self.columns[i + 1..].iter().zip(&mut tiles) {
                add_tile::<S, false>(simd, tile, one, other);
            }
        }
    }
}

#[inline(always)]
fn add_tile<S: Simd, const THEMSELVES: bool>(
    simd: S,
    tile: &mut Tile,
    one: &[Block<Lane>; TILE],
    other: &[Block<Lane>; TILE],
) {
    for part in 0..LANES / S::F64_LANES {
        if S::F64_LANES == LANES {
            add_rows::<S, THEMSELVES, 0, TILE>(simd, tile, one, other, part);
            continue;
        }
        add_rows::<S, THEMSELVES, 0, 2>(simd, tile, one, other, part);
        if THEMSELVES {
            // The last three rows have half of their products: as many as two rows.
            add_rows::<S, THEMSELVES, 2, 3>(simd, tile, one, other, part);
        } else {
            add_rows::<S, THEMSELVES, 2, 2>(simd, tile, one, other, part);
            add_rows::<S, THEMSELVES, 4, 1>(simd, tile, one, other, part);
        }
    }
}

/// Adds `ROWS` rows of a tile, from row `FROM` on, in the lanes of `part`: a register of the processor's.
#[allow(clippy::needless_range_loop)] // Unrolled, so that every sum has a register.
#[inline(always)]
fn add_rows<S: Simd, const THEMSELVES: bool, const FROM: usize, const ROWS: usize>(
    simd: S,
    tile: &mut Tile,
    one: &[Block<Lane>; TILE],
    other: &[Block<Lane>; TILE],
    part: usize,
) {
    let mut sums = [[simd.splat_f64s(0.0); TILE]; ROWS];
    for t in 0..BLOCK {
        for i in 0..ROWS {
            let factor = S::as_simd_f64s(&one[FROM + i][t].0).0[part];
            for j in 0..TILE {
                if !THEMSELVES || FROM + i <= j {
                    let other = S::as_simd_f64s(&other[j][t].0).0[part];
                    sums[i][j] = simd.mul_add_f64s(factor, other, sums[i][j]);
                }
            }
        }
    }
    for i in 0..ROWS {
        for j in 0..TILE {
            if !THEMSELVES || FROM + i <= j {
                let sum = &mut S::as_mut_simd_f64s(&mut tile[FROM + i][j].0).0[part];
                *sum = simd.add_f64s(*sum, sums[i][j]);
            }
        }
    }
}

pub(crate) struct ProductSums<X> {
    signals: usize,
    columns: usize,
    /// If every signal has its own column: the tiles of [`TILE`] columns with themselves and those after them.
    tiles: Vec<Tile>,
    /// If several signals share a column: per signal its products with its own column and all after it.
    rows: Vec<Lane>,
    kind: PhantomData<X>,
}

impl<X: Unknowns> ProductSums<X> {
    fn none(signals: usize) -> Self {
        let mut none = Self { signals, columns: 0, tiles: Vec::new(), rows: Vec::new(), kind: PhantomData };
        if X::PER_COLUMN == 1 {
            let blocks = signals.div_ceil(TILE);
            none.columns = TILE * blocks;
            none.tiles = vec![[[Lane::ZERO; TILE]; TILE]; blocks * (blocks + 1) / 2];
        } else {
            none.columns = signals.div_ceil(X::PER_COLUMN);
            none.rows = vec![Lane::ZERO; none.row(signals)];
        }
        none
    }

    fn row(&self, i: usize) -> usize {
        (0..i).map(|before| self.columns - before / X::PER_COLUMN).sum()
    }

    pub(crate) fn square(&self) -> Vec<X> {
        let n = self.signals;
        let mut square = vec![X::ZERO; n * n];
        for i in 0..n {
            let (first_row, block) = (self.row(i), i / TILE);
            let tiles: usize = (0..block).map(|before| n.div_ceil(TILE) - before).sum();
            for j in i..n {
                let sum = match X::PER_COLUMN {
                    1 => self.tiles[tiles + j / TILE - block][i % TILE][j % TILE],
                    several => self.rows[first_row + j / several - i / several],
                };
                square[i * n + j] = X::of_column(sum, j);
                square[j * n + i] = square[i * n + j];
            }
        }
        square
    }
}

// Passes over columns at one sample, in the processor's registers: by default compilers take eight columns at a time
/// λ(k) = Aᵀλ(k+1) + W s(k) in every column; A is the identity plus `slopes`, and zero at the last sample.
pub(crate) struct Backward<'a, const N: usize> {
    pub slopes: Option<[[Lane; 3]; 3]>,
    pub weights: [Lane; 3],
    pub sensitivities: &'a [[Lane; 3]],
    pub adjoints: &'a mut [[Lane; N]],
}

impl<const N: usize> WithSimd for Backward<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { slopes, weights, sensitivities, adjoints } = self;
        for at in 0..parts::<S>() {
            let zero = simd.splat_f64s(0.0);
            let (mut by, mut weight) = ([[zero; 3]; 3], [zero; 3]);
            for d in 0..3 {
                weight[d] = part::<S>(&weights[d], at);
                for i in 0..3 {
                    by[d][i] = slopes.as_ref().map_or(zero, |slopes| part::<S>(&slopes[d][i], at));
                }
            }
            for (adjoint, s) in adjoints.iter_mut().zip(sensitivities) {
                let mut entries = [zero; 3];
                for d in 0..3 {
                    entries[d] = part::<S>(&adjoint[d], at);
                }
                let after = entries;
                for i in 0..3 {
                    if slopes.is_some() {
                        let by_yaw = simd.mul_add_f64s(by[2][i], after[2], after[i]);
                        let by_sway = simd.mul_add_f64s(by[1][i], after[1], by_yaw);
                        entries[i] = simd.mul_add_f64s(by[0][i], after[0], by_sway);
                    }
                    entries[i] = simd.mul_add_f64s(weight[i], part::<S>(&s[i], at), entries[i]);
                    put::<S>(&mut adjoint[i], at, entries[i]);
                }
            }
        }
    }
}

/// Writes w₀x₀ + w₁x₁ + w₂x₂ of every column into row `row` of a block.
struct Weigh<'a, const N: usize> {
    pub weights: [Lane; 3],
    pub columns: &'a [[Lane; N]],
    pub blocks: &'a mut [Block<Lane>],
    pub row: usize,
}

impl<const N: usize> WithSimd for Weigh<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { weights: [x, y, z], columns, blocks, row } = self;
        for at in 0..parts::<S>() {
            let [x, y, z] = [part::<S>(&x, at), part::<S>(&y, at), part::<S>(&z, at)];
            for (block, column) in blocks.iter_mut().zip(columns) {
                let sum = simd.mul_f64s(z, part::<S>(&column[2], at));
                let sum = simd.mul_add_f64s(y, part::<S>(&column[1], at), sum);
                put::<S>(&mut block[row], at, simd.mul_add_f64s(x, part::<S>(&column[0], at), sum));
            }
        }
    }
}

/// Writes entry `entry` of every column, times `factor`, into row `row` of a block.
struct Scale<'a, const N: usize> {
    pub factor: Lane,
    pub entry: usize,
    pub columns: &'a [[Lane; N]],
    pub blocks: &'a mut [Block<Lane>],
    pub row: usize,
}

impl<const N: usize> WithSimd for Scale<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { factor, entry, columns, blocks, row } = self;
        for at in 0..parts::<S>() {
            let factor = part::<S>(&factor, at);
            for (block, column) in blocks.iter_mut().zip(columns) {
                put::<S>(&mut block[row], at, simd.mul_f64s(factor, part::<S>(&column[entry], at)));
            }
        }
    }
}
