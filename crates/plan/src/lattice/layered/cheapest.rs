//! The least whole keys where levels are primary costs alone: first all states on ways to goals that are optimal in levels, backwards
//! and as bits; then one distance for each of them.

use super::Layered;
use crate::lattice::graph::Graph;
use crate::lattice::layout::{self, Bits, Digit, Layout, Shift};
use crate::lattice::watch::{RadixHeap, Verdict, Watch};
use crate::lattice::{Limit, dense};

/// The least keys of optimal states. Those of a *group* have the same counts, which are a block and a bit.
struct Keys<'a> {
    graph: &'a Graph<'a>,
    layout: Layout,
    /// Words of a group: a bit for each node.
    words: usize,
    /// By `(block * bits + bit) * words + word`: the nodes, and the number of states before.
    nodes: Vec<u64>,
    before: Vec<u32>,
    /// By number of the state within its block; `u64::MAX` before it is reached.
    keys: Vec<Vec<u64>>,
    /// Basic moves below this key stay in their level; whether there are any.
    unit: u64,
    has_free: bool,
}

impl<'a, const W: usize> Layered<'a, W> {
    /// The cheapest plan among those with fewest levels, where the last one was just reached.
    pub(super) fn least(self, level: u64, goal_bit: usize, most: u64, watch: &mut Watch) -> Verdict {
        let (graph, lower) = (self.graph, self.levels.key(level));
        let required = graph.problem.required();
        let keys = match self.cheapest(level, goal_bit, watch) {
            Ok(keys) => keys,
            Err(limit) => return Verdict::stopped(None, lower, limit),
        };
        let Some((key, node)) = keys.at_goal(&required).filter(|(key, _)| *key <= most) else {
            return Verdict::proved(None);
        };
        match dense::walk(graph, node, required, &|node, counts| keys.of(node, counts)) {
            Some(walk) => Verdict::proved(Some((key, walk))),
            None => unreachable!("every reached state has a walk from the start"),
        }
    }

    /// The least keys of all states on ways to the goals of the last block that are optimal in levels.
    fn cheapest(mut self, last: u64, goal_bit: usize, watch: &mut Watch) -> Result<Keys<'a>, Limit> {
        if self.planes_left.is_none() {
            return Err(Limit::Memory);
        }
        let goals = self.graph.goals.iter().filter(|node| layout::has(&self.now[**node as usize], goal_bit));
        let goals: Vec<u32> = goals.copied().collect();
        // What was not followed has no level.
        for (reached, fresh) in self.reached.iter_mut().zip(&self.fresh) {
            *reached = layout::beyond(reached, fresh);
        }
        self.fresh.fill([0; W]);
        self.reached = Backwards::new(&mut self).all((last, goal_bit), &goals, watch).ok_or(Limit::Time)?;
        self.fresh = Vec::new();
        let states: usize = self.reached.iter().map(layout::count).sum();
        // The states as they are, by groups, and the number before each.
        let held = (3 + self.planes.len()) * size_of_val(&self.reached[..]) + 8 * states;
        if held as u64 + self.graph.arc_bytes(false) > self.memory {
            return Err(Limit::Memory);
        }
        self.graph.lay_out(false, watch).ok_or(Limit::Time)?;
        let mut keys = Keys::new(&self);
        keys.run(&self, last, watch).ok_or(Limit::Time)?;
        Ok(keys)
    }

    /// The states of a level.
    fn at_level(&self, level: u64, at: usize) -> Bits<W> {
        self.planes.iter().enumerate().fold(self.reached[at], |states, (number, plane)| {
            if level >> number & 1 == 1 {
                layout::both(&states, &plane[at])
            } else {
                layout::beyond(&states, &plane[at])
            }
        })
    }
}

/// The way back from goals, level after level, and in each from the highest block.
struct Backwards<'l, 'a, const W: usize> {
    searched: &'l mut Layered<'a, W>,
    shifts: Vec<Shift<W>>,
    /// By `block * nodes + node`, the states that are optimal in levels. Those still to be followed are `fresh`.
    optimal: Vec<Bits<W>>,
    /// By block, the nodes to be followed at this level, and at the one below.
    here: Vec<Vec<u32>>,
    below: Vec<Vec<u32>>,
}

