//! The weakest direction of a block.

use numerics::weakest;

#[test]
fn law_the_weakest_direction_of_a_scaled_identity_is_its_smallest_axis() {
    let found = weakest(3, &[3.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 2.0]).unwrap();
    assert!((found.ratio - 0.5 / 3.0).abs() < 1e-15);
    assert!((found.direction[1].abs() - 1.0).abs() < 1e-12);
    assert_eq!(weakest(2, &[0.0; 4]), None);
    assert_eq!(weakest(2, &[f64::NAN, 0.0, 0.0, 1.0]), None);
}
