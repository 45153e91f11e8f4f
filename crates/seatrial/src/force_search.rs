//! The search for forces that a ship lacks, judged by recordings that are left out of all of it.

use estimation::fitting::{Channels, Settings, Starts};
use estimation::search::{
    Cut, FittedShip, JudgedShips, Recording, SearchError, ShipsWithoutFold, folds, judged_ships,
};
use rayon::prelude::*;
use refusal::{Invalid, listed};
use regression::pooled::PooledRuns;
use ship::model::Vessel;
use study::documents::{
    FittedParameter, ForceScores, ForcesWithoutFold, FoundForce, ModelDocument, SearchSummary,
    SearchedForces, TriedForce,
};

use crate::criticism::channels;
use crate::growing::{self, FEWEST, GrownShip, Recorded};
use crate::physical::{Physical, PhysicalError};
use crate::structure::FoundStructure;

/// A search for forces that a ship lacks.
#[derive(Clone, Copy)]
pub struct ForceSearch<'a> {
    /// The ship, whose model is made of forces.
    pub vessel: &'a Vessel,
    /// Windows, weights and starts of fits.
    pub settings: Settings,
    /// Samples of a window that ships are scored on; none: whole runs.
    pub scored: Option<usize>,
    /// Folds that recordings are dealt into.
    pub folds: usize,
    /// Most forces that are added, one after the other.
    pub most_added: usize,
    /// Terms of surge, sway and yaw to try in place of the usual products.
    pub listed: Option<&'a [Vec<String>; 3]>,
}

