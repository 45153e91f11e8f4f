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

impl Pose {
    /// The same, ahead and to starboard of `origin`.
    #[must_use]
    pub fn seen_from(&self, origin: &Self) -> Self {
        let (sin, cos) = libm::sincos(origin.psi);
        let [north, east] = [self.x - origin.x, self.y - origin.y];
        Self { x: north * cos + east * sin, y: east * cos - north * sin, psi: self.psi - origin.psi }
    }

    /// Moves on by `seconds` with body velocities over the ground \[m/s, m/s, rad/s\], by an explicit Euler step.
    pub fn advance(&mut self, state: [f64; 3], seconds: f64) {
        let (sin, cos) = libm::sincos(self.psi);
        self.x += seconds * (state[0] * cos - state[1] * sin);
        self.y += seconds * (state[0] * sin + state[1] * cos);
        self.psi += seconds * state[2];
    }
}

/// Poses at N+1 samples from body velocities over the ground, (N+1) × 3 row-major \[m/s, m/s, rad/s\], by explicit
/// Euler steps from the origin, heading north.
pub fn track(states: &[f64], sample_rate_hz: f64) -> Vec<Pose> {
    let dt = 1.0 / sample_rate_hz;
    let mut pose = Pose::default();
    let mut poses = Vec::with_capacity(states.len() / 3);
    for state in states.as_chunks::<3>().0 {
        poses.push(pose);
        pose.advance(*state, dt);
    }
    poses
}
