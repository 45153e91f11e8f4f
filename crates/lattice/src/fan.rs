//! The arcs of a graph, sorted by what they do to bits and blocks.

use crate::bits::Shift;
use crate::by_node::ByNode;
use crate::graph::Graph;
use crate::layout::{Digit, Layout};

/// Arcs by node: where they end, and an index.
pub(crate) type Fan = ByNode<(u32, u32)>;

/// One use of a slot kept in the block's number.
#[derive(Clone, Copy)]
pub(crate) struct Hop {
    stride: u64,
    radix: u64,
}

impl Hop {
    /// The block after one use more, if the count allows it.
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
    /// Arcs to the next level.
    pub onward: Fan,
}

#[derive(Clone, Copy, PartialEq)]
enum Class {
    Within(u32),
    Higher(u32),
    Onward,
}

impl<const W: usize> Fans<W> {
    pub fn new(graph: &Graph, layout: &Layout) -> Self {
        // The first shift is that of a free basic move: none.
        let mut shifts = vec![Shift { mask: [u64::MAX; W], words: 0, bits: 0 }];
        let mut hops = Vec::new();
        let mut by_slot = Vec::new();
        for digit in &layout.digits {
            match *digit {
                Digit::Bit { stride, radix } => {
                    by_slot.push(Class::Within(shifts.len() as u32));
                    let mask = layout.mask(stride, radix);
                    shifts.push(Shift { mask, words: stride as usize / 64, bits: stride % 64 });
                }
                Digit::Block { stride, radix } => {
                    by_slot.push(Class::Higher(hops.len() as u32));
                    hops.push(Hop { stride, radix });
                }
            }
        }
        let class = |step: u32| match graph.price(step) {
            (_, Some(slot)) => by_slot[slot as usize],
            (0, None) => Class::Within(0),
            (_, None) => Class::Onward,
        };
        let pick = |wanted: fn(Class) -> Option<u32>| fan(graph, |step| wanted(class(step)));
        Self {
            within: pick(|class| if let Class::Within(index) = class { Some(index) } else { None }),
            shifts,
            higher: pick(|class| if let Class::Higher(index) = class { Some(index) } else { None }),
            hops,
            onward: pick(|class| (class == Class::Onward).then_some(0)),
        }
    }
}

fn fan(graph: &Graph, wanted: impl Fn(u32) -> Option<u32>) -> Fan {
    let mut fan = Fan::new();
    for node in 0..graph.len() as u32 {
        fan.push(graph.arcs(node).iter().filter_map(|arc| Some((arc.node, wanted(arc.step)?))));
    }
    fan
}
