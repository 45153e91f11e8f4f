//! Searches that go step by step.

use std::sync::atomic::{AtomicUsize, Ordering};

use numerics::{Watch, iterate};

#[test]
fn a_search_ends_by_itself_after_so_many_steps_or_by_its_watch() {
    let taken = |most: usize, last: usize, watch: &Watch| {
        let mut steps = 0;
        iterate("counting", most, watch, || {
            steps += 1;
            (steps < last).then_some(())
        });
        steps
    };
    let none = Watch::default();
    assert_eq!([taken(7, 9, &none), taken(9, 7, &none), taken(0, 7, &none)], [7, 7, 0]);
    let seen = AtomicUsize::new(0);
    let watch = Watch::new(move || seen.fetch_add(1, Ordering::Relaxed) < 3);
    assert!(!watch.ended());
    assert_eq!(taken(9, 7, &watch), 4);
    assert!(watch.ended() && !none.ended());
}
