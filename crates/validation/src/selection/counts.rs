use std::collections::BTreeMap;

use regression::pooled::Part;

/// The number of `parts` of each maneuver.
pub fn available(parts: &[Part]) -> BTreeMap<String, u64> {
    let mut available = BTreeMap::new();
    parts.iter().for_each(|part| *available.entry(part.label.clone()).or_insert(0) += 1);
    available
}
