//! One estimate from many sub-experiments, and how far it can be trusted.
//!
//! Scalars instead of lanes: measured data sets are small.

mod delivered;
mod estimate;
mod resampler;
mod search;
mod searched;
pub(crate) mod statements;
mod trust;

use std::fmt;

use numerics::LANES;
use refusal::{Invalid, listed};
use regression::pooled::{
    AnyParts, COLLINEAR, CutRuns, DegreeFit, Faults, LostInstruments, NominalModel, Options, PartView, Parts,
    PooledRuns, PooledSums, Prior, Recorded, Regression, Unread, joined, unidentified,
};
use regression::{MeanRemoval, Sums};
use ship::model::{Degree, DegreeOfFreedom, Model, Vessel};
use thiserror::Error;

use crate::Estimator;
use crate::criticism::Kinds;
use crate::estimator::AdditionalUnknowns;
use crate::predictor::{InitialState, Unknown};
use crate::validate::StateMeans;

pub use crate::validate::{FreeRunErrors, Score, deviations};
pub use delivered::{
    Covariance, Covered, Delivered, FoundUnknown, RecordingConstant, Surroundings, Uncertain, covered,
};
pub use estimate::{PoolError, Pooled, StandardErrors, estimate, resampled, standard_errors, unstated};
pub use resampler::{Bootstrap, Resample, Resampled, Resampling, redraw};
pub use searched::{Follow, Scales, Searched, least_errors};
pub use statements::{collinear, lies_above};
pub use trust::{DegreeTrust, InstrumentFit, InstrumentResidual, Judgement, ParameterTrust, SourceErrors};

/// The options of all estimates of a study.
#[derive(Clone)]
pub struct Pool<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// Its model with intercepts.
    pub model: Model,
    /// The intercepts.
    pub removal: MeanRemoval,
    /// Strength of the prior.
    pub strength: f64,
    /// The source of the instruments.
    pub nominal: NominalModel,
    /// Maximum number of samples of a part; segments are not cut without it.
    pub part_samples: Option<usize>,
    /// Additional unknowns of searches.
    pub additional: AdditionalUnknowns,
    /// Logged channels that never vary, named in warnings about terms that hardly vary.
    pub constant: Vec<String>,
}

/// An estimate of pooled parts.
pub struct Estimated {
    /// Surge, sway, yaw.
    pub degrees: [DegreeFit; 3],
    /// The estimator of each.
    pub used: [Estimator; 3],
    /// Nominal parameters and intercepts, if there were any.
    pub nominal: Option<(Vec<f64>, [f64; 3])>,
    /// The result of a search and its scales, if one was requested and converged.
    pub searched: Option<(Searched, Scales)>,
    /// The kinds of noise that predictions found; empty without predictions.
    noises: Kinds,
    /// Set if a requested search found no model: then no degree of freedom has an estimate.
    pub unfound: Option<Unfound>,
    /// Why instruments could not be simulated for `auto`, which then is least squares.
    pub diverged: Option<LostInstruments>,
    /// Parameters of the model with intercepts that the instruments were simulated with.
    pub instruments: Option<Vec<f64>>,
    /// Sums of the parts with the regressors as instruments.
    ls: PooledSums,
    /// Those with simulated instruments.
    iv: Option<PooledSums>,
    /// Of the measured states.
    means: StateMeans,
}

/// Why there is no estimate.
#[derive(Clone, Debug, PartialEq)]
pub enum NoEstimate<E> {
    /// The simulation of the instruments diverges.
    Lost(LostInstruments),
    /// The parts cannot be read.
    Unread(E),
}

impl NoEstimate<Unread> {
    fn restored<E>(self, faults: &Faults<E>) -> NoEstimate<E> {
        match self {
            Self::Lost(lost) => NoEstimate::Lost(lost),
            Self::Unread(unread) => NoEstimate::Unread(faults.take(unread)),
        }
    }
}

impl Estimated {
    /// The sums that degree of freedom `d` was estimated from.
    pub fn data(&self, d: usize) -> &PooledSums {
        self.iv.as_ref().filter(|_| self.by_instruments(d)).unwrap_or(&self.ls)
    }

    /// The model that simulated the instruments of degree of freedom `d`; `None` if they are the regressors.
    pub fn simulated(&self, d: usize) -> Option<&[f64]> {
        self.instruments.as_deref().filter(|_| self.iv.is_some() && self.by_instruments(d))
    }

    fn by_instruments(&self, d: usize) -> bool {
        self.used[d] == Estimator::Iv
    }

    fn least_squares_sums(&self) -> &PooledSums {
        &self.ls
    }

    fn means(&self) -> &StateMeans {
        &self.means
    }

