use refusal::listed;
use regression::pooled::{
    AnyParts, AnyRuns, Faults, LostInstruments, Part, PooledRuns, Recorded, Status, Unread,
};
use ship::engine::RunView;
use ship::model::DegreeOfFreedom;
use thiserror::Error;

use super::resampler::{Resampler, Resampling};
use super::statements::{collinear, statements};
use super::trust::Judge;
use super::{
    DegreeTrust, Delivered, Estimated, Follow, Judgement, NoEstimate, Pool, Resample, SourceErrors, Unfound,
};
use crate::criticism::{Absent, Criticism, Subject, Verdict, against_nominal, criticise_after, signs};
use crate::predictor::{InitialState, Unknown};
use crate::sensitivity::Flow;
use crate::{EstimateStatus, Estimator, RunEstimate};

/// One estimate from all runs, and how far it can be trusted.
#[derive(Clone, Debug, PartialEq)]
pub struct Pooled {
    /// Name of the design of the first run.
    pub design: String,
    /// Number of parts.
    pub parts: usize,
    /// Regression pairs.
    pub samples: u64,
    /// Lags of Bartlett's weights in the standard errors.
    pub bandwidth: usize,
    /// Surge, sway, yaw.
    pub degrees: Vec<DegreeTrust>,
    /// Free simulation over every run or recording.
    pub sources: Vec<SourceErrors>,
    /// What to know before using the estimate, in words.
    pub statements: Vec<String>,
    /// What is said of signs: a channel that acts with the opposite one, or estimates against their nominal values.
    pub turned: Option<String>,
    /// The whole model; none unless all degrees of freedom have an estimate.
    pub delivered: Option<Delivered>,
    /// What the model lacks; none where it diverges or has no estimate.
    pub criticism: Option<Criticism>,
}

impl Pooled {
    /// The estimate as that of one run; none unless all degrees of freedom have one.
    pub fn as_run(&self, estimator: Estimator) -> RunEstimate {
        let parameters = || self.degrees.iter().flat_map(|d| &d.parameters);
        let theta: Option<Vec<f64>> = parameters().map(|p| p.estimate).collect();
        // 0 where nothing says how large they are.
        let errors = parameters().map(|p| p.spread().unwrap_or(0.0)).collect();
        let estimate = theta.map(|theta| (theta, errors));
        let diverges = self.degrees.iter().any(|d| d.status == EstimateStatus::Diverges);
        let rejected = self.criticism.as_ref().is_some_and(|criticism| criticism.rejected);
        RunEstimate {
            design: self.design.clone(),
            run: 0,
            estimator,
            status: match (&estimate, rejected) {
                (None, _) => EstimateStatus::NotIdentifiable,
                (Some(_), _) if diverges => EstimateStatus::Diverges,
                (Some(_), true) => EstimateStatus::Rejected,
                (Some(_), false) => EstimateStatus::Identified,
            },
            estimate,
            condition: [0, 1, 2].map(|d: usize| self.degrees[d].condition.unwrap_or(f64::INFINITY)),
            weakest: [0, 1, 2].map(|d: usize| self.degrees[d].weakest_parameter().to_owned()),
        }
    }
}

/// Why there is no pooled estimate.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PoolError<E> {
    /// No instruments could be simulated.
    #[error(transparent)]
    Lost(LostInstruments),
    /// No degree of freedom is identifiable, with the reasons.
    #[error("no degree of freedom is identifiable ({})", .0.join("; "))]
    NotIdentifiable(Vec<String>),
    /// The degrees of freedom all of whose parameters are at bounds.
    #[error("the bounds exclude every estimate ({})", .0.join("; "))]
    Bounded(Vec<String>),
    /// Some degrees of freedom are not identifiable, with the reasons, so that a search has no model to simulate.
    #[error("not all degrees of freedom are identifiable ({})", .0.join("; "))]
    Incomplete(Vec<String>),
    /// A search found no model.
    #[error(transparent)]
    Unfound(Unfound),
    /// The runs cannot be read.
    #[error("{0}")]
    Unread(E),
}

impl PoolError<Unread> {
    fn restored<E>(self, faults: &Faults<E>) -> PoolError<E> {
        match self {
            Self::Lost(lost) => PoolError::Lost(lost),
            Self::NotIdentifiable(reasons) => PoolError::NotIdentifiable(reasons),
            Self::Bounded(reasons) => PoolError::Bounded(reasons),
            Self::Incomplete(reasons) => PoolError::Incomplete(reasons),
            Self::Unfound(unfound) => PoolError::Unfound(unfound),
            Self::Unread(unread) => PoolError::Unread(faults.take(unread)),
        }
    }
}

