//! Exhaustive search where every basic move is free or costs one and the same step and informative moves are
//! free: all count vectors of a node at once, as bits, one level of cost after the other.
//!
//! Informative moves lead to higher blocks or stay in a block, so at every level one pass over the blocks in order is
//! enough. The level of a state is kept as a binary number across *planes* of bits; with it a plan is recovered.
//!
//! Where that holds of the primary costs alone, levels are these. Only the states on ways to the goal that are optimal in them are then
//! searched for the least whole cost.

mod cheapest;

use super::dense;
use super::layout::{self, Bits, Fans};
use crate::lattice::Limit;
use crate::lattice::graph::Graph;
use crate::lattice::layout::Layout;
use crate::lattice::watch::{self, Verdict, Watch};

/// Planes to budget for: enough for 63 levels.
const USUAL_PLANES: u128 = 6;
/// To budget for: one state in so many is on a way that is optimal in levels.
const USUALLY_OPTIMAL: u128 = 8;

/// How keys become levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Levels {
    /// What keys are divided by: 1, or the radix of primary costs.
    pub unit: u64,
    /// The divided key of a basic move that is not free.
    pub step: u64,
}

impl Levels {
    /// Of whole keys, else of primary costs; `None` if the search applies to neither.
    pub fn of(graph: &Graph) -> Option<Self> {
        Self::by(graph, 1).or_else(|| Self::by(graph, graph.problem.units.radix))
    }

    fn by(graph: &Graph, unit: u64) -> Option<Self> {
        let mut step = None;
        for known in &graph.problem.moves {
            let key = known.key / unit;
            let fits = match known.slot {
                Some(_) => key == 0,
                None => key == 0 || *step.get_or_insert(key) == key,
            };
            if !fits {
                return None;
            }
        }
        Some(Self { unit, step: step.unwrap_or(1) })
    }

    /// Whether states of a level may differ in their whole keys.
    pub fn are_partial(self) -> bool {
        self.unit > 1
    }

    /// The least key of a level.
    fn key(self, level: u64) -> u64 {
        level * self.step * self.unit
    }
}

/// Bytes that the search usually needs.
pub(crate) fn bytes(graph: &Graph, levels: Levels) -> u128 {
    let layout = Layout::new(&graph.problem.required());
    if !levels.are_partial() {
        return bits_bytes(graph, &layout, 2 + USUAL_PLANES);
    }
    // Optimal states as bits, by groups, and how many there are before each; and a key for each.
    let keys = graph.states().saturating_mul(8) / USUALLY_OPTIMAL;
    bits_bytes(graph, &layout, 3 + USUAL_PLANES) + keys + u128::from(graph.arc_bytes(false))
}

/// Bytes of [`front`].
pub(crate) fn front_bytes(graph: &Graph) -> u128 {
    bits_bytes(graph, &Layout::new(&graph.problem.required()), 2)
}

/// Bytes of so many bits for each state, and of what the search holds besides.
fn bits_bytes(graph: &Graph, layout: &Layout, planes: u128) -> u128 {
    let plane = layout.blocks.saturating_mul((graph.len() * layout.words * 8) as u128);
    plane.saturating_mul(planes) + u128::from(other_bytes(graph, layout.words))
}

/// Bytes besides the states of all blocks: arcs, the states of one block, queues.
fn other_bytes(graph: &Graph, words: usize) -> u64 {
    (graph.arc_count() * 8 + graph.len() * (20 + 16 * words)) as u64
}

/// The cheapest plan with a key of at most `most`. Stops with limit `Memory` and a lower bound if levels, or the states that are
/// optimal in them, do not fit.
pub(crate) fn search(graph: &Graph, levels: Levels, most: u64, memory: u64, watch: &mut Watch) -> Verdict {
    let layout = Layout::new(&graph.problem.required());
    let verdict = match layout.words {
        1 => Layered::<1>::new(graph, layout, levels, memory, watch).map(|new| new.search(most, watch)),
        2 => Layered::<2>::new(graph, layout, levels, memory, watch).map(|new| new.search(most, watch)),
        3 => Layered::<3>::new(graph, layout, levels, memory, watch).map(|new| new.search(most, watch)),
        4 => Layered::<4>::new(graph, layout, levels, memory, watch).map(|new| new.search(most, watch)),
        _ => Layered::<8>::new(graph, layout, levels, memory, watch).map(|new| new.search(most, watch)),
    };
    verdict.unwrap_or_else(|| Verdict::stopped(None, watch.lower, Limit::Time))
}

