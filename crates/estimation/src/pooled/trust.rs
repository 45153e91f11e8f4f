use std::borrow::Cow;

use regression::pooled::{
    AnyParts, AnyRuns, Centring, Meat, Part, PartView, Regression, ResidualTests, Solution, Status, Strength,
    Unread, Whiteness, default_bandwidth, residuals_of, unidentified, weakest,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::DegreeOfFreedom;

use super::resampler::{Resampler, Resampling};
use super::{Bootstrap, Estimated, FreeRunErrors, Pool, Resample, Score, deviations};
use crate::validate::{StateDeviations, StateMeans};
use crate::{EstimateStatus, Estimator};

/// Options for judging an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Judgement {
    /// Resamples of the bootstrap over parts.
    pub replicates: u32,
    /// Seed of the bootstrap.
    pub seed: u64,
}

/// How far the estimate of one degree of freedom can be trusted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DegreeTrust {
    /// `surge`, `sway` or `yaw`.
    pub name: String,
    /// Whether there is an estimate.
    pub status: EstimateStatus,
    /// Why it is not identifiable.
    pub reason: Option<String>,
    /// What the estimate was made with: `auto` takes one for each degree of freedom.
    pub estimator: Estimator,
    /// Condition number of the correlations between instruments and regressors; null where singular.
    pub condition: Option<f64>,
    /// Condition index of instruments and regressors with the intercept; from 30 on collinear. Null where singular.
    pub condition_index: Option<f64>,
    /// The direction that the data tell least about.
    pub weakest: String,
    /// Its parameters.
    pub parameters: Vec<ParameterTrust>,
    /// Correlations between the estimates: row-major, as many rows as parameters.
    pub correlation: Option<Vec<f64>>,
    /// Whether the residuals are white: Ljung and Box.
    pub whiteness: Option<Whiteness>,
    /// The largest correlation of residuals with instruments at other times.
    pub instrument_residual: Option<InstrumentResidual>,
    /// How well the instruments follow the measured state: 100 (1 − RMSE/std) over the sub-experiments.
    pub instrument_fit: Option<f64>,
}

impl DegreeTrust {
    pub(super) fn without_errors(&mut self) {
        self.correlation = None;
        for parameter in &mut self.parameters {
            (parameter.standard_error, parameter.bootstrap_std) = (None, None);
            (parameter.bootstrap_low, parameter.bootstrap_high) = (None, None);
        }
    }

    /// The parameter with the largest relative standard error.
    pub fn weakest_parameter(&self) -> &str {
        let relative = |p: &ParameterTrust| match (p.estimate, p.spread()) {
            (Some(estimate), Some(error)) if estimate != 0.0 => (error / estimate).abs(),
            _ => 1.0 / p.variation.max(1e-300),
        };
        let largest = self.parameters.iter().max_by(|a, b| relative(a).total_cmp(&relative(b)));
        largest.map_or("", |p| p.name.as_str())
    }
}

/// How far the estimate of one parameter can be trusted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterTrust {
    /// Name as in `vessel.toml`.
    pub name: String,
    /// Its term.
    pub term: String,
    /// Its unit.
    pub unit: String,
    /// The estimate.
    pub estimate: Option<f64>,
    /// Its standard error: sandwich with autocorrelation; of `output-error` with any correlation within a sub-experiment.
    /// None at a bound, and where there is only one.
    pub standard_error: Option<f64>,
    /// Whether it lies at a bound beyond which the data pull it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub at_bound: bool,
    /// Its standard deviation over the resamples.
    pub bootstrap_std: Option<f64>,
    /// 2.5 % of the resamples are below.
    pub bootstrap_low: Option<f64>,
    /// 2.5 % are above.
    pub bootstrap_high: Option<f64>,
    /// Size of the term without its mean over its size: 0 for a constant.
    pub variation: f64,
    /// Shea's partial R² of the instruments: 1 least squares, near 0 instruments that have lost the motion.
    pub instrument_strength: Option<f64>,
}

