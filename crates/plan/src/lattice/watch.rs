//! The interface between the engines and their caller.

use crate::lattice::{Limit, Problem, Progress};

/// A plan as moves in order.
pub(crate) type MoveSequence = Vec<u32>;

/// The result of an engine. Keys are without the least keys of informative actions.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Verdict {
    /// The best plan found and its key.
    pub plan: Option<(u64, MoveSequence)>,
    /// No plan has a smaller key.
    pub lower: u64,
    /// `None` if the search was completed: the plan is optimal, or there is none.
    pub stopped_by: Option<Limit>,
    /// Counts of most uses in total that reach a goal, if known.
    pub possible: Option<Vec<u32>>,
}

impl Verdict {
    pub fn proved(plan: Option<(u64, MoveSequence)>) -> Self {
        let lower = plan.as_ref().map_or(0, |plan| plan.0);
        Self { plan, lower, stopped_by: None, possible: None }
    }

    pub fn stopped(plan: Option<(u64, MoveSequence)>, lower: u64, by: Limit) -> Self {
        match plan {
            Some((key, _)) if key <= lower => Self::proved(plan),
            _ => Self { plan, lower, stopped_by: Some(by), possible: None },
        }
    }
}

/// Counts work and polls the caller.
pub(crate) struct Watch<'a, 'b> {
    problem: &'a Problem,
    keep_going: &'b mut dyn FnMut(Progress) -> bool,
    every: u64,
    work: u64,
    polled_at: u64,
    /// No plan has a smaller key.
    pub lower: u64,
    stopped: bool,
}

impl<'a, 'b> Watch<'a, 'b> {
    pub fn new(problem: &'a Problem, every: u64, keep_going: &'b mut dyn FnMut(Progress) -> bool) -> Self {
        let every = every.max(1);
        Self { problem, keep_going, every, work: 0, polled_at: 0, lower: 0, stopped: false }
    }

    /// Notes a lower bound on every plan's key.
    pub fn raise(&mut self, lower: u64) {
        self.lower = self.lower.max(lower);
    }

    /// Counts work; returns false once the search is cancelled.
    pub fn keep_going(&mut self, work: u64) -> bool {
        self.work += work;
        if !self.stopped && self.work - self.polled_at >= self.every {
            self.polled_at = self.work;
            let progress = self.progress();
            self.stopped = !(self.keep_going)(progress);
        }
        !self.stopped
    }

    fn progress(&self) -> Progress {
        Progress { work: self.work, lower_bound: self.problem.cost(self.lower, &self.problem.required()) }
    }
}

/// Entries that are written between two polls.
const AT_ONCE: usize = 1 << 18;

/// `count` times `value`. `None` if cancelled.
pub(crate) fn filled<T: Copy>(count: usize, value: T, watch: &mut Watch) -> Option<Vec<T>> {
    let mut all = Vec::with_capacity(count);
    while all.len() < count {
        watch.keep_going(AT_ONCE as u64).then_some(())?;
        all.resize((all.len() + AT_ONCE).min(count), value);
    }
    Some(all)
}

/// Polls a callback every few thousand calls, and remembers a cancellation.
pub struct Poll<'a> {
    keep_going: &'a dyn Fn() -> bool,
    times: u32,
    /// Whether the callback returned false.
    pub stopped: bool,
}

impl<'a> Poll<'a> {
    /// Polls `keep_going`.
    pub fn new(keep_going: &'a dyn Fn() -> bool) -> Self {
        Self { keep_going, times: 0, stopped: false }
    }

    /// Returns false once cancelled.
    pub fn proceed(&mut self) -> bool {
        self.times = self.times.wrapping_add(1);
        if self.times.is_multiple_of(1 << 16) {
            self.stopped |= !(self.keep_going)();
        }
        !self.stopped
    }
}

/// Strides of a mixed-radix number of count vectors, first slot fastest, and how many there are.
pub(crate) fn strides(required: &[u32]) -> (Vec<u64>, u128) {
    let mut next = 1u128;
    let mut strides = Vec::new();
    for &count in required {
        strides.push(next.min(u128::from(u64::MAX)) as u64);
        next = next.saturating_mul(u128::from(count) + 1);
    }
    (strides, next)
}

/// The mixed-radix number of counts.
pub(crate) fn number(counts: &[u32], strides: &[u64]) -> u64 {
    counts.iter().zip(strides).map(|(&count, stride)| u64::from(count) * stride).sum()
}

/// Counts of a mixed-radix number.
pub(crate) fn counts(mut number: u64, required: &[u32]) -> Vec<u32> {
    let digits = required.iter().map(|&count| {
        let radix = u64::from(count) + 1;
        let digit = number % radix;
        number /= radix;
        digit as u32
    });
    digits.collect()
}

// A queue of whole-number keys that never decrease: buckets by the highest bit in which a key differs from the last
// one taken out (Ahuja, Mehlhorn, Orlin, Tarjan 1990). For small costs it acts like Dial's buckets.

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
