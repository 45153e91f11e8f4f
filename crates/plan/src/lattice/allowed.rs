//! Which moves are allowed from which poses: a bit for each.

use crate::lattice::Lattice;

/// The moves that are allowed from every pose; those that leave the lattice are not.
#[derive(Clone, Debug)]
pub(crate) struct Allowed {
    lattice: Lattice,
    /// By layer: the moves from it in order, and those into it in the order of the poses that they come from.
    from: Vec<Vec<Way>>,
    into: Vec<Vec<Way>>,
    /// By layer: where its bits begin.
    first: Vec<usize>,
    bits: Vec<u64>,
    /// By move: the number of poses that it is allowed from.
    counts: Vec<usize>,
}

/// An allowed move: the pose (or node) at its other end, and the move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    pub node: u32,
    pub step: u32,
}

/// A move in terms of pose numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    pub step: u32,
    /// Layer where it starts, and its place among the moves from there.
    layer: usize,
    rank: usize,
    di: isize,
    dj: isize,
    /// Difference of the pose numbers.
    by: isize,
}

impl Allowed {
    /// Before any of these moves is allowed; each is `(from, di, dj, to)`.
    pub fn new(lattice: Lattice, moves: impl Iterator<Item = (usize, i32, i32, usize)>) -> Self {
        let cells = lattice.nx * lattice.ny;
        let (mut from, mut into) = (vec![Vec::new(); lattice.layers], vec![Vec::new(); lattice.layers]);
        for (step, (layer, di, dj, to)) in moves.enumerate() {
            let (di, dj, rank) = (di as isize, dj as isize, from[layer].len());
            // In 64 bits no sum overflows: a lattice has fewer than 2^32 poses.
            let by = (to as isize - layer as isize) * cells as isize + dj * lattice.nx as isize + di;
            let way = Way { step: step as u32, layer, rank, di, dj, by };
            from[layer].push(way);
            into[to].push(way);
        }
        into.iter_mut().for_each(|ways| ways.sort_by_key(|way: &Way| (-way.by, way.step)));
        let (mut first, mut end) = (Vec::new(), 0);
        for ways in &from {
            first.push(end);
            end += cells * ways.len();
        }
        let counts = vec![0; from.iter().map(Vec::len).sum()];
        Self { lattice, from, into, first, bits: vec![0; end.div_ceil(64)], counts }
    }

    /// The moves from a layer.
    pub fn ways(&self, layer: usize) -> &[Way] {
        &self.from[layer]
    }

    /// Allows a move from a cell of its layer.
    pub fn allow(&mut self, way: Way, cell: usize) {
        let bit = self.bit(&way, cell);
        self.bits[bit / 64] |= 1 << (bit % 64);
        self.counts[way.step as usize] += 1;
    }

    /// By move: the number of poses that it is allowed from.
    pub fn counts(&self) -> &[usize] {
        &self.counts
    }

    /// The allowed moves from the pose with this number, each with the pose where it ends.
    pub fn arcs(&self, number: usize) -> impl Iterator<Item = Arc> + '_ {
        let cells = self.lattice.nx * self.lattice.ny;
        let (layer, cell) = (number / cells, number % cells);
        let allowed = self.from[layer].iter().filter(move |way| self.has(way, cell));
        allowed.map(move |way| Arc { node: number.wrapping_add_signed(way.by) as u32, step: way.step })
    }

    /// The allowed moves into the pose with this number, each with the pose where it starts, ordered by the
    /// latter.
    pub fn arcs_into(&self, number: usize) -> impl Iterator<Item = Arc> + '_ {
        let Lattice { nx, ny, .. } = self.lattice;
        let pose = self.lattice.pose(number);
        self.into[pose.layer].iter().filter_map(move |way| {
            let i = pose.i.checked_add_signed(-way.di).filter(|&i| i < nx)?;
            let j = pose.j.checked_add_signed(-way.dj).filter(|&j| j < ny)?;
            let node = number.wrapping_add_signed(-way.by) as u32;
            self.has(way, j * nx + i).then_some(Arc { node, step: way.step })
        })
    }

    fn has(&self, way: &Way, cell: usize) -> bool {
        let bit = self.bit(way, cell);
        self.bits[bit / 64] >> (bit % 64) & 1 == 1
    }

    fn bit(&self, way: &Way, cell: usize) -> usize {
        self.first[way.layer] + cell * self.from[way.layer].len() + way.rank
    }
}
