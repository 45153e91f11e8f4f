use numerics::Lane;
use regression::Noise;
use ship::engine::{Compiled, Stepping};
use ship::model::Model;

use super::Unknowns;

/// The state transition of the N states: u, v, r, then the current's two components (N = 5, 8), then three forces
/// (N = 6, 8). With drifting sensors (N = 7) the first three states are the measured ones, including drift; the last
/// three are the drift itself, and the one between them stays zero.
#[derive(Clone, Debug)]
pub(crate) struct Dynamics<'m, X: Stepping, const N: usize> {
    pub model: Compiled<'m, X>,
    pub motion: Motion<X, N>,
}

/// The linear part of [`Dynamics`]: the transition of deviations of the states, and of the disturbances.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion<X, const N: usize> {
    current: X,
    turning: X,
    force: [X; 3],
    drift: X,
}

#[derive(Clone, Copy)]
pub(crate) struct Local<X> {
    pub slopes: [[X; 3]; 3],
    turn: Turn<X>,
}

/// A current over ground turns with the heading: cosine and sine, and the derivatives of its components by r.
#[derive(Clone, Copy)]
struct Turn<X> {
    cos: X,
    sin: X,
    by_r: [X; 2],
}

const fn current(n: usize) -> bool {
    n == 5 || n == 8
}

const fn force(n: usize) -> bool {
    n == 6 || n == 8
}

const fn drift(n: usize) -> bool {
    n == 7
}

impl<'m, X: Unknowns, const N: usize> Dynamics<'m, X, N> {
    pub(crate) fn new(model: &'m Model, theta: &[X], levels: Option<&NoiseModel<X>>) -> Self {
        Self { model: Compiled::new(model, theta), motion: Motion::new(levels) }
    }

    #[inline(always)]
    pub(crate) fn at(&mut self, z: &[X; N], exogenous: &[X]) -> Local<X> {
        let water = if current(N) { Some([z[3], z[4]]) } else { None };
        self.model.look(vessel_state(z), exogenous, water);
        Local { slopes: self.model.slopes(), turn: self.motion.turn(z) }
    }

    #[inline(always)]
    pub(crate) fn next(&self, z: &[X; N], local: &Local<X>) -> [X; N] {
        let forces = force(N).then(|| [z[N - 3], z[N - 2], z[N - 1]]);
        self.motion.next(z, self.model.next(vessel_state(z), forces), local)
    }
}

/// u, v, r of the vessel itself, without the drift of its sensors.
#[inline(always)]
pub(crate) fn vessel_state<X: Unknowns, const N: usize>(z: &[X; N]) -> [X; 3] {
    match drift(N) {
        true => [z[0] - z[N - 3], z[1] - z[N - 2], z[2] - z[N - 1]],
        false => [z[0], z[1], z[2]],
    }
}

/// The components of the current among the states; `None` in still water.
#[inline(always)]
pub(crate) fn current_of<X: Unknowns, const N: usize>(z: &[X; N]) -> Option<[X; 2]> {
    current(N).then(|| [z[3], z[4]])
}

impl<X: Unknowns, const N: usize> Motion<X, N> {
    pub(crate) fn new(levels: Option<&NoiseModel<X>>) -> Self {
        let (current, turning) = match levels.map(|l| l.current) {
            Some(Flow::Markov { factor, turning, .. }) => (factor, turning),
            _ => (X::ZERO, X::ZERO),
        };
        let force = levels.and_then(|l| l.force).map_or([X::ZERO; 3], |gusts| gusts.factor);
        let drift = levels.and_then(|l| l.drift).map_or(X::ZERO, |drift| drift.factor);
        Self { current, turning, force, drift }
    }

    /// The dynamics at the states `z`, where the model's derivatives by its states are `slopes`.
    #[inline(always)]
    pub(crate) fn local(&self, z: &[X; N], slopes: [[X; 3]; 3]) -> Local<X> {
        Local { slopes, turn: self.turn(z) }
    }

