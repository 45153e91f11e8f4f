//! Sequences of maneuvers.

use trial::arranging::merged;

#[test]
fn parts_without_samples_go_and_neighbours_of_one_maneuver_become_one() {
    let plan = vec![(1, 3), (2, 0), (1, 4), (0, 2), (0, 2)];
    assert_eq!(merged(plan, |q| q == 0), [(1, 7), (0, 2), (0, 2)]);
}
