//! Finds plans quickly, without proof: keeps the most promising states for every number of uses left.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::graph::Graph;
use crate::nodes::{By, Nodes, ways_on};
use crate::relaxation::Bound;
use crate::watch::{Walk, Watch};

/// By bound of the plan, then larger key first, then state.
type Queue = BinaryHeap<Reverse<(u64, Reverse<u64>, u32)>>;

/// Bytes of a state in a queue, with spare capacity.
const QUEUED_BYTES: u64 = 2 * size_of::<Reverse<(u64, Reverse<u64>, u32)>>() as u64;

/// A plan cheaper than `upper`. Follows at most `width` states for every number of uses left (as many as
/// needed once none is left), as far as memory allows. `None` if it finds none or is cancelled.
pub(crate) fn search(
    graph: &Graph,
    bound: &Bound,
    (width, memory): (usize, u64),
    upper: Option<u64>,
    watch: &mut Watch,
) -> Option<(u64, Walk)> {
    let upper = upper.unwrap_or(u64::MAX);
    let all = bound.packing.all();
    let mut nodes = Nodes::new();
    let mut queues: Vec<Queue> = (0..=all.total).map(|_| Queue::new()).collect();
    let first = nodes.reach(graph.start, all, 0, By::START)?;
    queues[all.total as usize].push(Reverse((bound.key(graph.start, all)?, Reverse(0), first)));
    let mut queued = 0;
    for total in (0..=all.total as usize).rev() {
        let mut followed = 0;
        while let Some(Reverse((least, _, index))) = queues[total].pop() {
            let seen = *nodes.at(index);
            if seen.closed || least >= upper {
                continue;
            }
            if total == 0 && graph.is_goal[seen.node as usize] {
                return Some((seen.key, nodes.walk(index)));
            }
            followed += 1;
            let is_full = nodes.bytes() + queued * QUEUED_BYTES > memory;
            if (followed > width && total > 0) || is_full || !watch.keep_going(1) {
                break;
            }
            nodes.at_mut(index).closed = true;
            for (step, node, left, key) in ways_on(graph, &bound.packing, seen) {
                let Some(rest) = bound.key(node, left).filter(|rest| key + rest < upper) else { continue };
                if let Some(index) = nodes.reach(node, left, key, By::step(index, step)) {
                    queues[left.total as usize].push(Reverse((key + rest, Reverse(key), index)));
                    queued += 1;
                }
            }
        }
    }
    None
}
