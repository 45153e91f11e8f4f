use super::recording::Recording;

/// The fold of each of `recordings`: those of one kind are dealt out in turns, so that each fold has some of every kind.
pub(super) fn folds(recordings: &[&Recording], count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..recordings.len()).collect();
    order.sort_by_key(|i| recordings[*i].kind());
    let mut folds = vec![0; recordings.len()];
    order.into_iter().enumerate().for_each(|(place, recording)| folds[recording] = place % count);
    folds
}
