use std::marker::PhantomData;

use vessel::Lane;

use super::unknowns::Unknowns;
use crate::batch::{BLOCK, Block, accumulate};

/// Columns whose products with as many others are summed up at once: each sum has a register.
const TILE: usize = 5;
type Tile = [[Lane; TILE]; TILE];

/// Σ over samples of the product of every two signals, [`BLOCK`] samples at a time. Signals stand in columns as unknowns do.
pub(crate) struct Products<X> {
    signals: usize,
    columns: Vec<Block<Lane>>,
    filled: usize,
    sums: Sums<X>,
}

impl<X: Unknowns> Products<X> {
    pub(crate) fn new(signals: usize) -> Self {
        let sums = Sums::none(signals);
        Self { signals, columns: vec![[Lane::ZERO; BLOCK]; sums.columns], filled: 0, sums }
    }

    /// Column `c` at this sample.
    #[inline(always)]
    pub(crate) fn set(&mut self, c: usize, value: Lane) {
        self.columns[c][self.filled] = value;
    }

    /// Goes to the next sample: every column was set at this one.
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
            let mut tiles = self.sums.tiles.iter_mut();
            let columns = self.columns.as_chunks().0;
            for (i, one) in columns.iter().enumerate() {
                if let Some(tile) = tiles.next() {
                    add_tile::<true>(tile, one, one);
                }
                for (other, tile) in columns[i + 1..].iter().zip(&mut tiles) {
                    add_tile::<false>(tile, one, other);
                }
            }
            return;
        }
        let mut rest = &mut self.sums.rows[..];
        for i in 0..self.signals {
            let others = &self.columns[i / X::PER_COLUMN..];
            let own = &others[0];
            let (row, after) = std::mem::take(&mut rest).split_at_mut(others.len());
            rest = after;
            accumulate(
                others,
                row,
                #[inline(always)]
                |t, other, sum| X::of_column(own[t], i).lane().fused(other, sum),
            );
        }
    }

    /// The sums over all samples.
    pub(crate) fn finish(mut self) -> Sums<X> {
        for signal in &mut self.columns {
            signal[self.filled..].fill(Lane::ZERO);
        }
        vessel::vectorized!(self.add());
        self.sums
    }
}

/// Adds the products of some columns with some others over a block; of those with themselves each once.
#[allow(clippy::needless_range_loop)] // Unrolled, so that every sum has a register.
#[inline(always)]
fn add_tile<const THEMSELVES: bool>(tile: &mut Tile, one: &[Block<Lane>; TILE], other: &[Block<Lane>; TILE]) {
    let mut own = [[Lane::ZERO; TILE]; TILE];
    for t in 0..BLOCK {
        for i in 0..TILE {
            for j in 0..TILE {
                if !THEMSELVES || i <= j {
                    own[i][j] = one[i][t].fused(other[j][t], own[i][j]);
                }
            }
        }
    }
    for i in 0..TILE {
        for j in 0..TILE {
            if !THEMSELVES || i <= j {
                tile[i][j] += own[i][j];
            }
        }
    }
}

/// What [`Products`] came to.
pub(crate) struct Sums<X> {
    signals: usize,
    columns: usize,
    /// Where every signal has a column: those of [`TILE`] columns with themselves, with the next ones and so on.
    tiles: Vec<Tile>,
    /// Where several signals share one: by signal its products with its own column and all after it.
    rows: Vec<Lane>,
    kind: PhantomData<X>,
}

impl<X: Unknowns> Sums<X> {
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

    /// Where the sums of signal `i` begin.
    fn row(&self, i: usize) -> usize {
        (0..i).map(|before| self.columns - before / X::PER_COLUMN).sum()
    }

    /// All of them: signals × signals.
    pub(crate) fn square(&self) -> Vec<X> {
        let n = self.signals;
        let mut square = vec![X::ZERO; n * n];
        for i in 0..n {
            let (own, block) = (self.row(i), i / TILE);
            let tiles: usize = (0..block).map(|before| n.div_ceil(TILE) - before).sum();
            for j in i..n {
                let sum = match X::PER_COLUMN {
                    1 => self.tiles[tiles + j / TILE - block][i % TILE][j % TILE],
                    several => self.rows[own + j / several - i / several],
                };
                square[i * n + j] = X::of_column(sum, j);
                square[j * n + i] = square[i * n + j];
            }
        }
        square
    }
}
