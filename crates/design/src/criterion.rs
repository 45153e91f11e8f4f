//! The criterion that shares are optimised for.

use numerics::symmetric;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::design::alone;
use crate::{
    Bounds, Candidates, CountOptions, Counted, Covariance, CovariancePoint, Design, Dictionary, Error,
    Evaluation, Method, NoDesign, Norm, Objective, Options, Restricted, Selected, count_segments, is_concave,
    select, solve_covariance, solve_within,
};

/// The criterion that is maximised.
#[derive(Clone, Debug)]
pub enum Criterion {
    /// log|det| of the information matrix.
    Information(Candidates),
    /// A criterion of the covariance.
    Covariance(Box<CovarianceCriterion>),
}

/// A criterion of the covariance.
#[derive(Clone, Debug)]
pub struct CovarianceCriterion {
    /// The criterion.
    pub covariance: Covariance,
    /// Weights of the parameters' variances, in their order.
    pub weights: Vec<f64>,
    of: Weighed,
}

/// What a criterion of the covariance adds up.
#[derive(Clone, Debug)]
enum Weighed {
    /// The weighted variances of the parameters.
    Parameters,
    /// G of the free runs: tr(cov G).
    Matrix(Vec<f64>),
    /// The variances of functions of the parameters, by row.
    Functions(Vec<Vec<f64>>),
}

/// The prediction of a criterion of the covariance for a number of samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Predicted {
    /// The norm of the covariance.
    pub value: f64,
    /// Of every parameter.
    pub standard_errors: Vec<f64>,
}

impl CovarianceCriterion {
    /// The prediction for `samples` at `shares` of `dictionary`; `None` if the covariance is not defined.
    pub fn predicted(&self, dictionary: &Dictionary, shares: &[f64], samples: f64) -> Option<Predicted> {
        let variances = self.covariance.variances(shares)?;
        let rows = dictionary.parameter_rows();
        let errors = rows.iter().map(|row| (variances[*row].max(0.0) / samples).sqrt());
        let value = self.covariance.value(shares, &mut CovariancePoint::default())?;
        let value = match self.covariance.norm() {
            Norm::LogDet => -value - self.weights.len() as f64 * libm::log(samples),
            Norm::Trace => libm::exp(-value) / samples,
        };
        Some(Predicted { value, standard_errors: errors.collect() })
    }
}

impl Candidates {
    /// log|det| of the scaled candidates at `shares`; `None` if it is singular.
    pub fn log_det(&self, shares: &[f64]) -> Option<f64> {
        let (scaled, offset) = self.scaled().ok()?;
        scaled.evaluate(shares, &mut Evaluation::default()).map(|value| value + offset)
    }
}

/// Smallest gap to which restricted shares are solved.
const RESTRICTED_TOLERANCE: f64 = 1e-7;

impl Criterion {
    /// A norm of the covariance. `meat`: B_q of the dictionary's candidates. `weights`: of the parameters' variances.
    ///
    /// # Errors
    /// A singular covariance, naming the parameter.
    pub fn of_covariance(
        dictionary: &Dictionary,
        meat: &Candidates,
        weights: Vec<f64>,
        norm: Norm,
    ) -> Result<Self, NoDesign> {
        let rows = dictionary.by_row(&weights);
        let built = Covariance::new(&dictionary.information, meat, &rows, norm);
        Self::built(built, dictionary, weights, Weighed::Parameters)
    }

    /// Σ weight · gᵀ cov g / value² over `figures`, plus 10⁻⁵ of the sum of the variances relative to `parameters`,
    /// which are in the order of the dictionary and not 0.
    ///
    /// # Errors
    /// As [`Criterion::of_covariance`]; a weighted figure of 0.
    pub fn of_figures(
        dictionary: &Dictionary,
        meat: &Candidates,
        figures: &[WeightedFigure],
        parameters: &[f64],
    ) -> Result<Self, NoDesign> {
        let rows = weighted(figures, parameters);
        let functions: Vec<Vec<f64>> = rows.iter().map(|row| dictionary.by_row(row)).collect();
        let built = Covariance::of_functions(&dictionary.information, meat, &functions);
        Self::built(built, dictionary, vec![1.0; dictionary.parameters()], Weighed::Functions(functions))
    }

    /// The mean square of a free run's error: tr(cov G), one block of all rows.
    ///
    /// # Errors
    /// As [`Criterion::of_covariance`].
    pub fn of_free_runs(dictionary: &Dictionary, meat: &Candidates, g: Vec<f64>) -> Result<Self, NoDesign> {
        let built = Covariance::of_matrices(&dictionary.information, meat, std::slice::from_ref(&g));
        Self::built(built, dictionary, vec![1.0; dictionary.parameters()], Weighed::Matrix(g))
    }

