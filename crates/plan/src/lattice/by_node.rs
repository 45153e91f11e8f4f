//! Entries by node, in one array.

use crate::lattice::watch::Watch;

/// Some entries of every node.
#[derive(Clone, Debug)]
pub(crate) struct ByNode<T> {
    /// Where the entries of each node begin; then where the last end.
    offsets: Vec<u32>,
    entries: Vec<T>,
}

impl<T> ByNode<T> {
    /// Without nodes yet, with capacity for `nodes` and `entries`.
    pub fn with_capacity(nodes: usize, entries: usize) -> Self {
        let mut offsets = Vec::with_capacity(nodes + 1);
        offsets.push(0);
        Self { offsets, entries: Vec::with_capacity(entries) }
    }

    /// Adds the next node with its entries.
    pub fn push(&mut self, entries: impl IntoIterator<Item = T>) {
        self.entries.extend(entries);
        self.offsets.push(self.entries.len() as u32);
    }

    /// The entries of a node.
    pub fn of(&self, node: usize) -> &[T] {
        let range = self.range(node);
        &self.entries[range.start as usize..range.end as usize]
    }

    /// Indices of a node's entries.
    pub fn range(&self, node: usize) -> std::ops::Range<u32> {
        self.offsets[node]..self.offsets[node + 1]
    }

    /// The entries of all nodes.
    pub fn entries(&self) -> &[T] {
        &self.entries
    }
}

impl<T: Copy + Default> ByNode<T> {
    /// For `nodes` nodes, from entries in any order, each with its node; the order within a node is kept.
    /// `None` if cancelled.
    pub fn sorted<I: Iterator<Item = (u32, T)>>(
        nodes: usize,
        entries: impl Fn() -> I,
        watch: &mut Watch,
    ) -> Option<Self> {
        let mut offsets = vec![0; nodes + 1];
        for (node, _) in entries() {
            offsets[node as usize + 1] += 1;
            watch.keep_going(1).then_some(())?;
        }
        for node in 0..nodes {
            offsets[node + 1] += offsets[node];
        }
        let mut next = offsets.clone();
        let mut sorted = vec![T::default(); offsets[nodes] as usize];
        for (node, entry) in entries() {
            let at = &mut next[node as usize];
            sorted[*at as usize] = entry;
            *at += 1;
            watch.keep_going(1).then_some(())?;
        }
        Some(Self { offsets, entries: sorted })
    }
}