impl ParameterTrust {
    pub(super) fn spread(&self) -> Option<f64> {
        self.standard_error.or(self.at_bound.then_some(0.0))
    }
}

/// A correlation of residuals with an instrument.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InstrumentResidual {
    /// The instrument's term.
    pub instrument: String,
    /// Samples by which the instrument comes earlier; below 0 later.
    pub lag: i64,
    /// The correlation.
    pub strongest: f64,
    /// Probability of a larger one, of all lags and instruments tried, under independence.
    pub p_value: f64,
}

/// Free simulation over one run or recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SourceErrors {
    /// Its name.
    pub source: String,
    /// Samples simulated.
    pub samples: u64,
    /// Simulations that diverged.
    pub diverged: u64,
    /// Root mean square errors and fits; null where a simulation diverged or there is no model.
    pub errors: Option<FreeRunErrors>,
}

pub(super) struct Judge<'a> {
    pub pool: &'a Pool<'a>,
    pub estimated: &'a Estimated,
    pub parts: &'a AnyParts<'a>,
    pub judgement: &'a Judgement,
    pub resampling: Resampling<'a>,
}

impl Judge<'_> {
    pub(super) fn samples(&self) -> usize {
        (0..self.parts.count()).map(|i| self.parts.samples(i)).sum()
    }

    /// Lags of Bartlett's weights.
    pub(super) fn bandwidth(&self) -> usize {
        default_bandwidth(self.samples())
    }

    pub(super) fn degrees(&self) -> Result<Vec<DegreeTrust>, Unread> {
        let mut accounts =
            DegreeOfFreedom::ALL.map(|d| Account::new(self.estimated, d as usize, self.bandwidth()));
        let mut fit = InstrumentFit::new(self.estimated);
        let mut i = 0;
        self.parts.each(&mut |part| {
            self.account(i, &part, &mut accounts, &mut fit);
            i += 1;
        })?;
        let (fits, resamples) = (fit.found(), self.resamples()?);
        let layout = self.pool.vessel.model.layout();
        let closed = |account: Account| {
            let d = account.d;
            let bootstrap = Bootstrap::of_resamples(&resamples, &layout.terms(d));
            DegreeTrust { instrument_fit: fits.map(|fits| fits[d]), ..account.closed(self, bootstrap) }
        };
        Ok(accounts.map(closed).into())
    }

    fn account(&self, i: usize, part: &PartView, accounts: &mut [Account; 3], fit: &mut InstrumentFit) {
        let instruments = self.estimated.instruments.as_deref();
        // Parts that diverge were refused before.
        let simulated = instruments.and_then(|model| self.pool.regression(part, Some(model)).ok());
        if let Some((_, states)) = &simulated {
            fit.add(states, part.run.measured);
        }
        let by = |account: &&mut Account| self.estimated.simulated(account.d).is_some();
        let (instrumented, others): (Vec<_>, Vec<_>) = accounts.iter_mut().partition(by);
        if let Some((regression, _)) = simulated {
            instrumented.into_iter().for_each(|account| account.add(i, &regression));
        }
        if !others.is_empty() {
            let regression = Regression::of(&self.pool.vessel.model, part);
            others.into_iter().for_each(|account| account.add(i, &regression));
        }
    }

    fn resamples(&self) -> Result<Cow<'_, [Resample]>, Unread> {
        let Judgement { replicates, seed, .. } = *self.judgement;
        match self.resampling {
            Resampling::Given(resamples) => Ok(Cow::Borrowed(resamples)),
            Resampling::Drawn(_) if replicates == 0 => Ok(Cow::Borrowed(&[])),
            Resampling::Drawn(done) => {
                let resampler = Resampler::new(self.pool, self.estimated, self.parts, seed)?;
                Ok(Cow::Owned(resampler.first(replicates, done)?))
            }
        }
    }

    pub(super) fn sources(&self, runs: &dyn AnyRuns) -> Result<Vec<SourceErrors>, Unread> {
        let model = self.estimated.parameters(&self.pool.model);
        let mut sources = Vec::with_capacity(runs.sources());
        runs.each_source(&mut |name, parts| sources.push(self.source(name, &parts, model.as_deref())))?;
        Ok(sources)
    }

    fn source(&self, source: &str, windows: &[Part], model: Option<&[f64]>) -> SourceErrors {
        let std = deviations(windows.iter().map(|w| w.measured.as_slice()));
        let views = || windows.iter().map(Part::view);
        let score = model.map(|model| Score::of(&self.pool.model, model, views()));
        SourceErrors {
            source: source.to_owned(),
            samples: windows.iter().map(|w| w.samples() as u64).sum(),
            diverged: score.map_or(0, |score| score.diverged),
            errors: score.and_then(|score| score.errors(std)),
        }
    }
}

