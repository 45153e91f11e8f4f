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

/// Bits that are set, in order.
pub(crate) fn ones<const W: usize>(bits: &Bits<W>) -> impl Iterator<Item = usize> + use<W> {
    let bits = *bits;
    (0..64 * W).filter(move |&bit| has(&bits, bit))
}

/// One use of a slot that is kept in the bits: where it may be used, shifted.
#[derive(Clone, Copy)]
pub(crate) struct Shift<const W: usize> {
    pub mask: Bits<W>,
    pub words: usize,
    pub bits: u32,
}

impl<const W: usize> Shift<W> {
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
}
