//! Visited states, with the best known way to each, found by hashing.

use crate::graph::Graph;
use crate::uses::Left;
use crate::watch::Walk;

const CHUNK_BITS: u32 = 14;
const EMPTY: u32 = u32::MAX;
/// Parent of the first state.
const NO_PARENT: u32 = u32::MAX;

/// A state: node, uses left; least key so far and the arc by which it came.
#[derive(Clone, Copy)]
pub(crate) struct Seen {
    packed: [u64; 2],
    pub key: u64,
    total: u32,
    pub node: u32,
    parent: u32,
    step: u32,
    pub closed: bool,
}

impl Seen {
    pub fn left(&self) -> Left {
        let packed = u128::from(self.packed[0]) | u128::from(self.packed[1]) << 64;
        Left { packed, total: self.total }
    }
}

/// How a state is reached: from which state, by which move.
#[derive(Clone, Copy)]
pub(crate) struct By {
    parent: u32,
    step: u32,
}

impl By {
    pub const START: Self = Self { parent: NO_PARENT, step: 0 };

    pub fn step(parent: u32, step: u32) -> Self {
        Self { parent, step }
    }
}

pub(crate) struct Nodes {
    chunks: Vec<Vec<Seen>>,
    len: u32,
    slots: Vec<u32>,
}

impl Nodes {
    pub fn new() -> Self {
        Self { chunks: Vec::new(), len: 0, slots: vec![EMPTY; 1 << 10] }
    }

    /// Bytes held, with spare capacity of the table.
    pub fn bytes(&self) -> u64 {
        ((self.chunks.len() * size_of::<Seen>()) << CHUNK_BITS) as u64 + self.slots.len() as u64 * 12
    }

    /// Whether another state can be numbered.
    pub fn has_capacity(&self) -> bool {
        self.len < u32::MAX - (1 << CHUNK_BITS)
    }

    pub fn at(&self, index: u32) -> &Seen {
        &self.chunks[(index >> CHUNK_BITS) as usize][(index & ((1 << CHUNK_BITS) - 1)) as usize]
    }

    pub fn at_mut(&mut self, index: u32) -> &mut Seen {
        &mut self.chunks[(index >> CHUNK_BITS) as usize][(index & ((1 << CHUNK_BITS) - 1)) as usize]
    }

    /// Notes a way to a state. Returns its index if the state is new, or open and now reached with a smaller
    /// key.
    pub fn reach(&mut self, node: u32, left: Left, key: u64, by: By) -> Option<u32> {
        let packed = [left.packed as u64, (left.packed >> 64) as u64];
        let mask = self.slots.len() - 1;
        let mut slot = hash(node, packed) as usize & mask;
        while self.slots[slot] != EMPTY {
            let index = self.slots[slot];
            let seen = self.at_mut(index);
            if seen.node == node && seen.packed == packed {
                if seen.closed || seen.key <= key {
                    return None;
                }
                (seen.key, seen.parent, seen.step) = (key, by.parent, by.step);
                return Some(index);
            }
            slot = (slot + 1) & mask;
        }
        let (parent, step) = (by.parent, by.step);
        let seen = Seen { packed, key, total: left.total, node, parent, step, closed: false };
        Some(self.add(slot, seen))
    }

    fn add(&mut self, slot: usize, seen: Seen) -> u32 {
        let index = self.len;
        if index & ((1 << CHUNK_BITS) - 1) == 0 {
            self.chunks.push(Vec::with_capacity(1 << CHUNK_BITS));
        }
        if let Some(chunk) = self.chunks.last_mut() {
            chunk.push(seen);
        }
        self.slots[slot] = index;
        self.len += 1;
        if self.len as usize * 2 > self.slots.len() {
            self.grow();
        }
        index
    }

    fn grow(&mut self) {
        let mask = self.slots.len() * 2 - 1;
        self.slots = vec![EMPTY; mask + 1];
        for index in 0..self.len {
            let seen = self.at(index);
            let mut slot = hash(seen.node, seen.packed) as usize & mask;
            while self.slots[slot] != EMPTY {
                slot = (slot + 1) & mask;
            }
            self.slots[slot] = index;
        }
    }

    /// The moves that lead to a state.
    pub fn walk(&self, mut index: u32) -> Walk {
        let mut walk = Walk::new();
        while self.at(index).parent != NO_PARENT {
            walk.push(self.at(index).step);
            index = self.at(index).parent;
        }
        walk.reverse();
        walk
    }
}

/// Mixes the bits of a state (the finalizer of SplitMix64, twice).
fn hash(node: u32, packed: [u64; 2]) -> u64 {
    let first = mix(packed[0] ^ (u64::from(node) << 32) ^ u64::from(node));
    mix(first ^ packed[1].wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

fn mix(mut word: u64) -> u64 {
    word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    word ^ (word >> 31)
}

/// All moves from a state: the arc's move, its end, the uses left there and the key.
pub(crate) fn ways_on<'a>(
    graph: &'a Graph,
    packing: &'a crate::uses::Packing,
    from: Seen,
) -> impl Iterator<Item = (u32, u32, Left, u64)> + 'a {
    let left = from.left();
    graph.arcs(from.node).iter().filter_map(move |arc| {
        let (key, slot) = graph.price(arc.step);
        let left = match slot {
            Some(slot) => packing.after(left, slot as usize)?,
            None => left,
        };
        Some((arc.step, arc.node, left, from.key + key))
    })
}
