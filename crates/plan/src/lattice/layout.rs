//! How count vectors become bits: some counts number the bits of a block, the others number the blocks.

use super::graph::ByNode;
use crate::lattice::graph::Graph;
use crate::lattice::watch::Watch;

/// Where the count of a slot is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Digit {
    /// In the bit: one use shifts the block's bits by `stride`.
    Bit { stride: u32, radix: u32 },
    /// In the block's number: one use leads `stride` blocks on.
    Block { stride: u64, radix: u64 },
}

/// Count vectors as blocks of `64 * words` bits.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    /// 1, 2, 3, 4 or 8.
    pub words: usize,
    pub digits: Vec<Digit>,
    pub blocks: u128,
}

impl Layout {
    /// The most efficient layout; wider blocks are preferred.
    pub fn new(required: &[u32]) -> Self {
        let (words, chosen) = [(1, 0.8), (2, 0.9), (3, 0.95), (4, 1.0), (8, 1.0)]
            .map(|(words, efficiency)| (words, efficiency, fullest(required, 64 * words)))
            .into_iter()
            .filter(|(words, _, (used, _))| *words == 1 || used * 2 > 64 * words)
            .map(|(words, efficiency, (used, chosen))| {
                (efficiency * used as f64 / (64 * words) as f64, words, chosen)
            })
            .reduce(|best, other| if other.0 > best.0 { other } else { best })
            .map_or((1, vec![false; required.len()]), |(_, words, chosen)| (words, chosen));
        Self::with(required, words, &chosen)
    }

    fn with(required: &[u32], words: usize, chosen: &[bool]) -> Self {
        let (mut bit, mut block) = (1u32, 1u128);
        let digit = |(&count, &in_bit): (&u32, &bool)| {
            if in_bit {
                let stride = bit;
                bit *= count + 1;
                return Digit::Bit { stride, radix: count + 1 };
            }
            let stride = block.min(u128::from(u64::MAX)) as u64;
            block = block.saturating_mul(u128::from(count) + 1);
            Digit::Block { stride, radix: u64::from(count) + 1 }
        };
        let digits = required.iter().zip(chosen).map(digit).collect();
        Self { words, digits, blocks: block }
    }

    /// Block and bit of a count vector.
    pub fn place(&self, counts: &[u32]) -> (usize, usize) {
        let (mut block, mut bit) = (0, 0);
        for (digit, &count) in self.digits.iter().zip(counts) {
            match *digit {
                Digit::Bit { stride, .. } => bit += (stride * count) as usize,
                Digit::Block { stride, .. } => block += stride as usize * count as usize,
            }
        }
        (block, bit)
    }

    /// The count vector of a block and bit.
    pub fn counts(&self, block: usize, bit: usize) -> Vec<u32> {
        let count = |digit: &Digit| match *digit {
            Digit::Bit { stride, radix } => bit as u32 / stride % radix,
            Digit::Block { stride, radix } => (block as u64 / stride % radix) as u32,
        };
        self.digits.iter().map(count).collect()
    }

    /// The bits from which a slot in the bit may be used once more, as words.
    pub fn mask<const W: usize>(&self, stride: u32, radix: u32) -> [u64; W] {
        let mut mask = [0; W];
        let bits = self.digits.iter().map(|one| if let Digit::Bit { radix, .. } = one { *radix } else { 1 });
        for bit in (0..bits.product()).filter(|bit| bit / stride % radix + 1 < radix) {
            mask[bit as usize / 64] |= 1 << (bit % 64);
        }
        mask
    }
}

/// The slots whose vectors fill most of `bits` bits, and how many bits these are.
fn fullest(required: &[u32], bits: usize) -> (usize, Vec<bool>) {
    let mut best: Vec<Option<Vec<bool>>> = vec![None; bits + 1];
    best[1] = Some(vec![false; required.len()]);
    for (slot, &count) in required.iter().enumerate() {
        let radix = count as usize + 1;
        for used in (1..=bits / radix).rev() {
            let Some(chosen) = best[used].clone() else { continue };
            best[used * radix].get_or_insert_with(|| {
                let mut chosen = chosen;
                chosen[slot] = true;
                chosen
            });
        }
    }
    let full = (1..=bits).rev().find_map(|used| best[used].clone().map(|chosen| (used, chosen)));
    full.unwrap_or((1, vec![false; required.len()]))
}

pub(crate) type Bits<const W: usize> = [u64; W];

