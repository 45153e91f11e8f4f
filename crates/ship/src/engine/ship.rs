use crate::engine::{Ambient, Changing, Compiled, Pose};
use crate::model::{Actuator, ActuatorState, SampleCommand, Vessel};

/// A vessel under way: pose and state, advanced sample by sample in a current.
#[derive(Clone, Debug)]
pub struct Ship<'a> {
    vessel: &'a Vessel,
    model: Compiled<'a, f64>,
    sample_s: f64,
    /// Actuator settings, then measured disturbances and derived channels.
    exogenous: Vec<f64>,
    /// The actuators; none before the first command, which is reached at once.
    acting: Vec<ActuatorState>,
    /// North and east components of the current \[m/s\].
    pub current_m_s: [f64; 2],
    /// How that and the wind change from sample to sample; without it they do not.
    pub changing: Option<Changing>,
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
            acting: Vec::new(),
            current_m_s: [0.0; 2],
            changing: None,
            pose,
            state: [speed_m_s, 0.0, 0.0],
        }
    }

    /// Time of a sample \[s\].
    pub fn sample_s(&self) -> f64 {
        self.sample_s
    }

    /// Advances by one sample while the actuators follow `commands`; returns their settings. Commands that change
    /// within the sample have `ends`: those at its beginning and at its end.
    pub fn command(&mut self, commands: &[f64], ends: Option<[&[f64]; 2]>) -> &[f64] {
        self.act(commands, |acting, own, i, command, seconds| {
            acting.follow(own, SampleCommand::of(i, command, ends), seconds)
        })
    }

    /// Advances by one sample with the actuators as near to `wanted` as commands take them; returns their settings.
    pub fn reach(&mut self, wanted: &[f64]) -> &[f64] {
        self.act(wanted, |acting, own, _, wanted, seconds| acting.reach(own, wanted, seconds))
    }

    fn act(
        &mut self,
        commands: &[f64],
        next: impl Fn(&mut ActuatorState, &Actuator, usize, f64, f64) -> f64,
    ) -> &[f64] {
        if self.acting.is_empty() {
            self.step(commands);
            self.acting
                .iter_mut()
                .zip(commands)
                .for_each(|(own, command)| *own = ActuatorState::begun(*command));
            return &self.exogenous[..self.vessel.model.inputs];
        }
        let each = self.acting.iter_mut().zip(commands).zip(&self.vessel.actuators);
        for (i, (setting, ((acting, command), own))) in self.exogenous.iter_mut().zip(each).enumerate() {
            *setting = next(acting, own, i, *command, self.sample_s);
        }
        self.advance();
        &self.exogenous[..self.vessel.model.inputs]
    }

    /// Advances by one sample under `inputs`, regardless of the actuators.
    pub fn step(&mut self, inputs: &[f64]) {
        self.acting.clear();
        self.acting.extend(inputs.iter().map(|input| ActuatorState::at(*input)));
        self.exogenous.iter_mut().zip(inputs).for_each(|(to, from)| *to = *from);
        self.advance();
    }

    /// x(k+1) = x(k) + θᵀφ, then the pose by an explicit Euler step.
    fn advance(&mut self) {
        let (sin, cos) = libm::sincos(self.pose.psi);
        let changes = self.changing.as_mut().and_then(Iterator::next);
        let [north, east] = match changes {
            None => self.current_m_s,
            Some((change, _)) => [0, 1].map(|d| self.current_m_s[d] + change[d]),
        };
        let current = Some([north * cos + east * sin, east * cos - north * sin]);
        self.vessel.model.complete(&mut self.exogenous);
        self.pose.move_on(self.state, self.sample_s, (sin, cos));
        let ambient = Ambient { current, force: changes.map(|(_, force)| force) };
        self.state = self.model.step(self.state, &self.exogenous, ambient);
    }
}