/// The least level of every count vector at any goal, as its key and by mixed-radix number, of keys up to `most`; `None` if cancelled.
pub(crate) fn front(graph: &Graph, levels: Levels, most: u64, watch: &mut Watch) -> Option<Vec<Option<u64>>> {
    let layout = Layout::new(&graph.problem.required());
    match layout.words {
        1 => Layered::<1>::new(graph, layout, levels, 0, watch)?.front(most, watch),
        2 => Layered::<2>::new(graph, layout, levels, 0, watch)?.front(most, watch),
        3 => Layered::<3>::new(graph, layout, levels, 0, watch)?.front(most, watch),
        4 => Layered::<4>::new(graph, layout, levels, 0, watch)?.front(most, watch),
        _ => Layered::<8>::new(graph, layout, levels, 0, watch)?.front(most, watch),
    }
}

struct Layered<'a, const W: usize> {
    graph: &'a Graph<'a>,
    layout: Layout,
    fans: Fans<W>,
    levels: Levels,
    /// Bytes that it may hold.
    memory: u64,
    nodes: usize,
    blocks: usize,
    /// By `block * nodes + node`: states reached, those of them that are still to be followed, and the levels.
    reached: Vec<Bits<W>>,
    fresh: Vec<Bits<W>>,
    planes: Vec<Vec<Bits<W>>>,
    /// Nodes with fresh states, as bits, `words` per block.
    dirty: Vec<u64>,
    dirty_words: usize,
    /// In the present block and level, by node: all new states, and those not yet followed within the block.
    now: Vec<Bits<W>>,
    pending: Vec<Bits<W>>,
    /// Nodes with pending states, in order; nodes with new states.
    queue: Vec<u32>,
    touched: Vec<u32>,
    /// Planes that fit in the memory; `None` once a level did not fit.
    planes_left: Option<u64>,
}

/// The state of a block after a level.
enum Level {
    Goal(u32),
    Done,
    Stopped,
}

impl<'a, const W: usize> Layered<'a, W> {
    /// `None` if cancelled.
    fn new(
        graph: &'a Graph<'a>,
        layout: Layout,
        levels: Levels,
        memory: u64,
        watch: &mut Watch,
    ) -> Option<Self> {
        let (nodes, blocks) = (graph.len(), layout.blocks as usize);
        let plane = (nodes * blocks * W * 8) as u64;
        let dirty_words = nodes.div_ceil(64);
        let for_planes = memory.saturating_sub(other_bytes(graph, W));
        let planes_left = Some((for_planes / plane.max(1)).saturating_sub(2));
        Some(Self {
            fans: Fans::new(graph, &layout, levels.unit, watch)?,
            graph,
            layout,
            levels,
            memory,
            nodes,
            blocks,
            reached: vec![[0; W]; nodes * blocks],
            fresh: vec![[0; W]; nodes * blocks],
            planes: Vec::new(),
            dirty: vec![0; dirty_words * blocks],
            dirty_words,
            now: vec![[0; W]; nodes],
            pending: vec![[0; W]; nodes],
            queue: Vec::new(),
            touched: Vec::new(),
            planes_left,
        })
    }

    fn search(mut self, most: u64, watch: &mut Watch) -> Verdict {
        let goal_bit = self.layout.place(&self.graph.problem.required()).1;
        self.begin();
        let mut level = 0;
        while self.is_open() && self.levels.key(level) <= most {
            watch.raise(self.levels.key(level));
            match self.level(level, Some(goal_bit), watch, &mut |_, _| ()) {
                Level::Goal(_) if self.levels.are_partial() => {
                    return self.least(level, goal_bit, most, watch);
                }
                Level::Goal(node) => return self.solved(node, self.levels.key(level)),
                Level::Stopped => return Verdict::stopped(None, watch.lower, Limit::Time),
                Level::Done => level += 1,
            }
        }
        Verdict { possible: self.possible(), ..Verdict::proved(None) }
    }

