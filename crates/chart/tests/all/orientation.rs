//! On which side of a line a point lies.

use chart::ring::{cross_properly, turn};

#[test]
fn turns_are_exact_where_rounding_would_decide() {
    let ulp = f64::EPSILON / 2.0;
    let (a, b) = ([12.0, 12.0], [24.0, 24.0]);
    for i in 0..64 {
        for j in 0..64 {
            let c = [0.5 + f64::from(i) * ulp, 0.5 + f64::from(j) * ulp];
            // On a line of slope one through the origin the turn is the sign of y − x, which is exact here.
            assert_eq!(turn(a, b, c), c[1].total_cmp(&c[0]), "{i} {j}");
        }
    }
}

#[test]
fn touching_is_not_crossing() {
    let (p, q) = ([0.0, 0.0], [2.0, 0.0]);
    assert!(cross_properly(p, q, [1.0, -1.0], [1.0, 1.0]));
    assert!(!cross_properly(p, q, [1.0, 0.0], [1.0, 1.0]));
    assert!(!cross_properly(p, q, [2.0, 0.0], [3.0, 1.0]));
    assert!(!cross_properly(p, q, [1.0, 0.0], [3.0, 0.0]));
}
