use std::array::from_fn;
use std::fmt::Debug;
use std::sync::Arc;

use numerics::{Lane, Wide, vectorized};

use crate::engine::simulate::{AT_ONCE, Follow, mark_beyond};
use crate::engine::{Ambient, Compiled, Recording};
use crate::model::Model;

/// A run under commands, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct Commanded {
    /// N × exogenous.
    pub exogenous: Vec<f64>,
    /// What was commanded: N × inputs. It differs from the inputs where actuators follow it.
    pub commands: Vec<f64>,
    /// u, v \[m/s\], r \[rad/s\]: (N+1) × 3.
    pub states: Vec<f64>,
}

/// The inputs of runs in lanes, row-major.
pub struct Driving<'a> {
    /// N × exogenous.
    pub exogenous: &'a mut [Lane],
    /// What was commanded, N × inputs; empty where it is not needed.
    pub commands: &'a mut [Lane],
}

/// Simulates one run in still water under commands. The helmsman sees the true states.
pub fn simulate_command(
    model: &Model,
    parameters: &[f64],
    initial: [f64; 3],
    samples: usize,
    rate_hz: f64,
    helm: &Helm,
) -> Commanded {
    let width = model.exogenous().max(1);
    let mut compiled = Compiled::new(model, parameters);
    let mut helmsman = Helmsman::new(helm, width);
    let (mut exogenous, mut states) = (Vec::with_capacity(width * samples), initial.to_vec());
    let mut commands = Vec::with_capacity(model.inputs * samples);
    let mut state = initial;
    for _ in 0..samples {
        let row = helmsman.commands(model, state, state, rate_hz);
        exogenous.extend_from_slice(row);
        state = compiled.step(state, row, Ambient::default());
        states.extend(state);
        commands.extend_from_slice(helmsman.commanded(model));
    }
    Commanded { exogenous, commands, states }
}

/// Simulates and measures up to [`numerics::LANES`] disturbed runs, each commanded by its own of `helms`, who
/// see the measured states. `driving` is filled with their inputs. Returns a number above zero in lanes where a state
/// is beyond [`crate::engine::DIVERGED`] or not finite.
pub fn simulate_commanded(
    model: &Model,
    parameters: &[Lane],
    initial: [Lane; 3],
    helms: &[Helm],
    rate_hz: f64,
    recording: Recording,
    driving: Driving,
) -> Lane {
    let Driving { exogenous, commands } = driving;
    let Recording { mut disturbing, truth, measured } = recording;
    let width = model.exogenous().max(1);
    let mut helmsmen: Vec<Helmsman> = helms.iter().map(|helm| Helmsman::new(helm, width)).collect();
    let mut follow = Follow::<1>::new(model, parameters, initial.map(Wide::from));
    let mut beyond = Lane::ZERO;
    let (samples, mut noise) = (measured.len() / 3 - 1, [Lane::ZERO; 3 * AT_ONCE + 3]);
    for first in (0..samples.max(1)).step_by(AT_ONCE) {
        let count = samples.min(first + AT_ONCE) - first;
        let rows = count + usize::from(first + count == samples);
        let noise = &mut noise[..3 * rows];
        disturbing.noise(noise);
        let weather = disturbing.next(count);
        for i in 0..rows {
            let state = follow.state.map(|wide| wide.0[0]);
            let seen: [Lane; 3] = from_fn(|d| state[d] + noise[3 * i + d]);
            let k = first + i;
            for d in 0..3 {
                measured[3 * k + d] = state[d];
                mark_beyond(&mut beyond, state[d]);
                if let Some(entry) = truth.get_mut(3 * k + d) {
                    *entry = state[d];
                }
            }
            if i == count {
                break;
            }
            let row = &mut exogenous[width * k..width * (k + 1)];
            for (lane, helmsman) in helmsmen.iter_mut().enumerate() {
                let of = |states: [Lane; 3]| states.map(|lanes| lanes[lane]);
                let inputs = helmsman.commands(model, of(seen), of(state), rate_hz);
                row.iter_mut().zip(inputs).for_each(|(to, from)| to[lane] = *from);
                if !commands.is_empty() {
                    let to = commands[model.inputs * k..].iter_mut();
                    to.zip(helmsman.commanded(model)).for_each(|(to, from)| to[lane] = *from);
                }
            }
            let here = [weather.from(i)];
            vectorized!(follow.go(&&*row, 0..1, &here, &mut [&mut []]));
        }
        disturbing.measure(&mut measured[3 * first..3 * (first + rows)]);
    }
    beyond
}

/// A running command, and the pose of its ship.
struct Helmsman {
    command: Box<dyn Command>,
    pose: Pose,
    row: Vec<f64>,
}

impl Helmsman {
    fn new(helm: &Helm, width: usize) -> Self {
        Self { command: helm.begin(), pose: Pose::default(), row: vec![0.0; width] }
    }

    /// The exogenous inputs of a sample: the commanded ones for `seen`, and the ones that follow from them.
    fn commands(&mut self, model: &Model, seen: [f64; 3], state: [f64; 3], rate_hz: f64) -> &[f64] {
        let seen = Seen { state: seen, own: state, pose: self.pose };
        self.command.command(&seen, &mut self.row[..model.inputs]);
        model.complete(&mut self.row);
        self.pose.advance(state, 1.0 / rate_hz);
        &self.row
    }

    /// What was commanded in the last sample.
    fn commanded(&self, model: &Model) -> &[f64] {
        self.command.commanded().unwrap_or(&self.row[..model.inputs])
    }
}

