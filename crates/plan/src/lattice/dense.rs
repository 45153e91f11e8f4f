//! Exhaustive search for any costs: one distance per node and count vector.

use std::collections::BTreeMap;

use super::watch::RadixHeap;
use crate::lattice::Limit;
use crate::lattice::graph::Graph;
use crate::lattice::watch::{self, MoveSequence, Verdict, Watch, filled};

/// States between two checks of the queue's memory.
const LOOKS: u32 = 1 << 12;

/// A distance in storage.
pub(crate) trait Stored: Copy + Default + Ord + Into<u64> {
    const UNREACHED: Self;
    /// `None` if it is too large.
    fn store(key: u64) -> Option<Self>;
}

impl Stored for u32 {
    const UNREACHED: Self = u32::MAX;
    fn store(key: u64) -> Option<Self> {
        u32::try_from(key).ok().filter(|&stored| stored < u32::MAX)
    }
}

impl Stored for u64 {
    const UNREACHED: Self = u64::MAX;
    fn store(key: u64) -> Option<Self> {
        Some(key)
    }
}

/// How a run ended.
enum Ended {
    /// Goal reached with all uses: its node and key.
    Goal(u32, u64),
    /// All states are settled.
    Exhausted,
    Stopped,
    /// A distance did not fit into its storage.
    Overflow,
    /// The queue did not fit into the memory.
    Full,
}

/// Bytes that the search usually needs: distances, and about half of a state's entries in a queue at its widest.
pub(crate) fn bytes(graph: &Graph) -> u128 {
    graph.states().saturating_mul(if narrow(graph) { 12 } else { 16 }) + u128::from(graph.arc_bytes(false))
}

/// Whether distances are likely to fit in 32 bits.
fn narrow(graph: &Graph) -> bool {
    graph.problem.moves.iter().all(|step| step.key < 1 << 20)
}

/// Whether the states can be numbered.
pub(crate) fn fits(graph: &Graph) -> bool {
    graph.states() < u128::from(u32::MAX)
}

/// The cheapest plan with a key of at most `most`.
pub(crate) fn search(graph: &Graph, most: u64, memory: u64, watch: &mut Watch) -> Verdict {
    let verdict = searched(graph, most, memory, watch);
    verdict.unwrap_or_else(|| Verdict::stopped(None, watch.lower, Limit::Time))
}

/// `None` if cancelled before it began.
fn searched(graph: &Graph, most: u64, memory: u64, watch: &mut Watch) -> Option<Verdict> {
    graph.lay_out(false, watch)?;
    if narrow(graph) {
        let mut dense = Dense::<u32>::new(graph, most, memory, watch)?;
        match dense.run(watch, false) {
            Ended::Overflow => {}
            ended => return Some(dense.verdict(&ended, watch.lower)),
        }
    }
    let mut dense = Dense::<u64>::new(graph, most, memory, watch)?;
    let ended = dense.run(watch, false);
    Some(dense.verdict(&ended, watch.lower))
}

/// The least key of every count vector at any goal, by mixed-radix number, of keys up to `most`; `None` if cancelled.
pub(crate) fn front(graph: &Graph, most: u64, memory: u64, watch: &mut Watch) -> Option<Vec<Option<u64>>> {
    graph.lay_out(false, watch)?;
    let mut dense = Dense::<u64>::new(graph, most, memory, watch)?;
    match dense.run(watch, true) {
        Ended::Exhausted => Some((0..dense.vectors as u64).map(|vector| dense.at_goal(vector)).collect()),
        _ => None,
    }
}

struct Dense<'a, D> {
    graph: &'a Graph<'a>,
    required: Vec<u32>,
    strides: Vec<u64>,
    vectors: usize,
    /// By `vector * nodes + node`.
    distances: Vec<D>,
    /// Bytes that the queue may hold.
    queued: u64,
    /// States with larger keys are not visited.
    most: u64,
}

impl<'a, D: Stored> Dense<'a, D> {
    /// `None` if cancelled.
    fn new(graph: &'a Graph, most: u64, memory: u64, watch: &mut Watch) -> Option<Self> {
        let required = graph.problem.required();
        let (strides, vectors) = watch::strides(&required);
        let vectors = vectors as usize;
        let distances = filled(vectors * graph.len(), D::UNREACHED, watch)?;
        let queued = memory.saturating_sub(graph.arc_bytes(false) + size_of_val(&distances[..]) as u64);
        Some(Self { graph, required, strides, vectors, distances, queued, most })
    }

    fn run(&mut self, watch: &mut Watch, to_the_end: bool) -> Ended {
        let nodes = self.graph.len() as u32;
        let mut queue = RadixHeap::new();
        let Some(zero) = D::store(0) else { return Ended::Overflow };
        self.distances[self.graph.start as usize] = zero;
        queue.push(zero, self.graph.start);
        let mut popped = 0_u32;
        while let Some((key, state)) = queue.pop() {
            popped = popped.wrapping_add(1);
            if popped.is_multiple_of(LOOKS) && queue.bytes() > self.queued {
                return Ended::Full;
            }
            if self.distances[state as usize] != key {
                continue;
            }
            let key = key.into();
            let (vector, node) = (state / nodes, state % nodes);
            if !to_the_end {
                watch.raise(key);
                if vector as usize == self.vectors - 1 && self.graph.is_goal[node as usize] {
                    return Ended::Goal(node, key);
                }
            }
            if !watch.keep_going(1) {
                return Ended::Stopped;
            }
            if self.relax(&mut queue, key, vector, node).is_none() {
                return Ended::Overflow;
            }
        }
        Ended::Exhausted
    }

