use ship::engine::Pose;

/// A ship's motion over ground at two consecutive samples: u, v \[m/s\], r \[rad/s\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// At the first.
    pub from: [f64; 3],
    /// At the second.
    pub to: [f64; 3],
}

/// The pose `dt` seconds after `pose` with body velocities that change linearly: the heading exactly, ψ(s) =
/// ψ + ∫r, the position ∫R(ψ)(u, v) by Simpson's rule.
///
/// Velocities from Euler differences of these poses are means over a step, not the velocities at its start.
pub fn advance(pose: Pose, pace: Pace, dt: f64) -> Pose {
    let mean = [0, 1].map(|d: usize| 0.5 * (pace.from[d] + pace.to[d]));
    let halfway = pose.psi + dt * (3.0 * pace.from[2] + pace.to[2]) / 8.0;
    let psi = pose.psi + 0.5 * dt * (pace.from[2] + pace.to[2]);
    let ends = [(pose.psi, [pace.from[0], pace.from[1]]), (halfway, mean), (psi, [pace.to[0], pace.to[1]])];
    let (mut north, mut east) = (0.0, 0.0);
    for ((psi, [u, v]), weight) in ends.into_iter().zip([1.0, 4.0, 1.0]) {
        let (sin, cos) = libm::sincos(psi);
        north += weight * (u * cos - v * sin);
        east += weight * (u * sin + v * cos);
    }
    Pose { x: pose.x + dt * north / 6.0, y: pose.y + dt * east / 6.0, psi }
}
