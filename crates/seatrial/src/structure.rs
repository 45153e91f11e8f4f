//! The structure of a model, found from recordings.

use estimation::against_nominal;
use estimation::fitting::{Settings, Starts};
use estimation::pooled::{FreeRunErrors, Score};
use estimation::search::{
    Alone, Dealt, FittedShip, Kind, NestedScore, Recording, Roles, SearchError, SearchOptions, Searched,
    averaged, core, fits, folds, library, search, unscored, with_channels,
};
use numerics::statistics::mean;
use rayon::prelude::*;
use refusal::Invalid;
use regression::pooled::PooledRuns;
use ship::model::terms::listed;
use ship::model::{Actuator, CandidateTerms, Model, Vessel};
use study::documents::{AverageMember, BesideForces, DeliveredKind, ModelDocument, SearchSummary, TriedFit};
use validation::comparison::Magnitudes;

use crate::force_fit::{ForceFit, Recorded};

/// The start of a search, and its candidate terms.
#[derive(Clone, Debug)]
pub struct StructureSearch {
    /// The vessel, whose terms the search begins with, and the channels that the terms need: runs need all of them.
    pub vessel: Vessel,
    /// Its model with all candidate terms.
    pub library: Model,
}

impl StructureSearch {
    /// A search over the candidates that `vessel` lists, or else the library of terms for her channels in their roles.
    ///
    /// # Errors
    /// A term with channels that do not exist; a role that a channel has without another one that it needs.
    pub fn by_roles(vessel: Vessel) -> Result<Self, Invalid> {
        vessel.check_terms("search")?;
        if let Some(CandidateTerms { surge, sway, yaw }) = &vessel.candidates {
            let library = listed(&vessel.model, [surge, sway, yaw])?;
            return Ok(Self { vessel, library });
        }
        let roles = Roles::new(&vessel.model)?;
        let (model, roles) = with_channels(&vessel.model, &roles)?;
        let library = library(&model, &roles);
        Ok(Self { vessel: Vessel { model, ..vessel }, library })
    }

    /// A search over the same library that begins with a core of terms ([`core_of`]) instead of those of `vessel`, or of her forces.
    ///
    /// # Errors
    /// As [`Self::by_roles`].
    pub fn by_core(vessel: &Vessel) -> Result<Self, Invalid> {
        if vessel.candidates.is_some() && !vessel.model.has_regressors() {
            let (found, expected) =
                ("terms for a ship with forces", "none: a search beside forces has terms of its own");
            return Err(Invalid::new("[candidates]", found, expected, "remove the table"));
        }
        let (vessel, roles) = with_core(vessel)?;
        let library = library(&vessel.model, &roles);
        Ok(Self { vessel, library })
    }

    /// Searches `runs`; `done` is called with the number of fits that are done, of [`SearchOptions::fits`] at most.
    ///
    /// # Errors
    /// Too few recordings; no model that follows them.
    pub fn find(
        &self,
        runs: &PooledRuns,
        options: &SearchOptions,
        done: &(dyn Fn(usize) + Sync),
    ) -> Result<FoundStructure, SearchError> {
        let vessel = &self.vessel;
        let mut searched = search(&vessel.model, &self.library, runs, options, done)?;
        searched.statements.extend(self.turned(&searched));
        let mut model = self.model(runs, &searched);
        if let Some(average) = &searched.average {
            let magnitudes = model.magnitudes.as_ref();
            model.members = AverageMember::all(vessel, average, searched.samples, magnitudes);
            model.average_rmse = average.output_rmse;
        }
        Ok(FoundStructure { search: SearchSummary::new(vessel, options, &searched), model })
    }

    /// Estimates with another sign than the nominal value, in words; standard errors are those of the jackknife over folds.
    fn turned(&self, found: &Searched) -> Option<String> {
        let of = |model: &Model, theta: &[f64], name: &str| {
            theta.get(model.parameter_names().position(|other| other == name)?).copied()
        };
        let known = self.vessel.model.parameter_names().map(|name| {
            let ships = found.without.iter().flatten();
            let without: Vec<f64> = ships.filter_map(|ship| of(&ship.model, &ship.theta, name)).collect();
            let (count, mean) = (without.len() as f64, mean(&without)?);
            let squares: f64 = without.iter().map(|value| (value - mean).powi(2)).sum();
            Some([of(&found.model, &found.delivered.theta, name)?, ((count - 1.0) / count * squares).sqrt()])
        });
        against_nominal(&self.vessel.model, &self.vessel.nominal, &known.collect::<Vec<_>>())
    }