    fn front(mut self, most: u64, watch: &mut Watch) -> Option<Vec<Option<u64>>> {
        let (strides, vectors) = watch::strides(&self.graph.problem.required());
        let mut least = vec![None; vectors as usize];
        let (layout, levels) = (self.layout.clone(), self.levels);
        self.planes_left = None;
        self.begin();
        let mut level = 0;
        while self.is_open() && levels.key(level) <= most {
            let mut note = |block: usize, bits: &Bits<W>| {
                for bit in layout::ones(bits) {
                    let number = watch::number(&layout.counts(block, bit), &strides);
                    least[number as usize].get_or_insert(levels.key(level));
                }
            };
            match self.level(level, None, watch, &mut note) {
                Level::Stopped => return None,
                _ => level += 1,
            }
        }
        Some(least)
    }

    fn begin(&mut self) {
        let start = self.graph.start as usize;
        self.reached[start][0] = 1;
        self.fresh[start][0] = 1;
        self.dirty[start / 64] |= 1 << (start % 64);
    }

    fn is_open(&self) -> bool {
        self.dirty.iter().any(|&word| word != 0)
    }

    /// Follows all fresh states; those of the next level are fresh afterwards.
    fn level(
        &mut self,
        level: u64,
        goal_bit: Option<usize>,
        watch: &mut Watch,
        at_goal: &mut dyn FnMut(usize, &Bits<W>),
    ) -> Level {
        for block in 0..self.blocks {
            self.open(block);
            if self.queue.is_empty() {
                continue;
            }
            self.close_under_free_moves(block);
            self.note_level(block, level);
            for &node in self.touched.iter().filter(|&&node| self.graph.is_goal[node as usize]) {
                let new = &self.now[node as usize];
                if block + 1 == self.blocks && goal_bit.is_some_and(|bit| layout::has(new, bit)) {
                    return Level::Goal(node);
                }
                at_goal(block, new);
            }
            if !watch.keep_going(self.touched.len() as u64) {
                return Level::Stopped;
            }
            self.leave(block);
        }
        Level::Done
    }

    /// Queues the fresh states of a block.
    fn open(&mut self, block: usize) {
        let base = block * self.nodes;
        for word in 0..self.dirty_words {
            let mut nodes = std::mem::take(&mut self.dirty[block * self.dirty_words + word]);
            while nodes != 0 {
                let node = word * 64 + nodes.trailing_zeros() as usize;
                nodes &= nodes - 1;
                let fresh = std::mem::replace(&mut self.fresh[base + node], [0; W]);
                self.now[node] = fresh;
                self.pending[node] = fresh;
                self.queue.push(node as u32);
            }
        }
        self.touched.extend_from_slice(&self.queue);
    }

    /// Follows free moves that stay in the block, first come first served.
    fn close_under_free_moves(&mut self, block: usize) {
        let reached = &mut self.reached[block * self.nodes..(block + 1) * self.nodes];
        let (now, pending) = (&mut self.now[..], &mut self.pending[..]);
        let mut next = 0;
        while let Some(&node) = self.queue.get(next) {
            next += 1;
            let here = std::mem::replace(&mut pending[node as usize], [0; W]);
            for &(end, shift) in self.fans.within.of(node as usize) {
                let moved = self.fans.shifts[shift as usize].apply(&here);
                let known = &mut reached[end as usize];
                let new = layout::beyond(&moved, known);
                if !layout::any(&new) {
                    continue;
                }
                layout::or(known, &new);
                let (now, pending) = (&mut now[end as usize], &mut pending[end as usize]);
                if !layout::any(pending) {
                    self.queue.push(end);
                    if !layout::any(now) {
                        self.touched.push(end);
                    }
                }
                layout::or(pending, &new);
                layout::or(now, &new);
            }
        }
        self.queue.clear();
    }

