//! Lower bounds by Lagrangian relaxation of the counts: only the pose and the total number of uses left are
//! kept (and the uses left of one *tracked* action); every use of another action earns its price λ.
//!
//! With r_q uses left of action q, R = Σ r_q, D(p, R) the least cost of a walk from p to a goal with exactly R
//! informative moves, every use of q earning λ_q: the walk of any plan from (p, r) costs at least
//! `h(p, r) = Σ λ_q r_q + D(p, R)`. h is consistent: D obeys Bellman's inequality along every arc. So are the largest of
//! several such bounds and, costs being whole numbers, the bound rounded up.

use crate::graph::Graph;
use crate::radix_heap::RadixHeap;
use crate::uses::{Left, Packing};
use crate::watch::{Watch, filled};

/// No walk.
const NEVER: i64 = i64::MAX;
/// No arc.
pub(crate) const NO_ARC: u32 = u32::MAX;
/// Sums of keys times the scale stay below this.
const LARGEST_SCALED: i64 = 1 << 60;

/// Prices λ by slot, in `1 / scale` of a key.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Prices {
    pub scale: i64,
    pub values: Vec<i64>,
}

impl Prices {
    pub fn zero(graph: &Graph) -> Self {
        let largest = graph.problem.units.largest_sum.max(1) as i64;
        let scale = (0..=10).rev().map(|bits| 1 << bits).find(|scale| largest <= LARGEST_SCALED / scale);
        Self { scale: scale.unwrap_or(1), values: vec![0; graph.problem.informative.len()] }
    }

    /// Prices nearest to `values` that cannot overflow.
    pub fn set(&mut self, values: &[f64], uses: u32) {
        let limit = (LARGEST_SCALED / (i64::from(uses) + 1)) as f64;
        self.values = values.iter().map(|value| value.clamp(-limit, limit).round() as i64).collect();
    }

    /// A scaled bound as a key: rounded up, since keys are whole.
    pub fn key(&self, scaled: i64) -> u64 {
        (scaled.max(0) as u64).div_ceil(self.scale as u64)
    }
}

/// D by uses left: of the tracked slot, of the others together, and node.
pub(crate) struct Table {
    tracked: Option<usize>,
    /// Layers of the others' uses.
    rest: usize,
    nodes: usize,
    values: Vec<i64>,
    /// The first arc of a cheapest walk, if requested.
    next: Vec<u32>,
}

impl Table {
    /// Entries of a table.
    pub fn entries(graph: &Graph, tracked: Option<usize>) -> u128 {
        let required = graph.problem.required();
        let own = tracked.map_or(0, |slot| u128::from(required[slot]));
        let all: u128 = required.iter().map(|&count| u128::from(count)).sum();
        (own + 1) * (all - own + 1) * graph.len() as u128
    }

    /// `None` if cancelled.
    pub fn new(
        graph: &Graph,
        prices: &Prices,
        tracked: Option<usize>,
        with_next: bool,
        watch: &mut Watch,
    ) -> Option<Self> {
        let required = graph.problem.required();
        let own = tracked.map_or(0, |slot| required[slot] as usize);
        let rest = required.iter().sum::<u32>() as usize - own + 1;
        let entries = (own + 1) * rest * graph.len();
        let next = if with_next { filled(entries, NO_ARC, watch)? } else { Vec::new() };
        let values = filled(entries, NEVER, watch)?;
        let mut table = Self { tracked, rest, nodes: graph.len(), values, next };
        let mut queue = RadixHeap::new();
        for layer in 0..(own + 1) * rest {
            table.begin(graph, prices, layer, watch)?;
            table.spread(graph, prices, layer, &mut queue, watch)?;
        }
        Some(table)
    }

    /// Values of a layer from those with one use less. `None` if cancelled.
    fn begin(&mut self, graph: &Graph, prices: &Prices, layer: usize, watch: &mut Watch) -> Option<()> {
        let base = layer * self.nodes;
        if layer == 0 {
            graph.goals.iter().for_each(|&goal| self.values[goal as usize] = 0);
        }
        for node in 0..self.nodes as u32 {
            watch.keep_going(1).then_some(())?;
            for index in graph.range(node) {
                let arc = graph.arc(index);
                let (key, Some(slot)) = graph.price(arc.step) else { continue };
                let Some((before, price)) = self.one_use_less(layer, slot as usize, prices) else { continue };
                let after = self.values[before * self.nodes + arc.node as usize];
                let value = after.saturating_add(key as i64 * prices.scale - price);
                if after != NEVER && value < self.values[base + node as usize] {
                    self.set(base + node as usize, value, index);
                }
            }
        }
        Some(())
    }

