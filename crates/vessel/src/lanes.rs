//! Runs side by side: between one run's rows and [`Lane`]s.

use crate::{LANES, Lane};

/// Puts rows of up to [`LANES`] runs side by side; unused lanes repeat the last run.
pub fn interleave(runs: &[&[f64]]) -> Vec<Lane> {
    let length = runs.first().map_or(0, |run| run.len());
    let run = |lane: usize| runs[lane.min(runs.len() - 1)];
    (0..length).map(|i| Lane(std::array::from_fn(|lane| run(lane)[i]))).collect()
}

/// The rows of one lane.
pub fn lane_of(values: &[Lane], lane: usize) -> Vec<f64> {
    values.iter().map(|v| v[lane]).collect()
}

/// Indices of neighbours with the same key, in groups of at most [`LANES`].
pub fn groups<K: PartialEq>(keys: &[K]) -> Vec<std::ops::Range<usize>> {
    let mut groups: Vec<std::ops::Range<usize>> = Vec::new();
    for (i, key) in keys.iter().enumerate() {
        match groups.last_mut() {
            Some(group) if group.len() < LANES && keys[group.start] == *key => group.end = i + 1,
            _ => groups.push(i..i + 1),
        }
    }
    groups
}