/// Why nothing was searched for.
#[derive(Debug, thiserror::Error)]
pub enum ForceSearchError {
    /// Too few recordings, or too short ones.
    #[error("{0}")]
    Search(#[from] SearchError),
    /// Without a fold there are too few recordings to verify an addition.
    #[error("{left} recordings without some of {folds} folds")]
    FewLeft {
        /// Recordings without the largest fold.
        left: usize,
        /// Fewest that verify an addition.
        least: usize,
        /// Number of folds.
        folds: usize,
    },
    /// The ship cannot be fitted to all recordings.
    #[error("{0}")]
    Physical(#[from] PhysicalError),
}

impl ForceSearch<'_> {
    /// The number of products that are tried; refuses lists that have none.
    ///
    /// # Errors
    /// A listed text that is no term of this ship, or lists without any that she lacks.
    pub fn check(&self) -> Result<usize, Invalid> {
        let physical = self.physical(self.vessel);
        let forces = physical.forces()?;
        let (all, inputs) = (channels(self.vessel), self.vessel.model.inputs);
        let lacking = Channels { all: &all, inputs, listed: self.listed }.lacking(forces);
        match lacking.map_err(|e| e.invalid())? {
            0 => Err(Invalid::new("the lists", "no term that the ship lacks", "one at least", "list others")),
            count => Ok(count),
        }
    }

    /// Number of searches.
    pub fn searches(&self) -> usize {
        self.folds + 1
    }

    /// Searches without each fold, scores the ships that are found on what was left out, and searches all `runs`. The ship with
    /// the forces that are found is delivered if it is better there beyond chance, else the ship as she was. `done` is called
    /// with the number of searches that are done.
    ///
    /// # Errors
    /// Too few recordings; no fit to all of them.
    pub fn find(
        &self,
        runs: &PooledRuns,
        done: &(dyn Fn(usize) + Sync),
    ) -> Result<FoundStructure, ForceSearchError> {
        let recordings = Recording::all(runs, self.cut());
        let dealt = self.dealt(&recordings)?;
        if recordings.iter().all(|recording| recording.windows() == 0) {
            return Err(SearchError::NoWindow.into());
        }
        let held = runs.are_inputs_held();
        let sources: Vec<Recorded> = recordings.iter().map(|r| (r.name.clone(), r.whole.clone())).collect();
        // Fails at once where the ship cannot be fitted.
        let base = self.physical(self.vessel).fitted_model(runs, (&sources, held))?;
        let without = |fold| {
            let without = self.without(fold, &dealt, &sources, held);
            done(1);
            without
        };
        let (ships, said): (Vec<_>, Vec<_>) = (0..self.folds).into_par_iter().map(without).unzip();
        let judged = judged_ships(&recordings, &dealt, &ships, held);
        let grown = self.physical(self.vessel).grown((&sources, held), self.most_added, self.listed);
        let grown = grown.map_err(PhysicalError::from)?;
        done(1);
        self.delivered(runs, (&sources, held), (base, grown), said, judged)
    }

    fn cut(&self) -> Cut {
        let window = (self.settings.window_s / self.settings.sample_s).round().max(1.0) as usize;
        Cut { window, every: window, scored: self.scored }
    }

    fn physical<'p>(&self, vessel: &'p Vessel) -> Physical<'p> {
        Physical { vessel, settings: self.settings, former: None, reference: None }
    }

    /// The fold of each recording.
    fn dealt(&self, recordings: &[Recording]) -> Result<Vec<usize>, ForceSearchError> {
        let (count, all) = (self.folds, recordings.len());
        if all < count {
            return Err(SearchError::FewRecordings { recordings: all, folds: count }.into());
        }
        let dealt = folds(&recordings.iter().collect::<Vec<_>>(), count);
        let kept = |fold: usize| dealt.iter().filter(|other| **other != fold).count();
        match (0..count).map(kept).min() {
            Some(left) if left < FEWEST => {
                Err(ForceSearchError::FewLeft { left, least: FEWEST, folds: count })
            }
            _ => Ok(dealt),
        }
    }

    /// The whole search without the recordings of `fold`: its ships, and what is said of it.
    fn without(
        &self,
        fold: usize,
        dealt: &[usize],
        sources: &[Recorded],
        held: bool,
    ) -> (ShipsWithoutFold, ForcesWithoutFold) {
        let kept = sources.iter().zip(dealt).filter(|(_, other)| **other != fold);
        let kept: Vec<Recorded> = kept.map(|(source, _)| source.clone()).collect();
        let fitted = |vessel: &Vessel| {
            let theta = self.physical(vessel).theta_of(&kept, held);
            theta.map(|theta| FittedShip { model: vessel.model.clone(), theta })
        };
        let base = fitted(self.vessel);
        let grown = self.physical(self.vessel).grown((&kept, held), self.most_added, self.listed);
        let (tried, ended) =
            grown.as_ref().map_or((Vec::new(), None), |grown| (grown.tried.clone(), grown.ended.clone()));
        let search = match (&base, grown) {
            (Ok(base), Ok(grown)) if added(&grown.tried).next().is_none() => Ok(base.clone()),
            (_, Ok(grown)) => fitted(&grown.vessel),
            (_, Err(error)) => Err(error.into()),
        };
        let failed = [&base, &search].into_iter().find_map(|s| s.as_ref().err()).map(ToString::to_string);
        let ships = ShipsWithoutFold { search: search.ok(), base: base.ok() };
        (ships, ForcesWithoutFold { fold: fold as u64, tried, ended, failed })
    }

    /// The documents, and the ship that recordings left out speak for: as she was (`base`), or `grown`, both fitted to all.
    fn delivered(
        &self,
        runs: &PooledRuns,
        recorded: (&[Recorded], bool),
        (base, grown): (ModelDocument, GrownShip),
        said: Vec<ForcesWithoutFold>,
        judged: JudgedShips,
    ) -> Result<FoundStructure, ForceSearchError> {
        let confirmed = judged.nested.margin.as_ref().is_some_and(estimation::search::Margin::is_above);
        let any = added(&grown.tried).next().is_some();
        let delivered = any && confirmed && judged.nested.search.is_some();
        let with = any.then(|| self.physical(&grown.vessel).fitted_model(runs, recorded)).transpose()?;
        let forces = self.forces(delivered, &base, with.as_ref(), &grown, said);
        let statements = statements(&forces, &judged, &grown);
        let (ship, mut model) = match with {
            Some(with) if delivered => (&grown.vessel, with),
            _ => (self.vessel, base),
        };
        model.statements = statements.iter().cloned().chain(model.statements).collect();
        if let Some(fitted) = model.forces.as_mut().filter(|_| delivered) {
            fitted.tried = grown.tried;
        }
        let numbers = numbers(&model).to_vec();
        let scores = self.scores(recorded.0, judged);
        let search = SearchSummary::of_forces(self.vessel, scores, forces, (ship, &numbers), statements);
        Ok(FoundStructure { search, model })
    }

    fn scores(&self, sources: &[Recorded], judged: JudgedShips) -> ForceScores {
        let samples = sources.iter().flat_map(|(_, parts)| parts).map(|part| part.samples() as u64).sum();
        ForceScores {
            fitted_window_s: self.settings.window_s,
            window_s: self.scored.map(|window| window as f64 * self.settings.sample_s),
            windows: judged.windows,
            samples,
            folds: self.folds as u64,
            std: judged.std,
            nested: judged.nested,
        }
    }

    fn forces(
        &self,
        delivered: bool,
        base: &ModelDocument,
        with: Option<&ModelDocument>,
        grown: &GrownShip,
        without: Vec<ForcesWithoutFold>,
    ) -> SearchedForces {
        let cost = |model: &ModelDocument| model.forces.as_ref().map_or(f64::NAN, |forces| forces.cost);
        SearchedForces {
            delivered,
            found: added(&grown.tried).filter_map(|f| found_force(f, numbers(with?), &without)).collect(),
            tried: grown.tried.clone(),
            ended: grown.ended.clone(),
            most_added: self.most_added as u64,
            prior_weight: self.settings.prior_weight,
            unknown_starts: self.settings.starts == Starts::Unknown,
            base_cost: cost(base),
            found_cost: cost(with.unwrap_or(base)),
            without,
        }
    }
}

