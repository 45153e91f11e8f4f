use super::grid::{self, Allowed, Arc};
use crate::lattice::{Action, Cost, Goal, Invalid, Lattice, MoveId, Pose, Solution, Step};

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
        grid::lattice(&lattice)?;
        grid::actions(&lattice, &actions)?;
        grid::ends(&lattice, start, &goal)?;
        let informative = informative(&actions);
        let costs: Vec<Cost> = actions.iter().flat_map(|it| it.moves.iter().map(|step| step.cost)).collect();
        let units = Units::new(&costs, longest_plan(&lattice, &actions))?;
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

    /// An allowed move from `pose`.
    pub(crate) fn step(&self, from: Pose, step: u32) -> Step {
        let known = &self.moves[step as usize];
        let (action, shape) = (known.id.action, &self.actions[known.id.action].moves[known.id.index]);
        let Some(to) = self.lattice.end(from, shape) else {
            unreachable!("the searches follow allowed moves, and those stay in the lattice")
        };
        Step { action, variant: known.variant as usize, from, to, cost: shape.cost }
    }

    /// Allows no moves that end at a pose whose number is `closed`.
    pub(crate) fn close(&mut self, closed: &[bool]) {
        self.allowed.close(closed);
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

    /// The cost of a plan with these counts whose key is `key`, without the least keys of informative actions.
    pub(crate) fn cost(&self, key: u64, uses: &[u32]) -> Cost {
        let least = self.informative.iter().zip(uses).map(|(slot, &count)| slot.least_key * u64::from(count));
        self.units.cost(key.saturating_add(least.sum()))
    }

    /// The sum of the keys of a plan's moves, with the least keys of informative actions.
    pub(crate) fn whole_key(&self, plan: &Solution) -> u64 {
        plan.steps.iter().map(|step| self.units.key(step.cost)).sum()
    }

    /// Every plan pays each of the least costs of an informative action `required` times: the searches need not carry them.
    fn split_off_least_keys(&mut self) {
        let radix = self.units.radix;
        for (number, slot) in self.informative.iter_mut().enumerate() {
            let keys =
                || self.moves.iter().filter(|step| step.slot == Some(number as u32)).map(|step| step.key);
            let least = keys().map(|key| key / radix).min().zip(keys().map(|key| key % radix).min());
            slot.least_key = least.map_or(0, |(primary, secondary)| primary * radix + secondary);
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
        grid::arcs(count)?;
    }
    Ok(all)
}

/// The finest decimal of a cost.
const FINEST_DECIMAL: i32 = 9;
/// Largest sum of keys, so that sums and differences stay within 64 bits.
const LARGEST_SUM: u128 = 1 << 61;

/// The common unit of one criterion: `unit = divisor / 10^decimals`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scale {
    ten: f64,
    divisor: u64,
    /// Largest cost in units.
    largest: u64,
}

impl Scale {
    fn of(criterion: &str, costs: &[f64]) -> Result<Self, Invalid> {
        let ten = (0..FINEST_DECIMAL).map(|k| 10f64.powi(k)).find(|&ten| costs.iter().all(|&c| fits(c, ten)));
        let ten = ten.unwrap_or(10f64.powi(FINEST_DECIMAL));
        if let Some(&cost) = costs.iter().find(|&&cost| cost * ten > 1e15) {
            let thing = format!("{criterion} cost");
            let expected = format!("at most {:e} with so many decimals", 1e15 / ten);
            return Err(Invalid::new(thing, cost.to_string(), expected, "give costs with fewer digits"));
        }
        let whole = || costs.iter().map(|&cost| (cost * ten).round() as u64);
        let divisor = whole().fold(0, gcd).max(1);
        Ok(Self { ten, divisor, largest: whole().max().unwrap_or(0) / divisor })
    }

    fn units(&self, cost: f64) -> u64 {
        (cost * self.ten).round() as u64 / self.divisor
    }

