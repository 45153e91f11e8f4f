//! How count vectors become bits: some counts number the bits of a block, the others number the blocks.

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
        let bits =
            self.digits.iter().map(|digit| if let Digit::Bit { radix, .. } = digit { *radix } else { 1 });
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