impl<'l, 'a, const W: usize> Backwards<'l, 'a, W> {
    fn new(searched: &'l mut Layered<'a, W>) -> Self {
        let layout = &searched.layout;
        let shift = |digit: &Digit| match *digit {
            Digit::Bit { stride, radix } => Shift::new(layout.mask(stride, radix), stride),
            Digit::Block { .. } => Shift::new([0; W], 0),
        };
        let shifts = layout.digits.iter().map(shift).collect();
        let (optimal, blocks) = (vec![[0; W]; searched.reached.len()], searched.blocks);
        let [here, below] = [(); 2].map(|()| vec![Vec::new(); blocks]);
        Self { searched, shifts, optimal, here, below }
    }

    /// The states on ways to `goals` of the last block and a bit, which are reached at level `last`. `None` if cancelled.
    fn all(mut self, (last, bit): (u64, usize), goals: &[u32], watch: &mut Watch) -> Option<Vec<Bits<W>>> {
        let (mut goal, block) = ([0; W], self.searched.blocks - 1);
        goal[bit / 64] = 1 << (bit % 64);
        for &node in goals {
            if self.arrive(last, block, node, &goal) {
                self.below[block].push(node);
            }
        }
        for level in (0..=last).rev() {
            std::mem::swap(&mut self.here, &mut self.below);
            for block in (0..self.searched.blocks).rev() {
                while let Some(node) = self.here[block].pop() {
                    watch.keep_going(1).then_some(())?;
                    self.follow(level, block, node);
                }
            }
        }
        Some(self.optimal)
    }

    /// To the states before those of a node, a block and a level.
    fn follow(&mut self, level: u64, block: usize, node: u32) {
        let at = block * self.searched.nodes + node as usize;
        let counts = layout::both(&self.searched.fresh[at], &self.searched.at_level(level, at));
        self.searched.fresh[at] = layout::beyond(&self.searched.fresh[at], &counts);
        if !layout::any(&counts) {
            return;
        }
        let (graph, unit) = (self.searched.graph, self.searched.levels.unit);
        for (from, step) in graph.ways_into(node) {
            let (key, slot) = graph.price(step);
            let Some(slot) = slot.map(|slot| slot as usize) else {
                let free = key < unit;
                if (free || level > 0) && self.arrive(level - u64::from(!free), block, from, &counts) {
                    let lists = if free { &mut self.here } else { &mut self.below };
                    lists[block].push(from);
                }
                continue;
            };
            let (block, states) = match self.searched.layout.digits[slot] {
                Digit::Bit { .. } => (block, self.shifts[slot].undo(&counts)),
                Digit::Block { stride, radix } if !(block as u64 / stride).is_multiple_of(radix) => {
                    (block - stride as usize, counts)
                }
                Digit::Block { .. } => continue,
            };
            if self.arrive(level, block, from, &states) {
                self.here[block].push(from);
            }
        }
    }

    /// Notes those of `states` that have this level; whether any of them is new.
    fn arrive(&mut self, level: u64, block: usize, node: u32, states: &Bits<W>) -> bool {
        let at = block * self.searched.nodes + node as usize;
        let new = layout::beyond(states, &self.optimal[at]);
        if !layout::any(&new) {
            return false;
        }
        let new = layout::both(&new, &self.searched.at_level(level, at));
        layout::or(&mut self.optimal[at], &new);
        layout::or(&mut self.searched.fresh[at], &new);
        layout::any(&new)
    }
}

impl<'a> Keys<'a> {
    /// Of the states that `optimal` has reached.
    fn new<const W: usize>(optimal: &Layered<'a, W>) -> Self {
        let (graph, bits) = (optimal.graph, 64 * W);
        let words = optimal.nodes.div_ceil(64);
        let mut nodes = vec![0_u64; optimal.blocks * bits * words];
        for (at, reached) in optimal.reached.iter().enumerate() {
            let (block, node) = (at / optimal.nodes, at % optimal.nodes);
            for bit in layout::ones(reached) {
                nodes[(block * bits + bit) * words + node / 64] |= 1 << (node % 64);
            }
        }
        let (mut before, mut keys) = (Vec::with_capacity(nodes.len()), Vec::with_capacity(optimal.blocks));
        for block in nodes.chunks(bits * words) {
            let mut count = 0;
            for word in block {
                before.push(count);
                count += word.count_ones();
            }
            keys.push(vec![u64::MAX; count as usize]);
        }
        let mut moves = 0..graph.problem.moves.len() as u32;
        let unit = optimal.levels.unit;
        let has_free = moves.any(|step| matches!(graph.price(step), (key, None) if key < unit));
        Self { graph, layout: optimal.layout.clone(), words, nodes, before, keys, unit, has_free }
    }