struct Account<'a> {
    d: usize,
    centring: Centring,
    solution: Option<&'a Solution>,
    meat: Option<Meat>,
    tests: ResidualTests,
    strength: Strength,
}

impl<'a> Account<'a> {
    fn new(estimated: &'a Estimated, d: usize, bandwidth: usize) -> Self {
        let (sums, solution) = (estimated.data(d), estimated.degrees[d].solution.as_ref());
        let p = sums.total().degrees[d].parameters();
        // An estimate of a search has a covariance of its own.
        let searches = estimated.searched.is_some() && estimated.used[d].searches();
        Self {
            d,
            centring: sums.centring(),
            solution,
            meat: solution.filter(|_| !searches).map(|_| Meat::new(p, bandwidth)),
            tests: ResidualTests::new(bandwidth.max(1), p),
            strength: Strength::default(),
        }
    }

    fn add(&mut self, i: usize, part: &Regression) {
        let (d, degree, centring) = (self.d, &part.degrees[self.d], &self.centring);
        self.strength.add(i, degree, centring, d);
        let Some(solution) = self.solution else { return };
        let residuals = residuals_of(part, i, centring, solution, d);
        let (mut columns, mut row) = (vec![Vec::with_capacity(part.samples); degree.parameters], Vec::new());
        for k in 0..part.samples {
            centring.zeta(i, d, degree.zeta(k), &mut row);
            columns.iter_mut().zip(&row).for_each(|(column, z)| column.push(*z));
        }
        self.tests.add(&residuals, &columns);
        if let Some(meat) = &mut self.meat {
            meat.add(degree, &residuals, |row, out| centring.zeta(i, d, row, out));
        }
    }

