use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vessel::{DegreeOfFreedom, Streams};

use super::{
    Bootstrap, Centring, CrossCorrelation, Diagnosis, Estimated, FreeRunErrors, Options, Part, Pool,
    PooledRuns, Remade, Score, Solution, Status, Whiteness, bootstrap, cross_correlation, default_bandwidth,
    deviations, diagnose, redraw, residuals, sandwich, strength, unidentified, weakest, whiteness,
};
use crate::{EstimateStatus, Estimator, Sums};

/// How an estimate is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Judgement {
    /// Lags of Bartlett's weights in the standard errors; none: by a rule of thumb.
    pub bandwidth: Option<usize>,
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
    /// The parameter with the largest standard error for its size.
    pub fn weakest_parameter(&self) -> &str {
        let relative = |p: &ParameterTrust| match (p.estimate, p.standard_error) {
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
    pub standard_error: Option<f64>,
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

/// What the trust in an estimate is judged from.
pub(super) struct Judge<'a> {
    pub pool: &'a Pool<'a>,
    pub found: &'a Estimated,
    pub parts: &'a [Part],
    pub judgement: &'a Judgement,
    /// Called with the number of resamples that are done.
    pub resampled: &'a (dyn Fn(usize) + Sync),
}

/// Numbers of one degree of freedom.
struct Degree<'a> {
    data: Remade<'a>,
    centring: Centring,
    diagnosis: Diagnosis,
    bootstrap: Option<Bootstrap>,
}

