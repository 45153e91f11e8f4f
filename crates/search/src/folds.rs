use std::cmp::Reverse;

use crate::recording::Recording;

/// The fold of each of `recordings`. Those of one kind are dealt out one to each fold in turn, so that each fold has
/// some of every kind. The longest come first, each to the fold with the fewest samples so far, so that folds are
/// about equally long.
pub(crate) fn folds(recordings: &[&Recording], count: usize) -> Vec<usize> {
    let samples = |i: &usize| recordings[*i].samples();
    let kind = |i: &usize| recordings[*i].kind();
    let mut order: Vec<usize> = (0..recordings.len()).collect();
    order.sort_by_key(|i| (kind(i), Reverse(samples(i))));
    let (mut folds, mut samples_by_fold) = (vec![0; recordings.len()], vec![0; count]);
    for of_one_kind in order.chunk_by(|a, b| kind(a) == kind(b)) {
        let mut dealt = vec![0_usize; count];
        for recording in of_one_kind {
            let least = (0..count).min_by_key(|fold| (dealt[*fold], samples_by_fold[*fold]));
            let fold = least.unwrap_or(0);
            dealt[fold] += 1;
            samples_by_fold[fold] += samples(recording);
            folds[*recording] = fold;
        }
    }
    folds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Cut;
    use regression::pooled::Part;

    #[test]
    fn law_folds_have_some_of_every_kind_and_are_about_as_long() {
        let part = |samples: usize| Part {
            label: String::new(),
            source: String::new(),
            measured: vec![0.0; 3 * (samples + 1)],
            instrument_exogenous: Vec::new(),
            exogenous: vec![0.0; samples],
        };
        let cut = Cut { window: 10, every: 5, scored: None };
        let lengths = [("turn", [90, 20, 60, 30, 80, 40]), ("zigzag", [50, 10, 40, 20, 30, 70])];
        let all: Vec<Recording> = lengths
            .iter()
            .flat_map(|(kind, lengths)| {
                lengths.iter().enumerate().map(move |(i, n)| (format!("{kind}_{i}"), *n))
            })
            .map(|(name, samples)| Recording::new(name, vec![part(samples)], cut))
            .collect();
        let found = folds(&all.iter().collect::<Vec<_>>(), 3);
        let of = |fold: usize| all.iter().zip(&found).filter(move |(_, own)| **own == fold).map(|(r, _)| r);
        for fold in 0..3 {
            let kinds = |kind: &str| of(fold).filter(|r| r.kind() == kind).count();
            assert_eq!([kinds("turn"), kinds("zigzag")], [2, 2]);
            // A third of all is 180.
            let samples: usize = of(fold).map(Recording::samples).sum();
            assert!((160..=200).contains(&samples), "{samples} in fold {fold}: {found:?}");
        }
    }
}
