use std::collections::BTreeMap;

use numerics::statistics::median;
use rayon::prelude::*;
use refusal::listed;
use regression::pooled::{Part, PooledRuns};
use ship::model::Model;
use thiserror::Error;

use super::average::{AverageOptions, Averaged, BootstrapOptions, Resampled, share};
use super::compact::{Compact, SizeScore, combined, delivered, without_intercepts, without_zeros};
use super::judged::{FittedShip, Judged, Margin, NestedAverage, NestedRecording, NestedScore};
use super::nested::{Candidate, Choice, Fitted, Nested, Study};
use super::{Cut, Laid, Recording, folds, mean_of, scores, varying};
use crate::pooled::{Delivered, FreeRunErrors};

/// Options of a search for a model.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchOptions {
    /// Windows that are fitted and scored.
    pub cut: Cut,
    /// Number of folds.
    pub folds: usize,
    /// Ridges Λ from the largest on.
    pub ridges: Vec<f64>,
    /// Whether few terms are selected instead of penalising all by the ridge.
    pub compact: bool,
    /// The bootstrap over recordings, with few terms.
    pub bootstrap: Option<BootstrapOptions>,
    /// Several additional models of few terms, to be averaged.
    pub average: Option<AverageOptions>,
    /// The sampling rate \[Hz\].
    pub rate_hz: f64,
}

impl SearchOptions {
    /// Maximum number of fits of a search.
    pub fn fits(&self) -> usize {
        let each = 1 + self.average.map_or(0, |average| average.models as usize);
        let resamples = self.bootstrap.map_or(0, |bootstrap| bootstrap.resamples as usize);
        resamples + self.folds * (self.folds + 1) / 2 * self.ridges.len() + each * (self.folds + 1)
    }

    /// Ridges from 0.3 to 1e-6 in half decades.
    pub fn half_decades() -> Vec<f64> {
        (0..=11).map(|i| libm::pow(10.0, -0.5 - 0.5 * f64::from(i))).collect()
    }
}

/// The result of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Searched {
    /// The structure: the base's terms, then those of the library that are not always 0.
    pub model: Model,
    /// The model with this structure.
    pub delivered: Delivered,
    /// The number of samples it was fitted to.
    pub samples: u64,
    /// Windows that models were scored on.
    pub windows: u64,
    /// Standard deviations of u, v, r over these.
    pub std: [f64; 3],
    /// Candidates in the order in which they were tried.
    pub candidates: Vec<Candidate>,
    /// The index of the chosen one.
    pub chosen: usize,
    /// Numbers of terms in the order of additions, with few terms.
    pub sizes: Vec<SizeScore>,
    /// By name, the number of searches without a fold that chose each parameter too, with few terms.
    pub chosen_by_folds: BTreeMap<String, u64>,
    /// The whole search and the base structure on recordings that were left out of both.
    pub nested: NestedScore,
    /// The bootstrap, if requested.
    pub resampled: Option<Resampled>,
    /// Names of parameters whose terms no recording distinguishes from others.
    pub combined: Vec<String>,
    /// Several models of few terms, if an average is requested.
    pub average: Option<Averaged>,
    /// What was found without each fold, with intercepts; `None` where nothing was.
    pub without: Vec<Option<FittedShip>>,
    /// Remarks on the result, in words.
    pub statements: Vec<String>,
}

/// Why there is no model.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SearchError {
    /// Too few recordings to leave one out.
    #[error("{recordings} recordings for {folds} folds")]
    FewRecordings {
        /// Number of recordings.
        recordings: usize,
        /// Requested folds.
        folds: usize,
    },
    /// Too few to draw some of them for each model of an average.
    #[error("{recordings} recordings for an average")]
    FewForAverage {
        /// Number of recordings.
        recordings: usize,
        /// Least number of recordings.
        needed: usize,
    },
    /// A model of the average diverges.
    #[error("a model of the average diverges, or cannot be fitted")]
    NoAverage,
    /// Hardly any resample of the recordings gives a model.
    #[error("fewer than two resamples of the recordings give a model")]
    NoResample,
    /// No run is as long as a window.
    #[error("no run is as long as a window")]
    NoWindow,
    /// All candidates were rejected.
    #[error("all of {candidates} candidates diverge in some fold{}", left_out_in(recordings))]
    AllDiverge {
        /// Number of candidates that were tried.
        candidates: usize,
        /// Recordings on which the last of them diverges when they are left out.
        recordings: Vec<String>,
    },
    /// The best model is useless.
    #[error("the best candidate has a mean fit of {0:.1} %, no better than the mean of the data")]
    Useless(f64),
}