    /// θ̂ of all degrees of freedom, and their intercepts; none unless all have one.
    pub fn theta(&self) -> Option<(Vec<f64>, [f64; 3])> {
        whole(&self.degrees)
    }

    /// Standard errors of θ̂ by white innovations, which tell even of one part; `None` without predictions.
    fn errors_of_predictions(&self, pool: &Pool) -> Option<Vec<f64>> {
        let (searched, scales) = self.searched.as_ref()?;
        let layout = pool.model.layout();
        let of_degree = |d| {
            let places = layout.terms(d);
            let covariance = searched.covariance_of(places.clone());
            (0..places.len())
                .map(|i| covariance[i * (places.len() + 1)].max(0.0).sqrt())
                .collect::<Vec<f64>>()
        };
        matches!(scales.follow(), Follow::Predicted(..)).then(|| (0..3).flat_map(of_degree).collect())
    }

    /// Whether instruments were simulated.
    pub fn instrumented(&self) -> bool {
        self.iv.is_some()
    }

    /// θ̂ and intercepts, in the order of `model`, which has them.
    pub fn parameters(&self, model: &Model) -> Option<Vec<f64>> {
        self.theta().map(|(theta, intercepts)| model.layout().woven(&theta, intercepts))
    }
}

fn whole(degrees: &[DegreeFit; 3]) -> Option<(Vec<f64>, [f64; 3])> {
    joined(degrees.each_ref().map(|degree| degree.solution.as_ref()))
}

impl<'a> Pool<'a> {
    /// The default: an intercept everywhere, instruments by the nominal values of `vessel`.
    pub fn new(vessel: &'a Vessel) -> Self {
        Self {
            vessel,
            model: vessel.model.with_intercepts(),
            removal: MeanRemoval::Complete,
            strength: 0.0,
            nominal: NominalModel::Known(vessel.nominal.clone()),
            part_samples: None,
            additional: AdditionalUnknowns::default(),
            constant: Vec::new(),
        }
    }
}