    fn built(
        built: Result<Covariance, Error>,
        dictionary: &Dictionary,
        weights: Vec<f64>,
        of: Weighed,
    ) -> Result<Self, NoDesign> {
        let covariance = built.map_err(|e| dictionary.explain(e))?;
        Ok(Self::Covariance(Box::new(CovarianceCriterion { covariance, weights, of })))
    }

    /// The best shares within `bounds`.
    ///
    /// # Errors
    /// Those of the solvers.
    pub fn solve(&self, bounds: &Bounds, options: &Options) -> Result<Design, Error> {
        let is_concave = match self {
            Self::Information(candidates) => is_concave(candidates),
            Self::Covariance(c) => c.covariance.is_concave(),
        };
        // The end of one start is proved optimal where the problem is concave.
        let random_starts = if is_concave { 0 } else { options.random_starts };
        let options = &Options { random_starts, ..*options };
        match self {
            Self::Information(candidates) => solve_within(candidates, bounds, options),
            Self::Covariance(c) => solve_covariance(&c.covariance, bounds, options),
        }
    }

    /// The design with at most `most` candidates, starting from the unrestricted design `relaxed`. `parameters`: their number.
    ///
    /// # Errors
    /// As [`select`].
    pub fn restricted(
        &self,
        relaxed: &Design,
        bounds: &Bounds,
        most: usize,
        options: &Options,
        parameters: usize,
    ) -> Result<Restricted, Error> {
        let selected = self.selected(relaxed, bounds, most, options)?;
        let loss = selected.loss_bound(relaxed, self.per_time(parameters));
        let method = if selected.exhaustive { Method::Exhaustive } else { Method::Exchange };
        let design = Design {
            shares: selected.shares,
            log_det: selected.value,
            sensitivities: selected.sensitivities,
            gap: selected.gap,
            ..relaxed.clone()
        };
        Ok(Restricted { design, method, tried: selected.tried, loss })
    }

    fn selected(
        &self,
        relaxed: &Design,
        bounds: &Bounds,
        most: usize,
        options: &Options,
    ) -> Result<Selected, Error> {
        let options = &Options { tolerance: options.tolerance.max(RESTRICTED_TOLERANCE), ..*options };
        match self {
            Self::Information(candidates) => {
                let (scaled, offset) = candidates.scaled()?;
                let mut balanced = relaxed.clone();
                balanced.log_det -= offset;
                let mut selected = select(&scaled, &balanced, bounds, most, options)?;
                selected.value += offset;
                Ok(selected)
            }
            Self::Covariance(c) => select(&c.covariance, relaxed, bounds, most, options),
        }
    }

    /// The best counts.
    ///
    /// # Errors
    /// As [`count_segments`].
    pub fn count(
        &self,
        shares: &[f64],
        total: u64,
        limits: Option<&[u64]>,
        options: &CountOptions,
    ) -> Result<Counted, Error> {
        match self {
            Self::Information(candidates) => {
                let (scaled, offset) = candidates.scaled()?;
                let mut counted = count_segments(&scaled, shares, total, limits, options)?;
                counted.value += offset;
                counted.apportioned += offset;
                Ok(counted)
            }
            Self::Covariance(c) => count_segments(&c.covariance, shares, total, limits, options),
        }
    }

    /// The value at `shares`; `None` if it is not defined.
    pub fn value(&self, shares: &[f64]) -> Option<f64> {
        match self {
            Self::Information(candidates) => candidates.value(shares, &mut Evaluation::default()),
            Self::Covariance(c) => c.covariance.value(shares, &mut CovariancePoint::default()),
        }
    }

    /// The value of one whole experiment among those of `dictionary`, from its own matrices; `None` if it is not defined.
    pub fn of_experiment(
        &self,
        dictionary: &Dictionary,
        information: &Candidates,
        meat: Option<&Candidates>,
    ) -> Option<f64> {
        let Self::Covariance(c) = self else {
            let (scaled, offset) = information.scaled().ok()?;
            return scaled.value(&[1.0], &mut Evaluation::default()).map(|value| value + offset);
        };
        let covariance = match &c.of {
            Weighed::Matrix(g) => Covariance::of_matrices(information, meat?, std::slice::from_ref(g)),
            Weighed::Functions(functions) => Covariance::of_functions(information, meat?, functions),
            Weighed::Parameters => {
                let rows = dictionary.by_row(&c.weights);
                Covariance::new(information, meat?, &rows, c.covariance.norm())
            }
        };
        covariance.ok()?.value(&[1.0], &mut CovariancePoint::default())
    }

