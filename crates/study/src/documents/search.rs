use estimation::pooled::FreeRunErrors;
use estimation::search::{Candidate, NestedScore, SearchOptions, Searched, SizeScore};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::{DegreeOfFreedom, Vessel};

use super::average::{AverageSummary, parameters, resampled};

/// How a model's structure was searched for in recordings, and how far the search can be trusted.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SearchSummary {
    /// Name of the vessel.
    pub vessel: String,
    /// Length of the windows that were fitted \[s\].
    pub fitted_window_s: f64,
    /// From the start of one to that of the next \[s\].
    pub every_s: f64,
    /// Length of the windows that models were scored on \[s\]; null: whole runs.
    pub window_s: Option<f64>,
    /// Number of those.
    pub windows: u64,
    /// Samples that the model was fitted to.
    pub samples: u64,
    /// Number of folds that whole recordings were dealt into.
    pub folds: u64,
    /// Standard deviations of the measured states over the windows.
    pub std_u: f64,
    /// Of sway speed.
    pub std_v: f64,
    /// Of yaw rate.
    pub std_r: f64,
    /// The ridge Λ that was chosen; null where none was found.
    #[serde(default)]
    pub ridge: Option<f64>,
    /// Ridges in the order that they were tried in.
    pub candidates: Vec<Candidate>,
    /// Numbers of terms in the order of additions, where few terms were asked for.
    pub sizes: Vec<SizeScore>,
    /// The whole search on recordings that were left out of it, beside the base structure.
    pub nested: NestedScore,
    /// How often recordings were drawn again and searched anew, where few terms were asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resamples: Option<Resamples>,
    /// The terms that were found.
    pub terms: Vec<SearchTerm>,
    /// What the models of an average are made of, where an average was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub average: Option<AverageSummary>,
    /// The forces that were fitted beside, where the search began with a core for a ship with forces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beside: Option<BesideForces>,
    /// What was found, in words.
    pub statements: Vec<String>,
}

/// Searches over recordings that were drawn again, with replacement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Resamples {
    /// The seed of the draws.
    pub seed: u64,
    /// Searches that found a model.
    pub searches: u64,
    /// Those that found none.
    pub failed: u64,
}

/// A term with its value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SearchTerm {
    /// `surge`, `sway` or `yaw`.
    pub degree: String,
    /// Name of its parameter.
    pub name: String,
    /// What the parameter multiplies.
    pub term: String,
    /// Whether the structure that the search began with has it.
    pub base: bool,
    /// The estimate.
    pub value: f64,
    /// 2.5 % of the searches over recordings that were drawn again found less, where few terms were asked for: 0 without the term.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// 2.5 % found more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// In how many of these it was chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chosen_by_resamples: Option<u64>,
    /// In how many of the searches without a fold it was chosen too; null where all terms are kept.
    pub chosen_by_folds: Option<u64>,
}

impl SearchSummary {
    /// The result for `vessel`, whose terms are the base structure, of a search with `options`.
    pub fn new(vessel: &Vessel, options: &SearchOptions, found: &Searched) -> Self {
        let (std, counts) = (found.std, [found.windows, found.samples]);
        let average = found.average.as_ref().zip(options.average.map(|average| average.seed));
        Self {
            ridge: Some(found.candidates[found.chosen].ridge),
            candidates: found.candidates.clone(),
            sizes: found.sizes.clone(),
            resamples: found.resampled.as_ref().zip(options.bootstrap).map(|(resampled, wanted)| Resamples {
                seed: wanted.seed,
                searches: resampled.searches,
                failed: resampled.failed,
            }),
            terms: DegreeOfFreedom::ALL.into_iter().flat_map(|d| terms(vessel, d, found)).collect(),
            average: average.map(|(average, seed)| AverageSummary::new(vessel, seed, average)),
            statements: found.statements.clone(),
            ..Self::by_options(vessel, options, std, counts, found.nested.clone())
        }
    }

