use crate::lattice::graph::{Graph, Reach, within};
use crate::lattice::layered::Levels;
use crate::lattice::watch::{self, Watch};
use crate::lattice::{Options, Problem, Progress, Solution, dense, layered};

/// The least cost of a count vector.
#[derive(Clone, Debug, PartialEq)]
pub struct FrontPoint {
    /// Uses of every informative action, in the order of the problem's actions.
    pub counts: Vec<u32>,
    /// Least primary cost of a walk to a goal with exactly these uses; `None` if there is none.
    pub primary: Option<f64>,
}

/// Least primary cost of reaching the goal with exactly g uses, for every count vector g up to the required one, from
/// one exhaustive search: information against cost. One point per count vector, the first informative
/// action's count fastest; `None` if the search is cancelled or does not fit in the memory.
///
/// Where a `plan` of the problem is known, costs above its own may be missing: those counts are fewer and cost more than the plan. The
/// search then takes as long as the plan's surroundings are large, not the lattice.
pub fn front(
    problem: &Problem,
    plan: Option<&Solution>,
    options: &Options,
    keep_going: &mut dyn FnMut(Progress) -> bool,
) -> Option<Vec<FrontPoint>> {
    let required = problem.required();
    let vectors = watch::strides(&required).1;
    let own_bytes = vectors.saturating_mul((24 + size_of::<FrontPoint>() + 4 * required.len()) as u128);
    if own_bytes > u128::from(options.memory_bytes) {
        return None;
    }
    let mut watch = Watch::new(problem, options.poll_every, keep_going);
    let most = plan.map_or(u64::MAX, |plan| problem.whole_key(plan));
    let live = match plan {
        None => Reach::new(problem, &mut watch)?.live(),
        Some(_) => {
            let memory = u128::from(options.memory_bytes) - own_bytes;
            within(problem, most, memory as u64, &mut watch).ok()?
        }
    };
    let Some(graph) = Graph::new(problem, &live, &mut watch) else {
        return watch.keep_going(0).then(|| points(problem, &vec![None; vectors as usize]));
    };
    drop(live);
    let levels = Levels::of(&graph);
    let bytes = match levels {
        Some(_) => layered::front_bytes(&graph),
        // Distances are kept in 64 bits here.
        None => crate::lattice::plan::exhaustive_bytes(&graph).saturating_mul(2),
    };
    if bytes.saturating_add(own_bytes) + u128::from(graph.bytes()) > u128::from(options.memory_bytes) {
        return None;
    }
    let memory = options.memory_bytes.saturating_sub(graph.bytes());
    let keys = match levels {
        Some(levels) => layered::front(&graph, levels, most, &mut watch),
        None => dense::front(&graph, most, memory, &mut watch),
    };
    keys.map(|keys| points(problem, &keys))
}

fn points(problem: &Problem, keys: &[Option<u64>]) -> Vec<FrontPoint> {
    let required = problem.required();
    let point = |(number, key): (usize, &Option<u64>)| {
        let counts = watch::counts(number as u64, &required);
        let primary = key.map(|key| problem.cost(key, &counts).primary);
        FrontPoint { counts, primary }
    };
    keys.iter().enumerate().map(point).collect()
}