fn added(tried: &[TriedForce]) -> impl Iterator<Item = &TriedForce> {
    tried.iter().filter(|force| force.added)
}

fn numbers(model: &ModelDocument) -> &[FittedParameter] {
    model.forces.as_ref().map_or(&[], |forces| &forces.parameters)
}

fn found_force(
    force: &TriedForce,
    numbers: &[FittedParameter],
    without: &[ForcesWithoutFold],
) -> Option<FoundForce> {
    let number = numbers.iter().find(|number| number.name == force.parameter)?;
    let too = |fold: &&ForcesWithoutFold| added(&fold.tried).any(|other| other.parameter == force.parameter);
    Some(FoundForce {
        degree: force.degree.clone(),
        term: force.term.clone(),
        parameter: force.parameter.clone(),
        unit: number.unit.clone(),
        value: number.value,
        standard_error: number.standard_error,
        found_by_folds: without.iter().filter(too).count() as u64,
    })
}

/// What was found, whether recordings left out confirm it, and what is delivered.
fn statements(forces: &SearchedForces, judged: &JudgedShips, grown: &GrownShip) -> Vec<String> {
    let folds = forces.without.len();
    let each = |force: &FoundForce| {
        format!("`{}` in {} (in {} of {folds} folds too)", force.term, force.degree, force.found_by_folds)
    };
    let named: Vec<String> = forces.found.iter().map(each).collect();
    let (what, verdict) = match (named.is_empty(), forces.delivered) {
        (true, _) => ("no force that the ship lacks was found".to_owned(), "delivered: the ship as she was"),
        (false, true) => (format!("found: {}", listed(&named)), "delivered: the ship with what was found"),
        (false, false) => (
            format!("found: {}", listed(&named)),
            "delivered: the ship as she was, for recordings left out of the whole search do not tell that what was found predicts \
             better",
        ),
    };
    let failed = forces.without.iter().filter_map(|without| {
        without.failed.as_ref().map(|why| format!("without fold {} there is no fit: {why}", without.fold + 1))
    });
    let begin = [what, verdict.to_owned()].into_iter();
    begin
        .chain(estimation::search::left_out(&judged.nested))
        .chain(failed)
        .chain(growing::statements(grown))
        .collect()
}
