//! From an antenna to the reference point.

use logs::Lever;

#[test]
fn law_an_antenna_at_the_reference_point_changes_nothing() {
    let lever = Lever::default();
    assert!(lever.is_zero());
    assert_eq!(lever.position([3.0, -4.0], 0.7), [3.0, -4.0]);
    assert_eq!(lever.velocity([0.5, 0.1], -0.2), [0.5, 0.1]);
}

#[test]
fn law_positions_and_velocities_move_together() {
    let lever = Lever([1.5, -0.4]);
    let (r, dt) = (0.3, 1e-6);
    let antenna = |t: f64| [2.0 * t, -t];
    let psi = |t: f64| 0.4 + r * t;
    let [p0, p1] = [-dt, dt].map(|t| lever.position(antenna(t), psi(t)));
    let rate = [(p1[0] - p0[0]) / (2.0 * dt), (p1[1] - p0[1]) / (2.0 * dt)];
    let (sin, cos) = psi(0.0).sin_cos();
    let body = |[n, e]: [f64; 2]| [n * cos + e * sin, -n * sin + e * cos];
    let (found, expected) = (lever.velocity(body([2.0, -1.0]), r), body(rate));
    approx::assert_abs_diff_eq!(found[0], expected[0], epsilon = 1e-9);
    approx::assert_abs_diff_eq!(found[1], expected[1], epsilon = 1e-9);
}
