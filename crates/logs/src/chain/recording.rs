use std::f64::consts::{PI, TAU};

use ship::engine::{Ambient, Compiled, Diverged, Helm, Origin, Pose, Seen, Streams, check_diverged};
use ship::model::Model;

use super::{Actuator, Compass, GaussMarkov, Gnss, Hits, Hull, Logged, Weather, quantised};
use crate::{Allocation, Setting, Unreachable, body_velocity};

/// A ship with its thrusters and its sensors.
#[derive(Clone, Debug)]
pub struct Chain<'a> {
    /// The structure; its first three inputs are τ1, τ2, τ3.
    pub model: &'a Model,
    /// The model's parameters.
    pub parameters: &'a [f64],
    /// Samples per second, of the model and of the logs.
    pub rate_hz: f64,
    /// The factors from newtons and newton metres to the model's inputs.
    pub units: [f64; 3],
    /// The thrusters.
    pub actuators: &'a [Actuator],
    /// The position sensor.
    pub gnss: Gnss,
    /// The heading sensor.
    pub compass: Compass,
    /// The hull that the wind acts on; without it there is no wind.
    pub hull: Option<Hull>,
    /// Relative scatter of the forces between repeats, because a maneuver is never repeated exactly.
    pub scatter_std: f64,
    /// Heading at the start \[rad\]; drawn if absent.
    pub course_rad: Option<f64>,
}

/// The key of a recording's random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key<'a> {
    /// The study's seed.
    pub seed: u64,
    /// The maneuver.
    pub maneuver: &'a str,
    /// Its repeat, from 0.
    pub repeat: u32,
}

/// What a ship is commanded to do.
#[derive(Clone, Debug)]
pub struct Commanded {
    /// The forces τ1, τ2, τ3 in the model's units; the helmsman sees the true motion.
    pub helm: Helm,
    /// Whether it is carried out to the other side.
    pub is_mirrored: bool,
    /// State at the start: u, v over ground \[m/s\], r \[rad/s\].
    pub initial: [f64; 3],
    /// For so many samples.
    pub samples: usize,
}

impl Commanded {
    /// What the helmsman sees of a motion and a place: of a mirrored maneuver, their mirror image.
    fn seen(&self, state: [f64; 3], pose: Pose) -> Seen {
        let side = self.side();
        let state = [state[0], side * state[1], side * state[2]];
        Seen { state, own: state, pose: Pose { x: pose.x, y: side * pose.y, psi: side * pose.psi } }
    }

    fn side(&self) -> f64 {
        if self.is_mirrored { -1.0 } else { 1.0 }
    }
}

/// What was logged, a row per sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// North and east \[m\] at the rows with a fix.
    pub fixes: Vec<Option<[f64; 2]>>,
    /// Heading, from 0 to 2π \[rad\].
    pub heading: Vec<f64>,
    /// Per row and thruster: speed \[1/s\] and angle, from −π to π \[rad\].
    pub settings: Vec<Vec<Setting>>,
    /// Per thruster, how often it could not follow its command.
    pub hits: Vec<Hits>,
    /// The true motion.
    pub truth: Truth,
}

/// The true motion and forces, a row per sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// u, v \[m/s\] over ground, r \[rad/s\].
    pub states: Vec<[f64; 3]>,
    /// Position and heading.
    pub poses: Vec<Pose>,
    /// Of the thrusters, in the model's units.
    pub forces: Vec<[f64; 3]>,
    /// The thrusters' settings.
    pub settings: Vec<Vec<Setting>>,
    /// Their commands.
    pub commands: Vec<Vec<Setting>>,
}

/// Why a recording could not be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Failed {
    /// The thrusters cannot produce the forces of sample `sample`.
    Unreachable {
        /// The sample.
        sample: usize,
        /// The force that cannot be produced, in N and N m.
        what: Unreachable,
    },
    /// The motion diverges.
    Diverged(Diverged),
}

/// Channels of the random streams. Each thruster has two from `THRUSTER` on.
mod channel {
    pub const HEADING_AT_START: u32 = 0;
    pub const SCATTER: u32 = 1;
    pub const CURRENT: [u32; 2] = [2, 3];
    pub const GUST: u32 = 4;
    pub const FIX: [u32; 2] = [5, 6];
    pub const FIX_WANDER: [u32; 2] = [7, 8];
    pub const HEADING: u32 = 9;
    pub const HEADING_WANDER: u32 = 10;
    pub const THRUSTER: u32 = 11;
}

/// Number of headings at the start, which is drawn uniformly.
const HEADINGS: u32 = 3600;

/// The keyed source of everything random in a recording.
struct Draws<'a> {
    streams: Streams,
    key: Key<'a>,
    rows: usize,
    dt: f64,
}