fn left_out_in(recordings: &[String]) -> String {
    let named: Vec<String> = recordings.iter().map(|name| format!("`{name}`")).collect();
    if named.is_empty() { String::new() } else { format!(", left out in it: {}", listed(&named)) }
}

/// Finds a model of `runs`: all terms of `library` in addition to those of `base`, with a ridge penalty that is
/// chosen by leaving out recordings. `done` is called with the number of fits that are done.
///
/// # Errors
/// See [`SearchError`].
pub fn search(
    base: &Model,
    library: &Model,
    runs: &PooledRuns,
    options: &SearchOptions,
    done: &(dyn Fn(usize) + Sync),
) -> Result<Searched, SearchError> {
    let recordings = Recording::all(runs, options.cut);
    if recordings.len() < options.folds.max(3) {
        let (recordings, folds) = (recordings.len(), options.folds.max(3));
        return Err(SearchError::FewRecordings { recordings, folds });
    }
    if let (Some(_), needed) = (options.average, needed(options.folds))
        && recordings.len() < needed
    {
        return Err(SearchError::FewForAverage { recordings: recordings.len(), needed });
    }
    if recordings.iter().all(|r| r.scored(Laid::SideBySide).next().is_none()) {
        return Err(SearchError::NoWindow);
    }
    let structure = without_zeros(base, library, &recordings);
    let (base, library) = (base.with_intercepts(), structure.with_intercepts());
    let setting = Study {
        base: &base,
        library: &library,
        recordings: &recordings,
        folds: &folds(&recordings.iter().collect::<Vec<_>>(), options.folds),
        ridges: &options.ridges,
        rate_hz: options.rate_hz,
        std: varying(recordings.iter(), Laid::SideBySide),
        overlapping_std: varying(recordings.iter(), Laid::Overlapping),
        choosing_std: varying(recordings.iter(), Laid::Choosing),
        whole_runs: options.cut.scored.is_none(),
    };
    let nested = setting.nested(done);
    let lost = || SearchError::AllDiverge {
        candidates: nested.all.candidates.len(),
        recordings: setting.diverging(&nested),
    };
    let (chosen, score) = chosen(&nested.all, lost)?;
    let mut models = setting.by_ridge(&nested, chosen).ok_or_else(lost)?;
    if options.compact {
        models = setting.few(&nested, chosen, done).ok_or_else(lost)?;
    }
    let averages = match options.average {
        Some(wanted) => Some(setting.averages(&nested, chosen, wanted, done).ok_or(SearchError::NoAverage)?),
        None => None,
    };
    let wanted = options.bootstrap.filter(|_| options.compact);
    let resampled = match wanted {
        Some(wanted) => Some(setting.resampled(wanted, done).ok_or(SearchError::NoResample)?),
        None => None,
    };
    let nested_score = setting.judged(&models.by_folds, averages.as_ref().map(|all| all.by_folds.as_slice()));
    let ship = |fitted: &Fitted| FittedShip { model: fitted.model.clone(), theta: fitted.theta.clone() };
    let without = models.by_folds.iter().map(|judged| judged.model.as_ref().map(ship)).collect();
    let candidates = nested.all.candidates;
    let mut statements =
        self::statements(&candidates, chosen, score, &models.sizes, &models.all, &nested_score);
    statements.push(errors(resampled.as_ref(), &models.all));
    if options.cut.scored.is_none() {
        statements.insert(1, CHOSEN_ON_WINDOWS.to_owned());
    }
    let parts: Vec<Part> = recordings.iter().flat_map(|r| &r.whole).cloned().collect();
    let structure = without_intercepts(&models.all.model);
    let combined = combined(&structure, &recordings);
    statements.extend(combined_in_words(&combined));
    Ok(Searched {
        statements,
        delivered: delivered(&structure, &models.all, &recordings, &parts),
        samples: parts.iter().map(|part| part.samples() as u64).sum(),
        windows: recordings.iter().map(|r| r.scored(Laid::SideBySide).count() as u64).sum(),
        std: setting.std,
        candidates,
        chosen,
        sizes: models.sizes,
        chosen_by_folds: models.chosen_by_folds,
        nested: nested_score,
        model: structure,
        resampled,
        combined,
        average: averages.map(|several| several.delivered(&recordings, &parts)),
        without,
    })
}