    /// The model that was found in `runs`.
    pub(crate) fn model(&self, runs: &PooledRuns, found: &Searched) -> ModelDocument {
        let Ok(magnitudes) = Magnitudes::of(&self.vessel.model, runs, self.vessel.sample_rate_hz);
        ModelDocument { magnitudes, ..ModelDocument::searched(&self.vessel, found) }
    }
}

/// `vessel` with a core of terms per sample in place of her own, or of her forces: [`estimation::search::core`]. Nothing is known of their values.
///
/// # Errors
/// As [`StructureSearch::by_roles`].
pub fn core_of(vessel: &Vessel) -> Result<Vessel, Invalid> {
    with_core(vessel).map(|(vessel, _)| vessel)
}

fn with_core(vessel: &Vessel) -> Result<(Vessel, Roles), Invalid> {
    let roles = Roles::new(&vessel.model)?;
    let astern = |actuator: &Actuator| actuator.range.is_some_and(|[low, _]| low < 0.0);
    let reversing: Vec<usize> =
        (3..).zip(&vessel.actuators).filter(|(_, actuator)| astern(actuator)).map(|(i, _)| i).collect();
    let (model, roles) = core(&vessel.model, &roles, &reversing)?;
    if model.degrees == vessel.model.degrees && vessel.model.has_regressors() {
        return Ok((Vessel { model, ..vessel.clone() }, roles));
    }
    let count = model.parameters();
    let (value, nominal) = (vec![None; count], vec![0.0; count]);
    Ok((Vessel { model, value, nominal, constrained: Vec::new(), ..vessel.clone() }, roles))
}

/// The result of a search.
#[derive(Clone, Debug)]
pub struct FoundStructure {
    /// How it was found, and its validation.
    pub search: SearchSummary,
    /// The model, with those that it averages.
    pub model: ModelDocument,
}

// A search that begins with a core of terms, beside the forces of the same ship: the average of both is delivered.

/// A model whose mean fit of recordings left out is worse than the other's by more than this \[%\] leaves the average.
const WORSE: f64 = 20.0;
/// How much longer the windows are that start at their first measured sample.
const LONGER: f64 = 1.5;
/// What is averaged.
const NAMES: [&str; 2] = ["the searched terms", "the forces"];

/// A search from the core of a ship with forces, and fits of these.
pub struct AveragedSearch<'a> {
    /// The search.
    pub search: &'a StructureSearch,
    /// Its options.
    pub options: &'a SearchOptions,
    /// The ship with forces.
    pub vessel: &'a Vessel,
    /// Windows and weights of her fits, with starts that are found. Longer windows that start at their first measured sample
    /// are tried too.
    pub settings: Settings,
}

/// What is delivered of both, and why not the other.
struct DeliveredModels {
    kind: DeliveredKind,
    left: Vec<String>,
    output_rmse: Option<[f64; 3]>,
}

