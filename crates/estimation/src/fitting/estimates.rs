//! How well a fit is known.

use numerics::{congruence, scaled_inverse, symmetric};

use crate::fitting::bounded::held;
use crate::fitting::pass::Pass;
use crate::fitting::{Fit, Problem, Unfit};

/// A free parameter after the fit, in the system that it was written in.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its estimate.
    pub value: f64,
    /// Its standard error; none at a bound.
    pub standard_error: Option<f64>,
    /// How much of the estimate is the prior's, from 0 to 1.
    pub prior_share: f64,
    /// By what the recordings' standard error grows because other parameters are unknown; none where the recordings
    /// leave a direction open.
    pub inflation: Option<f64>,
}

/// The errors of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimates {
    /// One per free parameter.
    pub parameters: Vec<Parameter>,
    /// Covariance of the estimates; rows and columns of those at bounds are 0.
    pub covariance: Vec<f64>,
    /// Square root of the largest over the smallest eigenvalue of the recordings' information, in correlations.
    pub condition: f64,
    /// Pieces of recordings that count as independent.
    pub pieces: usize,
}

/// Weakest eigenvalue of an information in correlations that still counts as one.
const OPEN: f64 = 1e-14;

impl Problem<'_> {
    /// The errors of `fit`, from pieces of the windows as clusters; what the priors do not know is added.
    ///
    /// # Errors
    /// A parameter that nothing determines.
    pub fn estimates(&self, fit: &Fit) -> Result<Estimates, Unfit> {
        Pass::new(self, fit.first).estimates(fit)
    }
}

impl Pass<'_> {
    fn estimates(&self, fit: &Fit) -> Result<Estimates, Unfit> {
        let n = fit.theta.len();
        let sums = self.all_sums(&fit.theta, &fit.starts);
        let windows = self.determined(&sums)?;
        let (data, gradient) = self.information(n, &sums, &windows);
        let (mut meat, mut pieces) = (vec![0.0; n * n], 0);
        for (own, window) in sums.iter().flatten().zip(windows.iter().flatten()) {
            let weight = self.weight(&own.errors);
            for score in own.scores(window, n).into_iter().filter(|own| own.iter().any(|own| *own != 0.0)) {
                let score: Vec<f64> = score.iter().map(|own| weight * own).collect();
                numerics::add_outer(&mut meat, &score, &score);
                pieces += 1;
            }
        }
        self.errors_of(fit, (data, meat), gradient, pieces)
    }

    /// The errors of `fit`, from the information and the scores' products of the recordings, and their gradient.
    fn errors_of(
        &self,
        fit: &Fit,
        (data, mut meat): (Vec<f64>, Vec<f64>),
        mut gradient: Vec<f64>,
        pieces: usize,
    ) -> Result<Estimates, Unfit> {
        let n = fit.theta.len();
        let pulls = self.pulls(&fit.theta);
        gradient.iter_mut().zip(&pulls).for_each(|(sum, [_, own])| *sum += own);
        let pulls: Vec<f64> = pulls.iter().map(|[own, _]| *own).collect();
        let held = held(self.forces, &fit.theta, &gradient);
        let free: Vec<usize> = (0..n).filter(|i| !held[*i]).collect();
        let m = free.len();
        let inner =
            |of: &[f64]| -> Vec<f64> { (0..m * m).map(|k| of[free[k / m] * n + free[k % m]]).collect() };
        let information = inner(&data);
        let mut bread = information.clone();
        (0..m).for_each(|i| bread[i * m + i] += pulls[free[i]]);
        let inverse = scaled_inverse(m, &bread).ok_or_else(|| self.undetermined(&free, &bread))?;
        let shares: Vec<f64> = (0..m).map(|i| inverse[i * m + i] * pulls[free[i]]).collect();
        // Parameters that the recordings determine use up pieces.
        let used = m as f64 - shares.iter().sum::<f64>();
        let correction = pieces as f64 / (pieces as f64 - used).max(1.0);
        meat.iter_mut().for_each(|own| *own *= correction);
        let mut meat = inner(&meat);
        (0..m).for_each(|i| {
            meat[i * m + i] +=
                self.priors[free[i]].map_or(0.0, |own| (pulls[free[i]] * own.deviation).powi(2));
        });
        let own = congruence(m, &inverse, &meat);
        let mut covariance = vec![0.0; n * n];
        (0..m * m).for_each(|k| covariance[free[k / m] * n + free[k % m]] = own[k]);
        let (condition, inflations) = conditioned(m, &information);
        let parameter = |i: usize| {
            let place = free.iter().position(|own| *own == i);
            Parameter {
                name: self.forces.parameters()[i].name.clone(),
                value: fit.theta[i],
                standard_error: place.map(|_| covariance[i * n + i].sqrt()),
                prior_share: place.map_or(0.0, |k| shares[k].clamp(0.0, 1.0)),
                inflation: place.and_then(|k| inflations.as_ref().map(|own| own[k])),
            }
        };
        let parameters = (0..n).map(parameter).collect();
        Ok(Estimates { parameters, covariance, condition, pieces })
    }

    pub(crate) fn undetermined(&self, free: &[usize], bread: &[f64]) -> Unfit {
        let m = free.len();
        let weakest = numerics::weakest(m, bread).map_or(0, |own| own.dominant(m));
        Unfit::Undetermined(self.forces.parameters()[free[weakest]].name.clone())
    }
}

/// The condition index of an information, and by what each standard error grows because of the others.
pub(crate) fn conditioned(n: usize, information: &[f64]) -> (f64, Option<Vec<f64>>) {
    let scale: Vec<f64> = (0..n).map(|i| information[i * n + i].sqrt()).collect();
    let own: Vec<f64> = (0..n * n).map(|k| information[k] / (scale[k / n] * scale[k % n])).collect();
    let Some((values, vectors)) = symmetric(n, &own) else { return (f64::INFINITY, None) };
    let (low, high) = (values.first().copied().unwrap_or(1.0), values.last().copied().unwrap_or(1.0));
    if low <= OPEN * high {
        return (f64::INFINITY, None);
    }
    let inflation = |i: usize| (0..n).map(|k| vectors[i * n + k].powi(2) / values[k]).sum::<f64>().sqrt();
    ((high / low).sqrt(), Some((0..n).map(inflation).collect()))
}