impl Draws<'_> {
    fn process(&self, channel: u32, std: f64, time_s: f64) -> Vec<f64> {
        GaussMarkov { std, time_s }.samples(&self.streams, self.key.repeat, channel, self.rows, self.dt)
    }

    fn white(&self, channel: u32, std: f64) -> Vec<f64> {
        self.process(channel, std, 0.0)
    }

    fn heading(&self) -> f64 {
        let drawn = self.streams.choices(self.key.repeat, channel::HEADING_AT_START, HEADINGS, 1);
        TAU * f64::from(drawn[0]) / f64::from(HEADINGS)
    }
}

/// Water and air at every sample.
struct Sea {
    /// Velocity of the water, north and east.
    water: Vec<[f64; 2]>,
    /// Velocity of the air, north and east; empty without wind.
    air: Vec<[f64; 2]>,
}

impl Sea {
    fn new(weather: &Weather, draws: &Draws) -> Self {
        let drift = &weather.current;
        let changing = channel::CURRENT.map(|c| draws.process(c, drift.std_m_s, drift.time_s.unwrap_or(0.0)));
        let water = changing[0].iter().zip(&changing[1]);
        let air = weather.wind.map_or(Vec::new(), |wind| {
            let gusts = draws.process(channel::GUST, wind.gust_std_m_s, wind.gust_time_s.unwrap_or(0.0));
            gusts.iter().map(|gust| wind.velocity(wind.speed_m_s + gust)).collect()
        });
        Self { water: water.map(|(n, e)| [drift.north_m_s + n, drift.east_m_s + e]).collect(), air }
    }

    /// The current in body axes, and the wind's forces \[N, N m\], on a ship at `state` with heading `psi`.
    fn acts(&self, sample: usize, state: [f64; 3], psi: f64, hull: Option<&Hull>) -> ([f64; 2], [f64; 3]) {
        let forces = hull.zip(self.air.get(sample)).map_or([0.0; 3], |(hull, air)| {
            let air = body_velocity(*air, psi);
            hull.forces([state[0] - air[0], state[1] - air[1]])
        });
        (body_velocity(self.water[sample], psi), forces)
    }
}

