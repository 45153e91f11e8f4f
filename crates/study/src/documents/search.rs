use artifact::{Document, Units};
use identification::pooled::Delivered;
use identification::search::{Candidate, Cut, NestedScore, Searched, SizeScore};
use identification::{Estimator, MeanRemoval};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vessel::{DegreeOfFreedom, Vessel, Written};

use super::model::{ModelDegree, ModelDocument, ModelParameter};

/// `search.json`: how a model's structure was searched for in recordings, and how far the search can be trusted.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SearchDocument {
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
    /// The ridge Λ that was chosen.
    pub ridge: f64,
    /// Ridges in the order that they were tried in.
    pub candidates: Vec<Candidate>,
    /// Numbers of terms in the order of additions, where few terms were asked for.
    pub sizes: Vec<SizeScore>,
    /// The whole search on recordings that were left out of it, beside the base structure.
    pub nested: NestedScore,
    /// The terms that were found.
    pub terms: Vec<SearchTerm>,
    /// What was found, in words.
    pub statements: Vec<String>,
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
    /// Its standard error; that of the ridge estimate, which knows nothing of the bias.
    pub standard_error: Option<f64>,
    /// In how many of the searches without a fold it was chosen too; null where all terms are kept.
    pub chosen_by_folds: Option<u64>,
}

impl SearchDocument {
    /// What was found for `vessel`, whose terms are the base structure, with windows `cut` in samples.
    pub fn new(vessel: &Vessel, cut: Cut, folds: usize, found: &Searched) -> Self {
        let seconds = |samples: usize| samples as f64 / vessel.sample_rate_hz;
        let [std_u, std_v, std_r] = found.std;
        Self {
            vessel: vessel.name.clone(),
            fitted_window_s: seconds(cut.window),
            every_s: seconds(cut.every),
            window_s: cut.scored.map(seconds),
            windows: found.windows,
            samples: found.samples,
            folds: folds as u64,
            std_u,
            std_v,
            std_r,
            ridge: found.candidates[found.chosen].ridge,
            candidates: found.candidates.clone(),
            sizes: found.sizes.clone(),
            nested: found.nested.clone(),
            terms: DegreeOfFreedom::ALL.into_iter().flat_map(|d| terms(vessel, d, found)).collect(),
            statements: found.statements.clone(),
        }
    }
}

fn terms(vessel: &Vessel, degree: DegreeOfFreedom, found: &Searched) -> Vec<SearchTerm> {
    let d = degree as usize;
    let known = vessel.written(degree).len();
    let all = parameters(&vessel.value, vessel, d, found).into_iter().enumerate();
    all.map(|(i, p)| SearchTerm {
        degree: degree.name().to_owned(),
        base: i < known,
        chosen_by_folds: (!found.sizes.is_empty() && !p.fixed && p.tied_to.is_none())
            .then(|| found.chosen_by_folds.get(&p.name).copied().unwrap_or(0)),
        name: p.name,
        term: p.term,
        value: p.value,
        standard_error: p.standard_error,
    })
    .collect()
}

impl ModelDocument {
    /// The model that a search found for `vessel`, whose terms are the base structure.
    pub fn searched(vessel: &Vessel, found: &Searched) -> Self {
        let (inputs, measured) = Self::channels(vessel);
        Self {
            vessel: vessel.name.clone(),
            sample_rate_hz: vessel.sample_rate_hz,
            inputs,
            measured,
            degrees: DegreeOfFreedom::ALL.into_iter().map(|d| degree(vessel, d, found)).collect(),
            covariance: found.delivered.covariance.clone(),
            estimator: Estimator::OutputError,
            mean_removal: MeanRemoval::Complete,
            samples: found.samples,
            recordings: found.delivered.recordings.clone(),
            covered: found.delivered.covered.clone(),
            magnitudes: None,
            rejected: Some(rejected(&found.nested)),
            statements: [&found.statements[..], &[verdict(&found.nested)]].concat(),
        }
    }
}

