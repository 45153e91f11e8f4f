//! Shares in whole numbers.

use std::collections::BTreeMap;

use validation::selection::apportioned;

fn map<T: Copy>(entries: &[(&str, T)]) -> BTreeMap<String, T> {
    entries.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
}

#[test]
fn shares_become_counts_that_exist() {
    let shares = map(&[("a", 0.74), ("b", 0.2), ("c", 0.06)]);
    let counts = apportioned(&shares, 6, &map(&[("a", 9), ("b", 9), ("c", 9)]));
    assert_eq!(counts, map(&[("a", 5), ("b", 1), ("c", 0)]));
    let counts = apportioned(&shares, 6, &map(&[("a", 3), ("b", 2), ("c", 9)]));
    assert_eq!(counts, map(&[("a", 3), ("b", 2), ("c", 1)]));
    assert_eq!(apportioned(&shares, 6, &map(&[("a", 1)])).values().sum::<u64>(), 1);
}