impl AveragedSearch<'_> {
    /// Number of fits at most.
    pub fn fits(&self) -> usize {
        self.options.fits() + self.options.folds
    }

    /// Searches `runs` and fits the forces to `of_forces`, the same runs in their channels. A model that diverges over them, that is not
    /// found, or that is far worse where recordings are left out is named and left out of the average. `done` is called with the number
    /// of fits that are done.
    ///
    /// # Errors
    /// Too few recordings or too short ones; neither a search nor a fit with a model.
    pub fn find(
        &self,
        [runs, of_forces]: [&PooledRuns; 2],
        done: &(dyn Fn(usize) + Sync),
    ) -> Result<FoundStructure, SearchError> {
        let begun = &self.search.vessel;
        let [recordings, of_ship] = [runs, of_forces].map(|runs| Recording::all(runs, self.options.cut));
        let searched = match search(&begun.model, &self.search.library, runs, self.options, done) {
            // The forces may give a model.
            result @ (Ok(_) | Err(SearchError::AllDiverge { .. } | SearchError::Useless(_))) => result,
            Err(error) => return Err(error),
        };
        let dealt = folds(&recordings.iter().collect::<Vec<_>>(), self.options.folds);
        let dealt = Dealt { folds: &dealt, are_inputs_held: of_forces.are_inputs_held() };
        let (without_forces, tried, forces) = self.forces(of_forces, &of_ship, dealt, done);
        let none = vec![None; self.options.folds];
        let without = searched.as_ref().map_or(&none, |searched| &searched.without);
        let kinds = [(&recordings, without), (&of_ship, &without_forces)]
            .map(|(recordings, without)| Kind { recordings, without });
        let mut document = match &searched {
            Ok(searched) => SearchSummary::new(begun, self.options, searched),
            Err(_) => self.unfound(&recordings, dealt),
        };
        let (nested, alone) = dealt.averaged(document.nested, &kinds);
        document.nested = nested;
        let terms = searched.map(|searched| self.search.model(runs, &searched));
        let lost = terms.as_ref().err().cloned();
        let models = [terms.map_err(|e| e.to_string()), forces];
        let inside = [document.nested.search.as_ref(), alone.errors.as_ref()];
        let Some(choice) =
            chosen(&models, inside.map(|errors| errors.and_then(mean_fit)), [&recordings, &of_ship], dealt)
        else {
            return Err(lost.unwrap_or(SearchError::NoAverage));
        };
        document.statements = statements(&choice, &document.nested, alone, &tried)
            .into_iter()
            .chain(document.statements)
            .collect();
        let (errors, overlapping) = (alone.errors, alone.overlapping);
        document.beside = Some(BesideForces { delivered: choice.kind, tried, errors, overlapping });
        let members = models.into_iter();
        let members: Vec<ModelDocument> =
            members.zip(choice.kind.members()).filter_map(|(model, is)| model.ok().filter(|_| is)).collect();
        let mut model = members.last().cloned().ok_or(SearchError::NoAverage)?;
        model.statements.insert(0, document.statements[0].clone());
        if members.len() > 1 {
            (model.members, model.average_rmse) = (AverageMember::of(members), choice.output_rmse);
        }
        Ok(FoundStructure { search: document, model })
    }

    /// The document of a search without a model.
    fn unfound(&self, recordings: &[Recording], dealt: Dealt) -> SearchSummary {
        let windows = recordings.iter().map(|recording| recording.windows() as u64).sum();
        let samples = recordings.iter().map(|recording| recording.samples() as u64).sum();
        let nested = unscored(recordings, dealt.folds);
        SearchSummary::unfound(&self.search.vessel, self.options, [windows, samples], nested)
    }

    /// Both ways to fit the forces.
    fn ways(&self) -> [Settings; 2] {
        let longer = LONGER * self.settings.window_s;
        [self.settings, Settings { window_s: longer, starts: Starts::Measured, ..self.settings }]
    }

    fn fit_of(&self, settings: Settings) -> ForceFit<'_> {
        ForceFit { vessel: self.vessel, settings, former: None, reference: None }
    }

    /// Fits the forces without each fold in both ways, each from what the one before found, and all of `runs` in the better way:
    /// the ships without each fold, in the way that the other folds choose, what was tried, and the model.
    fn forces(
        &self,
        runs: &PooledRuns,
        recordings: &[Recording],
        dealt: Dealt,
        done: &(dyn Fn(usize) + Sync),
    ) -> (Vec<Option<FittedShip>>, Vec<TriedFit>, Result<ModelDocument, String>) {
        let held = dealt.are_inputs_held;
        let all: Vec<Recorded> = recordings.iter().map(|r| (r.name.clone(), r.whole.clone())).collect();
        let ship = |theta: Vec<f64>| FittedShip { model: self.vessel.model.clone(), theta };
        let fold = |fold: usize| {
            let kept = all.iter().zip(dealt.folds).filter(|(_, other)| **other != fold);
            let kept: Vec<Recorded> = kept.map(|(source, _)| source.clone()).collect();
            let mut from = self.vessel.nominal.clone();
            let fitted = self.ways().map(|settings| {
                let theta = self.fit_of(settings).theta_from(&from, &kept, held).ok()?;
                from.clone_from(&theta);
                Some(ship(theta))
            });
            done(1);
            fitted
        };
        let by_folds: Vec<[Option<FittedShip>; 2]> =
            (0..self.options.folds).into_par_iter().map(fold).collect();
        let by_ways = [0, 1].map(|way| by_folds.iter().map(|ways| ways[way].clone()).collect::<Vec<_>>());
        let scores = by_ways.each_ref().map(|without| dealt.scores(&[Kind { recordings, without }]));
        let fit = |way: usize, without: Option<usize>| {
            dealt.fit(&Kind { recordings, without: &by_ways[way] }, &scores[way], without)
        };
        let better = |without: Option<usize>| usize::from(fit(1, without) > fit(0, without));
        let without = (0..self.options.folds).map(|fold| by_ways[better(Some(fold))][fold].clone()).collect();
        let chosen = better(None);
        let tried = self.ways().into_iter().enumerate().map(|(way, settings)| TriedFit {
            window_s: settings.window_s,
            measured_starts: settings.starts == Starts::Measured,
            score: fit(way, None),
            chosen: way == chosen,
        });
        let model = self.fit_of(self.ways()[chosen]).fitted_model(runs, (&all, held));
        (without, tried.collect(), model.map_err(|e| e.to_string()))
    }
}