    /// That of a search for `vessel` over recordings with so many `windows` and `samples` that found none; `nested` scores nothing.
    pub fn unfound(vessel: &Vessel, options: &SearchOptions, counts: [u64; 2], nested: NestedScore) -> Self {
        Self::by_options(vessel, options, [0.0; 3], counts, nested)
    }

    /// The scores of a search with `options`, without what it found.
    fn by_options(
        vessel: &Vessel,
        options: &SearchOptions,
        [std_u, std_v, std_r]: [f64; 3],
        [windows, samples]: [u64; 2],
        nested: NestedScore,
    ) -> Self {
        let seconds = |samples: usize| samples as f64 / vessel.sample_rate_hz;
        let cut = options.cut;
        Self {
            vessel: vessel.name.clone(),
            fitted_window_s: seconds(cut.window),
            every_s: seconds(cut.every),
            window_s: cut.scored.map(seconds),
            windows,
            samples,
            folds: options.folds as u64,
            std_u,
            std_v,
            std_r,
            ridge: None,
            candidates: Vec::new(),
            sizes: Vec::new(),
            nested,
            resamples: None,
            terms: Vec::new(),
            average: None,
            beside: None,
            statements: Vec::new(),
        }
    }

    /// Errors of the delivered model's kind on recordings that were left out of finding and fitting it.
    pub fn delivered_errors(&self) -> Option<FreeRunErrors> {
        match self.beside.as_ref().map(|beside| (beside.delivered, beside)) {
            Some((DeliveredKind::Average, _)) => return self.nested.average.as_ref()?.errors,
            Some((DeliveredKind::Forces, beside)) => return beside.errors,
            _ => {}
        }
        self.nested.search
    }
}

fn terms(vessel: &Vessel, degree: DegreeOfFreedom, found: &Searched) -> Vec<SearchTerm> {
    let d = degree as usize;
    let known = vessel.written(degree).len();
    let all = resampled(parameters(vessel, d, &found.model, &found.delivered), found).into_iter().enumerate();
    let chosen =
        |name: &str| found.resampled.as_ref().map(|r| r.parameters.get(name).map_or(0, |p| p.chosen));
    all.map(|(i, p)| SearchTerm {
        degree: degree.name().to_owned(),
        base: i < known,
        chosen_by_resamples: chosen(&p.name).filter(|_| !p.fixed && p.tied_to.is_none()),
        chosen_by_folds: (!found.sizes.is_empty() && !p.fixed && p.tied_to.is_none())
            .then(|| found.chosen_by_folds.get(&p.name).copied().unwrap_or(0)),
        name: p.name,
        term: p.term,
        value: p.value,
        low: p.low,
        high: p.high,
    })
    .collect()
}

/// Forces of the ship that were fitted beside a search, and what is delivered of the two.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BesideForces {
    /// What `model.json` has.
    pub delivered: DeliveredKind,
    /// How the forces may be fitted.
    pub tried: Vec<TriedFit>,
    /// The forces alone on recordings that were left out of them; none where a fold lacks a fit, or a window diverged.
    pub errors: Option<FreeRunErrors>,
    /// The same over windows of which one begins at every quarter of another.
    pub overlapping: Option<FreeRunErrors>,
}

/// What is delivered of a search and of forces beside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DeliveredKind {
    /// The mean of both trajectories.
    Average,
    /// The terms that the search found.
    Search,
    /// The forces.
    Forces,
}

/// A way to fit forces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TriedFit {
    /// The longest windows that are fitted \[s\].
    pub window_s: f64,
    /// Whether windows start at their first measured sample.
    pub measured_starts: bool,
    /// Mean fit of u, v, r of recordings that were left out of it \[%\]; null where a fold lacks a fit, or a window diverged.
    pub score: Option<f64>,
    /// Whether it is the delivered one.
    pub chosen: bool,
}

impl DeliveredKind {
    /// Whether the searched terms, and the forces, are delivered.
    pub fn members(self) -> [bool; 2] {
        [self != Self::Forces, self != Self::Search]
    }
}
