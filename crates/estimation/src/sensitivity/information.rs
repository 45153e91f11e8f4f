//! The information of free simulations about the parameters: the information matrix and covariance of an output-error
//! estimate.
//!
//! With s_d = ∂x_d/∂θ and the Jacobian J(k) = ∂(φᵀθ)/∂x at x(k): S(k+1) = (I + J(k)) S(k) + Φ(k), S(0) = 0;
//! intercepts are among the parameters. The estimate minimises Σ_k Σ_d w_d (y_d − x_d)²; its covariance is F⁻¹ (E +
//! P) F⁻¹ with F = Σ Sᵀ W S, E = Σ Sᵀ W R W S of the measurement errors and P of the current, which carries the
//! vessel: δx(k+1) = (I + J) δx(k) − J c(k), so that P = Σ_l λᵀ J σ_c² Jᵀ λ with the adjoint λ(k) = W S(k) + (I +
//! J(k))ᵀ λ(k+1) at k = l + 1.

use numerics::{LANES, Lane, lanes};
use regression::Noise;
use ship::engine::RunView;
use ship::model::{ForceModel, Model};

use super::dynamics::{Flow, NoiseModel};
use super::products::Products;
use super::sweep::{Sensitivities, Step, add_draws, backward, sweep};
use super::{Recordings, Unknowns};
use crate::fitting::{Inputs, SimulatedRun};

/// Information of one run about the parameters, those of terms with intercepts, per sample: n × n matrices, row-major, symmetric,
/// in the order of [`ship::model::ParameterLayout`].
#[derive(Clone, Debug, PartialEq)]
pub struct OutputInformation {
    /// F.
    pub information: Vec<f64>,
    /// E: the meat of measurement errors; F if every channel is weighted by its variance.
    pub measurement: Vec<f64>,
    /// P: the contribution of the current.
    pub process: Vec<f64>,
}

impl OutputInformation {
    /// E + P.
    pub fn middle(&self) -> Vec<f64> {
        sum(&self.measurement, &self.process)
    }
}

/// Information of a run of `exogenous` (N × inputs and measured disturbances) from `initial`, simulated with `theta`.
/// The channels are weighted by their variances; evenly if one has none. `None` if the simulation is not finite.
pub fn output_information(
    model: &Model,
    theta: &[f64],
    initial: [f64; 3],
    exogenous: &[f64],
    noise: &Noise,
) -> Option<OutputInformation> {
    if let Some(moved) = &model.forces {
        return of_forces(model, moved, &Simulated { theta, initial, exogenous }, noise);
    }
    let model = model.with_intercepts();
    let parameters = model.layout().woven(theta, [0.0; 3]);
    let run = Recordings::simulated(&model, initial, exogenous);
    RunInformation::by(&run, &parameters, noise, Sensitivities::default(), |_| ())
        .mean(run.longest(), |entry| *entry)
}

/// That of a ship with forces, by tangents of her steps.
fn of_forces(model: &Model, moved: &ForceModel, run: &Simulated, noise: &Noise) -> Option<OutputInformation> {
    let simulated = run.of_forces(model, moved);
    let sums = simulated.information(&moved.forces, run.theta, noise)?;
    let share = 1.0 / simulated.samples().max(1) as f64;
    let [information, process] =
        [sums.measurement, sums.current].map(|sum| sum.into_iter().map(|entry| share * entry).collect());
    Some(OutputInformation { measurement: Vec::clone(&information), information, process })
}

/// Sum over the samples of a run of what measurement errors alone leave to be known of the parameters: F of [`output_information`],
/// times their number. `None` if the simulation is not finite.
pub fn summed_information(model: &Model, run: &Simulated, noise: &Noise) -> Option<Vec<f64>> {
    let still = Noise { current: 0.0, ..*noise };
    let Some(moved) = &model.forces else {
        let Simulated { theta, initial, exogenous } = *run;
        let mean = output_information(model, theta, initial, exogenous, &still)?.information;
        let samples = (exogenous.len() / model.exogenous().max(1)) as f64;
        return Some(mean.into_iter().map(|entry| samples * entry).collect());
    };
    let sums = run.of_forces(model, moved).information(&moved.forces, run.theta, &still);
    sums.map(|sums| sums.measurement)
}

/// A run to be simulated with the parameters `theta`, see [`output_information`].
#[derive(Clone, Copy, Debug)]
pub struct Simulated<'a> {
    /// θ.
    pub theta: &'a [f64],
    /// u, v \[m/s\], r \[rad/s\].
    pub initial: [f64; 3],
    /// Inputs and measured disturbances, a row per sample.
    pub exogenous: &'a [f64],
}