struct FoundModels {
    all: Fitted,
    by_folds: Vec<Judged>,
    sizes: Vec<SizeScore>,
    chosen_by_folds: BTreeMap<String, u64>,
}

/// The least number of recordings from which an average can draw as many as there are folds, without any fold.
fn needed(folds: usize) -> usize {
    let left = |recordings: usize| recordings - recordings.div_ceil(folds);
    (folds..).find(|recordings| share(left(*recordings)) >= folds.max(3)).unwrap_or(usize::MAX)
}

fn chosen(all: &Choice, lost: impl Fn() -> SearchError) -> Result<(usize, f64), SearchError> {
    let best = all.best().ok_or_else(lost)?;
    match all.candidates[best].score {
        Some(score) if score > 0.0 => Ok((best, score)),
        score => Err(SearchError::Useless(score.unwrap_or(f64::NEG_INFINITY))),
    }
}

impl Study<'_> {
    fn diverging(&self, nested: &Nested) -> Vec<String> {
        let of = |fold: usize| {
            let path = &nested.paths[&vec![fold]];
            let recordings = self.within(fold);
            let over = |laid| {
                let theta = path.last_theta();
                theta.map_or(Vec::new(), |theta| scores(self.library, theta, &recordings, laid, path.limit))
            };
            let [windows, scored] = [Laid::Choosing, Laid::SideBySide].map(over);
            let diverges = |i: &usize| {
                [&windows, &scored].iter().any(|scores| scores.get(*i).is_some_and(|s| s.diverged > 0))
            };
            (0..recordings.len()).filter(diverges).map(|i| recordings[i].name.clone()).collect::<Vec<_>>()
        };
        self.all_folds().flat_map(of).collect()
    }

    /// All terms, with the ridge at `chosen`; without each fold, with the ridge that was chosen without it.
    fn by_ridge(&self, nested: &Nested, chosen: usize) -> Option<FoundModels> {
        let mut whole = self.path(&[]);
        self.ridges[..=chosen].iter().for_each(|ridge| whole.fit_next(*ridge));
        let judged = |(fold, choice): (usize, &Choice)| {
            let (path, best) = (&nested.paths[&vec![fold]], choice.best());
            let theta = best.and_then(|best| path.thetas[best].clone());
            let model = theta.map(|theta| Fitted { model: self.library.clone(), theta });
            let ridge = best.map(|best| choice.candidates[best].ridge);
            Judged { ridge, model, base: path.base.clone(), limit: path.limit }
        };
        let by_folds = nested.without.iter().enumerate().map(judged).collect();
        let all = whole.delivered(self.ridges[chosen])?;
        Some(FoundModels { all, by_folds, sizes: Vec::new(), chosen_by_folds: BTreeMap::new() })
    }

    fn few(&self, nested: &Nested, chosen: usize, done: &(dyn Fn(usize) + Sync)) -> Option<FoundModels> {
        let ridge = |choice: &Choice| choice.best().map(|best| choice.candidates[best].ridge);
        let search = |without: Option<usize>| {
            let (ridge, base) = self.given(nested, chosen, without)?;
            let folds = self.others(without);
            let compact = self.compact(&base, &folds, ridge)?;
            let fitted = self.fitted(&compact.places, &base, &folds, ridge);
            done(1);
            Some((compact, fitted?))
        };
        let wanted: Vec<Option<usize>> = std::iter::once(None).chain(self.all_folds().map(Some)).collect();
        let mut searches: Vec<Option<(Compact, Fitted)>> = wanted.into_par_iter().map(search).collect();
        let (compact, all) = searches.remove(0)?;
        let mut chosen_by_folds = BTreeMap::new();
        for (_, fitted) in searches.iter().flatten() {
            fitted
                .model
                .parameter_names()
                .for_each(|name| *chosen_by_folds.entry(name.to_owned()).or_insert(0) += 1);
        }
        let judged = |(fold, compacted): (usize, Option<(Compact, Fitted)>)| {
            let path = &nested.paths[&vec![fold]];
            let model = compacted.map(|(_, fitted)| fitted);
            Judged { ridge: ridge(&nested.without[fold]), model, base: path.base.clone(), limit: path.limit }
        };
        let by_folds = searches.into_iter().enumerate().map(judged).collect();
        Some(FoundModels { all, by_folds, sizes: compact.sizes, chosen_by_folds })
    }
}

