//! Finds a plan in a moment, without proof: keeps the most promising states for every number of uses left.

use std::cmp::Reverse;
use std::collections::hash_map::Entry;
use std::collections::{BinaryHeap, HashMap};

use super::watch::RadixHeap;
use crate::lattice::Limit;
use crate::lattice::graph::Graph;
use crate::lattice::watch::{MoveSequence, Verdict, Watch, filled};

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
pub(crate) fn glimpse(graph: &Graph, room: u64, lower: u64, by: Limit) -> Verdict {
    let fits = Bound::entries(graph) * ENTRY_BYTES <= u128::from(room.saturating_sub(graph.arc_bytes(true)));
    let plan = (fits && Bound::entries(graph) <= MOST_ENTRIES).then(|| {
        let mut keep_going = |_| true;
        let mut watch = Watch::new(graph.problem, u64::MAX, &mut keep_going);
        graph.lay_out(true, &mut watch)?;
        let bound = Bound::new(graph, &mut watch)?;
        search(graph, &bound, room.saturating_sub(graph.arc_bytes(true) + bound.bytes()))
    });
    Verdict::stopped(plan.flatten(), lower, by)
}

/// Follows at most [`WIDTH`] states for every number of uses left (as many as needed once none is left), as far as memory allows.
fn search(graph: &Graph, bound: &Bound, memory: u64) -> Option<(u64, MoveSequence)> {
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

// A lower bound that keeps only the pose and the total number of uses left, whatever the actions.
//
// With D(p, R) the least key of a walk from p to a goal with exactly R informative moves, no plan goes on from p with R uses left
// for less. D is consistent: it obeys Bellman's inequality along every arc.

/// No walk.
const NEVER: u64 = u64::MAX;

/// D by uses left and node.
pub(crate) struct Bound {
    nodes: usize,
    values: Vec<u64>,
}

impl Bound {
    /// Number of values.
    pub fn entries(graph: &Graph) -> u128 {
        let uses: u128 = graph.problem.required().iter().map(|&count| u128::from(count)).sum();
        (uses + 1) * graph.len() as u128
    }

    /// `None` if cancelled.
    pub fn new(graph: &Graph, watch: &mut Watch) -> Option<Self> {
        let nodes = graph.len();
        let layers = graph.problem.required().iter().sum::<u32>() as usize + 1;
        let mut bound = Self { nodes, values: filled(layers * nodes, NEVER, watch)? };
        graph.goals.iter().for_each(|&goal| bound.values[goal as usize] = 0);
        let mut queue = RadixHeap::new();
        for layer in 0..layers {
            bound.begin(graph, layer, watch)?;
            bound.spread(graph, layer, &mut queue, watch)?;
        }
        Some(bound)
    }

    /// Values of a layer from those with one use less. `None` if cancelled.
    fn begin(&mut self, graph: &Graph, layer: usize, watch: &mut Watch) -> Option<()> {
        for node in 0..self.nodes {
            watch.keep_going(1).then_some(())?;
            let used = graph.arcs(node as u32).iter().filter_map(|arc| {
                let (key, Some(_)) = graph.price(arc.step) else { return None };
                Some(self.key(arc.node, layer.checked_sub(1)? as u32)? + key)
            });
            if let Some(least) = used.min() {
                self.values[layer * self.nodes + node] = least;
            }
        }
        Some(())
    }

    /// Basic moves within a layer, by Dijkstra's method from all its nodes. `None` if cancelled.
    fn spread(
        &mut self,
        graph: &Graph,
        layer: usize,
        queue: &mut RadixHeap<u64, u32>,
        watch: &mut Watch,
    ) -> Option<()> {
        let values = &mut self.values[layer * self.nodes..(layer + 1) * self.nodes];
        queue.clear();
        values
            .iter()
            .zip(0..)
            .filter(|(key, _)| **key != NEVER)
            .for_each(|(key, node)| queue.push(*key, node));
        while let Some((key, node)) = queue.pop() {
            watch.keep_going(1).then_some(())?;
            if values[node as usize] != key {
                continue;
            }
            for back in graph.back(node) {
                let (step, None) = graph.price(graph.arc(back.arc).step) else { continue };
                let known = &mut values[back.from as usize];
                if key + step < *known {
                    *known = key + step;
                    queue.push(key + step, back.from);
                }
            }
        }
        Some(())
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        self.values.len() as u64 * 8
    }

    /// A lower bound on the key of any walk from the node to a goal with `uses` left; `None` if there is none.
    pub fn key(&self, node: u32, uses: u32) -> Option<u64> {
        let value = self.values[uses as usize * self.nodes + node as usize];
        (value != NEVER).then_some(value)
    }
}

/// A state: node, uses left; least key so far, and the state and the move by which it came.
#[derive(Clone, Copy)]
pub(crate) struct Seen {
    pub node: u32,
    pub left: Left,
    pub key: u64,
    pub by: Option<(u32, u32)>,
    pub closed: bool,
}

#[derive(Default)]
struct Nodes {
    all: Vec<Seen>,
    known: HashMap<(u32, u128), u32>,
}

impl Nodes {
    /// Bytes held, with spare capacity of the table.
    pub fn bytes(&self) -> u64 {
        (self.all.capacity() * size_of::<Seen>() + self.known.capacity() * 2 * size_of::<(u32, u128, u32)>())
            as u64
    }

    pub fn at(&self, index: u32) -> &Seen {
        &self.all[index as usize]
    }

    pub fn close(&mut self, index: u32) {
        self.all[index as usize].closed = true;
    }

    /// Notes a way to a state. Returns its index if the state is new, or open and now reached with a smaller key.
    pub fn reach(&mut self, node: u32, left: Left, key: u64, by: Option<(u32, u32)>) -> Option<u32> {
        match self.known.entry((node, left.packed)) {
            Entry::Vacant(entry) => {
                let index = *entry.insert(self.all.len() as u32);
                self.all.push(Seen { node, left, key, by, closed: false });
                Some(index)
            }
            Entry::Occupied(entry) => {
                let seen = &mut self.all[*entry.get() as usize];
                if seen.closed || seen.key <= key {
                    return None;
                }
                (seen.key, seen.by) = (key, by);
                Some(*entry.get())
            }
        }
    }

    /// The moves that lead to a state.
    pub fn walk(&self, mut index: u32) -> MoveSequence {
        let mut walk = MoveSequence::new();
        while let Some((parent, step)) = self.at(index).by {
            walk.push(step);
            index = parent;
        }
        walk.reverse();
        walk
    }
}

/// All moves from a state: the arc's move, its end, the uses left there and the key.
fn ways_on<'a>(
    graph: &'a Graph,
    packing: &'a Packing,
    from: Seen,
) -> impl Iterator<Item = (u32, u32, Left, u64)> + 'a {
    graph.arcs(from.node).iter().filter_map(move |arc| {
        let (key, slot) = graph.price(arc.step);
        let left = match slot {
            Some(slot) => packing.after(from.left, slot as usize)?,
            None => from.left,
        };
        Some((arc.step, arc.node, left, from.key + key))
    })
}

