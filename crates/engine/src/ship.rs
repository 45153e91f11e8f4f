use crate::{Ambient, Compiled, Pose};
use model::{Actuator, Vessel};

/// A vessel under way: pose and state, advanced sample by sample in a current.
#[derive(Clone, Debug)]
pub struct Ship<'a> {
    vessel: &'a Vessel,
    model: Compiled<'a, f64>,
    sample_s: f64,
    /// Actuator settings, then measured disturbances and derived channels.
    exogenous: Vec<f64>,
    /// Whether the actuators have been set: the first command is reached at once.
    is_set: bool,
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
            is_set: false,
            current_m_s: [0.0; 2],
            pose,
            state: [speed_m_s, 0.0, 0.0],
        }
    }

    /// Time of a sample \[s\].
    pub fn sample_s(&self) -> f64 {
        self.sample_s
    }

    /// Advances by one sample while the actuators follow `commands`; returns their settings.
    pub fn command(&mut self, commands: &[f64]) -> &[f64] {
        self.act(commands, Actuator::after)
    }

    /// Advances by one sample with the actuators as near to `wanted` as any commands take them; returns their
    /// settings.
    pub fn reach(&mut self, wanted: &[f64]) -> &[f64] {
        self.act(wanted, Actuator::towards)
    }

    fn act(&mut self, commands: &[f64], reached: fn(&Actuator, f64, f64, f64) -> f64) -> &[f64] {
        for ((setting, command), own) in self.exogenous.iter_mut().zip(commands).zip(&self.vessel.actuators) {
            *setting = if self.is_set { reached(own, *setting, *command, self.sample_s) } else { *command };
        }
        self.advance();
        &self.exogenous[..self.vessel.model.inputs]
    }

    /// Advances by one sample under `inputs`, regardless of the actuators.
    pub fn step(&mut self, inputs: &[f64]) {
        self.exogenous.iter_mut().zip(inputs).for_each(|(to, from)| *to = *from);
        self.advance();
    }

    /// x(k+1) = x(k) + θᵀφ, then the pose by an explicit Euler step.
    fn advance(&mut self) {
        self.is_set = true;
        let (sin, cos) = libm::sincos(self.pose.psi);
        let [north, east] = self.current_m_s;
        let current = Some([north * cos + east * sin, east * cos - north * sin]);
        self.vessel.model.complete(&mut self.exogenous);
        self.pose.move_on(self.state, self.sample_s, (sin, cos));
        let ambient = Ambient { current, ..Ambient::default() };
        self.state = self.model.step(self.state, &self.exogenous, ambient);
    }
}
