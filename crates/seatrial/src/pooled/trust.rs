use std::convert::Infallible;

use identification::pooled::{
    Bootstrap, Centring, Diagnosis, Part, Regression, Score, Solution, Windows, bootstrap, cross_correlation,
    default_bandwidth, diagnose, redraw, residuals, sandwich, strength, whiteness,
};
use identification::{EstimateStatus, Sums};
use vessel::{DegreeOfFreedom, Lane, Streams, Vessel};

use super::words::{unidentified, weakest};
use super::{Data, Estimated, Pool, Stretch, Used};
use crate::ordered::ordered;
use crate::progress::Progress;
use numerics::statistics::spread;
use study::documents::{FreeRunErrors, InstrumentResidual, TrustDegree, TrustParameter, TrustRun, Whiteness};

/// What the trust in an estimate is judged from.
pub struct Judge<'a> {
    pub vessel: &'a Vessel,
    pub pool: &'a Pool<'a>,
    pub found: &'a Estimated,
    pub parts: &'a [Part],
    pub bandwidth: Option<usize>,
    pub replicates: u32,
    pub seed: u64,
    pub quiet: bool,
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
    pub fn bandwidth(&self) -> usize {
        let samples = self.parts.iter().map(Part::samples).sum();
        self.bandwidth.unwrap_or_else(|| default_bandwidth(samples))
    }

    /// Surge, sway, yaw.
    pub fn degrees(&self) -> Vec<TrustDegree> {
        let mut resampled = Used::ALL.map(|used| self.resampled(used));
        DegreeOfFreedom::ALL
            .into_iter()
            .map(|d| {
                let data: Vec<&Regression> = self.found.data(d as usize).iter().collect();
                let sums: Vec<Sums> = data.iter().map(|r| r.sums()).collect();
                let sums: Vec<&Sums> = sums.iter().collect();
                let bootstrap = resampled[self.found.used[d as usize] as usize][d as usize].take();
                let degree = Degree {
                    data,
                    centring: Centring::new(&sums, self.pool.removal),
                    diagnosis: diagnose(&sums, self.pool.removal, d as usize),
                    bootstrap,
                };
                self.degree(d, &degree)
            })
            .collect()
    }

    fn resampled(&self, used: Used) -> [Option<Bootstrap>; 3] {
        let of = |d: &usize| self.found.used[*d] == used && self.found.degrees[*d].solution.is_some();
        let Some(d) = [0, 1, 2].into_iter().find(of).filter(|_| self.replicates > 0) else {
            return [const { None }; 3];
        };
        let streams = Streams::new(self.seed, "bootstrap over sub-experiments");
        if used == Used::OutputError {
            return self.simulated_again(&streams);
        }
        let sums: Vec<Sums> = self.found.data(d).iter().map(Regression::sums).collect();
        let nominal = self.nominal();
        let options = self.pool.options(nominal.as_deref(), used);
        // A resample is not refused for being collinear: its spread is what is asked for.
        let options = identification::pooled::Options { most: f64::INFINITY, ..options };
        bootstrap(&sums.iter().collect::<Vec<_>>(), &options, self.replicates, &streams)
    }

    /// The bootstrap of an output-error estimate: every resample is simulated and fitted anew.
    fn simulated_again(&self, streams: &Streams) -> [Option<Bootstrap>; 3] {
        let mut found: [Vec<Vec<f64>>; 3] = Default::default();
        let progress = Progress::new("resamples", self.replicates as usize, self.quiet);
        let work = |replicate: usize| {
            let drawn = redraw(streams, replicate as u32, self.parts.len());
            let thetas = self.pool.simulated_again(self.parts, &drawn, self.found);
            progress.advance(1);
            Ok::<_, Infallible>(thetas)
        };
        let Ok(()) = ordered(0..self.replicates as usize, work, |thetas| {
            for (own, theta) in found.iter_mut().zip(thetas.into_iter().flatten()) {
                own.push(theta);
            }
            Ok(())
        });
        found.map(|thetas| Bootstrap::of(&thetas, self.replicates as usize))
    }

    /// The nominal parameters without intercepts.
    fn nominal(&self) -> Option<Vec<f64>> {
        self.found.nominal.as_ref().map(|nominal| self.pool.lifted.layout().theta(nominal))
    }

    fn degree(&self, d: DegreeOfFreedom, degree: &Degree) -> TrustDegree {
        let fit = &self.found.degrees[d as usize];
        let model = &self.vessel.model.degrees[d as usize];
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        let covariance = fit.solution.as_ref().map(|s| self.covariance(d as usize, degree, s));
        let tests = fit.solution.as_ref().map(|solution| self.tests(d, degree, solution));
        let (white, crossed) = tests.map_or((None, None), |(w, c)| (Some(w), c));
        TrustDegree {
            name: d.name().to_owned(),
            status: match fit.solution {
                Some(_) => EstimateStatus::Identified,
                None => EstimateStatus::NotIdentifiable,
            },
            reason: unidentified(d, model, &fit.status, self.pool.constant),
            estimator: self.found.used[d as usize],
            condition: finite(degree.diagnosis.condition),
            condition_index: finite(degree.diagnosis.index),
            weakest: weakest(d, model, &degree.diagnosis, self.pool.constant),
            parameters: self.parameters(d, degree, fit.solution.as_ref(), covariance.as_deref()),
            correlation: covariance.as_deref().and_then(|c| correlation(c, model.terms.len())),
            whiteness: white,
            instrument_residual: crossed,
            instrument_fit: self.instrument_fit(d as usize),
        }
    }

    fn covariance(&self, d: usize, degree: &Degree, solution: &Solution) -> Vec<f64> {
        let Some((simulated, _)) =
            self.found.output_error.as_ref().filter(|_| self.found.used[d] == Used::OutputError)
        else {
            return sandwich(&degree.data, &degree.centring, solution, d, self.bandwidth());
        };
        let all = simulated.parameters.len();
        let first: usize = self.vessel.model.degrees[..d].iter().map(|m| m.terms.len() + 1).sum();
        let own = first..first + solution.theta.len();
        own.clone()
            .flat_map(|i| own.clone().map(move |j| (i, j)))
            .map(|(i, j)| simulated.covariance[i * all + j])
            .collect()
    }

    fn tests(
        &self,
        d: DegreeOfFreedom,
        degree: &Degree,
        solution: &Solution,
    ) -> (Whiteness, Option<InstrumentResidual>) {
        let lags = self.bandwidth().max(1);
        let residuals = residuals(&degree.data, &degree.centring, solution, d as usize);
        let white = whiteness(&residuals, lags);
        let crossed = cross_correlation(&degree.data, &residuals, &degree.centring, d as usize, lags);
        let whiteness = Whiteness {
            statistic: white.statistic,
            lags: white.lags as u64,
            p_value: white.p_value,
            first_autocorrelation: white.first,
        };
        let terms = &self.vessel.model.degrees[d as usize].terms;
        let crossed = crossed.map(|c| InstrumentResidual {
            instrument: terms[c.instrument].text.clone(),
            lag: c.lag,
            strongest: c.correlation,
            p_value: c.p_value,
        });
        (whiteness, crossed)
    }

    fn parameters(
        &self,
        d: DegreeOfFreedom,
        degree: &Degree,
        solution: Option<&Solution>,
        covariance: Option<&[f64]>,
    ) -> Vec<TrustParameter> {
        let model = &self.vessel.model.degrees[d as usize];
        let p = model.terms.len();
        let first: usize = self.vessel.model.degrees[..d as usize].iter().map(|m| m.terms.len()).sum();
        let units = self.vessel.model.parameter_units();
        let strength = strength(&degree.data, &degree.centring, d as usize);
        let resampled = |i: usize| degree.bootstrap.as_ref().map(|b| b.parameters[i]);
        let parameter = |i: usize| TrustParameter {
            name: model.parameters[i].clone(),
            term: model.terms[i].text.clone(),
            unit: units[first + i].clone(),
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
        self.found.instrumented()?;
        instrument_fit(self.parts).map(|fits| fits[d])
    }

    /// Free simulation over every source; `None` errors without a whole model.
    pub fn runs(&self, data: &Data) -> Vec<TrustRun> {
        let woven = |theta: Vec<f64>| self.pool.lifted.layout().woven(&theta, self.found.intercepts());
        let theta = self.found.theta().map(woven);
        let stretches = data.stretches();
        data.sources().iter().map(|source| self.run(source, &stretches, theta.as_deref())).collect()
    }

    fn run(&self, source: &str, stretches: &[Stretch], theta: Option<&[f64]>) -> TrustRun {
        let width = self.vessel.model.exogenous();
        let own = stretches.iter().filter(|stretch| stretch.source == source);
        let windows: Vec<_> = own.flat_map(|stretch| stretch.windows(width, None)).collect();
        let samples = windows.iter().map(|w| w.samples() as u64).sum();
        let Some(theta) = theta else {
            return TrustRun { source: source.to_owned(), samples, diverged: 0, errors: None };
        };
        let lanes: Vec<Lane> = theta.iter().copied().map(Lane::splat).collect();
        let prepared = Windows::new(self.pool.lifted, &windows);
        let mut score = Score::default();
        for i in 0..prepared.len() {
            score.add(prepared.run(&lanes, i)[0], prepared.samples(i));
        }
        let std = deviations(windows.iter().map(|w| w.measured.as_slice()));
        let errors = score.rmse().map(|rmse| FreeRunErrors::new(rmse, std));
        TrustRun { source: source.to_owned(), samples, diverged: score.diverged, errors }
    }
}

