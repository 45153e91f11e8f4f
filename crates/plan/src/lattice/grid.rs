use std::fmt;

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
