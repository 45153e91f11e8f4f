use std::cmp::Reverse;

use crate::search::recording::Recording;

/// The fold of each of `recordings`, below `count`. Those of one kind are dealt out one to each fold in turn, so that each fold has
/// some of every kind. The longest come first, each to the fold with the fewest samples so far, so that folds are
/// about equally long.
pub fn folds(recordings: &[&Recording], count: usize) -> Vec<usize> {
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
