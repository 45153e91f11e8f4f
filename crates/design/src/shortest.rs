//! The shortest experiment for a wanted accuracy.

use std::ops::Range;

use numerics::symmetric;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::dictionary::{AccuracyOf, OutOfReach};
use crate::{
    Bounds, Covariance, CovarianceCriterion, Criterion, Design, Dictionary, Error, Length, NoDesign, Norm,
    Options, Scarce, Stock, Wanted,
};

/// The question how long an experiment has to be.
pub struct Question<'a> {
    /// The maneuvers.
    pub dictionary: &'a Dictionary,
    /// Samples of each of them, as in its matrices.
    pub lengths: &'a [f64],
    /// The criterion, one of the covariance.
    pub criterion: &'a Criterion,
    /// The prediction of the accuracy.
    pub errors: Errors<'a>,
    /// The accuracy.
    pub wanted: Wanted,
    /// The available amount of every maneuver.
    pub stock: Option<&'a Stock>,
}

/// A design of the shortest experiment for an accuracy.
#[derive(Clone, Debug)]
pub struct Shortest {
    /// The design.
    pub design: Design,
    /// Samples of the experiment.
    pub samples: f64,
}

/// Other shares, to compare with.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rivals {
    /// Those of the paper's criterion for the same maneuvers, if they exist.
    pub paper: Option<Vec<f64>>,
    /// Random designs, of which the median is used.
    pub random: Vec<Vec<f64>>,
    /// Segments of each of these.
    pub random_segments: u32,
}

/// The answer in time, with rivals.
#[derive(Clone, Debug, PartialEq)]
pub struct Accuracy {
    /// What was wanted.
    pub wanted: Wanted,
    /// Samples of the experiment.
    pub samples: u64,
    /// Duration of the experiment \[s\].
    pub duration_s: f64,
    /// The accuracy that it is predicted to have.
    pub reached: f64,
    /// From which duration on the prediction holds: [`MOST`] of the time is spent on maneuvers that are as long as their matrices
    /// count them, and not on their beginnings \[s\].
    pub holds_from_s: f64,
    /// How long the shares of the paper's criterion take \[s\].
    pub paper_s: Option<f64>,
    /// How long equal shares take \[s\].
    pub equal_s: Option<f64>,
    /// How long the median of random designs takes \[s\].
    pub random_s: Option<f64>,
    /// Segments of each of these.
    pub random_segments: u32,
    /// Predicted accuracy against time.
    pub curve: Vec<AccuracyPoint>,
}

/// Predicted accuracy after some time; none where a design excites not every parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AccuracyPoint {
    /// Duration of the experiment \[s\].
    pub duration_s: f64,
    /// Of this design.
    pub design: f64,
    /// Of equal shares.
    pub equal: Option<f64>,
    /// Of the shares that the paper's criterion has for the same maneuvers.
    pub paper: Option<f64>,
    /// Median of random designs.
    pub random: Option<f64>,
}

/// Durations of the curve.
const POINTS: usize = 25;

/// Share of the time on whole maneuvers from which predictions hold. Measured: the errors of trials are then 0.8 to
/// 1.0 of the prediction, at a quarter of that length two to three times of it (docs/design.md).
pub const MOST: f64 = 0.8;

/// The number of samples from which on maneuvers of these `lengths` that take [`MOST`] of the time at `shares` are whole.
pub fn holds_from(shares: &[f64], lengths: &[f64]) -> f64 {
    let used = shares.iter().zip(lengths).filter(|(share, _)| **share > 0.0);
    let mut needs: Vec<(f64, f64)> = used.map(|(share, length)| (length / share, *share)).collect();
    needs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut whole = 0.0;
    let enough = needs.iter().find(|(_, share)| {
        whole += share;
        whole >= MOST
    });
    enough.or(needs.last()).map_or(f64::INFINITY, |(samples, _)| *samples)
}

