use crate::lattice::bits::{self, Bits};

/// The states of all blocks while a block is left.
pub(super) struct States<'a, const W: usize> {
    pub nodes: usize,
    pub reached: &'a mut [Bits<W>],
    pub fresh: &'a mut [Bits<W>],
    pub dirty: &'a mut [u64],
}

impl<const W: usize> States<'_, W> {
    pub fn arrive(&mut self, block: usize, end: u32, states: &Bits<W>) {
        let at = block * self.nodes + end as usize;
        let new = bits::beyond(states, &self.reached[at]);
        if bits::any(&new) {
            bits::or(&mut self.reached[at], &new);
            bits::or(&mut self.fresh[at], &new);
            self.dirty[block * self.nodes.div_ceil(64) + end as usize / 64] |= 1 << (end % 64);
        }
    }
}