impl Pool<'_> {
    /// The default estimator; `None` if the noise decides, see [`unstated`]. `simulated`: the runs are simulated ones.
    pub fn usual(&self, simulated: bool) -> Option<Estimator> {
        match simulated || self.strength > 0.0 {
            true => Some(Estimator::Iv),
            false => (self.additional != AdditionalUnknowns::default()).then_some(Estimator::OutputError),
        }
    }

    /// Refuses contradictions: see [`MeanRemoval::check`]; a prior together with bounds.
    ///
    /// # Errors
    /// Names the parameter.
    pub fn check(&self) -> Result<(), Invalid> {
        self.removal.check(&self.vessel.model)?;
        let bounded = |degree: &'_ Degree| degree.bounds.keys().next().map(|i| degree.parameters[*i].clone());
        match self.vessel.model.degrees.iter().find_map(bounded).filter(|_| self.strength > 0.0) {
            None => Ok(()),
            Some(name) => Err(Invalid::new(
                format!("parameter `{name}`"),
                "`bounds` beside a prior",
                "one of them: either holds an estimate back",
                "remove the bounds, or leave out --prior",
            )),
        }
    }

    /// The same for another vessel, whose instruments are simulated with `nominal`.
    pub fn of<'v>(&self, vessel: &'v Vessel, nominal: NominalModel) -> Pool<'v> {
        let constant = self.constant.clone();
        Pool { vessel, model: vessel.model.with_intercepts(), nominal, constant, ..*self }
    }

    /// Cuts `runs` into segments, or takes whole runs if a current is unknown, which stays throughout a run.
    pub fn cut<'r, R: Recorded>(&self, runs: &'r PooledRuns<R>) -> CutRuns<'r, R> {
        match self.unknown().current {
            None => runs.cut(self.part_samples),
            Some(_) => runs.whole(self.part_samples),
        }
    }

    fn unknown(&self) -> Unknown {
        Unknown::new(InitialState::Known, self.additional, 1.0 / self.vessel.sample_rate_hz)
    }

    /// Estimates from `parts`, with a pass over them for every kind of sums, and for every step of a search.
    ///
    /// # Errors
    /// The nominal simulation diverges; parts that cannot be read.
    pub fn estimate<P: Parts>(&self, parts: &P, by: Estimator) -> Result<Estimated, NoEstimate<P::Error>> {
        let faults = Faults::default();
        self.estimate_any(&faults.erased(parts), by).map_err(|e| e.restored(&faults))
    }

    fn estimate_any(&self, parts: &AnyParts, estimator: Estimator) -> Result<Estimated, NoEstimate<Unread>> {
        let mut means = StateMeans::default();
        let ls = self.sums_any(parts, None, &mut |part, _| means.add(part.run.measured))?;
        let nominal = self.nominal.parameters(&ls);
        let fitted =
            ls.fit(&self.options(nominal.as_ref().map(|(theta, _)| theta.as_slice()), Estimator::Ls));
        let mut estimated = Estimated {
            degrees: fitted,
            used: [Estimator::Ls; 3],
            nominal,
            searched: None,
            noises: Vec::new(),
            unfound: None,
            diverged: None,
            instruments: None,
            ls,
            iv: None,
            means,
        };
        if estimator == Estimator::Ls {
            return Ok(estimated);
        }
        // If least squares found no model to simulate, nothing is identified in any case.
        if let Some(nominal) = estimated.nominal.clone() {
            match self.instrumented(parts, estimator, nominal, &mut estimated) {
                Err(NoEstimate::Lost(diverged)) if estimator == Estimator::Auto || estimator.searches() => {
                    estimated.diverged = Some(diverged);
                }
                result => result?,
            }
        }
        if estimator.searches() {
            self.searched(parts, estimator, &mut estimated).map_err(NoEstimate::Unread)?;
        }
        Ok(estimated)
    }

    /// The least-squares estimate of the data of `estimated`, and its intercepts.
    pub fn least_squares(&self, estimated: &Estimated) -> Option<(Vec<f64>, [f64; 3])> {
        let nominal = estimated.nominal.as_ref().map(|(theta, _)| theta.as_slice());
        whole(&estimated.ls.fit(&self.options(nominal, Estimator::Ls)))
    }

    /// The regression of a part, and the states of its instruments: simulated from the measured state with these
    /// parameters of the model with intercepts; else the regressors are the instruments.
    ///
    /// # Errors
    /// The simulation diverges.
    pub fn regression(
        &self,
        part: &PartView,
        simulated: Option<&[f64]>,
    ) -> Result<(Regression, Vec<f64>), LostInstruments> {
        let Some(parameters) = simulated else {
            return Ok((Regression::of(&self.vessel.model, part), Vec::new()));
        };
        let states = part.simulated(&self.model, parameters)?;
        Ok((Regression::with(&self.vessel.model, part, &states).after_start(), states))
    }

    /// The sums of `parts` with instruments as in [`Pool::regression`]. `look` is called with every part and the sums of it.
    ///
    /// # Errors
    /// The first part whose simulation diverges; parts that cannot be read.
    pub fn sums<P: Parts>(
        &self,
        parts: &P,
        simulated: Option<&[f64]>,
        mut look: impl FnMut(PartView, &Sums),
    ) -> Result<PooledSums, NoEstimate<P::Error>> {
        let faults = Faults::default();
        self.sums_any(&faults.erased(parts), simulated, &mut look).map_err(|e| e.restored(&faults))
    }

    fn sums_any(
        &self,
        parts: &AnyParts,
        simulated: Option<&[f64]>,
        look: &mut dyn FnMut(PartView, &Sums),
    ) -> Result<PooledSums, NoEstimate<Unread>> {
        let (mut sums, mut lost) = (PooledSums::new(self.removal), None);
        let mut add = |part: PartView| {
            if lost.is_some() {
                return;
            }
            match self.regression(&part, simulated) {
                Ok((regression, _)) => {
                    let part_sums = regression.sums();
                    sums.add(&part_sums);
                    look(part, &part_sums);
                }
                Err(diverged) => lost = Some(diverged),
            }
        };
        parts.each(&mut add).map_err(NoEstimate::Unread)?;
        lost.map_or(Ok(sums), |lost| Err(NoEstimate::Lost(lost)))
    }

    fn instrumented(
        &self,
        parts: &AnyParts,
        estimator: Estimator,
        (theta, intercepts): (Vec<f64>, [f64; 3]),
        estimated: &mut Estimated,
    ) -> Result<(), NoEstimate<Unread>> {
        let model = self.model.layout().woven(&theta, intercepts);
        let data = self.sums_any(parts, Some(&model), &mut |_, _| {})?;
        let degrees = data.fit(&self.options(Some(&theta), Estimator::Iv));
        for (d, degree) in degrees.into_iter().enumerate() {
            if degree.solution.is_some() || !(estimator == Estimator::Auto || estimator.searches()) {
                (estimated.degrees[d], estimated.used[d]) = (degree, Estimator::Iv);
            }
        }
        (estimated.iv, estimated.instruments) = (Some(data), Some(model));
        Ok(())
    }

    /// Why degrees of freedom have no estimate, in words.
    pub fn unidentified(&self, degrees: &[DegreeFit; 3]) -> Vec<String> {
        let why = |d: DegreeOfFreedom| {
            let (degree, fit) = (&self.vessel.model.degrees[d as usize], &degrees[d as usize]);
            unidentified(d, degree, &fit.status, &self.constant)
        };
        DegreeOfFreedom::ALL.into_iter().filter_map(why).collect()
    }

    /// The options of a fit. Least squares works with collinear columns; instruments must not be collinear.
    pub fn options<'b>(&self, nominal: Option<&'b [f64]>, used: Estimator) -> Options<'b> {
        let prior = nominal.filter(|_| self.strength > 0.0);
        Options {
            removal: self.removal,
            prior: prior.map(|nominal| Prior { strength: self.strength, nominal }),
            most: if used.by_instruments() { COLLINEAR } else { f64::INFINITY },
        }
    }
}

