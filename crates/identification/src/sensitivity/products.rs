use std::marker::PhantomData;

use pulp::{Arch, Simd, WithSimd};
use vessel::{LANES, Lane};

use super::unknowns::Unknowns;
use crate::batch::{BLOCK, Block, accumulate};

/// Columns whose products with as many others are summed up in one go.
const TILE: usize = 5;
/// Half of the lanes: a register of processors whose registers are too few for a tile.
const HALF: usize = LANES / 2;
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

    /// The first columns at this sample: of every one in `from` its `value`.
    #[inline(always)]
    pub(crate) fn fill<T>(&mut self, from: &[T], value: impl Fn(&T) -> Lane) {
        let at = self.filled % BLOCK;
        for (column, own) in self.columns.iter_mut().zip(from) {
            column[at] = value(own);
        }
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
            let columns = self.columns.as_chunks().0;
            Arch::new().dispatch(Tiles { tiles: &mut self.sums.tiles, columns });
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

/// Adds the products of all columns with all over a block.
struct Tiles<'a> {
    tiles: &'a mut [Tile],
    columns: &'a [[Block<Lane>; TILE]],
}

impl WithSimd for Tiles<'_> {
    type Output = ();

    /// Every sum has a register: of 32 that hold all lanes there are enough for a tile, of 16 for two rows of half the lanes.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        if S::F64_LANES == LANES { self.add::<true>() } else { self.add::<false>() }
    }
}

impl Tiles<'_> {
    #[inline(always)]
    fn add<const WHOLE: bool>(self) {
        let mut tiles = self.tiles.iter_mut();
        for (i, one) in self.columns.iter().enumerate() {
            if let Some(tile) = tiles.next() {
                add_tile::<true, WHOLE>(tile, one, one);
            }
            for (other, tile) in self.columns[i + 1..].iter().zip(&mut tiles) {
                add_tile::<false, WHOLE>(tile, one, other);
            }
        }
    }
}

/// Adds the products of some columns with some others; of those with themselves each once.
#[inline(always)]
fn add_tile<const THEMSELVES: bool, const WHOLE: bool>(
    tile: &mut Tile,
    one: &[Block<Lane>; TILE],
    other: &[Block<Lane>; TILE],
) {
    if WHOLE {
        return add_rows::<THEMSELVES, LANES, 0, TILE>(tile, one, other, 0);
    }
    for half in 0..2 {
        add_rows::<THEMSELVES, HALF, 0, 2>(tile, one, other, half);
        if THEMSELVES {
            // Half of the last rows' products: as many as of two rows.
            add_rows::<THEMSELVES, HALF, 2, 3>(tile, one, other, half);
        } else {
            add_rows::<THEMSELVES, HALF, 2, 2>(tile, one, other, half);
            add_rows::<THEMSELVES, HALF, 4, 1>(tile, one, other, half);
        }
    }
}

/// Adds `ROWS` rows of a tile, from row `FROM` on, in the lanes of `part`: `WIDTH` lanes a part.
#[allow(clippy::needless_range_loop)] // Unrolled, so that every sum has a register.
#[inline(always)]
fn add_rows<const THEMSELVES: bool, const WIDTH: usize, const FROM: usize, const ROWS: usize>(
    tile: &mut Tile,
    one: &[Block<Lane>; TILE],
    other: &[Block<Lane>; TILE],
    part: usize,
) {
    let mut own = [[[0.0_f64; WIDTH]; TILE]; ROWS];
    for t in 0..BLOCK {
        for i in 0..ROWS {
            let factor = &one[FROM + i][t].0.as_chunks::<WIDTH>().0[part];
            for j in 0..TILE {
                let others = &other[j][t].0.as_chunks::<WIDTH>().0[part];
                if !THEMSELVES || FROM + i <= j {
                    for lane in 0..WIDTH {
                        own[i][j][lane] = factor[lane].mul_add(others[lane], own[i][j][lane]);
                    }
                }
            }
        }
    }
    for i in 0..ROWS {
        for j in 0..TILE {
            if !THEMSELVES || FROM + i <= j {
                let sums = &mut tile[FROM + i][j].0.as_chunks_mut::<WIDTH>().0[part];
                for lane in 0..WIDTH {
                    sums[lane] += own[i][j][lane];
                }
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
