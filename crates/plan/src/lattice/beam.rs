//! Finds a plan in a moment, without proof: keeps the most promising states for every number of uses left.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::lattice::Limit;
use crate::lattice::bound::Bound;
use crate::lattice::graph::Graph;
use crate::lattice::nodes::{Nodes, ways_on};
use crate::lattice::uses::Packing;
use crate::lattice::watch::{Verdict, Walk, Watch};

/// States that are followed for every number of uses left.
const WIDTH: usize = 64;
/// Most entries of the bound: it then takes at most a tenth of a second.
const MOST_ENTRIES: u128 = 500_000;
/// Bytes for each of them, with what else is held.
const ENTRY_BYTES: u128 = 18;

/// By bound of the plan, then larger key first, then state.
type Queue = BinaryHeap<Reverse<(u64, Reverse<u64>, u32)>>;

/// Bytes of a state in a queue, with spare capacity.
const QUEUED_BYTES: u64 = 2 * size_of::<Reverse<(u64, Reverse<u64>, u32)>>() as u64;

/// The end of a search that stopped at a limit without a plan, with the plan of a narrow beam if that takes only a moment.
pub(crate) fn glimpse(graph: &Graph, memory: u64, lower: u64, by: Limit) -> Verdict {
    let fits =
        Bound::entries(graph) * ENTRY_BYTES <= u128::from(memory.saturating_sub(graph.arc_bytes(true)));
    let plan = (fits && Bound::entries(graph) <= MOST_ENTRIES).then(|| {
        let mut keep_going = |_| true;
        let mut watch = Watch::new(graph.problem, u64::MAX, &mut keep_going);
        graph.lay_out(true, &mut watch)?;
        let bound = Bound::new(graph, &mut watch)?;
        search(graph, &bound, memory.saturating_sub(graph.arc_bytes(true) + bound.bytes()))
    });
    Verdict::stopped(plan.flatten(), lower, by)
}

/// Follows at most [`WIDTH`] states for every number of uses left (as many as needed once none is left), as far as memory allows.
fn search(graph: &Graph, bound: &Bound, memory: u64) -> Option<(u64, Walk)> {
    let packing = Packing::new(&graph.problem.required());
    let all = packing.all();
    let mut nodes = Nodes::default();
    let mut queues: Vec<Queue> = (0..=all.total).map(|_| Queue::new()).collect();
    let first = nodes.reach(graph.start, all, 0, None)?;
    queues[all.total as usize].push(Reverse((bound.key(graph.start, all.total)?, Reverse(0), first)));
    let mut queued = 0;
    for total in (0..=all.total as usize).rev() {
        let mut followed = 0;
        while let Some(Reverse((_, _, index))) = queues[total].pop() {
            let seen = *nodes.at(index);
            if seen.closed {
                continue;
            }
            if total == 0 && graph.is_goal[seen.node as usize] {
                return Some((seen.key, nodes.walk(index)));
            }
            followed += 1;
            let is_full = nodes.bytes() + queued * QUEUED_BYTES > memory;
            if (followed > WIDTH && total > 0) || is_full {
                break;
            }
            nodes.close(index);
            for (step, node, left, key) in ways_on(graph, &packing, seen) {
                let Some(rest) = bound.key(node, left.total) else { continue };
                if let Some(index) = nodes.reach(node, left, key, Some((index, step))) {
                    queues[left.total as usize].push(Reverse((key + rest, Reverse(key), index)));
                    queued += 1;
                }
            }
        }
    }
    None
}