pub(crate) fn any<const W: usize>(bits: &Bits<W>) -> bool {
    bits.iter().fold(0, |all, word| all | word) != 0
}

pub(crate) fn or<const W: usize>(into: &mut Bits<W>, bits: &Bits<W>) {
    for w in 0..W {
        into[w] |= bits[w];
    }
}

/// The bits of `bits` that are not in `known`.
pub(crate) fn beyond<const W: usize>(bits: &Bits<W>, known: &Bits<W>) -> Bits<W> {
    let mut new = [0; W];
    for w in 0..W {
        new[w] = bits[w] & !known[w];
    }
    new
}

pub(crate) fn has<const W: usize>(bits: &Bits<W>, bit: usize) -> bool {
    bits[bit / 64] >> (bit % 64) & 1 == 1
}

/// The bits of `bits` that are also in `others`.
pub(crate) fn both<const W: usize>(bits: &Bits<W>, others: &Bits<W>) -> Bits<W> {
    std::array::from_fn(|w| bits[w] & others[w])
}

/// How many bits are set.
pub(crate) fn count<const W: usize>(bits: &Bits<W>) -> usize {
    bits.iter().map(|word| word.count_ones() as usize).sum()
}

/// Bits that are set, in order.
pub(crate) fn ones<const W: usize>(bits: &Bits<W>) -> impl Iterator<Item = usize> + use<W> {
    let bits = *bits;
    (0..W).flat_map(move |number| {
        let mut left = bits[number];
        std::iter::from_fn(move || {
            let bit = (left != 0).then(|| 64 * number + left.trailing_zeros() as usize);
            left &= left.wrapping_sub(1);
            bit
        })
    })
}

/// One use of a slot that is kept in the bits: where it may be used, shifted.
#[derive(Clone, Copy)]
pub(crate) struct Shift<const W: usize> {
    pub mask: Bits<W>,
    pub words: usize,
    pub bits: u32,
}

impl<const W: usize> Shift<W> {
    /// By `stride` bits, of bits in `mask`.
    pub fn new(mask: Bits<W>, stride: u32) -> Self {
        Self { mask, words: stride as usize / 64, bits: stride % 64 }
    }

    pub fn apply(&self, bits: &Bits<W>) -> Bits<W> {
        let mut masked = [0; W];
        for w in 0..W {
            masked[w] = bits[w] & self.mask[w];
        }
        let mut shifted = [0; W];
        for w in self.words..W {
            shifted[w] = masked[w - self.words] << self.bits;
            if self.bits > 0 && w > self.words {
                shifted[w] |= masked[w - self.words - 1] >> (64 - self.bits);
            }
        }
        shifted
    }

    /// The bits that [`Self::apply`] takes to some of `bits`.
    pub fn undo(&self, bits: &Bits<W>) -> Bits<W> {
        let mut back = [0; W];
        for w in 0..W - self.words.min(W) {
            back[w] = bits[w + self.words] >> self.bits;
            if self.bits > 0 && w + self.words + 1 < W {
                back[w] |= bits[w + self.words + 1] << (64 - self.bits);
            }
            back[w] &= self.mask[w];
        }
        back
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_times_three_is_one_word() {
        let layout = Layout::new(&[3, 3, 3]);
        assert_eq!((layout.words, layout.blocks), (1, 1));
    }

    #[test]
    fn eleven_times_two_wastes_a_twentieth() {
        let layout = Layout::new(&[2; 11]);
        assert_eq!((layout.words, layout.blocks), (4, 729));
    }

    #[test]
    fn three_times_twelve_are_three_words() {
        let layout = Layout::new(&[12, 12, 12]);
        assert_eq!((layout.words, layout.blocks), (3, 13));
    }

    #[test]
    fn law_place_and_counts_are_inverse() {
        for required in [vec![], vec![1000], vec![2, 70, 1, 3], vec![4; 6]] {
            let layout = Layout::new(&required);
            let vectors: u64 = required.iter().map(|&count| u64::from(count) + 1).product();
            let mut seen = std::collections::BTreeSet::new();
            for number in 0..vectors {
                let counts = crate::lattice::watch::counts(number, &required);
                let (block, bit) = layout.place(&counts);
                assert!(bit < 64 * layout.words && (block as u128) < layout.blocks);
                assert_eq!(layout.counts(block, bit), counts);
                assert!(seen.insert((block, bit)));
            }
        }
    }
}