/// A search failed from all starts.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub struct Unfound {
    /// The requested estimator.
    pub estimator: Estimator,
    /// Recordings whose simulation from the search's start diverges; empty if a parameter has no effect of its own.
    pub recordings: Vec<String>,
}

impl fmt::Display for Unfound {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let name = self.estimator.name();
        match self.recordings.as_slice() {
            [] => write!(f, "{name}: a parameter has no effect of its own on simulations"),
            all => write!(
                f,
                "{name}: free simulations diverge from every start that was tried, short windows among them: of {}",
                listed(all)
            ),
        }
    }
}

/// Bytes that an estimate stores per run, and per part, wherever the samples are.
const KNOWN: [f64; 2] = [250.0, 60.0];

fn sample_bytes(model: &Model) -> f64 {
    8.0 * (model.exogenous() + 3) as f64
}

/// Bytes of the sums of one part, and of the row of them that is always stored.
fn sums_bytes(model: &Model) -> [f64; 2] {
    let degree = |p: usize| (p + 1) * (p + 2) + 2 * p;
    let terms = || model.degrees.iter().map(|degree| degree.terms.len());
    // Including the vectors' own size.
    let sums = 8 * terms().map(degree).sum::<usize>() + 3 * 160 + 80;
    [sums as f64, 8.0 * terms().map(|p| p + 1).sum::<usize>() as f64]
}

/// Bytes of a sample of a part while it is processed: regressions with two kinds of instruments, scores, signals.
fn look_bytes(model: &Model) -> f64 {
    let terms: usize = model.degrees.iter().map(|degree| degree.terms.len()).sum();
    8.0 * (6 * terms + 12) as f64
}

impl Pool<'_> {
    /// Upper bound on the bytes of memory of a pooled estimate of `runs`, on `threads` threads.
    pub fn bytes<R: Recorded>(
        &self,
        runs: &PooledRuns<R>,
        estimator: Estimator,
        replicates: u32,
        threads: usize,
    ) -> f64 {
        let [sums, end] = sums_bytes(&self.model);
        let parts = self.cut(runs);
        // Least squares and instruments; means of every part; sums for resamples.
        let part_bytes = if self.removal == MeanRemoval::Batch { 4.0 * end + 400.0 } else { 2.0 * end };
        // `auto` draws from sums with two kinds of instruments; every thread adds those of its own resample.
        let kinds = if estimator == Estimator::Auto { 2.0 } else { 1.0 };
        let drawn =
            if replicates > 0 { kinds * sums + 24.0 + threads as f64 * (part_bytes + 16.0) } else { 0.0 };
        let resamples = f64::from(replicates) * (16.0 * self.vessel.model.parameters() as f64 + 60.0);
        let known = KNOWN[0] * runs.count() as f64 + KNOWN[1] * parts.count() as f64;
        let (simulates, searches) = match estimator {
            used if used.searches() && replicates > 0 => (threads, threads),
            used if used.searches() => (threads, 1),
            _ => (0, 1),
        };
        let (samples, longest) = runs.samples();
        let held = if runs.held() { samples } else { 0 };
        let windows = held + 3 * longest + searches * samples.min(runs.window());
        let together = 2 * LANES * simulates * longest_of(&parts).min(samples);
        known
            + resamples
            + parts.count() as f64 * (3.0 * part_bytes + drawn)
            + (windows + together) as f64 * sample_bytes(&self.model)
            + longest_of(&parts) as f64 * look_bytes(&self.model)
    }

    /// Upper bound on the bytes of memory of estimates from picked or left-out parts of `runs`, with all runs and
    /// parts in memory, on `threads` threads.
    pub fn bytes_of_many(&self, runs: &PooledRuns, threads: usize) -> f64 {
        let [sums, end] = sums_bytes(&self.model);
        let parts = self.cut(runs);
        let several = parts.count() as f64 * (3.0 * sums + 200.0 + threads as f64 * (6.0 * end + 16.0));
        let looks = (threads * longest_of(&parts)) as f64 * look_bytes(&self.model);
        4.0 * runs.samples().0 as f64 * sample_bytes(&self.model) + several + looks
    }
}

fn longest_of(parts: &impl Parts) -> usize {
    (0..parts.count()).map(|i| parts.samples(i)).max().unwrap_or(0)
}
