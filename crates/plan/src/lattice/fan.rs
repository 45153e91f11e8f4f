//! The arcs of a graph, sorted by their effect on bits and blocks.

use crate::lattice::bits::Shift;
use crate::lattice::by_node::ByNode;
use crate::lattice::graph::Graph;
use crate::lattice::layout::{Digit, Layout};
use crate::lattice::watch::Watch;

/// Arcs by node: where they end, and an index.
pub(crate) type Fan = ByNode<(u32, u32)>;

/// One use of a slot that is kept in the block's number.
#[derive(Clone, Copy)]
pub(crate) struct Hop {
    stride: u64,
    radix: u64,
}

impl Hop {
    /// The block after one more use, if the count allows it.
    pub fn from(&self, block: usize) -> Option<usize> {
        let block = block as u64;
        (block / self.stride % self.radix + 1 < self.radix).then_some((block + self.stride) as usize)
    }
}

pub(crate) struct Fans<const W: usize> {
    /// Free arcs within a block, with an index of `shifts`.
    pub within: Fan,
    pub shifts: Vec<Shift<W>>,
    /// Free arcs to a higher block, with an index of `hops`.
    pub higher: Fan,
    pub hops: Vec<Hop>,
    /// Ends of arcs to the next level.
    pub onward: ByNode<u32>,
}

#[derive(Clone, Copy, PartialEq)]
enum Class {
    Within(u32),
    Higher(u32),
    Onward,
}

impl Class {
    fn within(self) -> Option<u32> {
        if let Self::Within(index) = self { Some(index) } else { None }
    }

    fn higher(self) -> Option<u32> {
        if let Self::Higher(index) = self { Some(index) } else { None }
    }
}

impl<const W: usize> Fans<W> {
    /// Moves with keys below `unit` count as free. `None` if cancelled.
    pub fn new(graph: &Graph, layout: &Layout, unit: u64, watch: &mut Watch) -> Option<Self> {
        // The first shift belongs to free basic moves: none.
        let mut shifts = vec![Shift::new([u64::MAX; W], 0)];
        let mut hops = Vec::new();
        let mut by_slot = Vec::new();
        for digit in &layout.digits {
            match *digit {
                Digit::Bit { stride, radix } => {
                    by_slot.push(Class::Within(shifts.len() as u32));
                    shifts.push(Shift::new(layout.mask(stride, radix), stride));
                }
                Digit::Block { stride, radix } => {
                    by_slot.push(Class::Higher(hops.len() as u32));
                    hops.push(Hop { stride, radix });
                }
            }
        }
        let class = |step: u32| match graph.price(step) {
            (_, Some(slot)) => by_slot[slot as usize],
            (key, None) if key < unit => Class::Within(0),
            (_, None) => Class::Onward,
        };
        let classes: Vec<Class> = (0..graph.problem.moves.len() as u32).map(class).collect();
        let mut within = fan(graph, &classes, |class| class.within().is_some());
        let mut higher = fan(graph, &classes, |class| class.higher().is_some());
        let mut onward = fan(graph, &classes, |class| class == Class::Onward);
        let mut arcs = Vec::new();
        for node in 0..graph.len() as u32 {
            if !watch.keep_going(1) {
                return None;
            }
            arcs.clear();
            arcs.extend(graph.ways(node).map(|arc| (arc.node, classes[arc.step as usize])));
            let arcs = || arcs.iter().copied();
            within.push(arcs().filter_map(|(end, class)| class.within().map(|index| (end, index))));
            higher.push(arcs().filter_map(|(end, class)| class.higher().map(|index| (end, index))));
            onward.push(arcs().filter(|(_, class)| *class == Class::Onward).map(|(end, _)| end));
        }
        Some(Self { within, shifts, higher, hops, onward })
    }
}

/// Without nodes yet, with capacity for all moves of some classes.
fn fan<T>(graph: &Graph, classes: &[Class], wanted: fn(Class) -> bool) -> ByNode<T> {
    let entries = graph.problem.arc_count(|step| wanted(classes[step]));
    ByNode::with_capacity(graph.len(), entries)
}
