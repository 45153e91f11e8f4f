use vessel::Pose;

/// How a ship moves over ground at two neighbouring samples: u, v \[m/s\], r \[rad/s\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// At the first.
    pub from: [f64; 3],
    /// At the second.
    pub to: [f64; 3],
}

/// Where a ship is `dt` seconds after `pose`, its body velocities changing evenly meanwhile: the heading exactly,
/// ψ(s) = ψ + ∫r, the position ∫R(ψ)(u, v) by Simpson's rule.
///
/// Velocities from Euler differences of what comes of this are means over a step, not the velocities at its start.
pub fn advance(pose: Pose, pace: Pace, dt: f64) -> Pose {
    let middle = [0, 1].map(|d: usize| 0.5 * (pace.from[d] + pace.to[d]));
    let halfway = pose.psi + dt * (3.0 * pace.from[2] + pace.to[2]) / 8.0;
    let psi = pose.psi + 0.5 * dt * (pace.from[2] + pace.to[2]);
    let ends = [(pose.psi, [pace.from[0], pace.from[1]]), (halfway, middle), (psi, [pace.to[0], pace.to[1]])];
    let (mut north, mut east) = (0.0, 0.0);
    for ((psi, [u, v]), weight) in ends.into_iter().zip([1.0, 4.0, 1.0]) {
        let (sin, cos) = psi.sin_cos();
        north += weight * (u * cos - v * sin);
        east += weight * (u * sin + v * cos);
    }
    Pose { x: pose.x + dt * north / 6.0, y: pose.y + dt * east / 6.0, psi }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
