use identification::{Noise, OutputInformation, lifted, output_information};
use optimal_design::{Bounds, Candidates, Covariance, Norm, Options, solve_covariance};
use vessel::{Generator, Invalid, Model, Realized};

use super::estimate::Leg;
use crate::simulate::exogenous;

/// Designs experiments for output-error estimates, from a model and from what was sailed before.
pub struct Planner<'a> {
    model: &'a Model,
    noise: Noise,
    /// Every maneuver at its own length: initial state and exogenous signals.
    maneuvers: Vec<([f64; 3], Vec<f64>)>,
}

/// What has been sailed: information and middle matrix, n × n sums over samples, and how many.
#[derive(Clone, Debug)]
pub struct Sailed {
    information: Vec<f64>,
    middle: Vec<f64>,
    samples: f64,
}

impl<'a> Planner<'a> {
    /// Over the maneuvers of `generator`, for disturbances of these levels.
    ///
    /// # Errors
    /// A maneuver that the model cannot hold.
    pub fn new(model: &'a Model, generator: &Generator, noise: Noise) -> Result<Self, Invalid> {
        let one = |q: usize| {
            let Realized { initial, inputs } = generator.realize(q, generator.samples(q)?)?;
            Ok((initial, exogenous(model, &inputs)))
        };
        let maneuvers = (0..generator.maneuvers().len()).map(one).collect::<Result<_, _>>()?;
        Ok(Self { model, noise, maneuvers })
    }

    /// Number of maneuvers.
    pub fn maneuvers(&self) -> usize {
        self.maneuvers.len()
    }

    /// Shares of `remaining` samples that make the sum of the relative variances of the parameters smallest for the model
    /// with parameters `theta`, beside what `sailed` tells already: every candidate's matrix is α M_sailed + (1 − α) M_q, α
    /// the share of the samples that were sailed. `None` where the model diverges in every maneuver or they do not excite it.
    pub fn shares(&self, theta: &[f64], sailed: Option<&Sailed>, remaining: usize) -> Option<Vec<f64>> {
        let own = |(initial, exogenous): &([f64; 3], Vec<f64>)| {
            output_information(self.model, theta, *initial, exogenous, &self.noise)
        };
        let found: Vec<Option<OutputInformation>> = self.maneuvers.iter().map(own).collect();
        let sizes = vec![lifted(self.model)];
        let (mut information, mut middle) = (Candidates::new(sizes.clone()), Candidates::new(sizes));
        for own in found.iter().flatten() {
            let both: Vec<f64> = own.measurement.iter().zip(&own.process).map(|(e, p)| e + p).collect();
            let mixed = |own: &[f64], past: &dyn Fn(&Sailed) -> Vec<f64>| mixed(own, sailed, remaining, past);
            information.push(&mixed(&own.information, &|s| s.information.clone())).ok()?;
            middle.push(&mixed(&both, &|s| s.middle.clone())).ok()?;
        }
        let weights = relative(self.model, theta);
        let criterion = Covariance::new(&information, &middle, &weights, Norm::PowerMean(1.0)).ok()?;
        let options = Options { random_starts: 0, tolerance: 1e-6, ..Options::default() };
        let design = solve_covariance(&criterion, &Bounds::default(), &options).ok()?;
        let usable = (0..found.len()).filter(|q| found[*q].is_some());
        let mut shares = vec![0.0; found.len()];
        usable.zip(design.shares).for_each(|(q, share)| shares[q] = share);
        Some(shares)
    }

    /// What `legs` tell about the model with parameters `theta`; `None` where it diverges in one of them.
    pub fn sailed(&self, legs: &[Leg], theta: &[f64]) -> Option<Sailed> {
        let n = lifted(self.model);
        let mut sum = Sailed { information: vec![0.0; n * n], middle: vec![0.0; n * n], samples: 0.0 };
        for leg in legs {
            let own = output_information(self.model, theta, leg.initial, &leg.exogenous, &self.noise)?;
            let samples = leg.samples() as f64;
            sum.samples += samples;
            for k in 0..n * n {
                sum.information[k] += samples * own.information[k];
                sum.middle[k] += samples * (own.measurement[k] + own.process[k]);
            }
        }
        Some(sum)
    }
}

impl Sailed {
    /// Standard errors of the parameters (without the intercepts) that an output-error estimate will have: the roots of the
    /// diagonal of F⁻¹ (E + P) F⁻¹. `None` where a direction is not excited.
    pub fn standard_errors(&self, model: &Model) -> Option<Vec<f64>> {
        let n = lifted(model);
        let size: Vec<f64> = (0..n).map(|i| self.information[i * n + i].sqrt()).collect();
        let mut scaled: Vec<f64> =
            (0..n * n).map(|k| self.information[k] / (size[k / n] * size[k % n])).collect();
        let mut inverse = vec![0.0; n * n];
        small_matrix::inverse(n, &mut scaled, &mut inverse)?;
        let entry = |i: usize, j: usize| inverse[i * n + j] / (size[i] * size[j]);
        let variance = |i: usize| -> f64 {
            let pairs = (0..n * n).map(|k| (k / n, k % n));
            pairs.map(|(j, l)| entry(i, j) * self.middle[j * n + l] * entry(i, l)).sum()
        };
        let kept = relative(model, &vec![1.0; model.parameters()]);
        let errors: Vec<f64> =
            (0..n).filter(|i| kept[*i] > 0.0).map(|i| variance(i).max(0.0).sqrt()).collect();
        errors.iter().all(|error| error.is_finite()).then_some(errors)
    }
}

/// Weights 1/θ² of the lifted parameters, none for intercepts.
fn relative(model: &Model, theta: &[f64]) -> Vec<f64> {
    let mut theta = theta.iter();
    let of = |degree: &vessel::Degree| {
        let own: Vec<f64> = theta.by_ref().take(degree.terms.len()).map(|t| t.powi(-2)).collect();
        own.into_iter().chain([0.0]).collect::<Vec<_>>()
    };
    model.degrees.iter().flat_map(of).collect()
}

/// α M_sailed + (1 − α) M, per sample.
fn mixed(
    own: &[f64],
    sailed: Option<&Sailed>,
    remaining: usize,
    matrix: &dyn Fn(&Sailed) -> Vec<f64>,
) -> Vec<f64> {
    let Some(sailed) = sailed else { return own.to_vec() };
    let total = sailed.samples + remaining as f64;
    let rest = remaining as f64 / total;
    matrix(sailed).iter().zip(own).map(|(past, own)| past / total + rest * own).collect()
}