    /// Follows all arcs of a state; `None` if a distance does not fit.
    fn relax(&mut self, queue: &mut RadixHeap<D, u32>, key: u64, vector: u32, node: u32) -> Option<()> {
        let nodes = self.graph.len() as u64;
        for arc in self.graph.arcs(node) {
            let (step, slot) = self.graph.price(arc.step);
            if key + step > self.most {
                continue;
            }
            let mut vector = u64::from(vector);
            if let Some(slot) = slot.map(|slot| slot as usize) {
                let required = u64::from(self.required[slot]);
                if vector / self.strides[slot] % (required + 1) == required {
                    continue;
                }
                vector += self.strides[slot];
            }
            let end = vector * nodes + u64::from(arc.node);
            let distance = D::store(key + step)?;
            let known = &mut self.distances[end as usize];
            // The largest distance means unreached.
            if *known > distance {
                *known = distance;
                queue.push(distance, end as u32);
            }
        }
        Some(())
    }

    fn verdict(&self, ended: &Ended, lower: u64) -> Verdict {
        match *ended {
            Ended::Goal(node, key) => match self.walk(node) {
                Some(walk) => Verdict::proved(Some((key, walk))),
                None => unreachable!("every reached state has a walk from the start"),
            },
            Ended::Exhausted => Verdict { possible: self.possible(), ..Verdict::proved(None) },
            Ended::Stopped | Ended::Overflow => Verdict::stopped(None, lower, Limit::Time),
            Ended::Full => Verdict::stopped(None, lower, Limit::Memory),
        }
    }

    fn walk(&self, node: u32) -> Option<MoveSequence> {
        let distance = |node: u32, counts: &[u32]| self.distance(watch::number(counts, &self.strides), node);
        self::walk(self.graph, node, self.required.clone(), &distance)
    }

    fn distance(&self, vector: u64, node: u32) -> Option<u64> {
        let stored = self.distances[vector as usize * self.graph.len() + node as usize];
        (stored != D::UNREACHED).then(|| stored.into())
    }

    fn at_goal(&self, vector: u64) -> Option<u64> {
        self.graph.goals.iter().filter_map(|&node| self.distance(vector, node)).min()
    }

    fn possible(&self) -> Option<Vec<u32>> {
        let reached = (0..self.vectors as u64).filter(|&vector| self.at_goal(vector).is_some());
        let counts = reached.map(|vector| watch::counts(vector, &self.required));
        counts.max_by_key(|counts| counts.iter().sum::<u32>())
    }
}

/// Distance of a node with counts from the start, by slot; `None` if it was not reached.
pub(crate) type Distance<'a> = dyn Fn(u32, &[u32]) -> Option<u64> + 'a;

/// The walk to `node` with `counts`, which are reached according to the distances.
pub(crate) fn walk(
    graph: &Graph,
    mut node: u32,
    mut counts: Vec<u32>,
    distance: &Distance,
) -> Option<MoveSequence> {
    let mut walk = MoveSequence::new();
    loop {
        let here = distance(node, &counts)?;
        let (along, before) = entry(graph, node, &mut counts, here, distance)?;
        walk.extend(along);
        let Some((from, step)) = before else { break };
        walk.push(step);
        node = from;
    }
    walk.reverse();
    Some(walk)
}

/// Free basic moves, last first, and the move before these with its start; none where they begin at the start.
type Entry = (MoveSequence, Option<(u32, u32)>);

/// How a walk enters a node.
///
/// Searches backwards over free basic moves for a move from a smaller distance or smaller counts. The counts become
/// those before that move.
fn entry(graph: &Graph, node: u32, counts: &mut [u32], here: u64, distance: &Distance) -> Option<Entry> {
    let mut after: BTreeMap<u32, Option<(u32, u32)>> = BTreeMap::from([(node, None)]);
    let mut queue = vec![node];
    while let Some(at) = queue.pop() {
        if at == graph.start && here == 0 && counts.iter().all(|&count| count == 0) {
            return Some((along(&after, at), None));
        }
        for (from, step) in graph.ways_into(at) {
            let (key, slot) = graph.price(step);
            let Some(before) = here.checked_sub(key) else { continue };
            match slot.map(|slot| slot as usize) {
                Some(slot) if counts[slot] > 0 => {
                    counts[slot] -= 1;
                    if distance(from, counts) == Some(before) {
                        return Some((along(&after, at), Some((from, step))));
                    }
                    counts[slot] += 1;
                }
                None if distance(from, counts) != Some(before) => {}
                None if key > 0 => return Some((along(&after, at), Some((from, step)))),
                None => {
                    after.entry(from).or_insert_with(|| {
                        queue.push(from);
                        Some((at, step))
                    });
                }
                Some(_) => {}
            }
        }
    }
    None
}

/// The free moves from `at` to where the search began, last first.
fn along(after: &BTreeMap<u32, Option<(u32, u32)>>, mut at: u32) -> MoveSequence {
    let mut moves = MoveSequence::new();
    while let Some(&Some((next, step))) = after.get(&at) {
        moves.push(step);
        at = next;
    }
    moves.reverse();
    moves
}