    /// Writes the level of all new states into the planes.
    fn note_level(&mut self, block: usize, level: u64) {
        let Some(left) = self.planes_left else { return };
        let needed = (u64::BITS - level.leading_zeros()) as usize;
        if needed > self.planes.len() {
            if left == 0 {
                self.planes_left = None;
                self.planes.clear();
                return;
            }
            self.planes_left = Some(left - 1);
            self.planes.push(vec![[0; W]; self.nodes * self.blocks]);
        }
        let base = block * self.nodes;
        for plane in (0..needed).filter(|plane| level >> plane & 1 == 1) {
            let plane = &mut self.planes[plane][base..base + self.nodes];
            for &node in &self.touched {
                layout::or(&mut plane[node as usize], &self.now[node as usize]);
            }
        }
    }

    /// Follows informative moves to higher blocks at this level, and basic moves to the next level.
    fn leave(&mut self, block: usize) {
        let mut states = States {
            nodes: self.nodes,
            reached: &mut self.reached,
            fresh: &mut self.fresh,
            dirty: &mut self.dirty,
        };
        for &node in &self.touched {
            let new = std::mem::replace(&mut self.now[node as usize], [0; W]);
            for &(end, hop) in self.fans.higher.of(node as usize) {
                if let Some(higher) = self.fans.hops[hop as usize].from(block) {
                    states.arrive(higher, end, &new);
                }
            }
            for &end in self.fans.onward.of(node as usize) {
                states.arrive(block, end, &new);
            }
        }
        self.touched.clear();
    }
}

/// The states of all blocks while a block is left.
struct States<'a, const W: usize> {
    pub nodes: usize,
    pub reached: &'a mut [Bits<W>],
    pub fresh: &'a mut [Bits<W>],
    pub dirty: &'a mut [u64],
}

impl<const W: usize> States<'_, W> {
    pub fn arrive(&mut self, block: usize, end: u32, states: &Bits<W>) {
        let at = block * self.nodes + end as usize;
        let new = layout::beyond(states, &self.reached[at]);
        if layout::any(&new) {
            layout::or(&mut self.reached[at], &new);
            layout::or(&mut self.fresh[at], &new);
            self.dirty[block * self.nodes.div_ceil(64) + end as usize / 64] |= 1 << (end % 64);
        }
    }
}

impl<const W: usize> Layered<'_, W> {
    fn solved(&self, node: u32, key: u64) -> Verdict {
        if self.planes_left.is_none() {
            return Verdict::stopped(None, key, Limit::Memory);
        }
        let distance = |node: u32, counts: &[u32]| self.distance(node, counts);
        match dense::walk(self.graph, node, self.graph.problem.required(), &distance) {
            Some(walk) => Verdict::proved(Some((key, walk))),
            None => unreachable!("every reached state has a walk from the start"),
        }
    }

    /// Distance of a state that was reached and followed.
    fn distance(&self, node: u32, counts: &[u32]) -> Option<u64> {
        let (block, bit) = self.layout.place(counts);
        let at = block * self.nodes + node as usize;
        if !layout::has(&self.reached[at], bit) || layout::has(&self.fresh[at], bit) {
            return None;
        }
        let level = |(plane, bits): (usize, &Vec<Bits<W>>)| u64::from(layout::has(&bits[at], bit)) << plane;
        Some(self.levels.step * self.planes.iter().enumerate().map(level).sum::<u64>())
    }

    fn possible(&self) -> Option<Vec<u32>> {
        let at_goal = |block: usize| {
            let mut all = [0; W];
            for &goal in &self.graph.goals {
                layout::or(&mut all, &self.reached[block * self.nodes + goal as usize]);
            }
            all
        };
        let vectors =
            (0..self.blocks).flat_map(|block| layout::ones(&at_goal(block)).map(move |bit| (block, bit)));
        let counts = vectors.map(|(block, bit)| self.layout.counts(block, bit));
        counts.max_by_key(|counts| counts.iter().sum::<u32>())
    }
}