    fn closed(self, judge: &Judge, bootstrap: Option<Bootstrap>) -> DegreeTrust {
        let Judge { pool, estimated, parts, .. } = *judge;
        let (d, solution, fit, used) =
            (self.d, self.solution, &estimated.degrees[self.d], estimated.used[self.d]);
        let (degree, model) = (DegreeOfFreedom::ALL[d], &pool.vessel.model.degrees[d]);
        let searched = || {
            let (searched, _) = estimated.searched.as_ref()?;
            Some(searched.covariance_of(pool.model.layout().terms(d)))
        };
        let covariance = solution.and_then(|solution| match self.meat {
            Some(meat) => Some(meat.covariance(&self.centring, solution, d)),
            None => searched(),
        });
        // Errors of a search compare parts.
        let covariance = covariance.filter(|_| parts.count() > 1 || !used.searches());
        let crossed = solution.and_then(|_| self.tests.strongest());
        let diagnosis = estimated.data(d).diagnose(d);
        let (strength, p) = (self.strength.partial(), model.terms.len());
        let units = &pool.vessel.model.parameter_units()[pool.vessel.model.layout().degree(d)];
        let at_bound = |i: usize| solution.is_some_and(|s| model.at_bound(i, s.theta[i]));
        let error = |i: usize| covariance.as_ref().map(|c| c[i * p + i].max(0.0).sqrt());
        let resampled = |i: usize| bootstrap.as_ref().map(|b| b.parameters[i]);
        let parameter = |i: usize| ParameterTrust {
            name: model.parameters[i].clone(),
            term: model.terms[i].text.clone(),
            unit: units[i].clone(),
            estimate: solution.map(|s| s.theta[i]),
            standard_error: error(i).filter(|_| !at_bound(i)),
            at_bound: at_bound(i),
            bootstrap_std: resampled(i).map(|r| r.std),
            bootstrap_low: resampled(i).map(|r| r.low),
            bootstrap_high: resampled(i).map(|r| r.high),
            variation: diagnosis.variation[i],
            instrument_strength: strength.as_ref().map(|s| s[i]),
        };
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        DegreeTrust {
            name: degree.name().to_owned(),
            status: match fit.status {
                Status::Identified => EstimateStatus::Identified,
                _ => EstimateStatus::NotIdentifiable,
            },
            reason: unidentified(degree, model, &fit.status, &pool.constant),
            estimator: used,
            condition: finite(diagnosis.condition),
            condition_index: finite(diagnosis.index),
            weakest: weakest(degree, model, &diagnosis, &pool.constant),
            parameters: (0..p).map(parameter).collect(),
            correlation: covariance.as_deref().and_then(|c| correlation(c, p, at_bound)),
            whiteness: solution.map(|_| self.tests.whiteness()),
            instrument_residual: crossed.map(|c| InstrumentResidual {
                instrument: model.terms[c.instrument].text.clone(),
                lag: c.lag,
                strongest: c.correlation,
                p_value: c.p_value,
            }),
            instrument_fit: None,
        }
    }
}

fn correlation(covariance: &[f64], p: usize, held: impl Fn(usize) -> bool) -> Option<Vec<f64>> {
    let size = |i: usize| covariance[i * p + i].sqrt();
    let entry = |k: usize| match held(k / p) || held(k % p) {
        true => 0.0,
        false => covariance[k] / (size(k / p) * size(k % p)),
    };
    let entries: Vec<f64> = (0..p * p).map(entry).collect();
    entries.iter().all(|x| x.is_finite()).then_some(entries)
}

/// How well the instruments' u, v, r follow the measured ones, part by part.
#[derive(Clone, Debug)]
pub struct InstrumentFit {
    squares: [f64; 3],
    samples: f64,
    deviations: StateDeviations,
}

impl InstrumentFit {
    /// The fit over the parts of `estimated`.
    pub fn new(estimated: &Estimated) -> Self {
        Self::from_deviations(estimated.means().deviations())
    }

    /// The fit over parts with these `measured` states.
    pub fn of<'a>(measured: impl Iterator<Item = &'a [f64]>) -> Self {
        let mut means = StateMeans::default();
        measured.for_each(|states| means.add(states));
        Self::from_deviations(means.deviations())
    }

    fn from_deviations(deviations: StateDeviations) -> Self {
        Self { squares: [0.0; 3], samples: 0.0, deviations }
    }

    /// Adds a part: the states that its instruments are formed with, and the measured ones.
    pub fn add(&mut self, states: &[f64], measured: &[f64]) {
        self.deviations.add(measured);
        for (z, y) in states.chunks_exact(3).zip(measured.chunks_exact(3)).skip(1) {
            (0..3).for_each(|d| self.squares[d] += (z[d] - y[d]) * (z[d] - y[d]));
            self.samples += 1.0;
        }
    }

    /// 100 (1 − RMSE/std) \[%\]; `None` if a state does not vary, and without instruments.
    pub fn found(&self) -> Option<[f64; 3]> {
        let std = self.deviations.std();
        let fits = [0, 1, 2].map(|d: usize| 100.0 * (1.0 - (self.squares[d] / self.samples).sqrt() / std[d]));
        fits.iter().all(|f| f.is_finite()).then_some(fits)
    }
}