/// Estimates from all of `runs` and judges the estimate.
///
/// # Errors
/// No instruments; no identifiable degree of freedom; runs that cannot be read again.
pub fn estimate<R: Recorded>(
    pool: &Pool,
    runs: &PooledRuns<R>,
    estimator: Estimator,
    judgement: &Judgement,
    resampling: Resampling,
) -> Result<Pooled, PoolError<R::Error>> {
    let (parts, faults) = (pool.cut(runs), Faults::default());
    let data: Data = (&faults.erased(runs), &faults.erased(&parts));
    estimate_any(pool, data, estimator, judgement, resampling).map_err(|e| e.restored(&faults))
}

/// Runs of any kind, and the parts that they are cut into.
type Data<'a> = (&'a dyn AnyRuns, &'a AnyParts<'a>);

fn estimate_any(
    pool: &Pool,
    (runs, parts): Data,
    estimator: Estimator,
    judgement: &Judgement,
    resampling: Resampling,
) -> Result<Pooled, PoolError<Unread>> {
    let estimated = solved(pool, parts, estimator)?;
    let judge = Judge { pool, estimated: &estimated, parts, judgement, resampling };
    let mut degrees = judge.degrees().map_err(PoolError::Unread)?;
    let errors = estimated.errors_of_predictions(pool);
    let parameters = degrees.iter().flat_map(|degree| &degree.parameters).enumerate();
    let error = |i: usize| errors.as_ref().map(|errors| errors[i]);
    let estimates: Vec<_> =
        parameters.map(|(i, p)| Some([p.estimate?, p.standard_error.or_else(|| error(i))?])).collect();
    let (model, nominal) = (&pool.vessel.model, &pool.vessel.nominal);
    let (signs, turned) = (signs(model, nominal, &estimates), against_nominal(model, nominal, &estimates));
    let mut criticism = criticism(pool, &estimated, runs, &signs).map_err(PoolError::Unread)?;
    let waves = criticism.as_mut().filter(|criticism| criticism.waves_s.is_some());
    let no_errors = waves.is_some();
    if let Some(criticism) = waves {
        degrees.iter_mut().for_each(DegreeTrust::without_errors);
        criticism.statements.push("no standard errors are given; choose a calm day".to_owned());
    }
    let sources = judge.sources(runs).map_err(PoolError::Unread)?;
    let diverging = diverging(&sources);
    let mut delivered =
        Delivered::new(pool, &estimated, parts, &degrees, &sources).map_err(PoolError::Unread)?;
    if let Some(model) = delivered.as_mut().filter(|_| no_errors) {
        model.covariance = None;
    }
    if diverging.is_some() {
        delivered = None;
        let identified = degrees.iter_mut().filter(|degree| degree.status == EstimateStatus::Identified);
        identified.for_each(|degree| degree.status = EstimateStatus::Diverges);
    }
    let lost = estimated.diverged.as_ref().map(LostInstruments::to_string);
    let criticised = criticism.iter().flat_map(|criticism| &criticism.statements).cloned();
    let alike = delivered.iter().flat_map(|model| collinear(model, pool.model.layout()));
    let stalled = stalled(&estimated).map(str::to_owned);
    let spread = stalled
        .into_iter()
        .chain(few_informative(pool, &estimated, parts.count()))
        .chain(beside(pool, &estimated));
    // What criticism says is not said twice.
    let is_named = criticism.as_ref().is_some_and(|criticism| criticism.wrong_signs().next().is_some());
    let also = turned.clone().filter(|_| !is_named);
    let known: Vec<String> =
        also.into_iter().chain(spread).chain(statements(&degrees)).chain(alike).collect();
    Ok(Pooled {
        design: runs.design().to_owned(),
        parts: parts.count(),
        samples: judge.samples() as u64,
        bandwidth: judge.bandwidth(),
        turned,
        statements: diverging.into_iter().chain(lost).chain(criticised).chain(known).collect(),
        degrees,
        sources,
        delivered,
        criticism,
    })
}