    fn cost(&self, units: u64) -> f64 {
        (u128::from(units) * u128::from(self.divisor)) as f64 / self.ten
    }
}

/// Whether `cost` is a whole number of `1 / ten`, as read from decimals.
fn fits(cost: f64, ten: f64) -> bool {
    (cost * ten).round() / ten == cost
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Converts costs to keys: `key = primary units * radix + secondary units`. The radix exceeds the secondary
/// units of any plan without a repeated state, so keys order plans like costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Units {
    primary: Scale,
    secondary: Scale,
    /// Keys divided by it are primary units.
    pub radix: u64,
    /// Bound on the key of any plan without a repeated state.
    pub largest_sum: u64,
}

impl Units {
    /// The units of `costs` for plans of at most `steps` steps.
    pub fn new(costs: &[Cost], steps: u64) -> Result<Self, Invalid> {
        let primary = Scale::of("primary", &costs.iter().map(|cost| cost.primary).collect::<Vec<_>>())?;
        let secondary = Scale::of("secondary", &costs.iter().map(|cost| cost.secondary).collect::<Vec<_>>())?;
        let steps_of_cost = primary.largest.max(secondary.largest);
        let steps = u128::from(steps.max(1));
        let radix = steps * u128::from(secondary.largest) + 1;
        let sum =
            u128::from(primary.largest).checked_mul(radix).and_then(|key| (key + radix).checked_mul(steps));
        match sum.filter(|&sum| sum < LARGEST_SUM) {
            Some(sum) => Ok(Self { primary, secondary, radix: radix as u64, largest_sum: sum as u64 }),
            None => Err(Invalid::new(
                "costs",
                format!("{steps_of_cost} different steps of cost at their common unit"),
                "sums below 2^61 in units of the costs' common divisor",
                "round the costs, for instance to 0.1, or leave out the secondary cost",
            )),
        }
    }

    /// The key of a move's cost.
    pub fn key(&self, cost: Cost) -> u64 {
        self.primary.units(cost.primary) * self.radix + self.secondary.units(cost.secondary)
    }

    /// The cost of a sum of keys.
    pub fn cost(&self, key: u64) -> Cost {
        let (primary, secondary) = (key / self.radix, key % self.radix);
        Cost { primary: self.primary.cost(primary), secondary: self.secondary.cost(secondary) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(values: &[f64]) -> Vec<Cost> {
        values.iter().map(|&value| Cost::primary(value)).collect()
    }

    #[test]
    fn seconds_get_the_greatest_common_unit() {
        let units = Units::new(&seconds(&[12.5, 31.5, 0.0]), 100).unwrap();
        assert_eq!(units.key(Cost::primary(12.5)), 25);
        assert_eq!(units.key(Cost::primary(31.5)), 63);
        assert_eq!(units.cost(88), Cost::primary(44.0));
    }

    #[test]
    fn costs_without_decimals_end_at_a_billionth() {
        let units = Units::new(&seconds(&[1.0 / 3.0]), 10).unwrap();
        assert!((units.cost(units.key(Cost::primary(1.0 / 3.0))).primary - 1.0 / 3.0).abs() < 1e-9);
    }

    #[test]
    fn a_key_orders_primary_before_secondary() {
        let costs = [Cost { primary: 1.0, secondary: 0.0 }, Cost { primary: 0.0, secondary: 7.5 }];
        let units = Units::new(&costs, 1000).unwrap();
        assert!(units.key(costs[0]) > 1000 * units.key(costs[1]));
        assert_eq!(units.cost(2 * units.key(costs[0]) + 3 * units.key(costs[1])).secondary, 22.5);
    }

    #[test]
    fn sums_beyond_64_bits_are_refused() {
        let costs =
            [(1.0 / 3.0, 1.0 / 7.0), (1.0, 1.0)].map(|(primary, secondary)| Cost { primary, secondary });
        assert!(Units::new(&costs, 1_000_000).unwrap_err().to_string().contains("round the costs"));
    }
}
