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
    /// Advances by `seconds` with body velocities over the ground \[m/s, m/s, rad/s\], by an explicit Euler
    /// step.
    pub(crate) fn advance(&mut self, state: [f64; 3], seconds: f64) {
        self.move_on(state, seconds, libm::sincos(self.psi));
    }

    /// [`Self::advance`] with the sine and the cosine of the heading.
    pub(crate) fn move_on(&mut self, state: [f64; 3], seconds: f64, (sin, cos): (f64, f64)) {
        self.x += seconds * (state[0] * cos - state[1] * sin);
        self.y += seconds * (state[0] * sin + state[1] * cos);
        self.psi += seconds * state[2];
    }
}

/// The origin of relative poses.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    pose: Pose,
    sin: f64,
    cos: f64,
}

impl From<Pose> for Origin {
    fn from(pose: Pose) -> Self {
        let (sin, cos) = libm::sincos(pose.psi);
        Self { pose, sin, cos }
    }
}

impl Origin {
    /// The pose relative to the origin: ahead, to starboard, and the difference of headings.
    pub fn sees(&self, pose: Pose) -> Pose {
        let Self { pose: own, sin, cos } = self;
        let [north, east] = [pose.x - own.x, pose.y - own.y];
        Pose { x: north * cos + east * sin, y: east * cos - north * sin, psi: pose.psi - own.psi }
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