/// The position of each slot's count in the number.
#[derive(Clone, Debug)]
pub(crate) struct Packing {
    fields: Vec<(u32, u128)>,
    full: u128,
    total: u32,
}

/// Uses left of every slot, and their sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Left {
    pub packed: u128,
    pub total: u32,
}

impl Packing {
    pub fn new(required: &[u32]) -> Self {
        let (mut fields, mut full, mut shift) = (Vec::new(), 0, 0);
        for &count in required {
            let bits = u32::BITS - count.leading_zeros();
            fields.push((shift, (1u128 << bits) - 1));
            full |= u128::from(count) << shift;
            shift += bits;
        }
        Self { fields, full, total: required.iter().sum() }
    }

    /// All uses are left.
    pub fn all(&self) -> Left {
        Left { packed: self.full, total: self.total }
    }

    fn of(&self, left: Left, slot: usize) -> u32 {
        let (shift, mask) = self.fields[slot];
        (left.packed >> shift & mask) as u32
    }

    /// The uses left after one use of the slot, if it has any.
    pub fn after(&self, left: Left, slot: usize) -> Option<Left> {
        let one = 1 << self.fields[slot].0;
        (self.of(left, slot) > 0).then(|| Left { packed: left.packed - one, total: left.total - 1 })
    }
}
