use std::collections::BTreeMap;

use ship::engine::Streams;

/// The random draw of a realization.
pub(super) struct Draw {
    /// `optimized` or `random`.
    pub design: &'static str,
    streams: Streams,
    /// Per picked maneuver: its parts, and the number to pick.
    groups: Vec<(Vec<usize>, usize)>,
}

impl Draw {
    /// Picks `counts` parts of each maneuver, from parts with these `labels`.
    pub(super) fn by_design(seed: u64, labels: &[&str], counts: &BTreeMap<String, u64>) -> Self {
        let group = |(name, count): (&String, &u64)| {
            let own = (0..labels.len()).filter(|i| labels[*i] == name).collect();
            (own, *count as usize)
        };
        Self::new(seed, "optimized", counts.iter().map(group).collect())
    }

    /// Picks `picks` of all `parts`.
    pub(super) fn at_random(seed: u64, parts: usize, picks: usize) -> Self {
        Self::new(seed, "random", vec![((0..parts).collect(), picks)])
    }

    fn new(seed: u64, design: &'static str, groups: Vec<(Vec<usize>, usize)>) -> Self {
        Self { design, streams: Streams::new(seed, &format!("selection {design}")), groups }
    }

    /// The parts of a realization, ascending, none twice. Depends on the seed and the realization's number alone.
    pub(super) fn realization(&self, number: u32) -> Vec<usize> {
        let mut picked = Vec::new();
        for (channel, (parts, count)) in self.groups.iter().enumerate() {
            let mut rest = parts.clone();
            for pick in 0..(*count).min(parts.len()) {
                let channel = (channel << 16 | pick) as u32;
                let place = self.streams.choices(number, channel, rest.len() as u32, 1)[0];
                picked.push(rest.swap_remove(place as usize));
            }
        }
        picked.sort_unstable();
        picked
    }
}