/// What is delivered of `models`, whose mean fits of recordings left out are `inside`; `None` without any model.
fn chosen(
    models: &[Result<ModelDocument, String>; 2],
    inside: [Option<f64>; 2],
    recordings: [&[Recording]; 2],
    dealt: Dealt,
) -> Option<DeliveredModels> {
    let ships = models.each_ref().map(|model| {
        let vessel = model.as_ref().ok()?.vessel().ok()?;
        Some(vec![Some(FittedShip { theta: vessel.nominal, model: vessel.model })])
    });
    let once = Dealt { folds: &vec![0; recordings[0].len()], ..dealt };
    let rmse = |which: &[usize]| {
        let kinds: Vec<Kind> = which
            .iter()
            .map(|&i| Some(Kind { recordings: recordings[i], without: ships[i].as_ref()? }))
            .collect::<Option<_>>()?;
        let mut all = Score::default();
        once.scores(&kinds).iter().flatten().for_each(|score| all.merge(score));
        all.rmse()
    };
    let [search, forces] = inside;
    let behind = [search.zip(forces), forces.zip(search)]
        .map(|pair| pair.map(|(one, other)| other - one).filter(|behind| *behind > WORSE));
    let why = |i: usize| match (&models[i], &ships[i], behind[i]) {
        (Err(why), ..) => Some(format!("{} are left out of the average: {why}", NAMES[i])),
        (_, None, _) => Some(format!("{} are left out of the average: they give no vessel", NAMES[i])),
        _ if rmse(&[i]).is_none() => Some(format!(
            "{} are left out of the average: they diverge over the recordings that they were fitted to",
            NAMES[i]
        )),
        (.., Some(behind)) => Some(format!(
            "{} are left out of the average: {behind:.1} points of mean fit behind, where recordings are left out",
            NAMES[i]
        )),
        _ => None,
    };
    let left = [why(0), why(1)];
    let (kind, which) = match &left {
        [None, None] => (DeliveredKind::Average, vec![0, 1]),
        [None, _] => (DeliveredKind::Search, vec![0]),
        [_, None] => (DeliveredKind::Forces, vec![1]),
        _ if ships[1].is_some() => (DeliveredKind::Forces, vec![1]),
        _ if ships[0].is_some() => (DeliveredKind::Search, vec![0]),
        _ => return None,
    };
    Some(DeliveredModels { kind, output_rmse: rmse(&which), left: left.into_iter().flatten().collect() })
}

/// What is delivered, and how well it and its models predict.
fn statements(
    choice: &DeliveredModels,
    nested: &NestedScore,
    alone: Alone,
    tried: &[TriedFit],
) -> Vec<String> {
    let mut all = vec![match choice.kind {
        DeliveredKind::Average => format!("delivered: the average of {} and {}", NAMES[0], NAMES[1]),
        DeliveredKind::Search => format!("delivered: {} alone", NAMES[0]),
        DeliveredKind::Forces => format!("delivered: {} alone", NAMES[1]),
    }];
    all.extend(choice.left.iter().cloned());
    all.extend(nested.average.iter().flat_map(averaged).filter(|_| choice.kind == DeliveredKind::Average));
    all.push(match &alone.errors {
        Some(errors) => format!("{} with recordings left out: fit {}", NAMES[1], fits(errors)),
        None => format!("{} are not validated: without some fold there is no fit, or it diverges", NAMES[1]),
    });
    all.extend(tried.iter().filter(|fit| fit.chosen).map(|fit| {
        let starts = if fit.measured_starts { "measured starts" } else { "starts that are found" };
        let why = "where recordings left out choose between this and the other way";
        format!("{} were fitted over windows of at most {} s with {starts}, {why}", NAMES[1], fit.window_s)
    }));
    all
}

fn mean_fit(errors: &FreeRunErrors) -> Option<f64> {
    mean(&errors.fits().into_iter().flatten().collect::<Vec<_>>())
}