/// 100 (1 − RMSE/std) of the instruments' u, v, r over all parts. `None` where a state does not vary.
pub fn instrument_fit(parts: &[Part]) -> Option<[f64; 3]> {
    let std = deviations(parts.iter().map(|p| p.measured.as_slice()));
    let (mut squares, mut samples) = ([0.0; 3], 0.0);
    for part in parts {
        for (z, y) in part.instrument_states.chunks_exact(3).zip(part.measured.chunks_exact(3)).skip(1) {
            (0..3).for_each(|d| squares[d] += (z[d] - y[d]) * (z[d] - y[d]));
            samples += 1.0;
        }
    }
    let fit = |d: usize| 100.0 * (1.0 - (squares[d] / samples).sqrt() / std[d]);
    let fits = [0, 1, 2].map(fit);
    fits.iter().all(|f| f.is_finite()).then_some(fits)
}

/// Standard deviations of u, v, r over samples 1 to N of several (N+1) × 3 states, as of a whole population.
pub fn deviations<'a>(measured: impl Iterator<Item = &'a [f64]>) -> [f64; 3] {
    let mut states: [Vec<f64>; 3] = Default::default();
    for rows in measured {
        for row in rows.chunks_exact(3).skip(1) {
            (0..3).for_each(|d| states[d].push(row[d]));
        }
    }
    states.map(|values| {
        let n = values.len() as f64;
        spread(&values).map_or(0.0, |s| s * ((n - 1.0) / n).sqrt())
    })
}

fn correlation(covariance: &[f64], p: usize) -> Option<Vec<f64>> {
    let size = |i: usize| covariance[i * p + i].sqrt();
    let entries: Vec<f64> = (0..p * p).map(|k| covariance[k] / (size(k / p) * size(k % p))).collect();
    entries.iter().all(|x| x.is_finite()).then_some(entries)
}
