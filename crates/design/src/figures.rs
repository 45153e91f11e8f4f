//! Figures that an owner asks of a model, to first order in its parameters: g = ∂figure/∂θ, and the variance of a
//! figure is gᵀ C g for a covariance C of the parameters.

use numerics::symmetric;

use crate::{Candidates, Covariance, Dictionary, NoDesign, Norm};

/// What the identity, in relative parameters, adds to the figures: figures alone leave directions of the parameters
/// without a weight, which the experiment would then leave without information.
const IDENTITY: f64 = 1e-5;

/// A figure that depends on the parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightedFigure {
    /// Its value, in its unit, that its error is relative to.
    pub value: f64,
    /// Its derivatives by the parameters of the dictionary, in their order, in its unit per unit of the parameter.
    pub slopes: Vec<f64>,
    /// Weight of its relative variance in the criterion; 0 leaves it out.
    pub weight: f64,
}

/// The rows whose variances the criterion adds up, by parameter: with the sum G over the figures of weight · ggᵀ/value² in
/// relative parameters, the rows of a root of G + 10⁻⁵. `parameters`: their values.
pub(crate) fn weighted(figures: &[WeightedFigure], parameters: &[f64]) -> Vec<Vec<f64>> {
    let n = parameters.len();
    let mut sum: Vec<f64> = (0..n * n).map(|k| if k % (n + 1) == 0 { IDENTITY } else { 0.0 }).collect();
    for figure in figures.iter().filter(|figure| figure.weight > 0.0) {
        let factor = figure.weight.sqrt() / figure.value;
        let relative: Vec<f64> =
            figure.slopes.iter().zip(parameters).map(|(slope, own)| factor * slope * own).collect();
        for (row, own) in sum.chunks_exact_mut(n.max(1)).zip(&relative) {
            row.iter_mut().zip(&relative).for_each(|(entry, other)| *entry += own * other);
        }
    }
    // Numbers that are not finite are refused with the rows.
    let (values, vectors) = symmetric(n, &sum).unwrap_or_else(|| (vec![f64::NAN; n], vec![f64::NAN; n * n]));
    let row = |e: usize| {
        let entry = |i: usize| values[e].max(IDENTITY).sqrt() * vectors[i * n + e] / parameters[i];
        (0..n).map(entry).collect()
    };
    (0..n).map(row).collect()
}

/// Predicts the standard errors of figures.
#[derive(Clone, Debug)]
pub struct FigureErrors {
    covariance: Covariance,
    /// The slopes of every figure by row of the covariance.
    slopes: Vec<Vec<f64>>,
}

impl FigureErrors {
    /// Of figures with `slopes` by parameter. `meat`: B_q of the dictionary's candidates.
    ///
    /// # Errors
    /// A singular covariance, naming the parameter.
    pub fn new(dictionary: &Dictionary, meat: &Candidates, slopes: &[Vec<f64>]) -> Result<Self, NoDesign> {
        let slopes: Vec<Vec<f64>> = slopes.iter().map(|slope| dictionary.by_row(slope)).collect();
        let all = vec![1.0; dictionary.parameters()];
        let built = Covariance::new(&dictionary.information, meat, &dictionary.by_row(&all), Norm::Trace);
        Ok(Self { covariance: built.map_err(|e| dictionary.explain(e))?, slopes })
    }

    /// The standard error of every figure in its unit, for an experiment of `samples` samples at `shares`; `None` if
    /// these do not excite every parameter.
    pub fn at(&self, shares: &[f64], samples: f64) -> Option<Vec<f64>> {
        let variances = self.covariance.variances_of(shares, &self.slopes)?;
        Some(variances.iter().map(|variance| (variance.max(0.0) / samples).sqrt()).collect())
    }
}
