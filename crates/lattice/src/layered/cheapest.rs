//! The least whole keys where levels are primary costs alone: first all states on ways to goals that are optimal in levels, backwards
//! and as bits; then one distance for each of them.

use super::{End, Layered};
use crate::Limit;
use crate::bits::{self, Bits, Shift};
use crate::graph::Graph;
use crate::layout::{Digit, Layout};
use crate::radix_heap::RadixHeap;
use crate::recover;
use crate::watch::{Verdict, Watch};

/// States between two checks of the queue's memory.
const LOOKS: u32 = 1 << 12;

/// The least keys of optimal states.
pub(super) struct Keys<'a, const W: usize> {
    graph: &'a Graph<'a>,
    layout: Layout,
    /// By `block * nodes + node`: the states, and the number of those before.
    optimal: Vec<Bits<W>>,
    before: Vec<usize>,
    /// By number of the state; `u64::MAX` before it is reached.
    keys: Vec<u64>,
}

impl<'a, const W: usize> Layered<'a, W> {
    /// The cheapest plan among those with fewest levels, where the last one was just reached.
    pub(super) fn least(self, level: u64, goal_bit: usize, most: u64, watch: &mut Watch) -> Verdict {
        let block = self.blocks - 1;
        let goals = self.graph.goals.iter().filter(|node| bits::has(&self.now[**node as usize], goal_bit));
        let mut ends: Vec<Vec<End>> = (0..=level).map(|_| Vec::new()).collect();
        ends[level as usize] = goals.map(|&node| End { block, node, bit: goal_bit }).collect();
        let (graph, lower) = (self.graph, self.levels.key(level));
        let required = graph.problem.required();
        let keys = match self.cheapest(ends, Some((block, goal_bit)), watch) {
            Ok(keys) => keys,
            Err(limit) => return Verdict::stopped(None, lower, limit),
        };
        let Some((key, node)) = keys.at_goal(&required).filter(|(key, _)| *key <= most) else {
            return Verdict::proved(None);
        };
        match recover::walk(graph, node, required, &|node, counts| keys.of(node, counts)) {
            Some(walk) => Verdict::proved(Some((key, walk))),
            None => unreachable!("every reached state has a walk from the start"),
        }
    }

