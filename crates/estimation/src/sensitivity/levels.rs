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

/// Calls a function that is generic over the number of states with that of [`NoiseModel`], and takes a field of its
/// result.
macro_rules! with_states {
    ($levels:expr, $function:ident $arguments:tt $($field:tt)*) => {
        match $levels.states() {
            3 => $function::<3> $arguments $($field)*,
            5 => $function::<5> $arguments $($field)*,
            6 => $function::<6> $arguments $($field)*,
            7 => $function::<7> $arguments $($field)*,
            _ => $function::<8> $arguments $($field)*,
        }
    };
}
use regression::Noise;

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
        let force = self.gusts().map_or(String::new(), |own| {
            let [a, b, c] = own.factor.map(over);
            let times = if a == b && b == c { a } else { format!("{a}, {b} and {c}") };
            format!(", forces that add {} in a sample and drift over {times}", three(own.std))
        });
        let drift = self.drift.map_or(String::new(), |drift| {
            format!(", sensors that drift by {} over {}", three(drift.std), over(drift.factor))
        });
        format!(
            "most likely disturbances: noise of {u:.2e}, {v:.2e} m/s and {r:.2e} rad/s, {current}{force}{drift}"
        )
    }

    /// Number of states of vessel and disturbances together: 3, plus 2 for a correlated current, plus 3 for gusts; 7
    /// for drifting sensors, see [`super::Dynamics`].
    pub(crate) fn states(&self) -> usize {
        if self.drift.is_some() {
            return 7;
        }
        let current = if matches!(self.current, Flow::Markov { .. }) { 2 } else { 0 };
        3 + current + if self.gusts().is_some() { 3 } else { 0 }
    }

    /// The forces that are states of the filter.
    fn gusts(&self) -> Option<ForceNoise> {
        self.force.filter(|force| force.factor.iter().all(|factor| *factor < 1.0))
    }

    /// The same in other numbers, without constant forces, which are left to the intercepts.
    pub(crate) fn spread<X: From<f64>>(&self) -> NoiseModel<X> {
        let current = match self.current {
            Flow::Still => Flow::Still,
            Flow::White { std } => Flow::White { std: std.into() },
            Flow::Markov { std, factor, turning } => {
                Flow::Markov { std: std.into(), factor: factor.into(), turning: turning.into() }
            }
        };
        let gusts = |g: ForceNoise| ForceNoise { std: g.std.map(X::from), factor: g.factor.map(X::from) };
        let drift = |d: Drift| Drift { std: d.std.map(X::from), factor: d.factor.into() };
        NoiseModel {
            measurement: self.measurement.map(X::from),
            current,
            force: self.gusts().map(gusts),
            drift: self.drift.map(drift),
        }
    }
}

impl<X: Copy> NoiseModel<X> {
    /// The Gauss–Markov processes among the N states of levels that are [`NoiseModel::spread`]: state, standard deviation,
    /// correlation of neighbouring samples.
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
