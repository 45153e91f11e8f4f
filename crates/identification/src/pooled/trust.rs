use rayon::prelude::*;
use vessel::{DegreeOfFreedom, Streams};

use super::{
    Bootstrap, Centring, CrossCorrelation, Diagnosis, Errors, Estimated, Options, Part, Pool, PooledRuns,
    Regression, Resampled, Solution, Whiteness, Window, Windows, bootstrap, cross_correlation,
    default_bandwidth, deviations, diagnose, redraw, residuals, sandwich, strength, unidentified, weakest,
    whiteness,
};
use crate::{Estimator, Sums};

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
#[derive(Clone, Debug, PartialEq)]
pub struct DegreeTrust {
    /// Surge, sway or yaw.
    pub degree: DegreeOfFreedom,
    /// Why it is not identifiable, in words.
    pub reason: Option<String>,
    /// What the estimate was made with: `auto` takes one for each degree of freedom.
    pub estimator: Estimator,
    /// See [`Diagnosis::condition`].
    pub condition: f64,
    /// See [`Diagnosis::index`].
    pub index: f64,
    /// The direction that the data tell least about, in words.
    pub weakest: String,
    /// Its parameters.
    pub parameters: Vec<ParameterTrust>,
    /// Correlations between the estimates: p × p, row-major.
    pub correlation: Option<Vec<f64>>,
    /// Whether the residuals are white.
    pub whiteness: Option<Whiteness>,
    /// The largest correlation of residuals with instruments at other times.
    pub instrument_residual: Option<CrossCorrelation>,
    /// How well the instruments follow the measured state: 100 (1 − RMSE/std) \[%\].
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
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterTrust {
    /// Its name.
    pub name: String,
    /// Its term.
    pub term: String,
    /// Its unit.
    pub unit: String,
    /// The estimate.
    pub estimate: Option<f64>,
    /// Its standard error: sandwich with autocorrelation; of output error with any correlation within a part.
    pub standard_error: Option<f64>,
    /// Over the resamples of the bootstrap.
    pub resampled: Option<Resampled>,
    /// See [`Diagnosis::variation`].
    pub variation: f64,
    /// Shea's partial R² of the instruments.
    pub instrument_strength: Option<f64>,
}

/// Free simulation of a model over the windows of one run or recording.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceErrors {
    /// Its name.
    pub source: String,
    /// Windows of it.
    pub windows: usize,
    /// Their samples.
    pub samples: u64,
    /// Windows in which the simulation diverged.
    pub diverged: u64,
    /// Errors against the standard deviations of its own states; absent where a simulation diverged or there is no model.
    pub errors: Option<Errors>,
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
    data: Vec<&'a Regression>,
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
            let data: Vec<&Regression> = self.found.data(d as usize).iter().collect();
            let sums: Vec<Sums> = data.iter().map(|r| r.sums()).collect();
            let sums: Vec<&Sums> = sums.iter().collect();
            let numbers = Degree {
                data,
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
        let sums: Vec<Sums> = self.found.data(d).iter().map(Regression::sums).collect();
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
        let (whiteness, instrument_residual) = tests.map_or((None, None), |(w, c)| (Some(w), c));
        DegreeTrust {
            degree: d,
            reason: unidentified(d, model, &fit.status, &self.pool.constant),
            estimator: self.found.used[d as usize],
            condition: degree.diagnosis.condition,
            index: degree.diagnosis.index,
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
        let first: usize = whole.degrees[..d as usize].iter().map(|m| m.terms.len()).sum();
        let units = whole.parameter_units();
        let strength = strength(&degree.data, &degree.centring, d as usize);
        let parameter = |i: usize| ParameterTrust {
            name: model.parameters[i].clone(),
            term: model.terms[i].text.clone(),
            unit: units[first + i].clone(),
            estimate: solution.map(|s| s.theta[i]),
            standard_error: covariance.map(|c| c[i * p + i].max(0.0).sqrt()),
            resampled: degree.bootstrap.as_ref().map(|b| b.parameters[i]),
            variation: degree.diagnosis.variation[i],
            instrument_strength: strength.as_ref().map(|s| s[i]),
        };
        (0..p).map(parameter).collect()
    }

    /// How well the instruments' state follows the measured one.
    fn instrument_fit(&self, d: usize) -> Option<f64> {
        self.found.instrumented()?;
        Part::instrument_fit(self.parts).map(|fits| fits[d])
    }

    /// Free simulation over every source.
    pub(super) fn sources(&self, runs: &PooledRuns) -> Vec<SourceErrors> {
        let model = self.found.parameters(&self.pool.model);
        let windows = runs.windows(self.pool.vessel, None);
        let source = |(source, windows)| self.source(source, windows, model.as_deref());
        windows.into_iter().map(source).collect()
    }

    fn source(&self, source: String, windows: Vec<Window>, model: Option<&[f64]>) -> SourceErrors {
        let std = deviations(windows.iter().map(|w| w.measured.as_slice()));
        let score = model.map(|model| Windows::new(&self.pool.model, &windows).score(model));
        SourceErrors {
            source,
            windows: windows.len(),
            samples: windows.iter().map(|w| w.samples() as u64).sum(),
            diverged: score.map_or(0, |score| score.diverged),
            errors: score.and_then(|score| Errors::of(&score, std)),
        }
    }
}

fn correlation(covariance: &[f64], p: usize) -> Option<Vec<f64>> {
    let size = |i: usize| covariance[i * p + i].sqrt();
    let entries: Vec<f64> = (0..p * p).map(|k| covariance[k] / (size(k / p) * size(k % p))).collect();
    entries.iter().all(|x| x.is_finite()).then_some(entries)
}
