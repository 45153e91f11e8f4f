//! The criterion of one experiment, with the intermediate results that its gradient needs.

use numerics::{Lane, dot, product};
use regression::Noise;
use ship::engine::check_diverged;
use ship::model::Model;

use crate::sensitivity::{Recordings, RunInformation, Sensitivities};

/// tr(G cov θ̃) of an output-error estimate from one run: G is diagonal, zero for intercepts.
#[derive(Clone, Copy, Debug)]
pub struct TraceCriterion<'a> {
    /// The model.
    pub model: &'a Model,
    /// The parameters that it is simulated with.
    pub parameters: &'a [f64],
    /// Weight of every parameter's variance.
    pub weights: &'a [f64],
    /// The disturbances of the run.
    pub noise: Noise,
    /// State at the start: u, v \[m/s\], r \[rad/s\].
    pub initial: [f64; 3],
}

/// The forward pass of a run, with all that the backward pass needs. n parameters with intercepts, N samples.
#[derive(Clone, Debug)]
pub struct Forward {
    /// (N+1) × 3.
    pub states: Vec<f64>,
    /// tr(G cov θ̃).
    pub value: f64,
    /// tr(G F⁻¹E F⁻¹): its value without current.
    pub measurement_value: f64,
    /// Variance of every parameter.
    pub variances: Vec<f64>,
    /// F of the whole run, n × n.
    pub information: Vec<f64>,
    /// S(k), k = 0 to N.
    pub(super) path: Sensitivities<f64>,
    /// Columns of λ(k) of the current, k = N to 1; empty without current.
    pub(super) adjoints: Vec<[Lane; 3]>,
    /// E + P.
    pub(super) meat: Vec<f64>,
    /// F⁻¹.
    pub(super) inverse: Vec<f64>,
}

impl Forward {
    /// Root of the criterion.
    pub fn parameter_error(&self) -> f64 {
        self.value.sqrt()
    }

    /// Of every parameter.
    pub fn standard_errors(&self) -> impl Iterator<Item = f64> {
        self.variances.iter().map(|v| v.max(0.0).sqrt())
    }

    /// log|det| of the information of one of its `samples`, on average; `None` if that is singular.
    pub fn log_det(&self, samples: u64) -> Option<f64> {
        let mut mean: Vec<f64> = self.information.iter().map(|f| f / samples as f64).collect();
        numerics::log_det(self.information.len().isqrt(), &mut mean).map(|found| found.log_abs)
    }

    /// −log of the criterion of one of its `samples`, by which designs are compared.
    pub fn log_value(&self, samples: u64) -> f64 {
        -libm::log(self.value * samples as f64)
    }
}

impl TraceCriterion<'_> {
    /// The criterion of a run of `exogenous`, N × (inputs and measured disturbances). `None` if the simulation
    /// diverges or the run has no information about a direction of the parameters.
    pub fn forward(&self, exogenous: &[f64]) -> Option<Forward> {
        let (model, parameters) = self.lifted();
        let run = Recordings::simulated(&model, self.initial, exogenous);
        let mut adjoints = Vec::new();
        let keep = |own: &[[Lane; 3]]| adjoints.extend_from_slice(own);
        let mut found = RunInformation::by(&run, &parameters, &self.noise, Sensitivities::default(), keep);
        let states = std::mem::take(&mut found.path.states);
        if check_diverged(states.iter().copied()).is_some() {
            return None;
        }
        let n = parameters.len();
        let inverse = inverse(n, &found.information)?;
        let meat = found.meat();
        let layout = model.layout();
        let counted = layout.woven(self.weights, [0.0; 3]);
        let trace = |variances: &[f64]| counted.iter().zip(variances).map(|(g, v)| g * v).sum::<f64>();
        let all = sandwich(n, &inverse, &meat);
        let (value, measurement_value) = (trace(&all), trace(&sandwich(n, &inverse, &found.measurement)));
        (value.is_finite() && value > 0.0).then(|| Forward {
            states,
            value,
            measurement_value,
            variances: layout.theta(&all),
            information: found.information,
            path: found.path,
            adjoints,
            meat,
            inverse,
        })
    }

    /// The model with intercepts, which are zero.
    pub(super) fn lifted(&self) -> (Model, Vec<f64>) {
        let model = self.model.with_intercepts();
        let parameters = model.layout().woven(self.parameters, [0.0; 3]);
        (model, parameters)
    }
}

/// The matrix with a unit diagonal is singular if its inverse has an entry above this.
const SINGULAR: f64 = 1e13;

/// F⁻¹, through the matrix with a unit diagonal.
fn inverse(n: usize, information: &[f64]) -> Option<Vec<f64>> {
    let unit: Vec<f64> = (0..n).map(|i| information[i * n + i].sqrt().recip()).collect();
    let scale = |m: &mut [f64]| (0..n * n).for_each(|e| m[e] *= unit[e / n] * unit[e % n]);
    let mut scaled = information.to_vec();
    scale(&mut scaled);
    let mut out = vec![0.0; n * n];
    numerics::inverse(n, &mut scaled, &mut out)?;
    let regular = out.iter().all(|x| x.abs() <= SINGULAR);
    scale(&mut out);
    let positive = (0..n).all(|i| out[i * n + i] > 0.0);
    (regular && positive && out.iter().all(|x| x.is_finite())).then_some(out)
}

/// The diagonal of C B C, C symmetric.
fn sandwich(n: usize, c: &[f64], b: &[f64]) -> Vec<f64> {
    product(n, c, b).chunks_exact(n).zip(c.chunks_exact(n)).map(|(row, c)| dot(row, c)).collect()
}