impl Question<'_> {
    /// The answer.
    ///
    /// # Errors
    /// An accuracy out of reach, with the best one; those of the solvers.
    pub fn shortest(&self, options: &Options) -> Result<Shortest, NoDesign> {
        if let Some(stock) = self.stock {
            return self.within_what_is_available(stock, options);
        }
        let design = self.solve(&Bounds::default(), options)?;
        let samples = self.errors.reachable(&design.shares, &self.wanted)?;
        Ok(Shortest { design, samples })
    }

    /// The best shares within bounds.
    fn solve(&self, bounds: &Bounds, options: &Options) -> Result<Design, NoDesign> {
        self.criterion.solve(bounds, options).map_err(|e| self.dictionary.explain(e))
    }

    /// The bounds of the shares of an experiment of `samples` samples; `None` if not so much is available.
    fn bounds(&self, stock: &Stock, samples: f64) -> Result<Option<Bounds>, NoDesign> {
        let length = Length { samples: Some(samples), segments: None };
        match stock.within(self.dictionary, &length) {
            Ok(available) => Bounds::new(&available.shares).map(Some).map_err(|e| self.dictionary.explain(e)),
            Err(Scarce::Time { .. } | Scarce::Segments { .. }) => Ok(None),
            Err(other) => Err(other.into()),
        }
    }

    /// By bisection: the longest experiment that is available, then the shortest that is accurate enough.
    fn within_what_is_available(&self, stock: &Stock, options: &Options) -> Result<Shortest, NoDesign> {
        let rate = self.dictionary.sample_rate_hz;
        let (mut longest, mut beyond) = (1.0, (self.wanted.longest_s * rate).floor() + 1.0);
        while beyond - longest > 1.0 {
            let middle = (0.5 * (longest + beyond)).floor();
            match self.bounds(stock, middle)? {
                Some(_) => longest = middle,
                None => beyond = middle,
            }
        }
        let Some(bounds) = self.bounds(stock, longest)? else {
            return Err(NoDesign::Search(Error::Infeasible { total: 0.0 }));
        };
        let mut design = self.solve(&bounds, options)?;
        let at_most = Wanted { longest_s: longest / rate, ..self.wanted };
        self.errors.reachable(&design.shares, &at_most)?;
        let (mut low, mut high) = (0.0, longest);
        while high - low > 1.0 {
            let middle = (0.5 * (low + high)).floor();
            let bounds = self.bounds(stock, middle)?;
            let solved = bounds.map(|bounds| self.solve(&bounds, options)).transpose()?;
            match solved.filter(|d| self.errors.samples(&d.shares, &self.wanted) <= middle) {
                Some(solved) => (design, high) = (solved, middle),
                None => low = middle,
            }
        }
        Ok(Shortest { design, samples: high })
    }

    /// `shortest` in time, with `rivals`.
    pub fn compare(&self, shortest: &Shortest, rivals: &Rivals) -> Accuracy {
        let (rate, samples, wanted) = (self.dictionary.sample_rate_hz, shortest.samples, self.wanted);
        let (square, count) = (self.errors.squared(&shortest.design.shares), self.dictionary.maneuvers.len());
        let paper = rivals.paper.as_deref().map(|shares| self.errors.squared(shares));
        let equal = self.errors.squared(&vec![1.0 / count as f64; count]);
        let random = self.median(&rivals.random);
        let at = |one: f64, samples: f64| Some((one / samples).sqrt()).filter(|a| a.is_finite());
        let point = |i: usize| {
            let factor = libm::pow(16.0_f64, 2.0 * i as f64 / (POINTS - 1) as f64 - 1.0);
            let n = (samples * factor).max(1.0);
            AccuracyPoint {
                duration_s: n / rate,
                design: (square / n).sqrt(),
                equal: at(equal, n),
                paper: paper.and_then(|p| at(p, n)),
                random: random.and_then(|r| at(r, n)),
            }
        };
        let needs = |one: f64| one / (wanted.accuracy * wanted.accuracy) / rate;
        let needed_s = |one: Option<f64>| one.map(needs).filter(|s| s.is_finite());
        Accuracy {
            wanted,
            samples: samples as u64,
            duration_s: samples / rate,
            reached: (square / samples).sqrt(),
            holds_from_s: holds_from(&shortest.design.shares, self.lengths) / rate,
            paper_s: needed_s(paper),
            equal_s: needed_s(Some(equal)),
            random_s: needed_s(random),
            random_segments: rivals.random_segments,
            curve: (0..POINTS).map(point).collect(),
        }
    }

    /// Median of the squared accuracies of designs.
    fn median(&self, designs: &[Vec<f64>]) -> Option<f64> {
        let mut all: Vec<f64> = designs.iter().map(|shares| self.errors.squared(shares)).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().filter(|m| m.is_finite())
    }
}

