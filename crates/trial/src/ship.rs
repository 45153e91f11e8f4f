use vessel::{Pose, Vessel};

/// A vessel under way: pose and state, moved sample by sample in a current.
#[derive(Clone, Debug)]
pub struct Ship<'a> {
    vessel: &'a Vessel,
    parameters: Vec<f64>,
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
        let parameters = parameters.to_vec();
        Self { vessel, parameters, current_m_s: [0.0; 2], pose, state: [speed_m_s, 0.0, 0.0] }
    }

    /// Time of a sample \[s\].
    pub fn sample_s(&self) -> f64 {
        1.0 / self.vessel.sample_rate_hz
    }

    /// Moves on by one sample under `inputs`: x(k+1) = x(k) + θᵀφ, then the pose by an explicit Euler step.
    pub fn step(&mut self, inputs: &[f64]) {
        let (sin, cos) = self.pose.psi.sin_cos();
        let [north, east] = self.current_m_s;
        let current = [north * cos + east * sin, east * cos - north * sin, 0.0];
        let mut values = Vec::with_capacity(3 + self.vessel.model.exogenous());
        values.extend(self.state.iter().zip(current).map(|(state, current)| state - current));
        values.extend_from_slice(inputs);
        values.resize(3 + self.vessel.model.exogenous(), 0.0);
        let increments = self.vessel.model.increments(&values, &self.parameters);
        let dt = self.sample_s();
        self.pose.x += dt * (self.state[0] * cos - self.state[1] * sin);
        self.pose.y += dt * (self.state[0] * sin + self.state[1] * cos);
        self.pose.psi += dt * self.state[2];
        for (state, increment) in self.state.iter_mut().zip(increments) {
            *state += increment;
        }
    }
}
