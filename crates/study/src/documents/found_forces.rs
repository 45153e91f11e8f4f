//! Documents of a search for forces that a ship lacks.

use estimation::search::NestedScore;
use ship::model::{DegreeOfFreedom, Vessel};

use super::force_search::{FoundForce, SearchedForces};
use super::forces::FittedParameter;
use super::search::{SearchDocument, SearchTerm};

/// How a search for forces was made and scored.
#[derive(Clone, Debug)]
pub struct ForceScores {
    /// Length of the windows that are fitted \[s\].
    pub fitted_window_s: f64,
    /// Of those that are scored; none: whole runs.
    pub window_s: Option<f64>,
    /// Number of those.
    pub windows: u64,
    /// Samples of the recordings.
    pub samples: u64,
    /// Number of folds.
    pub folds: u64,
    /// Standard deviations of u, v and r over the windows that are scored.
    pub std: [f64; 3],
    /// The whole search and the ship as she was, on recordings that were left out of both.
    pub nested: NestedScore,
}

impl SearchDocument {
    /// The result of a search for forces that `vessel` lacks, of which `delivered` is the ship in `model.json` with her numbers.
    pub fn of_forces(
        vessel: &Vessel,
        scores: ForceScores,
        forces: SearchedForces,
        (delivered, numbers): (&Vessel, &[FittedParameter]),
        statements: Vec<String>,
    ) -> Self {
        let [std_u, std_v, std_r] = scores.std;
        Self {
            vessel: vessel.name.clone(),
            fitted_window_s: scores.fitted_window_s,
            every_s: scores.fitted_window_s,
            window_s: scores.window_s,
            windows: scores.windows,
            samples: scores.samples,
            folds: scores.folds,
            std_u,
            std_v,
            std_r,
            ridge: None,
            candidates: Vec::new(),
            sizes: Vec::new(),
            nested: scores.nested,
            resamples: None,
            terms: terms(delivered, numbers, &forces.found),
            average: None,
            forces: Some(forces),
            beside: None,
            statements,
        }
    }
}

/// The terms of `ship` whose numbers are free.
fn terms(ship: &Vessel, numbers: &[FittedParameter], found: &[FoundForce]) -> Vec<SearchTerm> {
    let Some(moved) = &ship.model.forces else { return Vec::new() };
    let all = DegreeOfFreedom::ALL.into_iter().zip(moved.forces.description().terms());
    let term = |degree: DegreeOfFreedom, own: &ship::forces::TermSpec| {
        let number = numbers.iter().find(|number| number.name == own.parameter)?;
        let found = found.iter().find(|found| found.parameter == own.parameter);
        Some(SearchTerm {
            degree: degree.name().to_owned(),
            name: own.parameter.clone(),
            term: own.term.clone(),
            base: found.is_none(),
            value: number.value,
            low: None,
            high: None,
            chosen_by_resamples: None,
            chosen_by_folds: found.map(|found| found.found_by_folds),
        })
    };
    all.flat_map(|(degree, terms)| terms.iter().filter_map(move |own| term(degree, own))).collect()
}
