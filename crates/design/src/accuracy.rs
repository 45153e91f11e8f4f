//! Standard errors relative to the parameters, or to those wanted of figures, and the time that an experiment needs to
//! reach them.

use crate::dictionary::Dictionary;
use crate::no_design::NoDesign;
use crate::wanted::{AccuracyOf, OutOfReach, Wanted};
use crate::{Bounds, Candidates, Covariance, CovarianceCriterion, Error, Norm, Options, solve_covariance};

/// Iterations of the minimax search for the largest error.
const ROUNDS: usize = 30;

/// Predicts standard errors relative to what is wanted.
#[derive(Clone, Debug)]
pub struct Errors<'a> {
    dictionary: &'a Dictionary,
    meat: &'a Candidates,
    covariance: &'a Covariance,
    rows: Vec<usize>,
    /// The squares that variances are relative to, one per parameter.
    squares: &'a [f64],
    /// The slopes of figures by row, over the standard errors that are wanted of them.
    figures: Vec<Vec<f64>>,
    of: AccuracyOf,
}

impl<'a> Errors<'a> {
    /// `meat`: B_q of the dictionary's candidates. `squares`: of the parameters.
    pub fn new(
        dictionary: &'a Dictionary,
        meat: &'a Candidates,
        criterion: &'a CovarianceCriterion,
        squares: &'a [f64],
        of: AccuracyOf,
    ) -> Self {
        let (covariance, rows) = (&criterion.covariance, dictionary.parameter_rows());
        Self { dictionary, meat, covariance, rows, squares, figures: Vec::new(), of }
    }

    /// Of figures instead, by their slopes by parameter and the wanted standard error in the figure's unit.
    pub fn of_figures(
        dictionary: &'a Dictionary,
        meat: &'a Candidates,
        criterion: &'a CovarianceCriterion,
        wanted: &[(Vec<f64>, f64)],
    ) -> Self {
        let over = |(slopes, wanted): &(Vec<f64>, f64)| {
            dictionary.by_row(&slopes.iter().map(|slope| slope / wanted).collect::<Vec<_>>())
        };
        let figures = wanted.iter().map(over).collect();
        Self { figures, ..Self::new(dictionary, meat, criterion, &[], AccuracyOf::Figures) }
    }

    /// The variance of every parameter relative to its square, per sample.
    fn relative(&self, shares: &[f64]) -> Option<Vec<f64>> {
        let variances = self.covariance.variances(shares)?;
        Some(self.rows.iter().zip(self.squares).map(|(row, s)| variances[*row].max(0.0) / s).collect())
    }

    /// The squared accuracy for one sample; infinite if the shares do not excite every parameter.
    pub fn squared(&self, shares: &[f64]) -> f64 {
        let squares = match self.of {
            AccuracyOf::Figures => self.covariance.variances_of(shares, &self.figures),
            _ => self.relative(shares),
        };
        let Some(squares) = squares else { return f64::INFINITY };
        match self.of {
            AccuracyOf::Overall => squares.iter().sum(),
            AccuracyOf::PerParameter | AccuracyOf::Figures => squares.iter().copied().fold(0.0, f64::max),
        }
    }

    /// Samples that reach the wanted accuracy at fixed shares.
    pub fn samples(&self, shares: &[f64], wanted: &Wanted) -> f64 {
        (self.squared(shares) / (wanted.accuracy * wanted.accuracy)).ceil()
    }

    /// [`Errors::samples`], if the longest experiment has as many.
    ///
    /// # Errors
    /// [`NoDesign::OutOfReach`].
    pub fn reachable(&self, shares: &[f64], wanted: &Wanted) -> Result<f64, NoDesign> {
        let rate_hz = self.dictionary.sample_rate_hz;
        let samples = self.samples(shares, wanted);
        if samples <= wanted.longest_s * rate_hz {
            return Ok(samples);
        }
        let best = (self.squared(shares) / (wanted.longest_s * rate_hz)).sqrt();
        Err(NoDesign::OutOfReach(OutOfReach { wanted: *wanted, needed_s: samples / rate_hz, best }))
    }

    /// Shares that minimise the largest relative error, and a lower bound on its square for one sample (proved if the
    /// criterion is concave): the weights of the largest relative variances in their sum are increased.
    ///
    /// # Errors
    /// Those of the solver.
    pub fn least_largest(&self, bounds: &Bounds, options: &Options) -> Result<(Vec<f64>, f64), NoDesign> {
        let mut weights = vec![1.0 / self.squares.len() as f64; self.squares.len()];
        let (mut best, mut bound): (Option<(f64, Vec<f64>)>, f64) = (None, 0.0);
        let options = Options { random_starts: 0, tolerance: options.tolerance.max(1e-6), ..*options };
        for _ in 0..ROUNDS {
            let covariance = self.reweighted(&weights)?;
            let design =
                solve_covariance(&covariance, bounds, &options).map_err(|e| self.dictionary.explain(e))?;
            let relative =
                self.relative(&design.shares).unwrap_or_else(|| vec![f64::INFINITY; weights.len()]);
            bound = bound.max(libm::exp(-design.log_det) * (1.0 - design.gap.max(0.0)));
            let largest = relative.iter().copied().fold(0.0, f64::max);
            if best.as_ref().is_none_or(|(known, _)| largest < *known) {
                best = Some((largest, design.shares));
            }
            weights.iter_mut().zip(&relative).for_each(|(w, r)| *w *= r / largest);
            let sum: f64 = weights.iter().sum();
            weights.iter_mut().for_each(|w| *w /= sum);
        }
        best.map(|(_, shares)| (shares, bound)).ok_or(NoDesign::Search(Error::Empty))
    }

    /// The sum of the relative variances with other weights.
    fn reweighted(&self, weights: &[f64]) -> Result<Covariance, NoDesign> {
        let scaled: Vec<f64> = weights.iter().zip(self.squares).map(|(w, s)| w / s).collect();
        let rows = self.dictionary.by_row(&scaled);
        let built = Covariance::new(&self.dictionary.information, self.meat, &rows, Norm::Trace);
        built.map_err(|e| self.dictionary.explain(e))
    }
}
