//! Which sources are left out together.

use validation::crossval::dealt;

#[test]
fn law_every_source_is_left_out_once() {
    for (sources, folds) in [(5, None), (5, Some(2)), (3, Some(7))] {
        let mut all = dealt(sources, folds).concat();
        all.sort_unstable();
        assert_eq!(all, (0..sources).collect::<Vec<_>>());
    }
    assert_eq!(dealt(5, Some(2))[1], [1, 3]);
}
