//! A lower bound that keeps only the pose and the total number of uses left, whatever the actions.
//!
//! With D(p, R) the least key of a walk from p to a goal with exactly R informative moves, no plan goes on from p with R uses left
//! for less. D is consistent: it obeys Bellman's inequality along every arc.

use crate::lattice::graph::Graph;
use crate::lattice::radix_heap::RadixHeap;
use crate::lattice::watch::{Watch, filled};

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
