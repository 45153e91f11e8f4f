//! Which sources are left out together.

use validation::crossval::{CrossError, Folds};

const SOURCES: [&str; 5] = ["a", "b", "c", "d", "e"];

#[test]
fn law_every_source_is_left_out_once() {
    for (sources, how) in [(5, Folds::Each), (5, Folds::Dealt(2)), (3, Folds::Dealt(7))] {
        let mut all = how.left_out(&SOURCES[..sources]).unwrap().concat();
        all.sort_unstable();
        assert_eq!(all, (0..sources).collect::<Vec<_>>());
    }
    assert_eq!(Folds::Dealt(2).left_out(&SOURCES).unwrap()[1], [1, 3]);
}

#[test]
fn named_folds_are_those_named() {
    let left_out = |folds: &[&[&str]]| {
        let fold = |own: &&[&str]| own.iter().map(|name| (*name).to_owned()).collect();
        Folds::Named(folds.iter().map(fold).collect()).left_out(&SOURCES)
    };
    assert_eq!(left_out(&[&["d", "a"], &["e"]]), Ok(vec![vec![3, 0], vec![4]]));
    assert_eq!(left_out(&[&["a"], &["b", "a"]]), Err(CrossError::Twice("a".to_owned())));
    assert_eq!(left_out(&[&SOURCES]), Err(CrossError::OneSource));
    assert!(matches!(left_out(&[&["f"]]), Err(CrossError::Unknown { .. })));
}
