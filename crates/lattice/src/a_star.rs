//! A* with the Lagrangian bound: proves a plan optimal, or that there is none.

use crate::Limit;
use crate::graph::Graph;
use crate::nodes::{By, Nodes, Seen, ways_on};
use crate::radix_heap::RadixHeap;
use crate::relaxation::Bound;
use crate::watch::{Verdict, Walk, Watch};

/// Expands every state that a plan cheaper than `plan` could pass.
pub(crate) fn search(
    graph: &Graph,
    bound: &Bound,
    plan: Option<(u64, Walk)>,
    memory: u64,
    watch: &mut Watch,
) -> Verdict {
    let mut search = Search { graph, bound, plan, nodes: Nodes::new(), queue: RadixHeap::new() };
    search.begin();
    while let Some((least, index)) = search.queue.pop() {
        if search.nodes.at(index).closed {
            continue;
        }
        watch.raise(least.min(search.upper()));
        if watch.lower >= search.upper() {
            break;
        }
        if !watch.keep_going(1) {
            return Verdict::stopped(search.plan, watch.lower, Limit::Time);
        }
        if search.nodes.bytes() + search.queue.bytes() > memory || !search.nodes.has_capacity() {
            return Verdict::stopped(search.plan, watch.lower, Limit::Memory);
        }
        search.follow(index, watch);
    }
    Verdict::proved(search.plan)
}

struct Search<'a> {
    graph: &'a Graph<'a>,
    bound: &'a Bound,
    plan: Option<(u64, Walk)>,
    nodes: Nodes,
    queue: RadixHeap<u64, u32>,
}

impl Search<'_> {
    /// Key that a plan must undercut.
    fn upper(&self) -> u64 {
        self.plan.as_ref().map_or(u64::MAX, |plan| plan.0)
    }

    fn begin(&mut self) {
        let (start, all) = (self.graph.start, self.bound.packing.all());
        if let Some(index) = self.nodes.reach(start, all, 0, By::START) {
            self.enter(index);
        }
    }

    /// Queues a state, unless no better plan can pass it. A state that ends a plan yields one.
    fn enter(&mut self, index: u32) {
        let seen = *self.nodes.at(index);
        let Some(rest) = self.bound.key(seen.node, seen.left()) else { return };
        if seen.key + rest >= self.upper() {
            return;
        }
        self.queue.push(seen.key + rest, index);
        if self.ends_a_plan(&seen) {
            self.plan = Some((seen.key, self.nodes.walk(index)));
        }
    }

    fn ends_a_plan(&self, seen: &Seen) -> bool {
        seen.left().total == 0 && self.graph.is_goal[seen.node as usize]
    }

    fn follow(&mut self, index: u32, watch: &mut Watch) {
        let seen = *self.nodes.at(index);
        self.nodes.at_mut(index).closed = true;
        for (step, node, left, key) in ways_on(self.graph, &self.bound.packing, seen) {
            if let Some(reached) = self.nodes.reach(node, left, key, By::step(index, step)) {
                self.enter(reached);
            }
        }
        if let Some((key, _)) = &self.plan {
            watch.found(*key);
        }
    }
}
