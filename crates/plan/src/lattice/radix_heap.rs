//! A queue of whole-number keys that never decrease: buckets by the highest bit in which a key differs from the last
//! one taken out (Ahuja, Mehlhorn, Orlin, Tarjan 1990). For small costs it acts like Dial's buckets.

const BUCKETS: usize = 65;
/// Most entries for which a spread bucket keeps its memory.
const KEPT: usize = 1 << 16;

/// `K` is the storage of a key.
pub(crate) struct RadixHeap<K, T> {
    last: K,
    buckets: Vec<Vec<(K, T)>>,
}

impl<K: Copy + Default + Ord + Into<u64>, T: Copy> RadixHeap<K, T> {
    pub fn new() -> Self {
        Self { last: K::default(), buckets: (0..BUCKETS).map(|_| Vec::new()).collect() }
    }

    /// Bytes that the queue holds.
    pub fn bytes(&self) -> u64 {
        let entries: usize = self.buckets.iter().map(Vec::capacity).sum();
        (entries * size_of::<(K, T)>()) as u64
    }

    /// Empties the queue and lets keys start at 0 again.
    pub fn clear(&mut self) {
        self.buckets.iter_mut().for_each(Vec::clear);
        self.last = K::default();
    }

    /// Adds an entry. A key below the last one taken out is raised to that one.
    pub fn push(&mut self, key: K, value: T) {
        debug_assert!(key >= self.last, "keys never decrease");
        let key = key.max(self.last);
        self.buckets[bucket(key, self.last)].push((key, value));
    }

    /// Takes out an entry of the least key, the latest one if there are several.
    pub fn pop(&mut self) -> Option<(K, T)> {
        if self.buckets[0].is_empty() {
            self.spread()?;
        }
        self.buckets[0].pop()
    }

    /// Spreads the first non-empty bucket over the ones before it.
    fn spread(&mut self) -> Option<()> {
        let first = self.buckets.iter().position(|bucket| !bucket.is_empty())?;
        let mut entries = std::mem::take(&mut self.buckets[first]);
        self.last = entries.iter().map(|entry| entry.0).min()?;
        for &(key, value) in &entries {
            self.buckets[bucket(key, self.last)].push((key, value));
        }
        if entries.capacity() <= KEPT {
            entries.clear();
            self.buckets[first] = entries;
        }
        Some(())
    }
}

fn bucket<K: Into<u64>>(key: K, last: K) -> usize {
    (u64::BITS - (key.into() ^ last.into()).leading_zeros()) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_keys_come_out_in_order() {
        let mut heap = RadixHeap::new();
        let (mut state, mut last, mut taken) = (1u64, 0, 0);
        for round in 0..20_000u64 {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            heap.push(last + (state >> 33) % 1000, round);
            if round % 3 > 0 {
                let least = heap.buckets.iter().flatten().map(|entry| entry.0).min();
                let (key, _) = heap.pop().unwrap();
                assert!(key >= last && Some(key) == least);
                (last, taken) = (key, taken + 1);
            }
        }
        assert_eq!(heap.buckets.iter().map(Vec::len).sum::<usize>(), 20_000 - taken);
    }
}