    /// Visits the states level after level, and in each from the lowest block and bit. `None` if cancelled.
    fn run<const W: usize>(&mut self, optimal: &Layered<'a, W>, last: u64, watch: &mut Watch) -> Option<()> {
        let Some(start) = self.number(self.group(0, 0), self.graph.start) else { return Some(()) };
        self.keys[0][start] = 0;
        let mut groups: Vec<Vec<u32>> = vec![Vec::new(); 64 * W];
        let mut queue = RadixHeap::new();
        for level in 0..=last {
            for block in 0..optimal.blocks {
                for node in 0..optimal.nodes {
                    for bit in layout::ones(&optimal.at_level(level, block * optimal.nodes + node)) {
                        groups[bit].push(node as u32);
                    }
                }
                for (bit, nodes) in groups.iter_mut().enumerate().filter(|(_, nodes)| !nodes.is_empty()) {
                    watch.keep_going(nodes.len() as u64).then_some(())?;
                    self.leave((block, bit), nodes, &mut queue);
                    nodes.clear();
                }
            }
        }
        Some(())
    }

    /// Follows the moves from some nodes of a group, whose keys are known but for free moves between them.
    fn leave(&mut self, (block, bit): (usize, usize), nodes: &[u32], queue: &mut RadixHeap<u64, u32>) {
        let group = self.group(block, bit);
        let slots = 0..self.layout.digits.len() as u32;
        let after: Vec<_> = slots.map(|slot| after(&self.layout, slot, block, bit)).collect();
        if !self.has_free {
            nodes.iter().for_each(|&node| self.follow((block, group), node, &after, None));
            return;
        }
        queue.clear();
        for &node in nodes {
            if let Some(key) = self.key(block, group, node) {
                queue.push(key, node);
            }
        }
        while let Some((key, node)) = queue.pop() {
            if self.key(block, group, node) == Some(key) {
                self.follow((block, group), node, &after, Some(queue));
            }
        }
    }

    /// Follows the moves from a state; `after` has the counts after a use of each slot.
    fn follow(
        &mut self,
        (block, group): (usize, usize),
        node: u32,
        after: &[Option<(usize, usize)>],
        mut queue: Option<&mut RadixHeap<u64, u32>>,
    ) {
        let Some(key) = self.key(block, group, node) else { return };
        let graph = self.graph;
        for arc in graph.arcs(node) {
            let (step, slot) = graph.price(arc.step);
            let end = match slot {
                None => Some((block, group)),
                Some(slot) => after[slot as usize].map(|(block, bit)| (block, self.group(block, bit))),
            };
            let Some((end_block, end_group)) = end else { continue };
            let Some(number) = self.number(end_group, arc.node) else { continue };
            let known = &mut self.keys[end_block][number];
            if key + step < *known {
                *known = key + step;
                match queue.as_deref_mut() {
                    Some(queue) if slot.is_none() && step < self.unit => queue.push(key + step, arc.node),
                    _ => {}
                }
            }
        }
    }

    fn group(&self, block: usize, bit: usize) -> usize {
        block * 64 * self.layout.words + bit
    }

    /// The number of an optimal state within its block.
    fn number(&self, group: usize, node: u32) -> Option<usize> {
        let word = group * self.words + node as usize / 64;
        let (nodes, bit) = (self.nodes[word], 1 << (node % 64));
        (nodes & bit != 0).then(|| (self.before[word] + (nodes & (bit - 1)).count_ones()) as usize)
    }

    fn key(&self, block: usize, group: usize, node: u32) -> Option<u64> {
        self.number(group, node).map(|number| self.keys[block][number]).filter(|key| *key < u64::MAX)
    }

    /// Of a node with counts.
    fn of(&self, node: u32, counts: &[u32]) -> Option<u64> {
        let (block, bit) = self.layout.place(counts);
        self.key(block, self.group(block, bit), node)
    }

    /// The least key with `counts` at a goal, and the first such goal.
    fn at_goal(&self, counts: &[u32]) -> Option<(u64, u32)> {
        self.graph.goals.iter().filter_map(|&node| Some((self.of(node, counts)?, node))).min()
    }
}

/// Block and bit after a use of a slot, if the count allows it.
fn after(layout: &Layout, slot: u32, block: usize, bit: usize) -> Option<(usize, usize)> {
    match layout.digits[slot as usize] {
        Digit::Bit { stride, radix } => {
            (bit as u32 / stride % radix + 1 < radix).then(|| (block, bit + stride as usize))
        }
        Digit::Block { stride, radix } => {
            (block as u64 / stride % radix + 1 < radix).then(|| (block + stride as usize, bit))
        }
    }
}
