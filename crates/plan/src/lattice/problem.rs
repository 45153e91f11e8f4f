use crate::lattice::allowed::{Allowed, Arc};
use crate::lattice::units::Units;
use crate::lattice::{Action, Cost, Goal, Invalid, Lattice, MoveId, Pose, Solution, validate};

/// An accepted problem: the allowed moves as an adjacency over poses, and costs as integers.
#[derive(Clone, Debug)]
pub struct Problem {
    lattice: Lattice,
    actions: Vec<Action>,
    start: Pose,
    goal: Goal,
    pub(crate) units: Units,
    /// All moves of all actions, in order.
    pub(crate) moves: Vec<Known>,
    /// The informative actions, by slot: index of the action, uses, and the least key of every use.
    pub(crate) informative: Vec<Informative>,
    allowed: Allowed,
}

/// The properties of a move that searches need.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    pub id: MoveId,
    /// Index among the action's moves with the same `from`.
    pub variant: u32,
    /// Key of the cost; for an informative move only the excess over the least of its action.
    pub key: u64,
    /// Slot of an informative action.
    pub slot: Option<u32>,
}

/// An informative action.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Informative {
    pub action: usize,
    pub required: u32,
    pub least_key: u64,
}

impl Problem {
    /// Accepts a problem. `allowed` says whether a move may start at cell `(i, j)`; it is called once for
    /// every move and cell from which the move stays in the lattice.
    ///
    /// # Errors
    /// A lattice without poses or with more than 2^32, moves of layers that do not exist, costs that are negative or
    /// not finite or too large to add up, an informative action without moves, names given twice, start or goal outside
    /// of the lattice, an empty list of goals.
    pub fn new(
        lattice: Lattice,
        actions: Vec<Action>,
        start: Pose,
        goal: Goal,
        allowed: impl FnMut(MoveId, usize, usize) -> bool,
    ) -> Result<Self, Invalid> {
        validate::lattice(&lattice)?;
        validate::actions(&lattice, &actions)?;
        validate::ends(&lattice, start, &goal)?;
        let informative = informative(&actions);
        let units = Units::new(&costs(&actions), longest_plan(&lattice, &actions))?;
        let moves = known_moves(&actions, &units);
        let allowed = allowed_moves(&lattice, &actions, &moves, allowed)?;
        let mut problem = Self { lattice, actions, start, goal, units, moves, informative, allowed };
        problem.split_off_least_keys();
        Ok(problem)
    }

    /// The size of the lattice.
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// The actions, in the caller's order.
    pub fn actions(&self) -> &[Action] {
        &self.actions
    }

    /// The pose in which a plan starts.
    pub fn start(&self) -> Pose {
        self.start
    }

    /// Where a plan may end.
    pub fn goal(&self) -> &Goal {
        &self.goal
    }

    /// Whether a plan may end in `pose`.
    pub fn is_goal(&self, pose: Pose) -> bool {
        match &self.goal {
            Goal::Any => true,
            Goal::Poses(poses) => poses.contains(&pose),
        }
    }

    /// Number of states: poses times count vectors, saturating at 128 bits.
    pub fn states(&self) -> u128 {
        let vectors = self.informative.iter().map(|slot| u128::from(slot.required) + 1);
        vectors.fold(self.lattice.poses() as u128, u128::saturating_mul)
    }

    /// Whether the move of this action may be made from `pose`.
    pub fn is_allowed(&self, pose: Pose, id: MoveId) -> bool {
        self.lattice.contains(pose)
            && self.arcs(self.lattice.number(pose)).any(|arc| self.moves[arc.step as usize].id == id)
    }

