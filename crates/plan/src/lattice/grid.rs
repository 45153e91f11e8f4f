use std::collections::BTreeSet;
use std::fmt;

use crate::lattice::Invalid;

/// The size of a lattice: `nx * ny` cells, each with `layers` poses. A layer is a heading level, or a heading level
/// with a speed mode; the search does not care which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lattice {
    /// Number of cells along the first axis.
    pub nx: usize,
    /// Number of cells along the second axis.
    pub ny: usize,
    /// Number of layers.
    pub layers: usize,
}

impl Lattice {
    /// Whether the pose is one of the lattice's.
    pub fn contains(&self, pose: Pose) -> bool {
        pose.i < self.nx && pose.j < self.ny && pose.layer < self.layers
    }

    /// Number of poses. Valid once the problem has been accepted.
    pub(crate) fn poses(&self) -> usize {
        self.nx * self.ny * self.layers
    }

    /// The pose's number: layer slowest, `i` fastest.
    pub(crate) fn number(&self, pose: Pose) -> usize {
        (pose.layer * self.ny + pose.j) * self.nx + pose.i
    }

    /// The pose of a number.
    pub(crate) fn pose(&self, number: usize) -> Pose {
        let row = number / self.nx;
        Pose { i: number % self.nx, j: row % self.ny, layer: row / self.ny }
    }

    /// Where a move from `pose` ends, if that is a pose of the lattice.
    pub(crate) fn end(&self, pose: Pose, step: &Move) -> Option<Pose> {
        let i = pose.i.checked_add_signed(step.di as isize)?;
        let j = pose.j.checked_add_signed(step.dj as isize)?;
        let end = Pose { i, j, layer: step.to };
        self.contains(end).then_some(end)
    }
}

/// A pose of the lattice: cell and layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Pose {
    /// Cell along the first axis.
    pub i: usize,
    /// Cell along the second axis.
    pub j: usize,
    /// Layer.
    pub layer: usize,
}

impl fmt::Display for Pose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {}, {})", self.i, self.j, self.layer)
    }
}

/// A cost in the caller's units. Plans are compared by `primary`, then by `secondary`. Both are finite and
/// not negative. Resolution is 1e-9: finer differences are ignored.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Cost {
    /// Compared first.
    pub primary: f64,
    /// Decides between plans of equal `primary`.
    pub secondary: f64,
}

impl Cost {
    /// A primary cost only.
    pub fn primary(primary: f64) -> Self {
        Self { primary, secondary: 0.0 }
    }
}

/// Something the vessel can do. All moves of one action share its count.
#[derive(Clone, Debug, PartialEq)]
pub struct Action {
    /// Unique name.
    pub name: String,
    /// How often a plan uses it, exactly; 0 for a basic action, which a plan uses as it likes.
    pub required: u32,
    /// What it does from which layer. Several moves from one layer are variants.
    pub moves: Vec<Move>,
}

/// One move of an action: from any cell in layer `from` by `(di, dj)` cells into layer `to`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// Layer in which it starts.
    pub from: usize,
    /// Cells along the first axis.
    pub di: i32,
    /// Cells along the second axis.
    pub dj: i32,
    /// Layer in which it ends.
    pub to: usize,
    /// What it costs.
    pub cost: Cost,
}

/// Names a move of a problem: `index` counts within all moves of the action.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MoveId {
    /// Index of the action.
    pub action: usize,
    /// Index among the action's moves.
    pub index: usize,
}

/// Where a plan may end.
#[derive(Clone, Debug, PartialEq)]
pub enum Goal {
    /// Anywhere.
    Any,
    /// In one of these poses; the start itself for a plan that returns home.
    Poses(Vec<Pose>),
}

/// Most uses of all informative actions together, so that sums of keys and prices stay in range.
const MOST_USES: u64 = 100_000;
/// Bits for the counts of one state.
const COUNT_BITS: u32 = 128;

pub(crate) fn lattice(lattice: &Lattice) -> Result<(), Invalid> {
    let size = format!("{} x {} cells, {} layers", lattice.nx, lattice.ny, lattice.layers);
    let poses = lattice.nx.checked_mul(lattice.ny).and_then(|cells| cells.checked_mul(lattice.layers));
    match poses {
        Some(0) => Err(Invalid::new("lattice", size, "at least one cell and one layer", "give its size")),
        Some(poses) if u32::try_from(poses).is_ok_and(|poses| poses < u32::MAX) => Ok(()),
        _ => Err(Invalid::new("lattice", size, "fewer than 2^32 poses", "take larger cells")),
    }
}

