use std::ops::RangeBounds;

use super::input::{Frame, Raster};
use super::outline::{Vertex, outlines};
use super::view::View;
use crate::figures::svg::{Path, Point};

/// Cells finer than this many pixels are merged.
const FINEST: f64 = 0.7;

/// Ranks of the cells that lie in the frame: 0 for nothing, the greater the more dangerous.
#[derive(Clone, Debug)]
pub(crate) struct Ranks {
    origin: [f64; 2],
    cell_m: f64,
    nx: usize,
    ny: usize,
    ranks: Vec<u8>,
}

impl Ranks {
    /// The part of `grid` inside the frame; `None` if they are disjoint. `rank` is called with a cell's index.
    pub(crate) fn new(view: &View, grid: &Raster, rank: impl Fn(usize) -> u8) -> Option<Self> {
        let Frame { west, south, east, north } = view.frame;
        let (first_i, end_i) = range(west, east, grid.origin[0], grid.cell_m, grid.nx)?;
        let (first_j, end_j) = range(south, north, grid.origin[1], grid.cell_m, grid.ny)?;
        let [x, y] = grid.origin;
        let origin = [x + first_i as f64 * grid.cell_m, y + first_j as f64 * grid.cell_m];
        let (nx, ny) = (end_i - first_i, end_j - first_j);
        let finest = (FINEST / (grid.cell_m * view.scale)).ceil().max(1.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at least one, and cast saturates"
        )]
        let block = (finest as usize).min(nx.max(ny));
        let mut whole = Self { origin, cell_m: grid.cell_m, nx, ny, ranks: Vec::with_capacity(nx * ny) };
        for j in first_j..end_j {
            whole.ranks.extend((first_i..end_i).map(|i| rank(j * grid.nx + i)));
        }
        Some(whole.merged(block))
    }

    /// Blocks of `by` × `by` cells, each with its greatest rank.
    pub(crate) fn merged(self, by: usize) -> Self {
        if by < 2 {
            return self;
        }
        let (nx, ny) = (self.nx.div_ceil(by), self.ny.div_ceil(by));
        let mut ranks = vec![0; nx * ny];
        for (at, &rank) in self.ranks.iter().enumerate() {
            let block = &mut ranks[at / self.nx / by * nx + at % self.nx / by];
            *block = rank.max(*block);
        }
        Self { origin: self.origin, cell_m: self.cell_m * by as f64, nx, ny, ranks }
    }

    pub(crate) fn at(&self, i: usize, j: usize) -> u8 {
        self.ranks[j * self.nx + i]
    }

    pub(crate) fn size(&self) -> (usize, usize) {
        (self.nx, self.ny)
    }

    /// Whether there is a cell of this rank.
    pub(crate) fn holds(&self, rank: u8) -> bool {
        self.ranks.contains(&rank)
    }

    /// Pixels between two columns.
    pub(crate) fn pitch(&self, view: &View) -> f64 {
        self.cell_m * view.scale
    }

    /// Pixel of a vertex.
    pub(crate) fn vertex(&self, view: &View, (i, j): Vertex) -> Point {
        let [x, y] = self.origin;
        view.place([x + i as f64 * self.cell_m, y + j as f64 * self.cell_m])
    }

    /// Borders of all cells of these ranks, kept inside the frame.
    pub(crate) fn border(&self, view: &View, ranks: impl RangeBounds<u8>) -> Path {
        let mut path = Path::default();
        for ring in outlines(self.nx, self.ny, |i, j| ranks.contains(&self.at(i, j))) {
            let corners: Vec<Point> =
                ring.into_iter().map(|vertex| view.nearest(self.vertex(view, vertex))).collect();
            path.ring(&corners);
        }
        path
    }
}

/// First and end index of the cells between `low` and `high`.
fn range(low: f64, high: f64, origin: f64, cell: f64, count: usize) -> Option<(usize, usize)> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the count")]
    let index = |at: f64| at.clamp(0.0, count as f64) as usize;
    let first = index(((low - origin) / cell).floor());
    let end = index(((high - origin) / cell).ceil());
    (first < end).then_some((first, end))
}
