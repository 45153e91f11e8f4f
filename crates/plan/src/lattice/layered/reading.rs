//! Reads results from the bits and planes after the search.

use super::Layered;
use crate::lattice::bits::{self, Bits};
use crate::lattice::watch::Verdict;
use crate::lattice::{Limit, recover};

impl<const W: usize> Layered<'_, W> {
    pub(super) fn solved(&self, node: u32, key: u64) -> Verdict {
        if self.planes_left.is_none() {
            return Verdict::stopped(None, key, Limit::Memory);
        }
        let distance = |node: u32, counts: &[u32]| self.distance(node, counts);
        match recover::walk(self.graph, node, self.graph.problem.required(), &distance) {
            Some(walk) => Verdict::proved(Some((key, walk))),
            None => unreachable!("every reached state has a walk from the start"),
        }
    }

    /// Distance of a state that was reached and followed.
    fn distance(&self, node: u32, counts: &[u32]) -> Option<u64> {
        let (block, bit) = self.layout.place(counts);
        let at = block * self.nodes + node as usize;
        if !bits::has(&self.reached[at], bit) || bits::has(&self.fresh[at], bit) {
            return None;
        }
        let level = |(plane, bits): (usize, &Vec<Bits<W>>)| u64::from(bits::has(&bits[at], bit)) << plane;
        Some(self.levels.step * self.planes.iter().enumerate().map(level).sum::<u64>())
    }

    pub(super) fn possible(&self) -> Option<Vec<u32>> {
        let at_goal = |block: usize| {
            let mut all = [0; W];
            self.graph
                .goals
                .iter()
                .for_each(|&goal| bits::or(&mut all, &self.reached[block * self.nodes + goal as usize]));
            all
        };
        let vectors =
            (0..self.blocks).flat_map(|block| bits::ones(&at_goal(block)).map(move |bit| (block, bit)));
        vectors
            .map(|(block, bit)| self.layout.counts(block, bit))
            .max_by_key(|counts| counts.iter().sum::<u32>())
    }
}