impl<'a> Simulated<'a> {
    fn of_forces(&self, model: &Model, moved: &ForceModel) -> SimulatedRun<'a> {
        let (width, sample_s) = (model.exogenous(), moved.sample_s);
        SimulatedRun { initial: self.initial, inputs: self.exogenous, width, sample_s }
    }
}

/// [`output_information`] of many runs; those of one length are computed in lanes.
pub fn output_informations(
    model: &Model,
    runs: &[Simulated],
    noise: &Noise,
) -> Vec<Option<OutputInformation>> {
    if let Some(moved) = &model.forces {
        return runs.iter().map(|run| of_forces(model, moved, run, noise)).collect();
    }
    let model = model.with_intercepts();
    let layout = model.layout();
    let width = model.exogenous().max(1);
    let samples: Vec<usize> = runs.iter().map(|run| run.exogenous.len() / width).collect();
    let mut means = Vec::with_capacity(runs.len());
    let mut path = Sensitivities::default();
    for group in lanes::groups(&samples) {
        let (group_runs, samples) = (&runs[group.clone()], samples[group.start]);
        let parameters: Vec<Vec<f64>> = group_runs.iter().map(|r| layout.woven(r.theta, [0.0; 3])).collect();
        let parameters = lanes::interleave(&parameters.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let rows: Vec<&[f64]> = group_runs.iter().map(|run| run.exogenous).collect();
        let exogenous = lanes::interleave(&rows);
        let initial =
            [0, 1, 2].map(|d: usize| lanes::lane(group_runs.len(), |run| group_runs[run].initial[d]));
        let samples_of = [samples; LANES];
        let run =
            Recordings { model: &model, measured: &[], exogenous: &exogenous, initial, samples: samples_of };
        let sums = RunInformation::by(&run, &parameters, noise, path, |_| ());
        means.extend((0..group_runs.len()).map(|lane| sums.mean(samples, |entry| entry[lane])));
        path = sums.path;
    }
    means
}

/// Sum over the samples of Sᵀ S, n × n, rows and columns of intercepts zero: with G its mean, the variance of a free run due to
/// errors of the parameters, summed over the states, is tr(cov G). `None` if the simulation is not finite.
pub fn prediction_weights(model: &Model, theta: &[f64], initial: [f64; 3], rows: &[f64]) -> Option<Vec<f64>> {
    if let Some(moved) = &model.forces {
        let run = Simulated { theta, initial, exogenous: rows }.of_forces(model, moved);
        return Some(run.slopes(&moved.forces, theta)?.squares(theta.len()));
    }
    let model = model.with_intercepts();
    let layout = model.layout();
    let run = Recordings::simulated(&model, initial, rows);
    let mut path = Sensitivities::default();
    let [squares] = followed(&run, &layout.woven(theta, [0.0; 3]), [[1.0; 3]], &mut path);
    let (n, samples) = (layout.parameters(), run.longest().max(1) as f64);
    let (share, counted): (f64, Vec<f64>) =
        (1.0 / samples, layout.are_intercepts().map(|is| if is { 0.0 } else { 1.0 }).collect());
    let entry = |e: usize| samples * (share * counted[e / n] * counted[e % n] * squares[e]);
    let sum: Vec<f64> = (0..n * n).map(entry).collect();
    sum.iter().all(|x| x.is_finite()).then_some(sum)
}

/// Derivatives of the states of `run` by so many parameters: of all samples from the first on, of u, v and r. Intercepts of zero are
/// among them where that are more than `theta` has. `None` where they are not finite.
pub fn state_slopes(
    model: &Model,
    theta: &[f64],
    count: usize,
    run: &RunView,
    are_inputs_held: bool,
) -> Option<Vec<[Vec<f64>; 3]>> {
    let RunView { initial, exogenous, .. } = *run;
    let rows = 0..=run.samples();
    if let Some(moved) = &model.forces {
        let inputs = if are_inputs_held { Inputs::Held } else { Inputs::Linear };
        let simulated = Simulated { theta, initial, exogenous }.of_forces(model, moved);
        let by_theta = simulated.slopes_by(&moved.forces, theta, inputs)?.by_theta;
        let of = |k: usize| [0, 1, 2].map(|d| by_theta[(3 * k + d) * theta.len()..][..theta.len()].to_vec());
        return Some(rows.map(of).collect());
    }
    let model = model.with_intercepts();
    let layout = model.layout();
    // The model contains the constant; its error is that of an intercept of zero.
    let unknowns = [layout.woven(theta, [0.0; 3]), vec![0.0; 3]].concat();
    let joint = count == layout.parameters();
    let counts = layout.are_intercepts().map(|intercept| joint || !intercept);
    let free: Vec<usize> = counts.enumerate().filter_map(|(i, counts)| counts.then_some(i)).collect();
    let recordings =
        Recordings { measured: run.measured, ..Recordings::simulated(&model, initial, exogenous) };
    let sensitivities = Sensitivities::of(&recordings, &unknowns, &free, true);
    let of = |k: usize| {
        let all: Vec<[f64; 3]> = (0..free.len()).map(|i| sensitivities.by(k, i)).collect();
        [0, 1, 2].map(|d| all.iter().map(|by| by[d]).collect::<Vec<f64>>())
    };
    Some(rows.map(of).collect())
}

/// The information of a run, or of many in lanes, about the parameters: sums over samples, n × n each.
pub(crate) struct RunInformation<X = f64> {
    pub path: Sensitivities<X>,
    pub information: Vec<X>,
    pub measurement: Vec<X>,
    pub process: Vec<X>,
}

fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

impl RunInformation {
    /// E + P.
    pub(crate) fn meat(&self) -> Vec<f64> {
        sum(&self.measurement, &self.process)
    }
}

impl<X: Unknowns> RunInformation<X> {
    /// The mean per sample of the run whose entries `of` selects.
    fn mean(&self, samples: usize, of: impl Fn(&X) -> f64) -> Option<OutputInformation> {
        let share = 1.0 / samples.max(1) as f64;
        let [information, measurement, process] = [&self.information, &self.measurement, &self.process]
            .map(|matrix| -> Vec<f64> { matrix.iter().map(|entry| share * of(entry)).collect() });
        let finite = information.iter().chain(&process).all(|x| x.is_finite());
        finite.then_some(OutputInformation { information, measurement, process })
    }

    /// The information of `run`; its path overwrites `path`. `keep` is called with λ(k), k from N to 1, in a current.
    pub(crate) fn by(
        run: &Recordings<X>,
        parameters: &[X],
        noise: &Noise,
        mut path: Sensitivities<X>,
        mut keep: impl FnMut(&[[Lane; 3]]),
    ) -> Self {
        let (weights, variances) = channels(noise);
        let [information, measurement] = if variances.iter().all(|variance| *variance > 0.0) {
            let [both] = followed(run, parameters, [weights], &mut path);
            [both.clone(), both]
        } else {
            followed(run, parameters, [weights, variances], &mut path)
        };
        let mut draws = Products::new(parameters.len());
        if noise.current > 0.0 {
            let current = Flow::White { std: noise.current };
            let levels = NoiseModel { measurement: noise.measurement, current, force: None, drift: None };
            backward(
                run,
                parameters,
                &path,
                weights.map(X::from),
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

/// Weights W of the channels and variances R of their errors: W = 1/R if no error is zero.
pub(crate) fn channels(noise: &Noise) -> ([f64; 3], [f64; 3]) {
    let variances = noise.measurement.map(|std| std * std);
    let known = variances.iter().all(|v| *v > 0.0);
    (if known { variances.map(f64::recip) } else { [1.0; 3] }, variances)
}

/// Simulates `run` into `path`, and sums Σ_d w_d s_d s_dᵀ for all of the `weights` w.
fn followed<X: Unknowns, const W: usize>(
    run: &Recordings<X>,
    parameters: &[X],
    weights: [[f64; 3]; W],
    path: &mut Sensitivities<X>,
) -> [Vec<X>; W] {
    let n = parameters.len();
    let unknowns = [parameters, &[X::ZERO; 3]].concat();
    let free: Vec<usize> = (0..n).collect();
    path.clear(n, run.longest());
    let roots = weights.map(|by| by.map(|weight| Lane::splat(weight.sqrt())));
    let mut squares = [0; W].map(|_| Products::<X>::new(n));
    sweep(
        run,
        &unknowns,
        &free,
        None,
        &[],
        #[inline(always)]
        |step: Step<'_, X, 3>| {
            path.keep(&step, X::ONE);
            for (squares, roots) in squares.iter_mut().zip(&roots) {
                for (d, root) in roots.iter().enumerate() {
                    squares.scale(step.sensitivities, d, *root);
                    squares.advance();
                }
            }
        },
    );
    squares.map(|products| products.finish().square())
}