    /// The least keys of all states on ways to `ends`, by level, that are optimal in levels; with a block and bit of goals, only as far
    /// as the first of them.
    pub(super) fn cheapest(
        mut self,
        ends: Vec<Vec<End>>,
        until: Option<(usize, usize)>,
        watch: &mut Watch,
    ) -> Result<Keys<'a, W>, Limit> {
        if self.planes_left.is_none() {
            return Err(Limit::Memory);
        }
        // What was not followed has no level.
        for (reached, fresh) in self.reached.iter_mut().zip(&self.fresh) {
            *reached = bits::beyond(reached, fresh);
        }
        self.fresh.fill([0; W]);
        let optimal = Backwards::new(&mut self).all(ends, watch).ok_or(Limit::Time)?;
        let Self { graph, layout, memory, reached, fresh, planes, fans, .. } = self;
        drop((reached, fresh, planes, fans));
        let mut count = 0;
        let mut before = Vec::with_capacity(optimal.len());
        for own in &optimal {
            before.push(count);
            count += bits::count(own);
        }
        let bits = size_of_val(&optimal[..]) + size_of_val(&before[..]);
        let held = graph.arc_bytes(false) + (bits + 8 * count) as u64;
        if held > memory {
            return Err(Limit::Memory);
        }
        graph.lay_out(false, watch).ok_or(Limit::Time)?;
        let mut keys = Keys { graph, layout, optimal, before, keys: vec![u64::MAX; count] };
        keys.run(until, memory - held, watch)?;
        Ok(keys)
    }

    /// The states of a level.
    fn at_level(&self, level: u64, at: usize) -> Bits<W> {
        self.planes.iter().enumerate().fold(self.reached[at], |states, (number, plane)| {
            if level >> number & 1 == 1 {
                bits::both(&states, &plane[at])
            } else {
                bits::beyond(&states, &plane[at])
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

    /// The states on ways to `ends`, by level. `None` if cancelled.
    fn all(mut self, ends: Vec<Vec<End>>, watch: &mut Watch) -> Option<Vec<Bits<W>>> {
        for (level, ends) in ends.into_iter().enumerate().rev() {
            std::mem::swap(&mut self.here, &mut self.below);
            for End { block, node, bit } in ends {
                let mut state = [0; W];
                state[bit / 64] = 1 << (bit % 64);
                if self.arrive(level as u64, block, node, &state) {
                    self.here[block].push(node);
                }
            }
            for block in (0..self.searched.blocks).rev() {
                while let Some(node) = self.here[block].pop() {
                    watch.keep_going(1).then_some(())?;
                    self.follow(level as u64, block, node);
                }
            }
        }
        Some(self.optimal)
    }

    /// To the states before those of a node, a block and a level.
    fn follow(&mut self, level: u64, block: usize, node: u32) {
        let at = block * self.searched.nodes + node as usize;
        let own = bits::both(&self.searched.fresh[at], &self.searched.at_level(level, at));
        self.searched.fresh[at] = bits::beyond(&self.searched.fresh[at], &own);
        if !bits::any(&own) {
            return;
        }
        let (graph, unit) = (self.searched.graph, self.searched.levels.unit);
        for (from, step) in graph.ways_into(node) {
            let (key, slot) = graph.price(step);
            let Some(slot) = slot.map(|slot| slot as usize) else {
                let free = key < unit;
                if (free || level > 0) && self.arrive(level - u64::from(!free), block, from, &own) {
                    let lists = if free { &mut self.here } else { &mut self.below };
                    lists[block].push(from);
                }
                continue;
            };
            let (block, states) = match self.searched.layout.digits[slot] {
                Digit::Bit { .. } => (block, self.shifts[slot].undo(&own)),
                Digit::Block { stride, radix } if !(block as u64 / stride).is_multiple_of(radix) => {
                    (block - stride as usize, own)
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
        let new = bits::beyond(states, &self.optimal[at]);
        if !bits::any(&new) {
            return false;
        }
        let new = bits::both(&new, &self.searched.at_level(level, at));
        bits::or(&mut self.optimal[at], &new);
        bits::or(&mut self.searched.fresh[at], &new);
        bits::any(&new)
    }
}

impl<const W: usize> Keys<'_, W> {
    /// Visits the states in order of their keys.
    fn run(&mut self, until: Option<(usize, usize)>, memory: u64, watch: &mut Watch) -> Result<(), Limit> {
        let nodes = self.graph.len();
        let mut queue = RadixHeap::<u64, (u32, u32)>::new();
        let start = self.graph.start as usize;
        let Some(number) = self.number(start, 0) else { return Ok(()) };
        self.keys[number] = 0;
        queue.push(0, (start as u32, 0));
        let mut popped = 0_u32;
        while let Some((key, (at, bit))) = queue.pop() {
            let (at, bit) = (at as usize, bit as usize);
            popped = popped.wrapping_add(1);
            if popped.is_multiple_of(LOOKS) && queue.bytes() > memory {
                return Err(Limit::Memory);
            }
            if self.key(at, bit) != Some(key) {
                continue;
            }
            let (block, node) = (at / nodes, at % nodes);
            if until == Some((block, bit)) && self.graph.is_goal[node] {
                return Ok(());
            }
            if !watch.keep_going(1) {
                return Err(Limit::Time);
            }
            for arc in self.graph.arcs(node as u32) {
                let (step, slot) = self.graph.price(arc.step);
                let Some((block, bit)) = after(&self.layout, slot, block, bit) else { continue };
                let at = block * nodes + arc.node as usize;
                let Some(number) = self.number(at, bit) else { continue };
                if key + step < self.keys[number] {
                    self.keys[number] = key + step;
                    queue.push(key + step, (at as u32, bit as u32));
                }
            }
        }
        Ok(())
    }

    /// The number of an optimal state.
    fn number(&self, at: usize, bit: usize) -> Option<usize> {
        let own = &self.optimal[at];
        bits::has(own, bit).then(|| self.before[at] + bits::below(own, bit))
    }

    fn key(&self, at: usize, bit: usize) -> Option<u64> {
        self.number(at, bit).map(|number| self.keys[number]).filter(|key| *key < u64::MAX)
    }

    /// Of a node with counts.
    pub(super) fn of(&self, node: u32, counts: &[u32]) -> Option<u64> {
        let (block, bit) = self.layout.place(counts);
        self.key(block * self.graph.len() + node as usize, bit)
    }

    /// The least key with `counts` at a goal, and the first such goal.
    pub(super) fn at_goal(&self, counts: &[u32]) -> Option<(u64, u32)> {
        self.graph.goals.iter().filter_map(|&node| Some((self.of(node, counts)?, node))).min()
    }
}

/// Block and bit after a move of a slot, or a basic move, if the count allows it.
fn after(layout: &Layout, slot: Option<u32>, block: usize, bit: usize) -> Option<(usize, usize)> {
    let Some(slot) = slot else { return Some((block, bit)) };
    match layout.digits[slot as usize] {
        Digit::Bit { stride, radix } => {
            (bit as u32 / stride % radix + 1 < radix).then(|| (block, bit + stride as usize))
        }
        Digit::Block { stride, radix } => {
            (block as u64 / stride % radix + 1 < radix).then(|| (block + stride as usize, bit))
        }
    }
}
