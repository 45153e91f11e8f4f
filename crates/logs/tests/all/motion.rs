//! Where a ship gets within a sample.

use logs::chain::{Pace, advance};
use ship::engine::Pose;

#[test]
fn law_a_steady_turn_is_a_circle() {
    let pace = Pace { from: [2.0, -0.3, 0.4], to: [2.0, -0.3, 0.4] };
    let (mut pose, dt, steps) = (Pose::default(), 0.125, 40);
    for _ in 0..steps {
        pose = advance(pose, pace, dt);
    }
    let (psi, r) = (0.4 * dt * f64::from(steps), 0.4);
    approx::assert_abs_diff_eq!(pose.psi, psi, epsilon = 1e-13);
    approx::assert_abs_diff_eq!(pose.x, (2.0 * psi.sin() - 0.3 * psi.cos() + 0.3) / r, epsilon = 1e-6);
    approx::assert_abs_diff_eq!(pose.y, (-2.0 * psi.cos() - 0.3 * psi.sin() + 2.0) / r, epsilon = 1e-6);
}

#[test]
fn law_even_acceleration_ahead_covers_the_mean_speed() {
    let pace = Pace { from: [1.0, 0.0, 0.0], to: [3.0, 0.0, 0.0] };
    let pose = advance(Pose::default(), pace, 0.5);
    approx::assert_abs_diff_eq!(pose.x, 1.0, epsilon = 1e-15);
}