    /// The layer after a use of the slot, and the earnings of the use.
    fn one_use_less(&self, layer: usize, slot: usize, prices: &Prices) -> Option<(usize, i64)> {
        if self.tracked == Some(slot) {
            return Some((layer.checked_sub(self.rest)?, 0));
        }
        (!layer.is_multiple_of(self.rest)).then(|| (layer - 1, prices.values[slot]))
    }

    /// Basic moves within a layer, by Dijkstra's method from all its nodes. `None` if cancelled.
    fn spread(
        &mut self,
        graph: &Graph,
        prices: &Prices,
        layer: usize,
        queue: &mut RadixHeap<u64, u32>,
        watch: &mut Watch,
    ) -> Option<()> {
        let base = layer * self.nodes;
        let Some(&least) = self.values[base..base + self.nodes].iter().min().filter(|&&least| least != NEVER)
        else {
            return Some(());
        };
        queue.clear();
        for node in 0..self.nodes {
            if self.values[base + node] != NEVER {
                queue.push((self.values[base + node] - least) as u64, node as u32);
            }
        }
        while let Some((key, node)) = queue.pop() {
            watch.keep_going(1).then_some(())?;
            if self.values[base + node as usize] - least != key as i64 {
                continue;
            }
            for back in graph.back(node) {
                let (step, None) = graph.price(graph.arc(back.arc).step) else { continue };
                let value = key + step * prices.scale as u64;
                let known = base + back.from as usize;
                if self.values[known] == NEVER || value < (self.values[known] - least) as u64 {
                    self.set(known, least + value as i64, back.arc);
                    queue.push(value, back.from);
                }
            }
        }
        Some(())
    }

    fn set(&mut self, at: usize, value: i64, arc: u32) {
        self.values[at] = value;
        if let Some(next) = self.next.get_mut(at) {
            *next = arc;
        }
    }

    /// Uses by slot along the cheapest walk from the start with `total` uses, and its moves. Without a tracked slot.
    pub fn walk(&self, graph: &Graph, total: u32) -> (Vec<u32>, Vec<u32>) {
        let (mut node, mut layer) = (graph.start, total as usize);
        let (mut uses, mut steps) = (vec![0; graph.problem.informative.len()], Vec::new());
        while let Some(&index) =
            self.next.get(layer * self.nodes + node as usize).filter(|&&arc| arc != NO_ARC)
        {
            let arc = graph.arc(index);
            if let (_, Some(slot)) = graph.price(arc.step) {
                uses[slot as usize] += 1;
                layer -= 1;
            }
            steps.push(arc.step);
            node = arc.node;
        }
        (uses, steps)
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        (self.values.len() * 8 + self.next.len() * 4) as u64
    }

    /// D of a node; `None` if no walk exists.
    fn value(&self, node: u32, own: u32, others: u32) -> Option<i64> {
        let value = self.values[(own as usize * self.rest + others as usize) * self.nodes + node as usize];
        (value != NEVER).then_some(value)
    }
}

/// The largest of several bounds with the same prices.
pub(crate) struct Bound {
    pub prices: Prices,
    pub packing: Packing,
    pub tables: Vec<Table>,
}

impl Bound {
    pub fn new(graph: &Graph, prices: Prices, table: Table) -> Self {
        Self { prices, packing: Packing::new(&graph.problem.required()), tables: vec![table] }
    }

    /// A lower bound on the key of any walk from the node to a goal with exactly the uses left; `None` if
    /// there is none.
    pub fn key(&self, node: u32, left: Left) -> Option<u64> {
        let priced = |slot| self.prices.values[slot] * i64::from(self.packing.of(left, slot));
        let all: i64 = (0..self.packing.slots()).map(priced).sum();
        let mut best = 0;
        for table in &self.tables {
            let own = table.tracked.map_or(0, |slot| self.packing.of(left, slot));
            let earned = all - table.tracked.map_or(0, priced);
            best = best.max(earned + table.value(node, own, left.total - own)?);
        }
        Some(self.prices.key(best))
    }
}