impl Chain<'_> {
    /// Simulates what is `commanded` in `weather`, and logs the instruments from row `from` on.
    ///
    /// # Errors
    /// Forces that the thrusters cannot produce; a motion that diverges.
    pub fn record(
        &self,
        key: Key,
        commanded: &Commanded,
        weather: &Weather,
        from: usize,
    ) -> Result<Recording, Failed> {
        let streams = Streams::new(key.seed, &format!("logs {}", key.maneuver));
        let draws = Draws { streams, key, rows: commanded.samples, dt: 1.0 / self.rate_hz };
        let (truth, hits) = self.simulate(&draws, commanded, weather)?;
        Ok(self.logged(&draws, truth, hits, from))
    }

    fn simulate(
        &self,
        draws: &Draws,
        orders: &Commanded,
        weather: &Weather,
    ) -> Result<(Truth, Vec<Hits>), Failed> {
        let allocation = Allocation::new(self.actuators.iter().map(Actuator::thruster).collect());
        let sea = Sea::new(weather, draws);
        let scatter = 1.0 + self.scatter_std * draws.white(channel::SCATTER, 1.0).first().unwrap_or(&0.0);
        let mut hits = vec![Hits::default(); self.actuators.len()];
        let mut at: Option<Vec<Setting>> = None;
        let mut truth = Truth::default();
        let (mut state, mut pose) = (
            orders.initial,
            Pose { psi: self.course_rad.unwrap_or_else(|| draws.heading()), ..Pose::default() },
        );
        let still = vec![Setting::default(); self.actuators.len()];
        let mut model = Compiled::new(self.model, self.parameters);
        let (origin, mut command, mut wanted) = (Origin::from(pose), orders.helm.begin(), [0.0; 3]);
        for sample in 0..orders.samples {
            command.command(&orders.seen(state, origin.sees(pose)), &mut wanted);
            let wanted = [wanted[0], orders.side() * wanted[1], orders.side() * wanted[2]];
            let newtons = [0, 1, 2].map(|i| scatter * wanted[i] / self.units[i]);
            let near = at.as_deref().unwrap_or(&still);
            let commanded =
                allocation.settings(newtons, near).map_err(|what| Failed::Unreachable { sample, what })?;
            let settings = self.follow(at.as_deref(), &commanded, draws.dt, &mut hits);
            let made = allocation.forces(&settings);
            truth.states.push(state);
            truth.poses.push(pose);
            truth.forces.push([0, 1, 2].map(|i| made[i] * self.units[i]));
            let (current, forces) = sea.acts(sample, state, pose.psi, self.hull.as_ref());
            let exogenous = self.exogenous(made, forces);
            let next = model.step(state, &exogenous, Ambient { current: Some(current), force: None });
            if let Some(Diverged { state, .. }) = check_diverged(next.into_iter()) {
                return Err(Failed::Diverged(Diverged { sample: sample + 1, state }));
            }
            pose = advance(pose, Pace { from: state, to: next }, draws.dt);
            state = next;
            truth.settings.push(settings.clone());
            truth.commands.push(commanded);
            at = Some(settings);
        }
        Ok((truth, hits))
    }

    fn follow(
        &self,
        at: Option<&[Setting]>,
        commanded: &[Setting],
        dt: f64,
        hits: &mut [Hits],
    ) -> Vec<Setting> {
        let of =
            |i: usize, hits: &mut Hits| self.actuators[i].follow(at.map(|at| at[i]), commanded[i], dt, hits);
        hits.iter_mut().enumerate().map(|(i, hits)| of(i, hits)).collect()
    }

    /// The model's exogenous inputs under thruster and wind forces \[N, N m\]. Derived channels are computed
    /// from the forces that the thrusters actually produce.
    fn exogenous(&self, thrusters: [f64; 3], wind: [f64; 3]) -> Vec<f64> {
        let mut exogenous = vec![0.0; self.model.exogenous()];
        let set = |exogenous: &mut [f64], forces: [f64; 3]| {
            exogenous.iter_mut().zip(forces).zip(self.units).for_each(|((to, f), unit)| *to = f * unit);
        };
        set(&mut exogenous, thrusters);
        self.model.complete(&mut exogenous);
        set(&mut exogenous, [0, 1, 2].map(|i| thrusters[i] + wind[i]));
        exogenous
    }

    /// The sensors' readings of `truth`.
    fn logged(&self, draws: &Draws, truth: Truth, hits: Vec<Hits>, from: usize) -> Recording {
        let (gnss, compass) = (&self.gnss, &self.compass);
        let error = |white: u32, wander: u32, stds: [f64; 2], time_s: Option<f64>| -> Vec<f64> {
            let slow = draws.process(wander, stds[1], time_s.unwrap_or(0.0));
            draws.white(white, stds[0]).iter().zip(slow).map(|(white, slow)| white + slow).collect()
        };
        let stds = [gnss.white_std_m, gnss.wander_std_m];
        let place =
            [0, 1].map(|i: usize| error(channel::FIX[i], channel::FIX_WANDER[i], stds, gnss.wander_time_s));
        let stds = [compass.white_std_rad, compass.wander_std_rad];
        let turn = error(channel::HEADING, channel::HEADING_WANDER, stds, compass.wander_time_s);
        let every = gnss.every(self.rate_hz).unwrap_or(1);
        let rows = from..truth.poses.len();
        let fix = |k: usize| {
            let pose = truth.poses[k];
            let at = [pose.x + place[0][k], pose.y + place[1][k]];
            (k - from).is_multiple_of(every).then(|| at.map(|metres| quantised(metres, gnss.resolution_m)))
        };
        let heading =
            |k: usize| quantised(truth.poses[k].psi + turn[k], compass.resolution_rad).rem_euclid(TAU);
        Recording {
            fixes: rows.clone().map(fix).collect(),
            heading: rows.clone().map(heading).collect(),
            settings: self.shown(draws, &truth, rows),
            hits,
            truth: truth.without(from),
        }
    }

    /// The readings of the thrusters' sensors, or their commands.
    fn shown(&self, draws: &Draws, truth: &Truth, rows: std::ops::Range<usize>) -> Vec<Vec<Setting>> {
        let noise: Vec<[Vec<f64>; 2]> = self
            .actuators
            .iter()
            .zip((channel::THRUSTER..).step_by(2))
            .map(|(a, c)| [draws.white(c, a.speed_std_rps), draws.white(c + 1, a.angle_std_rad)])
            .collect();
        let one = |k: usize, i: usize| {
            let (actuator, [speed, angle]) = (&self.actuators[i], &noise[i]);
            let setting = match actuator.logged {
                Logged::Setting => truth.settings[k][i],
                Logged::Command => truth.commands[k][i],
            };
            let alpha = quantised(setting.alpha + angle[k], actuator.angle_resolution_rad);
            Setting {
                n: quantised(setting.n + speed[k], actuator.speed_resolution_rps),
                alpha: (alpha + PI).rem_euclid(TAU) - PI,
            }
        };
        rows.map(|k| (0..self.actuators.len()).map(|i| one(k, i)).collect()).collect()
    }
}

impl Truth {
    /// Without the first `from` rows.
    fn without(mut self, from: usize) -> Self {
        self.states.drain(..from);
        self.poses.drain(..from);
        self.forces.drain(..from);
        self.settings.drain(..from);
        self.commands.drain(..from);
        self
    }
}

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
