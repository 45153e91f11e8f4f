/// Position in a local tangent plane and heading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// North \[m\].
    pub x: f64,
    /// East \[m\].
    pub y: f64,
    /// Heading, clockwise from north \[rad\], not wrapped.
    pub psi: f64,
}

/// Poses at N+1 samples from body velocities over the ground, (N+1) × 3 row-major \[m/s, m/s, rad/s\], by explicit
/// Euler steps from the origin, heading north.
pub fn track(states: &[f64], sample_rate_hz: f64) -> Vec<Pose> {
    let dt = 1.0 / sample_rate_hz;
    let mut pose = Pose::default();
    let mut poses = Vec::with_capacity(states.len() / 3);
    for state in states.chunks_exact(3) {
        poses.push(pose);
        let (sin, cos) = libm::sincos(pose.psi);
        pose.x += dt * (state[0] * cos - state[1] * sin);
        pose.y += dt * (state[0] * sin + state[1] * cos);
        pose.psi += dt * state[2];
    }
    poses
}
