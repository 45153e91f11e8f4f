//! Bound, beam, better prices, wider beam, bounds per action, A*: each step only if a gap remains.

use crate::graph::Graph;
use crate::relaxation::{Bound, Prices, Table};
use crate::watch::{Verdict, Walk, Watch};
use crate::{Limit, a_star, ascent, beam};

/// Widths of the beam with prices.
const WIDTHS: [usize; 2] = [64, 512];
/// Width of the beam before there are prices, and with bounds per action.
const FIRST_WIDTH: usize = 64;
const LAST_WIDTH: usize = 2048;
/// Most entries of a bound that is still computed after the time limit.
const GLIMPSED: u128 = 500_000;
/// Most entries of all bounds per action.
const MOST_ENTRIES: u128 = 400_000_000;

/// The last step to take.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Depth {
    /// Bounds and beams.
    Root,
    /// A* as well.
    Proof,
}

/// The cheapest plan, or the best one found within the limits.
pub(crate) fn search(graph: &Graph, memory: u64, depth: Depth, watch: &mut Watch) -> Verdict {
    // Bounds and beams are temporary, and the allocator keeps their memory for a while.
    let mut search = Search { graph, memory: memory / 3 * 2, plan: None };
    match search.run(depth, watch) {
        Some(verdict) => verdict,
        None => Verdict::stopped(search.plan, watch.lower, Limit::Time),
    }
}

/// Whether [`glimpse`] takes at most a tenth of a second.
pub(crate) fn is_glimpsed_at_once(graph: &Graph) -> bool {
    Table::entries(graph, None) <= GLIMPSED
}

/// A plan from one bound without prices and a narrow beam.
pub(crate) fn glimpse(graph: &Graph, memory: u64, watch: &mut Watch) -> Option<(u64, Walk)> {
    graph.lay_out(true, watch)?;
    let prices = Prices::zero(graph);
    let table = Table::new(graph, &prices, None, false, watch)?;
    let memory = memory.saturating_sub(table.bytes());
    beam::search(graph, &Bound::new(graph, prices, table), (FIRST_WIDTH, memory), None, watch)
}

/// Bytes of all its tables.
fn bytes(bound: &Bound) -> u64 {
    bound.tables.iter().map(Table::bytes).sum()
}

struct Search<'a> {
    graph: &'a Graph<'a>,
    /// The remaining memory.
    memory: u64,
    plan: Option<(u64, Walk)>,
}

impl Search<'_> {
    /// `None` if cancelled.
    fn run(&mut self, depth: Depth, watch: &mut Watch) -> Option<Verdict> {
        self.memory = self.memory.saturating_sub(self.graph.arc_bytes(true));
        if Table::entries(self.graph, None) * 12 > u128::from(self.memory) {
            return Some(Verdict::stopped(None, watch.lower, Limit::Memory));
        }
        self.plan = glimpse(self.graph, self.memory, watch);
        self.note(watch);
        let mut bound = match ascent::ascend(self.graph, self.upper(), watch) {
            ascent::Ascent::Infeasible => return Some(Verdict::proved(None)),
            ascent::Ascent::Optimal(key, walk) => return Some(Verdict::proved(Some((key, walk)))),
            ascent::Ascent::Stopped => return None,
            ascent::Ascent::Bound(bound) => bound,
        };
        self.memory = self.memory.saturating_sub(bytes(&bound));
        for width in WIDTHS {
            self.widen(&bound, width, watch)?;
        }
        if !self.is_proved(watch) {
            let known = bytes(&bound);
            self.bounds_per_action(&mut bound, watch)?;
            self.memory = self.memory.saturating_sub(bytes(&bound) - known);
            if bound.key(self.graph.start, bound.packing.all()).is_none() {
                return Some(Verdict::proved(None));
            }
            self.widen(&bound, LAST_WIDTH, watch)?;
        }
        if self.is_proved(watch) {
            return Some(Verdict::proved(self.plan.take()));
        }
        if depth == Depth::Root {
            return None;
        }
        Some(a_star::search(self.graph, &bound, self.plan.take(), self.memory, watch))
    }

    fn upper(&self) -> Option<u64> {
        self.plan.as_ref().map(|plan| plan.0)
    }

    fn is_proved(&self, watch: &Watch) -> bool {
        self.upper().is_some_and(|upper| upper <= watch.lower)
    }

    fn note(&self, watch: &mut Watch) {
        if let Some(key) = self.upper() {
            watch.found(key);
        }
    }

    /// Improves the plan with a wider beam. `None` if cancelled.
    fn widen(&mut self, bound: &Bound, width: usize, watch: &mut Watch) -> Option<()> {
        if !self.is_proved(watch) {
            let found = beam::search(self.graph, bound, (width, self.memory), self.upper(), watch);
            self.plan = found.or(self.plan.take());
            self.note(watch);
        }
        watch.keep_going(0).then_some(())
    }

    /// A table per action that tracks its own count, as far as memory allows.
    fn bounds_per_action(&self, bound: &mut Bound, watch: &mut Watch) -> Option<()> {
        let slots = self.graph.problem.informative.len();
        if slots < 2 {
            return Some(());
        }
        let entries: u128 = (0..slots).map(|slot| Table::entries(self.graph, Some(slot))).sum();
        if entries > MOST_ENTRIES || entries * 8 > u128::from(self.memory) / 2 {
            return Some(());
        }
        for slot in 0..slots {
            let table = Table::new(self.graph, &bound.prices, Some(slot), false, watch)?;
            bound.tables.push(table);
        }
        if let Some(key) = bound.key(self.graph.start, bound.packing.all()) {
            watch.raise(key);
        }
        Some(())
    }
}