/// Whether recordings that were left out speak against what was found: it cannot follow them, is no better than their mean, or
/// is worse than the structure that the search began with.
fn rejected(nested: &NestedScore) -> bool {
    let useless = nested.search.as_ref().is_none_or(|own| own.fits().iter().flatten().any(|fit| *fit <= 0.0));
    let worse = nested.margin.as_ref().and_then(|margin| margin.interval[1]).is_some_and(|high| high < 0.0);
    useless || worse
}

fn verdict(nested: &NestedScore) -> String {
    let told = if rejected(nested) { "rejected" } else { "not rejected" };
    format!("{told} by the recordings that were left out of the search")
}

fn degree(vessel: &Vessel, degree: DegreeOfFreedom, found: &Searched) -> ModelDegree {
    let (d, Delivered { constant, increment_std, output_rmse, .. }) = (degree as usize, &found.delivered);
    ModelDegree {
        name: degree.name().to_owned(),
        state: degree.state().to_owned(),
        unit: degree.unit().to_owned(),
        parameters: parameters(&vessel.value, vessel, d, found),
        constant: constant[d],
        constant_least_squares: None,
        increment_std: increment_std[d],
        output_rmse: output_rmse.map(|rmse| rmse[d]),
    }
}

/// The terms of degree of freedom `d`; `truth` holds what is known of the base structure.
fn parameters(truth: &[Option<f64>], vessel: &Vessel, d: usize, found: &Searched) -> Vec<ModelParameter> {
    let (layout, known) = (found.model.layout(), vessel.model.layout().terms(d));
    let units = found.model.parameter_units();
    let covariance = found.delivered.covariance.as_ref();
    let error = |name: &String| {
        let (of, n) = (covariance?, covariance?.names.len());
        of.names.iter().position(|own| own == name).map(|i| of.entries[i * n + i].max(0.0).sqrt())
    };
    let degree = &found.model.degrees[d];
    let parameter = |i: usize| ModelParameter {
        name: degree.parameters[i].clone(),
        term: degree.terms[i].text.clone(),
        unit: units[layout.terms(d).start + i].clone(),
        value: found.delivered.theta[layout.terms(d).start + i],
        standard_error: error(&degree.parameters[i]),
        truth: known.clone().nth(i).and_then(|known| truth[known]),
        ..ModelParameter::default()
    };
    // The base's terms come first, in the order that they are written in.
    let names: Vec<&str> = vessel.model.parameter_names().collect();
    let theta = base(vessel, found);
    let written = vessel.written(DegreeOfFreedom::ALL[d]).into_iter().map(|written| match written {
        Written::Estimated(place) => parameter(place - known.start),
        Written::Constrained(own) => {
            ModelParameter::constrained(vessel, own, &theta, |to| error(&names[to].to_owned()))
        }
    });
    written.chain((known.len()..degree.terms.len()).map(parameter)).collect()
}

/// The values that were found for the parameters of the base structure.
fn base(vessel: &Vessel, found: &Searched) -> Vec<f64> {
    let (all, own) = (found.model.layout(), vessel.model.layout());
    let degree = |d: usize| found.delivered.theta[all.terms(d)][..own.terms(d).len()].to_vec();
    [0, 1, 2].map(degree).concat()
}

impl Document for SearchDocument {
    const ID: &'static str = "search";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("s", "fitted_window_s every_s window_s"),
        (
            "1",
            "terms windows samples folds chosen_by_folds loss excess ridge ridges rejected diverged fold margin search_norm base_norm",
        ),
        ("%", "score fit_u fit_v fit_r"),
        ("m/s", "std_u std_v rmse_u rmse_v"),
        ("rad/s", "std_r rmse_r"),
        ("the parameter's unit", "value"),
        ("the unit of what it belongs to", "standard_error"),
    ];
}