/// Predicts standard errors relative to what is wanted.
#[derive(Clone, Debug)]
pub struct Errors<'a> {
    dictionary: &'a Dictionary,
    covariance: &'a Covariance,
    rows: Vec<usize>,
    /// The squares that variances are relative to, one per parameter.
    squares: &'a [f64],
    /// The slopes of figures by row, over the standard errors that are wanted of them.
    figures: Vec<Vec<f64>>,
    of: AccuracyOf,
}

impl<'a> Errors<'a> {
    /// Of all parameters together, by their `squares`.
    pub fn new(dictionary: &'a Dictionary, criterion: &'a CovarianceCriterion, squares: &'a [f64]) -> Self {
        let (covariance, rows) = (&criterion.covariance, dictionary.parameter_rows());
        Self { dictionary, covariance, rows, squares, figures: Vec::new(), of: AccuracyOf::Overall }
    }

    /// Of figures instead, by their slopes by parameter and the wanted standard error in the figure's unit.
    pub fn of_figures(
        dictionary: &'a Dictionary,
        criterion: &'a CovarianceCriterion,
        wanted: &[(Vec<f64>, f64)],
    ) -> Self {
        let over = |(slopes, wanted): &(Vec<f64>, f64)| {
            dictionary.by_row(&slopes.iter().map(|slope| slope / wanted).collect::<Vec<_>>())
        };
        let figures = wanted.iter().map(over).collect();
        Self { figures, of: AccuracyOf::Figures, ..Self::new(dictionary, criterion, &[]) }
    }

    /// The squared accuracy for one sample; infinite if the shares do not excite every parameter.
    pub fn squared(&self, shares: &[f64]) -> f64 {
        let overall = |variances: Vec<f64>| {
            self.rows.iter().zip(self.squares).map(|(row, s)| variances[*row].max(0.0) / s).sum::<f64>()
        };
        let largest = |variances: Vec<f64>| variances.into_iter().fold(0.0, f64::max);
        let squared = match self.of {
            AccuracyOf::Overall => self.covariance.variances(shares).map(overall),
            AccuracyOf::Figures => self.covariance.variances_of(shares, &self.figures).map(largest),
        };
        squared.unwrap_or(f64::INFINITY)
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
}

/// The error that a norm measures of a covariance, n × n: for the trace the root of Σ weight × variance; for the determinant
/// |covariance|^(1/2n), with the correlations inside of `blocks` alone. `None` where the covariance is singular.
pub fn error_of(norm: Norm, weights: &[f64], covariance: &[f64], blocks: &[Range<usize>]) -> Option<f64> {
    let n = weights.len();
    let variance = |i: usize| covariance[i * n + i];
    match norm {
        Norm::Trace => Some(weights.iter().enumerate().map(|(i, w)| w * variance(i)).sum::<f64>().sqrt()),
        Norm::LogDet => {
            let logs = blocks.iter().map(|block| log_det(n, covariance, block.clone()));
            let sum = logs.sum::<Option<f64>>()?;
            Some(libm::exp(0.5 * sum / n as f64))
        }
    }
}

/// The same error as a design predicts it: `value` of the criterion of `parameters` for so many `samples`, at a trial of `of`.
pub fn promised_error(norm: Norm, value: f64, parameters: usize, samples: f64, of: f64) -> f64 {
    let shorter = (samples / of).sqrt();
    match norm {
        Norm::Trace => value.max(0.0).sqrt() * shorter,
        Norm::LogDet => libm::exp(0.5 * value / parameters as f64) * shorter,
    }
}

/// log det of a block, from its variances and its correlations.
fn log_det(n: usize, covariance: &[f64], block: Range<usize>) -> Option<f64> {
    let size = block.len();
    let spread = |i: usize| covariance[i * n + i].sqrt();
    let entry = |k: usize| {
        let (i, j) = (block.start + k / size, block.start + k % size);
        covariance[i * n + j] / (spread(i) * spread(j))
    };
    let correlations: Vec<f64> = (0..size * size).map(entry).collect();
    let (values, _) = symmetric(size, &correlations)?;
    let all = values.iter().all(|value| *value > 0.0);
    let logs = values.iter().map(|value| libm::log(*value)).sum::<f64>();
    all.then(|| logs + 2.0 * block.map(|i| libm::log(spread(i))).sum::<f64>())
}