/// Estimates as [`estimate`] does, from all of `runs`, without judging the estimate, and calls `work` with a
/// resampler of that estimate.
///
/// # Errors
/// See [`estimate`].
pub fn resampled<R: Recorded, T>(
    pool: &Pool,
    runs: &PooledRuns<R>,
    (estimator, seed): (Estimator, u64),
    work: impl FnOnce(&(dyn Fn(u32) -> Result<Resample, R::Error> + Sync)) -> T,
) -> Result<T, PoolError<R::Error>> {
    let (cut, faults) = (pool.cut(runs), Faults::default());
    let parts = faults.erased(&cut);
    let estimated = solved(pool, &parts, estimator).map_err(|e| e.restored(&faults))?;
    let unread = |unread: Unread| faults.take(unread);
    let resampler =
        Resampler::new(pool, &estimated, &parts, seed).map_err(|e| PoolError::Unread(unread(e)))?;
    Ok(work(&|number| resampler.draw(number).map_err(unread)))
}

/// Whether all of an estimate allows for a current that persists: as an unknown, or by a filter that knows of one.
fn allows_for_current(estimated: &Estimated) -> bool {
    let follow = estimated.searched.as_ref().map(|(_, scales)| scales.follow());
    let allows = match follow {
        Some(Follow::Simulated(unknown)) => unknown.current.is_some(),
        Some(Follow::Predicted(levels, _)) => matches!(levels.current, Flow::Markov { .. }),
        None => false,
    };
    allows && estimated.used.iter().all(|used| used.searches())
}

fn stalled(estimated: &Estimated) -> Option<&'static str> {
    let (searched, _) = estimated.searched.as_ref()?;
    (!searched.converged).then_some(
        "the search stalled before its minimum: standard errors are those of where it ended; vary the terms that the data \
         tell least about, or fix them",
    )
}

/// The warning that free simulations of some recordings diverge, so that there is no model.
fn diverging(sources: &[SourceErrors]) -> Option<String> {
    let diverging = sources.iter().filter(|source| source.diverged > 0);
    let names: Vec<String> = diverging.map(|source| format!("`{}`", source.source)).collect();
    let (count, all) = (names.len(), sources.len());
    let diverge = |names| {
        format!("no model is delivered: free simulations of {count} of {all} recordings diverge: {names}")
    };
    (!names.is_empty()).then(|| diverge(listed(&names)))
}

/// The remark that a model was found with starts, currents or a filter that free simulations do not use.
fn beside(pool: &Pool, estimated: &Estimated) -> Option<String> {
    let (_, scales) = estimated.searched.as_ref()?;
    match scales.follow() {
        Follow::Simulated(Unknown { current: None, initial }) => {
            (*initial == InitialState::Estimated).then(|| {
                "found with the start of every sub-experiment as an unknown: sensors' noise makes up much of the errors".to_owned()
            })
        }
        Follow::Simulated(_) => Some(
            "found with a current of its own in every run: free simulations of the recordings go in still water, and err by \
             what it does"
                .to_owned(),
        ),
        Follow::Predicted(levels, _) => Some(levels.words(1.0 / pool.vessel.sample_rate_hz)),
    }
}

/// With a smaller effective number of sub-experiments, standard errors, which compare them, are a guess.
const FEW: f64 = 3.0;

fn few_informative(pool: &Pool, estimated: &Estimated, parts: usize) -> Option<String> {
    let (searched, _) = estimated.searched.as_ref()?;
    if parts == 1 {
        let remedy = "use more runs, or a smaller --part-s";
        return Some(format!("no standard errors: they compare sub-experiments, and there is one; {remedy}"));
    }
    let layout = pool.model.layout();
    let degrees = DegreeOfFreedom::ALL.map(|d| d as usize).into_iter();
    let places = degrees.filter(|d| estimated.used[*d].searches()).flat_map(|d| layout.terms(d));
    let parameters = pool.vessel.model.parameter_names().zip(places);
    let few =
        parameters.filter(|(_, i)| searched.effective_parts[*i] > 0.0 && searched.effective_parts[*i] < FEW);
    let named: Vec<String> =
        few.map(|(name, i)| format!("`{name}` {:.1}", searched.effective_parts[i])).collect();
    (!named.is_empty()).then(|| {
        format!(
            "standard errors hold only roughly: they compare sub-experiments, of which few tell of a parameter ({}, if all told \
             alike); use more runs, or a smaller --part-s",
            listed(&named)
        )
    })
}

/// The estimator for logs without stated noise: `prediction-error` if the noise that is found describes the errors,
/// else `output-error`. A filter for the wrong noise gives models that predict worse.
///
/// # Errors
/// Runs that cannot be read.
pub fn unstated<R: Recorded>(pool: &Pool, runs: &PooledRuns<R>) -> Result<Estimator, PoolError<R::Error>> {
    let quick = Judgement { replicates: 0, seed: 1 };
    match estimate(pool, runs, Estimator::PredictionError, &quick, Resampling::Given(&[])) {
        Err(PoolError::Unread(e)) => Err(PoolError::Unread(e)),
        Ok(pooled)
            if pooled.criticism.as_ref().is_some_and(|criticism| criticism.verdict != Verdict::None) =>
        {
            Ok(Estimator::PredictionError)
        }
        _ => Ok(Estimator::OutputError),
    }
}

