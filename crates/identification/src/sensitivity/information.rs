//! What free simulation tells about the parameters: the information matrix and covariance of an output-error estimate.
//!
//! With s_d = ∂x_d/∂θ and the Jacobian J(k) = ∂(φᵀθ)/∂x at x(k): S(k+1) = (I + J(k)) S(k) + Φ(k), S(0) = 0; intercepts are among
//! the parameters. The estimate minimises Σ_k Σ_d w_d (y_d − x_d)²; its covariance is F⁻¹ (E + P) F⁻¹ with F = Σ Sᵀ W S,
//! E = Σ Sᵀ W R W S of the measurement errors and P of the current, which moves the vessel: δx(k+1) = (I + J) δx(k) − J c(k), so
//! that P = Σ_l λᵀ J σ_c² Jᵀ λ with the adjoint λ(k) = W S(k) + (I + J(k))ᵀ λ(k+1) at k = l + 1.

use vessel::{Lane, Model};

use super::adjoint::{add_draws, backward};
use super::levels::{Flow, Levels};
use super::products::Products;
use super::recordings::Recordings;
use super::sweep::{Sensitivities, Step, sweep};
use crate::Noise;

/// Information of one run about the parameters with intercepts, per sample: n × n matrices, row-major, symmetric, in the order
/// of [`vessel::ParameterLayout`].
#[derive(Clone, Debug, PartialEq)]
pub struct OutputInformation {
    /// F.
    pub information: Vec<f64>,
    /// E: what measurement errors add to the middle matrix; F where every channel is weighted by its variance.
    pub measurement: Vec<f64>,
    /// P: what the current adds.
    pub process: Vec<f64>,
}

impl OutputInformation {
    /// E + P.
    pub fn middle(&self) -> Vec<f64> {
        sum(&self.measurement, &self.process)
    }
}

/// Information of a run of `exogenous` (N × inputs and measured disturbances) from `initial`, simulated with `theta`. The
/// channels are weighted by their variances; evenly where one has none. `None` where the simulation is not finite.
pub fn output_information(
    model: &Model,
    theta: &[f64],
    initial: [f64; 3],
    exogenous: &[f64],
    noise: &Noise,
) -> Option<OutputInformation> {
    let model = model.with_intercepts();
    let parameters = model.layout().woven(theta, [0.0; 3]);
    let run = Recordings::simulated(&model, initial, exogenous);
    let told = Told::by(&run, &parameters, noise, |_| ());
    let share = 1.0 / run.longest().max(1) as f64;
    let mean = |matrix: Vec<f64>| -> Vec<f64> { matrix.into_iter().map(|entry| share * entry).collect() };
    let [information, measurement, process] = [told.information, told.measurement, told.process].map(mean);
    let finite = information.iter().chain(&process).all(|x| x.is_finite());
    finite.then_some(OutputInformation { information, measurement, process })
}

/// Mean over the samples of Sᵀ S, n × n, rows and columns of intercepts zero: the variance that parameters' errors give a
/// free run, summed over the states, is tr(cov G). `None` where the simulation is not finite.
pub fn prediction_weights(
    model: &Model,
    theta: &[f64],
    initial: [f64; 3],
    exogenous: &[f64],
) -> Option<Vec<f64>> {
    let model = model.with_intercepts();
    let layout = model.layout();
    let run = Recordings::simulated(&model, initial, exogenous);
    let (_, squares) = followed(&run, &layout.woven(theta, [0.0; 3]));
    let (n, share) = (layout.parameters(), 1.0 / run.longest().max(1) as f64);
    let counted: Vec<f64> = layout.are_intercepts().map(|is| if is { 0.0 } else { 1.0 }).collect();
    let entry = |e: usize| {
        let sum: f64 = squares.iter().map(|own| own[e]).sum();
        share * counted[e / n] * counted[e % n] * sum
    };
    let sum: Vec<f64> = (0..n * n).map(entry).collect();
    sum.iter().all(|x| x.is_finite()).then_some(sum)
}

/// What a run tells of the parameters: sums over its samples, n × n each.
pub(crate) struct Told {
    pub path: Sensitivities<f64>,
    /// F, E and P.
    pub information: Vec<f64>,
    pub measurement: Vec<f64>,
    pub process: Vec<f64>,
}

fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

impl Told {
    /// E + P.
    pub(crate) fn middle(&self) -> Vec<f64> {
        sum(&self.measurement, &self.process)
    }

    /// By `run`, simulated with `parameters`. `keep` is called with the columns of λ(k), for k from N to 1, where there is a
    /// current.
    pub(crate) fn by(
        run: &Recordings<f64>,
        parameters: &[f64],
        noise: &Noise,
        mut keep: impl FnMut(&[[Lane; 3]]),
    ) -> Self {
        let (path, squares) = followed(run, parameters);
        let (weights, variances) = channels(noise);
        let weighted = |by: [f64; 3]| -> Vec<f64> {
            (0..squares[0].len()).map(|e| (0..3).map(|d| by[d] * squares[d][e]).sum()).collect()
        };
        let information = weighted(weights);
        let measurement = weighted([0, 1, 2].map(|d: usize| weights[d] * weights[d] * variances[d]));
        let mut draws = Products::new(parameters.len());
        if noise.current > 0.0 {
            let current = Flow::White { std: noise.current };
            let levels = Levels { measurement: noise.measurement, current, force: None };
            backward(
                run,
                parameters,
                &path,
                weights,
                Some(&levels),
                #[inline(always)]
                |local, adjoints: &[[Lane; 3]]| {
                    add_draws(&mut draws, adjoints, local, &levels);
                    keep(adjoints);
                },
            );
        }
        Self { path, information, measurement, process: draws.finish().square() }
    }
}

/// Weights W of the channels and variances R of their errors: W = 1/R where no error is zero.
pub(crate) fn channels(noise: &Noise) -> ([f64; 3], [f64; 3]) {
    let variances = noise.measurement.map(|std| std * std);
    let known = variances.iter().all(|v| *v > 0.0);
    (if known { variances.map(f64::recip) } else { [1.0; 3] }, variances)
}

/// The run's states and sensitivities, and Σ s sᵀ of u, v and r.
fn followed(run: &Recordings<f64>, parameters: &[f64]) -> (Sensitivities<f64>, [Vec<f64>; 3]) {
    let n = parameters.len();
    let unknowns = [parameters, &[0.0; 3]].concat();
    let free: Vec<usize> = (0..n).collect();
    let mut path = Sensitivities::with_room(n, run.longest());
    let mut squares = [0; 3].map(|_| Products::<f64>::new(n));
    sweep(
        run,
        &unknowns,
        &free,
        None,
        &[],
        #[inline(always)]
        |step: Step<'_, f64, 3>| {
            path.keep(&step, 1.0);
            for (d, squares) in squares.iter_mut().enumerate() {
                for (c, s) in step.sensitivities.iter().enumerate() {
                    squares.set(c, s[d]);
                }
                squares.advance();
            }
        },
    );
    (path, squares.map(|own| own.finish().square()))
}