    #[inline(always)]
    fn turn(&self, z: &[X; N]) -> Turn<X> {
        if !current(N) {
            return Turn { cos: X::ONE, sin: X::ZERO, by_r: [X::ZERO; 2] };
        }
        // Polynomials: to 1e-9 for turns of up to 0.15 rad per sample.
        let angle = self.turning * z[2];
        let square = angle * angle;
        let cos = X::ONE + square * (X::from(-0.5) + square * X::from(1.0 / 24.0));
        let sin = angle * (X::ONE + square * (X::from(-1.0 / 6.0) + square * X::from(1.0 / 120.0)));
        let by_r = [cos * z[4] - sin * z[3], X::ZERO - (cos * z[3] + sin * z[4])];
        Turn { cos, sin, by_r: by_r.map(|by| self.turning * by) }
    }

    #[inline(always)]
    pub(crate) fn next(&self, z: &[X; N], vessel: [X; 3], local: &Local<X>) -> [X; N] {
        let mut next = *z;
        next[..3].copy_from_slice(&vessel);
        if current(N) {
            [next[3], next[4]] = local.turn.of([z[3], z[4]]).map(|c| self.current * c);
        }
        for d in 0..3 {
            if force(N) {
                next[N - 3 + d] = self.force[d] * z[N - 3 + d];
            }
            if drift(N) {
                next[N - 3 + d] = self.drift * z[N - 3 + d];
                next[d] += next[N - 3 + d];
            }
        }
        next
    }

    /// A s, A being the derivative of the next states, for a column of s.
    #[inline(always)]
    pub(crate) fn forward(&self, local: &Local<X>, s: &[Lane; N]) -> [Lane; N] {
        let mut out = *s;
        let mut vessel = [s[0], s[1], s[2]];
        if drift(N) {
            (0..3).for_each(|d| vessel[d] = s[d] - s[N - 3 + d]);
        }
        let (x, y) = if current(N) { (s[0] - s[3], s[1] - s[4]) } else { (vessel[0], vessel[1]) };
        for (d, slope) in local.slopes.iter().enumerate() {
            let by_r = slope[2].lane().fused(vessel[2], vessel[d]);
            out[d] = slope[0].lane().fused(x, slope[1].lane().fused(y, by_r));
            if force(N) {
                out[d] += s[N - 3 + d];
            }
        }
        if current(N) {
            [out[3], out[4]] = local.turn.forward([s[3], s[4]], s[2]).map(|c| self.current.lane() * c);
        }
        for d in 0..3 {
            if force(N) {
                out[N - 3 + d] = self.force[d].lane() * s[N - 3 + d];
            }
            if drift(N) {
                out[N - 3 + d] = self.drift.lane() * s[N - 3 + d];
                out[d] += out[N - 3 + d];
            }
        }
        out
    }

    /// Aᵀ λ for a column of λ.
    #[inline(always)]
    pub(crate) fn backward(&self, local: &Local<X>, adjoint: &[Lane; N]) -> [Lane; N] {
        let mut out = *adjoint;
        let [surge, sway, yaw] = &local.slopes;
        let through = |i: usize, start: Lane| {
            let by_yaw = yaw[i].lane().fused(adjoint[2], start);
            surge[i].lane().fused(adjoint[0], sway[i].lane().fused(adjoint[1], by_yaw))
        };
        for i in 0..3 {
            out[i] = through(i, adjoint[i]);
        }
        if current(N) {
            let (kept, [cos, sin, along, across]) = (self.current.lane(), local.turn.lanes());
            out[2] += kept * (along * adjoint[3] + across * adjoint[4]);
            out[3] = kept * (cos * adjoint[3] - sin * adjoint[4]) - through(0, Lane::ZERO);
            out[4] = kept * (sin * adjoint[3] + cos * adjoint[4]) - through(1, Lane::ZERO);
        }
        for d in 0..3 {
            if force(N) {
                out[N - 3 + d] = adjoint[d] + self.force[d].lane() * adjoint[N - 3 + d];
            }
            if drift(N) {
                out[N - 3 + d] = self.drift.lane() * (adjoint[d] + adjoint[N - 3 + d]) - out[d];
            }
        }
        out
    }
}