impl Judge<'_> {
    /// Lags of Bartlett's weights.
    pub(super) fn bandwidth(&self) -> usize {
        let samples = self.parts.iter().map(Part::samples).sum();
        self.judgement.bandwidth.unwrap_or_else(|| default_bandwidth(samples))
    }

    /// Surge, sway, yaw.
    pub(super) fn degrees(&self) -> Vec<DegreeTrust> {
        let mut resampled = Estimator::ALL.map(|used| self.resampled_by(used));
        let degree = |d: DegreeOfFreedom| {
            let (sums, simulated) = self.found.data(d as usize);
            let sums: Vec<&Sums> = sums.iter().collect();
            let numbers = Degree {
                data: self.pool.regressions(self.parts, simulated),
                centring: Centring::new(&sums, self.pool.removal),
                diagnosis: diagnose(&sums, self.pool.removal, d as usize),
                bootstrap: resampled[self.found.used[d as usize] as usize][d as usize].take(),
            };
            self.degree(d, &numbers)
        };
        DegreeOfFreedom::ALL.into_iter().map(degree).collect()
    }

    fn resampled_by(&self, used: Estimator) -> [Option<Bootstrap>; 3] {
        let replicates = self.judgement.replicates;
        let of = |d: &usize| self.found.used[*d] == used && self.found.degrees[*d].solution.is_some();
        let Some(d) = [0, 1, 2].into_iter().find(of).filter(|_| replicates > 0) else {
            return [const { None }; 3];
        };
        let streams = Streams::new(self.judgement.seed, "bootstrap over sub-experiments");
        if used == Estimator::OutputError {
            return self.simulated_again(&streams);
        }
        let (sums, _) = self.found.data(d);
        let nominal = self.found.nominal.as_ref().map(|(theta, _)| theta.as_slice());
        // A resample is not refused for being collinear: its spread is what is asked for.
        let options = Options { most: f64::INFINITY, ..self.pool.options(nominal, used) };
        bootstrap(&sums.iter().collect::<Vec<_>>(), &options, replicates, &streams)
    }

    /// The bootstrap of an output-error estimate: every resample is simulated and fitted anew.
    fn simulated_again(&self, streams: &Streams) -> [Option<Bootstrap>; 3] {
        let work = |replicate: u32| {
            let drawn = redraw(streams, replicate, self.parts.len());
            let thetas = self.pool.simulated_again(self.parts, &drawn, self.found);
            (self.resampled)(1);
            thetas
        };
        let replicates = self.judgement.replicates;
        let thetas: Vec<Option<[Vec<f64>; 3]>> = (0..replicates).into_par_iter().map(work).collect();
        let mut found: [Vec<Vec<f64>>; 3] = Default::default();
        for thetas in thetas.into_iter().flatten() {
            found.iter_mut().zip(thetas).for_each(|(own, theta)| own.push(theta));
        }
        found.map(|thetas| Bootstrap::of(&thetas, replicates as usize))
    }

    fn degree(&self, d: DegreeOfFreedom, degree: &Degree) -> DegreeTrust {
        let fit = &self.found.degrees[d as usize];
        let model = &self.pool.vessel.model.degrees[d as usize];
        let covariance = fit.solution.as_ref().map(|s| self.covariance(d as usize, degree, s));
        let tests = fit.solution.as_ref().map(|solution| self.tests(d as usize, degree, solution));
        let (whiteness, crossed) = tests.map_or((None, None), |(w, c)| (Some(w), c));
        let instrument_residual = crossed.map(|c| InstrumentResidual {
            instrument: model.terms[c.instrument].text.clone(),
            lag: c.lag,
            strongest: c.correlation,
            p_value: c.p_value,
        });
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        DegreeTrust {
            name: d.name().to_owned(),
            status: match fit.status {
                Status::Identified => EstimateStatus::Identified,
                _ => EstimateStatus::NotIdentifiable,
            },
            reason: unidentified(d, model, &fit.status, &self.pool.constant),
            estimator: self.found.used[d as usize],
            condition: finite(degree.diagnosis.condition),
            condition_index: finite(degree.diagnosis.index),
            weakest: weakest(d, model, &degree.diagnosis, &self.pool.constant),
            parameters: self.parameters(d, degree, fit.solution.as_ref(), covariance.as_deref()),
            correlation: covariance.as_deref().and_then(|c| correlation(c, model.terms.len())),
            whiteness,
            instrument_residual,
            instrument_fit: self.instrument_fit(d as usize),
        }
    }

    fn covariance(&self, d: usize, degree: &Degree, solution: &Solution) -> Vec<f64> {
        let simulated = self.found.output_error.as_ref();
        let Some((simulated, _)) = simulated.filter(|_| self.found.used[d] == Estimator::OutputError) else {
            return sandwich(&degree.data, &degree.centring, solution, d, self.bandwidth());
        };
        let all = simulated.parameters.len();
        let own = self.pool.model.layout().terms(d);
        let pairs = own.clone().flat_map(|i| own.clone().map(move |j| (i, j)));
        pairs.map(|(i, j)| simulated.covariance[i * all + j]).collect()
    }

    fn tests(&self, d: usize, degree: &Degree, solution: &Solution) -> (Whiteness, Option<CrossCorrelation>) {
        let lags = self.bandwidth().max(1);
        let residuals = residuals(&degree.data, &degree.centring, solution, d);
        let crossed = cross_correlation(&degree.data, &residuals, &degree.centring, d, lags);
        (whiteness(&residuals, lags), crossed)
    }

    fn parameters(
        &self,
        d: DegreeOfFreedom,
        degree: &Degree,
        solution: Option<&Solution>,
        covariance: Option<&[f64]>,
    ) -> Vec<ParameterTrust> {
        let whole = &self.pool.vessel.model;
        let model = &whole.degrees[d as usize];
        let p = model.terms.len();
        let units = &whole.parameter_units()[whole.layout().degree(d as usize)];
        let strength = strength(&degree.data, &degree.centring, d as usize);
        let resampled = |i: usize| degree.bootstrap.as_ref().map(|b| b.parameters[i]);
        let parameter = |i: usize| ParameterTrust {
            name: model.parameters[i].clone(),
            term: model.terms[i].text.clone(),
            unit: units[i].clone(),
            estimate: solution.map(|s| s.theta[i]),
            standard_error: covariance.map(|c| c[i * p + i].max(0.0).sqrt()),
            bootstrap_std: resampled(i).map(|r| r.std),
            bootstrap_low: resampled(i).map(|r| r.low),
            bootstrap_high: resampled(i).map(|r| r.high),
            variation: degree.diagnosis.variation[i],
            instrument_strength: strength.as_ref().map(|s| s[i]),
        };
        (0..p).map(parameter).collect()
    }

    /// How well the instruments' state follows the measured one.
    fn instrument_fit(&self, d: usize) -> Option<f64> {
        let fits = self.found.instrumented().then(|| Part::instrument_fit(self.parts)).flatten();
        fits.map(|fits| fits[d])
    }

    /// Free simulation over every source.
    pub(super) fn sources(&self, runs: &PooledRuns) -> Vec<SourceErrors> {
        let model = self.found.parameters(&self.pool.model);
        runs.windows(None).map(|(source, windows)| self.source(source, windows, model.as_deref())).collect()
    }

    fn source(&self, source: String, windows: Vec<Part>, model: Option<&[f64]>) -> SourceErrors {
        let std = deviations(windows.iter().map(|w| w.measured.as_slice()));
        let views = || windows.iter().map(Part::view);
        let score = model.map(|model| Score::of(&self.pool.model, model, views()));
        SourceErrors {
            source,
            samples: windows.iter().map(|w| w.samples() as u64).sum(),
            diverged: score.map_or(0, |score| score.diverged),
            errors: score.and_then(|score| score.errors(std)),
        }
    }
}

fn correlation(covariance: &[f64], p: usize) -> Option<Vec<f64>> {
    let size = |i: usize| covariance[i * p + i].sqrt();
    let entries: Vec<f64> = (0..p * p).map(|k| covariance[k] / (size(k / p) * size(k % p))).collect();
    entries.iter().all(|x| x.is_finite()).then_some(entries)
}
