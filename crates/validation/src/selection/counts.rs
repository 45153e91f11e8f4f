use std::collections::BTreeMap;

use identification::pooled::Part;

/// How many of `parts` there are of each maneuver.
pub fn available(parts: &[Part]) -> BTreeMap<String, u64> {
    let mut available = BTreeMap::new();
    parts.iter().for_each(|part| *available.entry(part.label.clone()).or_insert(0) += 1);
    available
}

/// Shares of `picks` in whole numbers: floors, then one more each in the order of what is missing, where there are more.
pub fn apportioned(
    shares: &BTreeMap<String, f64>,
    picks: u64,
    available: &BTreeMap<String, u64>,
) -> BTreeMap<String, u64> {
    let there = |name: &str| available.get(name).copied().unwrap_or(0);
    let mut counts: BTreeMap<String, u64> = shares
        .iter()
        .map(|(name, share)| (name.clone(), ((share * picks as f64).floor() as u64).min(there(name))))
        .collect();
    while counts.values().sum::<u64>() < picks {
        let missing = |(name, share): &(&String, &f64)| *share * picks as f64 - counts[*name] as f64;
        let next = shares
            .iter()
            .filter(|(name, _)| counts[*name] < there(name))
            .max_by(|a, b| missing(a).total_cmp(&missing(b)))
            .map(|(name, _)| name.clone());
        match next.and_then(|name| counts.get_mut(&name)) {
            Some(count) => *count += 1,
            None => break,
        }
    }
    counts
}