const CHOSEN_ON_WINDOWS: &str =
    "the ridge was chosen over windows of the length that is fitted, though whole runs are scored";

/// The errors of the parameters of the model `fitted`, in words: from searches over resampled recordings, or none.
fn errors(resampled: Option<&Resampled>, fitted: &Fitted) -> String {
    let Some(Resampled { searches, failed, parameters }) = resampled else {
        return "held back by a ridge; predictions have bands, parameters have no errors".to_owned();
    };
    let named = fitted.model.parameter_names().filter_map(|name| Some((name, parameters.get(name)?)));
    let intervals = named.map(|(name, resampled)| {
        let times =
            if resampled.chosen < *searches { format!(", in {}", resampled.chosen) } else { String::new() };
        format!("`{name}` {:.3e} to {:.3e}{times}", resampled.low, resampled.high)
    });
    let none = if *failed > 0 { format!(" ({failed} more found no model)") } else { String::new() };
    let all = intervals.collect::<Vec<_>>().join("; ");
    format!(
        "{searches} searches over recordings drawn again{none}: 95 % of them, and how many chose a term if not all: {all}"
    )
}

fn statements(
    candidates: &[Candidate],
    chosen: usize,
    score: f64,
    sizes: &[SizeScore],
    fitted: &Fitted,
    nested: &NestedScore,
) -> Vec<String> {
    let mut out = vec![format!(
        "ridge {:.1e} of {} tried: mean fit {score:.1} % of recordings that were left out",
        candidates[chosen].ridge,
        candidates.len()
    )];
    if !sizes.is_empty() {
        out.push(format!(
            "{} terms, the fewest that follow folds left out within a standard error of the best of {} numbers of terms",
            fitted.model.parameters(),
            sizes.len()
        ));
    }
    out.extend(at_bounds(fitted));
    out.extend(left_out(nested));
    let rejected: u64 = candidates.iter().map(|c| c.rejected).sum();
    if rejected > 0 {
        let ridges = candidates.iter().filter(|c| c.rejected > 0).count();
        out.push(format!("rejected: {ridges} ridges, of which fits or models diverge in {rejected} folds"));
    }
    if chosen + 1 == candidates.len() {
        out.push("the smallest ridge that was tried is the best: smaller ones may be better".to_owned());
    }
    out
}

/// How the whole search and the base structure follow recordings that were left out, in words.
pub fn left_out(nested: &NestedScore) -> Vec<String> {
    let whole = "the whole search with recordings left out: fit";
    let mut out = vec![match (&nested.search, &nested.base) {
        (Some(search), Some(base)) => {
            format!("{whole} {}; the base structure: fit {}", fits(search), fits(base))
        }
        (Some(search), None) => format!("{whole} {}; the base structure diverges", fits(search)),
        (None, _) => format!(
            "not validated: without some fold there is no model, or it diverges ({} windows) on what was left out",
            nested.diverged
        ),
    }];
    if let (Some(search), Some(base)) = (&nested.search_overlapping, &nested.base_overlapping) {
        let (search, base) = (fits(search), fits(base));
        out.push(format!(
            "the same over windows that begin at every quarter of one: fit {search}; the base structure: fit {base}"
        ));
    }
    out.extend(nested.margin.as_ref().map(|margin| against(margin, "the base structure")));
    out.extend(nested.average.iter().flat_map(averaged));
    out.extend(contradicting(nested));
    out
}