/// The helmsman's view at the beginning of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// u, v \[m/s\], r \[rad/s\], as the logged sensors measure them.
    pub state: [f64; 3],
    /// The same by sensors of the helmsman's own, without noise.
    pub own: [f64; 3],
    /// Position and heading relative to the pose where the commands began.
    pub pose: Pose,
}

/// How far commands have come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// They wait for this before they may end.
    Waiting(&'static str),
    /// They may end at any time, and go on until then.
    Open,
    /// They have ended.
    Done,
}

/// A running sequence of commands: the one way into a ship.
pub trait Command: Send {
    /// Sets the inputs of the sample that begins with `seen`.
    fn command(&mut self, seen: &Seen, inputs: &mut [f64]);

    /// What was commanded in the last sample, where actuators followed it to the inputs that were set.
    fn commanded(&self) -> Option<&[f64]> {
        None
    }

    /// The inputs at the beginning and the end of the last sample, where they changed within it. Those set are their mean.
    fn ends(&self) -> Option<[&[f64]; 2]> {
        None
    }

    /// How far they have come after the last sample.
    fn progress(&self) -> Progress {
        Progress::Open
    }
}

/// A program of commands, which each run begins anew.
pub trait Program: Debug + Send + Sync {
    /// Begins its commands.
    fn begin(&self) -> Box<dyn Command>;

    /// Whether it tracks a motion at every sample, so that its inputs follow all that it sees.
    fn tracks(&self) -> bool {
        false
    }

    /// Its orders as a bridge gives them; `None` where only a table has them.
    fn spoken(&self) -> Option<&Spoken> {
        None
    }
}

/// Orders as a bridge gives them: `zig-zag 20/20`, first to a side, `order 20°, reverse at 20° off` the heading at the beginning.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Spoken {
    /// What is done.
    pub what: String,
    /// Whether it begins to a side.
    pub has_side: bool,
    /// How, up to the heading.
    pub how: String,
}

/// A shared program.
#[derive(Clone, Debug)]
pub struct Helm(Arc<dyn Program>);

impl Helm {
    /// Wraps a program.
    pub fn new(program: impl Program + 'static) -> Self {
        Self(Arc::new(program))
    }

    /// Commands inputs, N × inputs, row-major, regardless of the ship. The last ones are held.
    pub fn table(inputs: &[f64]) -> Self {
        Self::new(Table(inputs.into()))
    }

    /// Several programs in sequence, each for so many samples.
    pub fn sequence(parts: Vec<(Self, usize)>) -> Self {
        Self::new(Sequence(parts.into()))
    }

    /// Begins its commands.
    pub fn begin(&self) -> Box<dyn Command> {
        self.0.begin()
    }

    /// See [`Program::spoken`].
    pub fn spoken(&self) -> Option<&Spoken> {
        self.0.spoken()
    }

    /// See [`Program::tracks`].
    pub fn tracks(&self) -> bool {
        self.0.tracks()
    }
}

impl PartialEq for Helm {
    /// Whether both are the same program, not whether their commands are equal.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

#[derive(Debug)]
struct Table(Arc<[f64]>);

impl Program for Table {
    fn begin(&self) -> Box<dyn Command> {
        Box::new(Played { rows: Arc::clone(&self.0), next: 0 })
    }
}

/// A table while it runs.
struct Played {
    rows: Arc<[f64]>,
    next: usize,
}

impl Command for Played {
    fn command(&mut self, _: &Seen, inputs: &mut [f64]) {
        if let Some(row) = self.rows.chunks_exact(inputs.len().max(1)).nth(self.next) {
            inputs.copy_from_slice(row);
        }
        self.next += 1;
    }
}

#[derive(Debug)]
struct Sequence(Arc<[(Helm, usize)]>);

impl Program for Sequence {
    fn begin(&self) -> Box<dyn Command> {
        Box::new(InTurn { parts: Arc::clone(&self.0), next: 0, now: None, left: 0 })
    }
}

/// Programs in sequence, each with the pose where it began as its origin.
struct InTurn {
    parts: Arc<[(Helm, usize)]>,
    next: usize,
    now: Option<(Box<dyn Command>, Origin)>,
    left: usize,
}

impl Command for InTurn {
    fn command(&mut self, seen: &Seen, inputs: &mut [f64]) {
        while self.left == 0 {
            let Some((helm, samples)) = self.parts.get(self.next) else { break };
            (self.now, self.left) = (Some((helm.begin(), seen.pose.into())), *samples);
            self.next += 1;
        }
        self.left = self.left.saturating_sub(1);
        if let Some((command, from)) = &mut self.now {
            command.command(&Seen { pose: from.sees(seen.pose), ..*seen }, inputs);
        }
    }

    fn commanded(&self) -> Option<&[f64]> {
        self.now.as_ref().and_then(|(command, _)| command.commanded())
    }

    fn ends(&self) -> Option<[&[f64]; 2]> {
        self.now.as_ref().and_then(|(command, _)| command.ends())
    }
}

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
    /// Advances by `seconds` with body velocities over the ground \[m/s, m/s, rad/s\], by an explicit Euler step.
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
        let Self { pose: origin, sin, cos } = self;
        let [north, east] = [pose.x - origin.x, pose.y - origin.y];
        Pose { x: north * cos + east * sin, y: east * cos - north * sin, psi: pose.psi - origin.psi }
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
