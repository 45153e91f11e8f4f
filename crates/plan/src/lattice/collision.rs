//! Where the boxes that a move sweeps are free, for all cells at once.
//!
//! Boxes are `[xmin, ymin, xmax, ymax]` \[m\]. A swept box moves with the cell, so the cells at which it
//! overlaps an obstacle form a rectangle of indices. The rectangles of a move are summed in a table of
//! differences. The result equals a test of every cell, bit for bit.

use crate::lattice::LatticeFile;

/// A half-open range of indices.
type Span = std::ops::Range<usize>;

/// Reusable answer to "at which cells are these swept boxes free?".
#[derive(Clone, Debug)]
pub struct FreeCells {
    grid: LatticeFile,
    per_cell: f64,
    x: Vec<f64>,
    y: Vec<f64>,
}

impl FreeCells {
    /// A grid with `cell` above 0 and finite numbers.
    pub fn new(grid: LatticeFile) -> Self {
        let nodes = |axis: usize, count: usize| {
            (0..count).map(|k| grid.origin[axis] + grid.cell * k as f64).collect()
        };
        Self { grid, per_cell: 1.0 / grid.cell, x: nodes(0, grid.nx), y: nodes(1, grid.ny) }
    }

    /// Cells at which all `swept` boxes (relative to the node, `min <= max`) lie in `bounds`, edges included, and share no
    /// area with any of `obstacles`; `nx * ny`, i fastest.
    pub fn of(&self, bounds: &[f64; 4], obstacles: &[[f64; 4]], swept: &[[f64; 4]]) -> Vec<bool> {
        let (nx, ny) = (self.grid.nx, self.grid.ny);
        let (mut inside_x, mut inside_y) = (0..nx, 0..ny);
        let mut hits = Hits::new(nx, ny);
        for swept in swept {
            inside_x = both(&inside_x, &self.inside(0, swept, bounds));
            inside_y = both(&inside_y, &self.inside(1, swept, bounds));
            for obstacle in obstacles {
                let across = self.overlap(0, swept, obstacle);
                if !across.is_empty() {
                    hits.add(&across, &self.overlap(1, swept, obstacle));
                }
            }
        }
        hits.free(&inside_x, &inside_y)
    }

    /// Indices along an axis at which the swept box lies in the bounds.
    fn inside(&self, axis: usize, swept: &[f64; 4], bounds: &[f64; 4]) -> Span {
        let first = self.first(axis, bounds[axis] - swept[axis], |node| node + swept[axis] >= bounds[axis]);
        let high = axis + 2;
        let end = self.first(axis, bounds[high] - swept[high], |node| node + swept[high] > bounds[high]);
        first..end
    }

    /// Indices along an axis at which the inner parts of swept box and obstacle overlap.
    fn overlap(&self, axis: usize, swept: &[f64; 4], obstacle: &[f64; 4]) -> Span {
        let high = axis + 2;
        let first =
            self.first(axis, obstacle[axis] - swept[high], |node| node + swept[high] > obstacle[axis]);
        let end = self.first(axis, obstacle[high] - swept[axis], |node| node + swept[axis] >= obstacle[high]);
        first..end
    }

    /// The first index whose node passes a test that all later ones pass as well; it is near the place `near` \[m\].
    fn first(&self, axis: usize, near: f64, passes: impl Fn(f64) -> bool) -> usize {
        let nodes = if axis == 0 { &self.x } else { &self.y };
        // The guess may be off; the cast maps negative numbers to 0.
        let mut index = ((near - self.grid.origin[axis]) * self.per_cell) as usize;
        index = index.min(nodes.len());
        while index > 0 && passes(nodes[index - 1]) {
            index -= 1;
        }
        while index < nodes.len() && !passes(nodes[index]) {
            index += 1;
        }
        index
    }
}

fn both(a: &Span, b: &Span) -> Span {
    a.start.max(b.start)..a.end.min(b.end)
}

/// Hits per cell, as differences along both axes.
struct Hits {
    nx: usize,
    ny: usize,
    differences: Vec<i32>,
}

impl Hits {
    fn new(nx: usize, ny: usize) -> Self {
        Self { nx, ny, differences: vec![0; (nx + 1) * (ny + 1)] }
    }

    fn add(&mut self, across: &Span, along: &Span) {
        if along.is_empty() {
            return;
        }
        let row = self.nx + 1;
        self.differences[along.start * row + across.start] += 1;
        self.differences[along.start * row + across.end] -= 1;
        self.differences[along.end * row + across.start] -= 1;
        self.differences[along.end * row + across.end] += 1;
    }

    fn free(&self, inside_x: &Span, inside_y: &Span) -> Vec<bool> {
        let mut above = vec![0; self.nx];
        let mut free = Vec::with_capacity(self.nx * self.ny);
        for j in 0..self.ny {
            let mut along = 0;
            for (i, above) in above.iter_mut().enumerate() {
                along += self.differences[j * (self.nx + 1) + i];
                *above += along;
                free.push(*above == 0 && inside_x.contains(&i) && inside_y.contains(&j));
            }
        }
        free
    }
}
