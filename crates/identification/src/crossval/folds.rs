/// One fold: the places of its sources among all sources.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Fold {
    /// Left out of the estimate, and simulated over.
    pub left_out: Vec<usize>,
}

/// Each of `sources` in a fold of its own, or dealt in turns into `count` folds.
pub(super) fn folds(sources: usize, count: Option<usize>) -> Vec<Fold> {
    let count = count.unwrap_or(sources).min(sources);
    (0..count).map(|i| Fold { left_out: (i..sources).step_by(count.max(1)).collect() }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_every_source_is_left_out_once() {
        for (sources, count) in [(5, None), (5, Some(2)), (3, Some(7))] {
            let mut all: Vec<usize> = folds(sources, count).into_iter().flat_map(|f| f.left_out).collect();
            all.sort_unstable();
            assert_eq!(all, (0..sources).collect::<Vec<_>>());
        }
        assert_eq!(folds(5, Some(2))[1].left_out, [1, 3]);
    }
}