impl<X: Unknowns> Turn<X> {
    #[inline(always)]
    fn of(&self, [along, across]: [X; 2]) -> [X; 2] {
        [self.cos * along + self.sin * across, self.cos * across - self.sin * along]
    }

    #[inline(always)]
    fn forward(&self, [along, across]: [Lane; 2], r: Lane) -> [Lane; 2] {
        let [cos, sin, by_along, by_across] = self.lanes();
        [cos * along + sin * across + by_along * r, cos * across - sin * along + by_across * r]
    }

    #[inline(always)]
    fn lanes(&self) -> [Lane; 4] {
        [self.cos, self.sin, self.by_r[0], self.by_r[1]].map(X::lane)
    }
}

/// Correlation of neighbouring samples from which a current counts as constant.
const LASTING: f64 = 1.0 - 1e-6;

/// The known disturbances of a run; `X`: of runs in lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseModel<X = f64> {
    /// Standard deviations of white noise in the measured u, v \[m/s\] and r \[rad/s\].
    pub measurement: [X; 3],
    /// The current.
    pub current: Flow<X>,
    /// Forces that no term describes, such as wind.
    pub force: Option<ForceNoise<X>>,
    /// Correlated errors of the sensors; not together with forces or a correlated current.
    pub drift: Option<Drift<X>>,
}

/// A current's components, independent of each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flow<X = f64> {
    /// Still water.
    Still,
    /// New at every sample, in body axes.
    White {
        /// Standard deviation of each component \[m/s\].
        std: X,
    },
    /// A Gauss–Markov process c(k+1) = factor · c(k) + white noise, stationary.
    Markov {
        /// Standard deviation of each component \[m/s\].
        std: X,
        /// Correlation of neighbouring samples; 1: constant over a run.
        factor: X,
        /// Sampling interval \[s\] if the process is in earth axes and turns with the heading, 0 in body axes.
        turning: X,
    },
}

/// Forces as Gauss–Markov processes in body axes. Constant ones are left to the intercepts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceNoise<X = f64> {
    /// Standard deviations of the increments of u, v \[m/s\] and r \[rad/s\] per sample.
    pub std: [X; 3],
    /// Correlation of neighbouring samples of each, below 1.
    pub factor: [X; 3],
}

/// Errors of the sensors of u, v, r as Gauss–Markov processes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift<X = f64> {
    /// Standard deviations \[m/s, m/s, rad/s\].
    pub std: [X; 3],
    /// Correlation of neighbouring samples, of all three.
    pub factor: X,
}

/// Calls a function that is generic over the number of states with this one, and takes a field of its result.
macro_rules! with_states {
    ($states:expr, $function:ident $arguments:tt $($field:tt)*) => {
        match $states {
            3 => $function::<3> $arguments $($field)*,
            5 => $function::<5> $arguments $($field)*,
            6 => $function::<6> $arguments $($field)*,
            7 => $function::<7> $arguments $($field)*,
            _ => $function::<8> $arguments $($field)*,
        }
    };
}

pub(crate) use with_states;

impl NoiseModel {
    /// The same as white noise; `None` with a force or a correlated current.
    pub fn white(&self) -> Option<Noise> {
        let current = match (self.current, self.force, self.drift) {
            (Flow::Still, None, None) => 0.0,
            (Flow::White { std }, None, None) => std,
            _ => return None,
        };
        Some(Noise { measurement: self.measurement, current })
    }

