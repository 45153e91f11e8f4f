//! Bits of one node and block.

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