    /// The allowed moves from the pose with this number.
    pub(crate) fn arcs(&self, number: usize) -> impl Iterator<Item = Arc> + '_ {
        self.allowed.arcs(number)
    }

    /// The allowed moves into the pose with this number, with their starts, ordered by the latter.
    pub(crate) fn arcs_into(&self, number: usize) -> impl Iterator<Item = Arc> + '_ {
        self.allowed.arcs_into(number)
    }

    /// Number of poses from which `wanted` moves are allowed, summed over these.
    pub(crate) fn arc_count(&self, wanted: impl Fn(usize) -> bool) -> usize {
        let counts = self.allowed.counts().iter().enumerate();
        counts.filter(|(step, _)| wanted(*step)).map(|(_, count)| count).sum()
    }

    /// The uses that are required, by slot.
    pub(crate) fn required(&self) -> Vec<u32> {
        self.informative.iter().map(|slot| slot.required).collect()
    }

    /// The cost of a plan with these counts whose key is `key`, without the least keys of informative
    /// actions.
    pub(crate) fn cost(&self, key: u64, counts: &[u32]) -> Cost {
        let least =
            self.informative.iter().zip(counts).map(|(slot, &count)| slot.least_key * u64::from(count));
        self.units.cost(key.saturating_add(least.sum()))
    }

    /// The sum of the keys of a plan's moves, with the least keys of informative actions.
    pub(crate) fn whole_key(&self, plan: &Solution) -> u64 {
        plan.steps.iter().map(|step| self.units.key(step.cost)).sum()
    }

    /// Every plan pays the least key of an informative action `required` times, so that the searches need not
    /// carry it.
    fn split_off_least_keys(&mut self) {
        for (number, slot) in self.informative.iter_mut().enumerate() {
            let own = || self.moves.iter().filter(|step| step.slot == Some(number as u32));
            slot.least_key = own().map(|step| step.key).min().unwrap_or(0);
        }
        for step in &mut self.moves {
            if let Some(slot) = step.slot {
                step.key -= self.informative[slot as usize].least_key;
            }
        }
    }
}

fn informative(actions: &[Action]) -> Vec<Informative> {
    let slots = actions.iter().enumerate().filter(|(_, action)| action.required > 0);
    slots.map(|(action, a)| Informative { action, required: a.required, least_key: 0 }).collect()
}

fn costs(actions: &[Action]) -> Vec<Cost> {
    actions.iter().flat_map(|action| action.moves.iter().map(|step| step.cost)).collect()
}

/// Steps of the longest plan that repeats no state: between two informative moves every pose at most once.
fn longest_plan(lattice: &Lattice, actions: &[Action]) -> u64 {
    let uses: u64 = actions.iter().map(|action| u64::from(action.required)).sum();
    uses.saturating_add(1).saturating_mul(lattice.poses() as u64)
}

fn known_moves(actions: &[Action], units: &Units) -> Vec<Known> {
    let mut known = Vec::new();
    let mut slots = 0;
    for (action, a) in actions.iter().enumerate() {
        let slot = (a.required > 0).then_some(slots);
        for (index, step) in a.moves.iter().enumerate() {
            let variant = a.moves[..index].iter().filter(|other| other.from == step.from).count() as u32;
            known.push(Known { id: MoveId { action, index }, variant, key: units.key(step.cost), slot });
        }
        slots += u32::from(a.required > 0);
    }
    known
}

fn allowed_moves(
    lattice: &Lattice,
    actions: &[Action],
    moves: &[Known],
    mut allowed: impl FnMut(MoveId, usize, usize) -> bool,
) -> Result<Allowed, Invalid> {
    let shape = |known: &Known| actions[known.id.action].moves[known.id.index];
    let shapes = moves.iter().map(shape);
    let mut all = Allowed::new(*lattice, shapes.map(|shape| (shape.from, shape.di, shape.dj, shape.to)));
    let mut count = 0;
    for layer in 0..lattice.layers {
        let ways: Vec<_> = all.ways(layer).iter().map(|way| (*way, &moves[way.step as usize])).collect();
        for cell in 0..lattice.nx * lattice.ny {
            let pose = Pose { i: cell % lattice.nx, j: cell / lattice.nx, layer };
            for &(way, known) in &ways {
                if lattice.end(pose, &shape(known)).is_some() && allowed(known.id, pose.i, pose.j) {
                    all.allow(way, cell);
                    count += 1;
                }
            }
        }
        validate::arcs(count)?;
    }
    Ok(all)
}
