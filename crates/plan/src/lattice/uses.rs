//! The uses left of all slots, as bits of one number.

/// The position of each slot's count in the number.
#[derive(Clone, Debug)]
pub(crate) struct Packing {
    fields: Vec<(u32, u128)>,
    full: u128,
    total: u32,
}

/// Uses left of every slot, and their sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Left {
    pub packed: u128,
    pub total: u32,
}

impl Packing {
    pub fn new(required: &[u32]) -> Self {
        let (mut fields, mut full, mut shift) = (Vec::new(), 0, 0);
        for &count in required {
            let bits = u32::BITS - count.leading_zeros();
            fields.push((shift, (1u128 << bits) - 1));
            full |= u128::from(count) << shift;
            shift += bits;
        }
        Self { fields, full, total: required.iter().sum() }
    }

    /// All uses are left.
    pub fn all(&self) -> Left {
        Left { packed: self.full, total: self.total }
    }

    fn of(&self, left: Left, slot: usize) -> u32 {
        let (shift, mask) = self.fields[slot];
        (left.packed >> shift & mask) as u32
    }

    /// The uses left after one use of the slot, if it has any.
    pub fn after(&self, left: Left, slot: usize) -> Option<Left> {
        let one = 1 << self.fields[slot].0;
        (self.of(left, slot) > 0).then(|| Left { packed: left.packed - one, total: left.total - 1 })
    }
}
