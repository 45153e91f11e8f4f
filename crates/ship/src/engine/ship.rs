use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::engine::disturbance::{MOST_CURRENT_M_S, factor};
use crate::engine::{Ambient, Compiled, NormalRows, Pose, Streams, Wind};
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
        self.act(commands, |acting, actuator, i, command, seconds| {
            acting.follow(actuator, SampleCommand::of(i, command, ends), seconds)
        })
    }

    /// Advances by one sample with the actuators as near to `wanted` as commands take them; returns their settings.
    pub fn reach(&mut self, wanted: &[f64]) -> &[f64] {
        self.act(wanted, |acting, actuator, _, wanted, seconds| acting.reach(actuator, wanted, seconds))
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
                .for_each(|(state, command)| *state = ActuatorState::begun(*command));
            return &self.exogenous[..self.vessel.model.inputs];
        }
        let each = self.acting.iter_mut().zip(commands).zip(&self.vessel.actuators);
        for (i, (setting, ((acting, command), actuator))) in self.exogenous.iter_mut().zip(each).enumerate() {
            *setting = next(acting, actuator, i, *command, self.sample_s);
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

/// How water and air change while one ship sails, about a constant current: stationary Gauss–Markov processes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Changes {
    /// Of the current.
    pub current: Option<ChangingCurrent>,
    /// Gusts.
    pub wind: Option<Wind>,
}

/// Changes of a current, north and east, correlated as exp(−|t|/T).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChangingCurrent {
    /// Standard deviation of each component \[m/s\].
    #[schemars(range(min = 0.0, max = MOST_CURRENT_M_S))]
    pub std_m_s: f64,
    /// Time constant T \[s\].
    #[schemars(range(min = 1e-6, max = 1e9))]
    pub time_constant_s: f64,
}

impl Changes {
    /// Whether nothing changes.
    pub fn are_none(&self) -> bool {
        *self == Self::default()
    }

    /// Those of run `run` of `streams`; `None` where nothing changes.
    pub fn of_run(&self, streams: Streams, run: u32, rate_hz: f64) -> Option<Changing> {
        let [u, v, r] = self.wind.map_or([0.0; 3], |wind| wind.std_per_sample(rate_hz));
        let gust = self.wind.map_or(0.0, |wind| wind.factor(rate_hz));
        let (water, flow) = self
            .current
            .map_or((0.0, 0.0), |current| (current.std_m_s, factor(current.time_constant_s, rate_hz)));
        let (stds, factors) = ([water, water, u, v, r], [flow, flow, gust, gust, gust]);
        let noise = NormalRows::new(streams, run);
        (!self.are_none()).then_some(Changing { stds, factors, noise, at: None })
    }
}

/// North and east of the current, and what the wind adds to u, v and r.
const VALUES: usize = 5;

/// The changes of one run, drawn sample by sample: x(k+1) = factor · x(k) + white noise.
#[derive(Clone, Debug)]
pub struct Changing {
    stds: [f64; VALUES],
    factors: [f64; VALUES],
    noise: NormalRows<VALUES>,
    /// The last sample.
    at: Option<[f64; VALUES]>,
}

impl Iterator for Changing {
    /// Of the current, north and east \[m/s\], and of the states after the next sample \[m/s, m/s, rad/s\].
    type Item = ([f64; 2], [f64; 3]);

    fn next(&mut self) -> Option<Self::Item> {
        let noise = self.noise.next()?;
        let next = |i: usize| match self.at {
            None => self.stds[i] * noise[i],
            Some(at) => {
                let factor = self.factors[i];
                factor * at[i] + (1.0 - factor * factor).sqrt() * self.stds[i] * noise[i]
            }
        };
        let [north, east, u, v, r] = *self.at.insert(std::array::from_fn(next));
        Some(([north, east], [u, v, r]))
    }
}