    /// g_q of every candidate at `shares`; `None` if the criterion is not defined.
    pub fn sensitivities(&self, shares: &[f64]) -> Option<Vec<f64>> {
        fn of<O: Objective>(objective: &O, shares: &[f64]) -> Option<Vec<f64>> {
            let mut at = O::Point::default();
            objective.evaluate(shares, &mut at).map(|_| objective.sensitivities(&at))
        }
        match self {
            Self::Information(candidates) => of(candidates, shares),
            Self::Covariance(c) => of(&c.covariance, shares),
        }
    }

    /// The criterion's gain per log of time at fixed shares: p = Σ w_q g_q.
    pub fn degree(&self) -> f64 {
        match self {
            Self::Information(candidates) => Objective::degree(candidates),
            Self::Covariance(c) => c.covariance.degree(),
        }
    }

    /// The divisor that turns a loss of the criterion into one of time: the degree, except for log|det| of the
    /// information, where intercepts add rows but no parameters of interest: there the number of `parameters`.
    pub fn per_time(&self, parameters: usize) -> f64 {
        match self {
            Self::Information(_) => parameters as f64,
            Self::Covariance(_) => self.degree(),
        }
    }

    /// The efficiency of other shares against `design`'s. `parameters`: their number.
    pub fn efficiency(&self, design: &Design, shares: &[f64], parameters: usize) -> f64 {
        match self {
            Self::Information(candidates) => design.efficiency(candidates, shares, parameters),
            Self::Covariance(_) => {
                let value = self.value(shares);
                value.map_or(0.0, |value| libm::exp((value - design.log_det) / self.degree()))
            }
        }
    }

    /// [`Criterion::efficiency`] of every candidate on its own.
    pub fn single_efficiencies(&self, design: &Design, parameters: usize) -> Vec<f64> {
        match self {
            Self::Information(candidates) => design.single_efficiencies(candidates, parameters),
            Self::Covariance(_) => {
                alone(design.shares.len(), |shares| self.efficiency(design, shares, parameters))
            }
        }
    }
}

// Figures that an owner asks of a model, to first order in its parameters: g = ∂figure/∂θ, and the variance of a
// figure is gᵀ C g for a covariance C of the parameters.

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
fn weighted(figures: &[WeightedFigure], parameters: &[f64]) -> Vec<Vec<f64>> {
    let n = parameters.len();
    let mut sum: Vec<f64> = (0..n * n).map(|k| if k % (n + 1) == 0 { IDENTITY } else { 0.0 }).collect();
    for figure in figures.iter().filter(|figure| figure.weight > 0.0) {
        let factor = figure.weight.sqrt() / figure.value;
        let relative: Vec<f64> =
            figure.slopes.iter().zip(parameters).map(|(slope, value)| factor * slope * value).collect();
        for (row, factor) in sum.chunks_exact_mut(n.max(1)).zip(&relative) {
            row.iter_mut().zip(&relative).for_each(|(entry, other)| *entry += factor * other);
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

/// The criteria by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CriterionName {
    /// log|det| of the information matrix (the paper's).
    DHessian,
    /// log det of the estimate's covariance.
    D,
    /// Sum of the variances.
    A,
    /// Sum of the variances relative to the parameters' squares.
    ARelative,
    /// Variance of free runs over the validation maneuvers.
    V,
    /// Sum of the variances of figures of merit relative to their squares.
    Figures,
}

impl CriterionName {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::DHessian, Self::D, Self::A, Self::ARelative, Self::V, Self::Figures];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        ["d-hessian", "d", "a", "a-relative", "v", "figures"][self as usize]
    }

    /// The name in reports.
    pub fn title(self) -> &'static str {
        let names = ["D", "covariance D", "covariance A", "covariance relative A", "covariance V", "figures"];
        names[self as usize]
    }

    /// Its meaning in one line.
    pub fn description(self) -> &'static str {
        let all = [
            "log|det| of the information matrix (the paper's)",
            "log det of the estimate's covariance",
            "Sum of the variances",
            "Sum of the variances relative to the parameters' squares",
            "Variance of free runs over the validation maneuvers (with --for output-error)",
            "Sum of the variances of figures of merit relative to their squares (with --figures)",
        ];
        all[self as usize]
    }
}