fn solved(pool: &Pool, parts: &AnyParts, estimator: Estimator) -> Result<Estimated, PoolError<Unread>> {
    let estimated = pool.estimate_any(parts, estimator).map_err(|e| match e {
        NoEstimate::Lost(lost) => PoolError::Lost(lost),
        NoEstimate::Unread(e) => PoolError::Unread(e),
    })?;
    if let Some(unfound) = estimated.unfound {
        return Err(PoolError::Unfound(unfound));
    }
    if estimated.degrees.iter().any(|d| d.status == Status::Bounded) {
        return Err(PoolError::Bounded(pool.unidentified(&estimated.degrees)));
    }
    if estimated.degrees.iter().all(|d| d.solution.is_none()) {
        return Err(PoolError::NotIdentifiable(pool.unidentified(&estimated.degrees)));
    }
    if estimator.searches() && estimated.searched.is_none() {
        return Err(PoolError::Incomplete(pool.unidentified(&estimated.degrees)));
    }
    Ok(estimated)
}

/// θ̂ of surge, sway and yaw, and its standard errors.
#[derive(Clone, Debug, PartialEq)]
pub struct StandardErrors {
    /// θ̂.
    pub theta: Vec<f64>,
    /// Of the same length.
    pub standard_errors: Vec<f64>,
}

/// The parameters and standard errors of [`estimate`] alone, for studies of many estimates; `None` unless all have
/// one.
///
/// # Errors
/// See [`estimate`].
pub fn standard_errors<R: Recorded>(
    pool: &Pool,
    runs: &PooledRuns<R>,
    estimator: Estimator,
    judgement: &Judgement,
) -> Result<Option<StandardErrors>, PoolError<R::Error>> {
    let (parts, faults) = (pool.cut(runs), Faults::default());
    let errors = standard_errors_any(pool, &faults.erased(&parts), estimator, judgement);
    errors.map_err(|e| e.restored(&faults))
}

fn standard_errors_any(
    pool: &Pool,
    parts: &AnyParts,
    estimator: Estimator,
    judgement: &Judgement,
) -> Result<Option<StandardErrors>, PoolError<Unread>> {
    let estimated = solved(pool, parts, estimator)?;
    let judge =
        Judge { pool, estimated: &estimated, parts, judgement, resampling: Resampling::Drawn(&|_| ()) };
    let degrees = judge.degrees().map_err(PoolError::Unread)?;
    let all = || degrees.iter().flat_map(|d| &d.parameters);
    let theta: Option<Vec<f64>> = all().map(|p| p.estimate).collect();
    let errors: Option<Vec<f64>> = all().map(|p| p.standard_error).collect();
    Ok(theta.zip(errors).map(|(theta, standard_errors)| StandardErrors { theta, standard_errors }))
}

const MOST_CRITICISED: usize = 200_000;

/// Tests what the model lacks on the first whole recordings up to [`MOST_CRITICISED`] samples.
fn criticism(
    pool: &Pool,
    estimated: &Estimated,
    runs: &dyn AnyRuns,
    signs: &[Absent],
) -> Result<Option<Criticism>, Unread> {
    let Some(parameters) = estimated.parameters(&pool.model) else { return Ok(None) };
    let (model, parameters) = pool.model.held_at_bounds(&parameters);
    let (mut samples, mut recordings) = (0, Vec::new());
    runs.each_source(&mut |_, whole| {
        samples += whole.iter().map(Part::samples).sum::<usize>();
        if samples <= MOST_CRITICISED {
            recordings.extend(whole);
        }
    })?;
    let views: Vec<RunView> = recordings.iter().map(Part::view).collect();
    let names: Vec<&str> = recordings.iter().map(|recording| recording.source.as_str()).collect();
    let subject = Subject {
        model: &model,
        runs: &views,
        rate_hz: pool.vessel.sample_rate_hz,
        known_start: false,
        levels: None,
        names: &names,
        signs,
    };
    let mut criticism = criticise_after(&subject, &parameters, &estimated.noises);
    if let Some(tests) = criticism.as_mut().filter(|_| !allows_for_current(estimated)) {
        tests.statements.extend(tests.persistent_current());
    }
    Ok(criticism)
}
