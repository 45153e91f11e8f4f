//! Visited states, with the best known way to each.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use crate::lattice::graph::Graph;
use crate::lattice::uses::{Left, Packing};
use crate::lattice::watch::Walk;

/// A state: node, uses left; least key so far, and the state and the move by which it came.
#[derive(Clone, Copy)]
pub(crate) struct Seen {
    pub node: u32,
    pub left: Left,
    pub key: u64,
    pub by: Option<(u32, u32)>,
    pub closed: bool,
}

#[derive(Default)]
pub(crate) struct Nodes {
    all: Vec<Seen>,
    known: HashMap<(u32, u128), u32>,
}

impl Nodes {
    /// Bytes held, with spare capacity of the table.
    pub fn bytes(&self) -> u64 {
        (self.all.capacity() * size_of::<Seen>() + self.known.capacity() * 2 * size_of::<(u32, u128, u32)>())
            as u64
    }

    pub fn at(&self, index: u32) -> &Seen {
        &self.all[index as usize]
    }

    pub fn close(&mut self, index: u32) {
        self.all[index as usize].closed = true;
    }

    /// Notes a way to a state. Returns its index if the state is new, or open and now reached with a smaller key.
    pub fn reach(&mut self, node: u32, left: Left, key: u64, by: Option<(u32, u32)>) -> Option<u32> {
        match self.known.entry((node, left.packed)) {
            Entry::Vacant(entry) => {
                let index = *entry.insert(self.all.len() as u32);
                self.all.push(Seen { node, left, key, by, closed: false });
                Some(index)
            }
            Entry::Occupied(entry) => {
                let seen = &mut self.all[*entry.get() as usize];
                if seen.closed || seen.key <= key {
                    return None;
                }
                (seen.key, seen.by) = (key, by);
                Some(*entry.get())
            }
        }
    }

    /// The moves that lead to a state.
    pub fn walk(&self, mut index: u32) -> Walk {
        let mut walk = Walk::new();
        while let Some((parent, step)) = self.at(index).by {
            walk.push(step);
            index = parent;
        }
        walk.reverse();
        walk
    }
}

/// All moves from a state: the arc's move, its end, the uses left there and the key.
pub(crate) fn ways_on<'a>(
    graph: &'a Graph,
    packing: &'a Packing,
    from: Seen,
) -> impl Iterator<Item = (u32, u32, Left, u64)> + 'a {
    graph.arcs(from.node).iter().filter_map(move |arc| {
        let (key, slot) = graph.price(arc.step);
        let left = match slot {
            Some(slot) => packing.after(from.left, slot as usize)?,
            None => from.left,
        };
        Some((arc.step, arc.node, left, from.key + key))
    })
}
