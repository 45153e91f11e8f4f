use vessel::{Ambient, Compiled, Pose, Vessel};

/// A vessel under way: pose and state, moved sample by sample in a current.
#[derive(Clone, Debug)]
pub struct Ship<'a> {
    vessel: &'a Vessel,
    model: Compiled<'a, f64>,
    sample_s: f64,
    /// Inputs, then measured disturbances and derived channels.
    exogenous: Vec<f64>,
    /// North and east components of the current \[m/s\].
    pub current_m_s: [f64; 2],
    /// Where it is.
    pub pose: Pose,
    /// u, v over the ground \[m/s\], r \[rad/s\].
    pub state: [f64; 3],
}

impl<'a> Ship<'a> {
    /// A vessel with `parameters` at `pose`, moving ahead at `speed_m_s`.
    pub fn new(vessel: &'a Vessel, parameters: &[f64], pose: Pose, speed_m_s: f64) -> Self {
        Self {
            vessel,
            model: Compiled::new(&vessel.model, parameters),
            sample_s: 1.0 / vessel.sample_rate_hz,
            exogenous: vec![0.0; vessel.model.exogenous()],
            current_m_s: [0.0; 2],
            pose,
            state: [speed_m_s, 0.0, 0.0],
        }
    }

    /// Time of a sample \[s\].
    pub fn sample_s(&self) -> f64 {
        self.sample_s
    }

    /// Moves on by one sample under `inputs`: x(k+1) = x(k) + θᵀφ, then the pose by an explicit Euler step.
    pub fn step(&mut self, inputs: &[f64]) {
        let (sin, cos) = libm::sincos(self.pose.psi);
        let [north, east] = self.current_m_s;
        let current = Some([north * cos + east * sin, east * cos - north * sin]);
        self.exogenous.iter_mut().zip(inputs).for_each(|(to, from)| *to = *from);
        self.vessel.model.complete(&mut self.exogenous);
        let dt = self.sample_s;
        self.pose.x += dt * (self.state[0] * cos - self.state[1] * sin);
        self.pose.y += dt * (self.state[0] * sin + self.state[1] * cos);
        self.pose.psi += dt * self.state[2];
        let ambient = Ambient { current, ..Ambient::default() };
        self.state = self.model.step(self.state, &self.exogenous, ambient);
    }
}