pub(crate) fn actions(lattice: &Lattice, actions: &[Action]) -> Result<(), Invalid> {
    let mut names = BTreeSet::new();
    for action in actions {
        let thing = || format!("action {}", action.name);
        if !names.insert(&action.name) {
            return Err(Invalid::new(thing(), "this name twice", "unique names", "rename one of them"));
        }
        if action.required > 0 && action.moves.is_empty() {
            let expected = "moves, since it must be used";
            return Err(Invalid::new(thing(), "no moves", expected, "give it moves or leave it out"));
        }
        for (index, step) in action.moves.iter().enumerate() {
            self::step(lattice, &format!("action {}, move {index}", action.name), step)?;
        }
    }
    uses(actions)
}

fn step(lattice: &Lattice, thing: &str, step: &Move) -> Result<(), Invalid> {
    for (side, layer) in [("from", step.from), ("to", step.to)] {
        if layer >= lattice.layers {
            let expected = format!("less than {}", lattice.layers);
            let remedy = "layers count from 0";
            return Err(Invalid::new(format!("{thing}, {side} layer"), layer.to_string(), expected, remedy));
        }
    }
    cost(thing, step.cost)
}

fn cost(thing: &str, cost: Cost) -> Result<(), Invalid> {
    for (criterion, value) in [("primary", cost.primary), ("secondary", cost.secondary)] {
        if !(value.is_finite() && value >= 0.0) {
            let thing = format!("{thing}, {criterion} cost");
            let expected = "a finite number not below 0";
            return Err(Invalid::new(thing, value.to_string(), expected, "a shortest plan needs such costs"));
        }
    }
    Ok(())
}

fn uses(actions: &[Action]) -> Result<(), Invalid> {
    let uses: u64 = actions.iter().map(|action| u64::from(action.required)).sum();
    if uses > MOST_USES {
        let (expected, remedy) = (format!("at most {MOST_USES}"), "take longer maneuvers");
        return Err(Invalid::new("required uses in total", uses.to_string(), expected, remedy));
    }
    let bits: u32 = actions.iter().map(|action| u32::BITS - action.required.leading_zeros()).sum();
    if bits > COUNT_BITS {
        let expected = format!("counts of all informative actions within {COUNT_BITS} bits");
        let remedy = "take fewer or longer maneuvers";
        return Err(Invalid::new("required uses", format!("{bits} bits"), expected, remedy));
    }
    Ok(())
}

pub(crate) fn ends(lattice: &Lattice, start: Pose, goal: &Goal) -> Result<(), Invalid> {
    let inside = |thing: &str, pose: Pose| {
        let expected = format!("below ({}, {}, {})", lattice.nx, lattice.ny, lattice.layers);
        let outside =
            || Invalid::new(thing, pose.to_string(), expected, "give a pose (i, j, layer) of the lattice");
        if lattice.contains(pose) { Ok(()) } else { Err(outside()) }
    };
    inside("start", start)?;
    match goal {
        Goal::Any => Ok(()),
        Goal::Poses(poses) if poses.is_empty() => {
            let remedy = "list poses, or let the plan end anywhere";
            Err(Invalid::new("goal", "no pose", "at least one pose", remedy))
        }
        Goal::Poses(poses) => poses.iter().try_for_each(|&pose| inside("goal", pose)),
    }
}

pub(crate) fn arcs(arcs: usize) -> Result<(), Invalid> {
    let too_many = |_| {
        Invalid::new("allowed moves", arcs.to_string(), "fewer than 2^32 over all poses", "take larger cells")
    };
    u32::try_from(arcs).map(|_| ()).map_err(too_many)
}

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

    /// Allows no moves into poses that are closed.
    pub fn close(&mut self, closed: &[bool]) {
        let cells = self.lattice.nx * self.lattice.ny;
        for (number, _) in closed.iter().enumerate().filter(|(_, closed)| **closed) {
            let into: Vec<Arc> = self.arcs_into(number).collect();
            for Arc { node, step } in into {
                let (layer, cell) = (node as usize / cells, node as usize % cells);
                let Some(way) = self.from[layer].iter().find(|way| way.step == step) else { continue };
                let bit = self.bit(way, cell);
                self.bits[bit / 64] &= !(1 << (bit % 64));
                self.counts[step as usize] -= 1;
            }
        }
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

    /// The allowed moves into the pose with this number, each with the pose where it starts, ordered by the latter.
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