/// Terms that are named.
const NAMED: usize = 5;

fn combined_in_words(names: &[String]) -> Option<String> {
    let mut named: Vec<String> = names.iter().take(NAMED).map(|name| format!("`{name}`")).collect();
    named.extend((names.len() > NAMED).then(|| format!("{} others", names.len() - NAMED)));
    (!named.is_empty()).then(|| {
        format!(
            "in no sample anything but a combination of other terms, hence fixed in model.json, so that the next experiment is designed \
             for the others: {}",
            listed(&named)
        )
    })
}

fn at_bounds(fitted: &Fitted) -> Option<String> {
    let bounds = fitted.model.bounds()?;
    let parameters = fitted.model.parameter_names().zip(&fitted.theta).zip(bounds);
    let held: Vec<String> = parameters
        .filter(|((_, theta), ends)| ends.contains(theta))
        .map(|((name, _), _)| format!("`{name}`"))
        .collect();
    (!held.is_empty()).then(|| format!("held at a bound: {}", held.join(", ")))
}

/// A model is useless from this norm of RMSE/std on: that of the mean of the data is √3.
const USELESS: f64 = 1.0;
/// A recording contradicts the others if its error exceeds this many times their median.
const CONTRADICTS: f64 = 4.0;

/// Names the recordings that contradict the others, whose models fit each other but not these.
fn contradicting(nested: &NestedScore) -> Option<String> {
    let norms: Vec<f64> = nested.recordings.iter().filter_map(|recording| recording.search_norm).collect();
    let usual = median(norms)?;
    let beyond = |recording: &&NestedRecording| match recording.search_norm {
        Some(norm) => norm > USELESS && norm > CONTRADICTS * usual,
        None => recording.search_diverged > 0,
    };
    let named = nested.recordings.iter().filter(beyond).map(|recording| match recording.search_norm {
        Some(norm) => format!("`{}` by an error norm of {norm:.2}", recording.source),
        None => format!("`{}`, where they diverge", recording.source),
    });
    let named: Vec<String> = named.collect();
    (!named.is_empty()).then(|| {
        format!(
            "models of the other recordings, whose median is {usual:.2}, contradict {}: look at its signs, units, load and ship, or \
             leave it out",
            listed(&named)
        )
    })
}

/// The gain of averaging on recordings that were left out.
pub fn averaged(average: &NestedAverage) -> Vec<String> {
    let mut out = vec![match &average.errors {
        Some(errors) => format!("the average with recordings left out: fit {}", fits(errors)),
        None => format!(
            "the average is not validated: without some fold a model is missing, or diverges ({} windows) on what was left out",
            average.diverged
        ),
    }];
    out.extend(average.overlapping.as_ref().map(|overlapping| {
        format!("the average over windows that begin at every quarter of one: fit {}", fits(overlapping))
    }));
    let pairs = [(&average.over_search, "the single model"), (&average.over_base, "the base structure")];
    let sentence = |(margin, than): (&Option<Margin>, &str)| {
        margin.as_ref().map(|margin| format!("the average is {}", against(margin, than)))
    };
    out.extend(pairs.into_iter().filter_map(sentence));
    out
}

fn against(margin: &Margin, than: &str) -> String {
    let Margin { pairs, median, interval } = margin;
    let verdict = match interval {
        [Some(low), _] if *low > 0.0 => "better than",
        [_, Some(high)] if *high < 0.0 => "worse than",
        // There are too few pairs for a 95 % interval.
        [None, None] => "too few recordings to tell it from",
        _ => "not told apart from",
    };
    format!("{verdict} {than}: {}", crate::pooled::lies_above(*median, *interval, *pairs, "recordings"))
}

/// Fits of u, v, r and their mean, in words.
pub fn fits(errors: &FreeRunErrors) -> String {
    let one = |(name, fit): (&str, Option<f64>)| match fit {
        Some(fit) => format!("{name} {fit:.1} %"),
        None => format!("{name} –"),
    };
    let each = ["u", "v", "r"].into_iter().zip(errors.fits()).map(one).collect::<Vec<_>>().join(", ");
    mean_of(errors).map_or(each.clone(), |mean| format!("{each}, mean {mean:.1} %"))
}