    /// The filter's noise and current, in words; samples are `interval_s` \[s\] apart.
    pub(crate) fn words(&self, interval_s: f64) -> String {
        let [u, v, r] = self.measurement;
        let current = match self.current {
            Flow::Still => "still water".to_owned(),
            Flow::White { std } => format!("a current of {std:.2e} m/s that is new at every sample"),
            Flow::Markov { std, factor, .. } if factor < LASTING => {
                format!(
                    "a current of {std:.2e} m/s that changes over {:.3} s",
                    -interval_s / libm::log(factor)
                )
            }
            Flow::Markov { std, .. } => format!("a current of {std:.2e} m/s that stays"),
        };
        let over = |factor: f64| format!("{:.3} s", -interval_s / libm::log(factor));
        let three = |std: [f64; 3]| format!("{:.2e}, {:.2e} m/s and {:.2e} rad/s", std[0], std[1], std[2]);
        let force = self.gusts().map_or(String::new(), |force| {
            let [a, b, c] = force.factor.map(over);
            let times = if a == b && b == c { a } else { format!("{a}, {b} and {c}") };
            format!(", forces that add {} in a sample and drift over {times}", three(force.std))
        });
        let drift = self.drift.map_or(String::new(), |drift| {
            format!(", sensors that drift by {} over {}", three(drift.std), over(drift.factor))
        });
        format!(
            "most likely disturbances: noise of {u:.2e}, {v:.2e} m/s and {r:.2e} rad/s, {current}{force}{drift}"
        )
    }

    /// Number of states: 3, plus 2 for a correlated current, plus 3 for gusts; 7 for drifting sensors.
    pub(crate) fn states(&self) -> usize {
        if self.drift.is_some() {
            return 7;
        }
        let current = if matches!(self.current, Flow::Markov { .. }) { 2 } else { 0 };
        3 + current + if self.gusts().is_some() { 3 } else { 0 }
    }

    fn gusts(&self) -> Option<ForceNoise> {
        self.force.filter(|force| force.factor.iter().all(|factor| *factor < 1.0))
    }

    /// The same in other numbers, without constant forces, which are left to the intercepts.
    pub(crate) fn spread<X: From<f64>>(&self) -> NoiseModel<X> {
        NoiseModel { force: self.gusts(), ..*self }.map(X::from)
    }
}

impl<X: Copy> NoiseModel<X> {
    pub(crate) fn map<Y>(self, of: impl Fn(X) -> Y) -> NoiseModel<Y> {
        let current = match self.current {
            Flow::Still => Flow::Still,
            Flow::White { std } => Flow::White { std: of(std) },
            Flow::Markov { std, factor, turning } => {
                Flow::Markov { std: of(std), factor: of(factor), turning: of(turning) }
            }
        };
        let force =
            |force: ForceNoise<X>| ForceNoise { std: force.std.map(&of), factor: force.factor.map(&of) };
        let drift = |drift: Drift<X>| Drift { std: drift.std.map(&of), factor: of(drift.factor) };
        let (force, drift) = (self.force.map(force), self.drift.map(drift));
        NoiseModel { measurement: self.measurement.map(&of), current, force, drift }
    }

    /// The Gauss–Markov processes among N [`NoiseModel::spread`] states: state, standard deviation, correlation.
    #[inline(always)]
    pub(crate) fn processes<const N: usize>(self) -> impl Iterator<Item = (usize, X, X)> {
        let current = match self.current {
            Flow::Markov { std, factor, .. } => Some([(3, std, factor), (4, std, factor)]),
            _ => None,
        };
        let gusts = self.force.map(|g| [0, 1, 2].map(|d: usize| (N - 3 + d, g.std[d], g.factor[d])));
        let drift = self.drift.map(|b| [0, 1, 2].map(|d: usize| (N - 3 + d, b.std[d], b.factor)));
        current.into_iter().flatten().chain([gusts, drift].into_iter().flatten().flatten())
    }
}
