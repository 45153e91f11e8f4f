use std::collections::BTreeMap;

use estimation::Estimator;
use estimation::pooled::Delivered;
use estimation::search::{Averaged, Member, NestedScore, Searched};
use regression::MeanRemoval;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::{DegreeOfFreedom, Model, Vessel, Written};
use validation::comparison::Magnitudes;

use super::model::{AverageMember, ModelDegree, ModelDocument, ModelParameter, bounds};

/// What the models of an average are made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AverageSummary {
    /// Their number.
    pub models: u64,
    /// The seed of the draws of recordings.
    pub seed: u64,
    /// How many recordings each structure was found on.
    pub recordings_each: u64,
    /// Terms that some model has: surge, sway, yaw, those that most models have first.
    pub terms: Vec<AverageTerm>,
}

/// A term of some of the models.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AverageTerm {
    /// `surge`, `sway` or `yaw`.
    pub degree: String,
    /// Name of its parameter.
    pub name: String,
    /// What the parameter multiplies.
    pub term: String,
    /// Whether the structure that the search began with has it.
    pub base: bool,
    /// In how many of the models.
    pub chosen: u64,
    /// Least value in these.
    pub lowest: f64,
    /// Mean value in these.
    pub mean: f64,
    /// Largest.
    pub highest: f64,
}

impl AverageMember {
    /// The models that were found for `vessel` from `samples` samples with motions of `magnitudes`.
    pub fn all(
        vessel: &Vessel,
        found: &Averaged,
        samples: u64,
        magnitudes: Option<&Magnitudes>,
    ) -> Vec<Self> {
        let count = found.members.len();
        let member = |(i, member): (usize, &Member)| Self {
            weight: 1.0 / count as f64,
            found_on: member.found_on.clone(),
            model: ModelDocument {
                magnitudes: magnitudes.cloned(),
                statements: vec![format!(
                    "model {} of {count} whose trajectories are averaged; its structure was found on {} recordings",
                    i + 1,
                    member.found_on.len()
                )],
                ..ModelDocument::of_search(vessel, &member.model, &member.delivered, samples)
            },
        };
        found.members.iter().enumerate().map(member).collect()
    }
}

impl AverageSummary {
    /// The summary of models that were found for `vessel` with draws of `seed`.
    pub fn new(vessel: &Vessel, seed: u64, found: &Averaged) -> Self {
        let each = |member: &Member| member.found_on.len() as u64;
        Self {
            models: found.members.len() as u64,
            seed,
            recordings_each: found.members.first().map_or(0, each),
            terms: DegreeOfFreedom::ALL.into_iter().flat_map(|degree| terms(vessel, degree, found)).collect(),
        }
    }
}

fn terms(vessel: &Vessel, degree: DegreeOfFreedom, found: &Averaged) -> Vec<AverageTerm> {
    let (d, base) = (degree as usize, vessel.written(degree).len());
    let mut all: BTreeMap<String, AverageTerm> = BTreeMap::new();
    for member in &found.members {
        let combined = parameters(vessel, d, &member.model, &member.delivered);
        for (i, ModelParameter { name, term, value, .. }) in combined.into_iter().enumerate() {
            let new = AverageTerm {
                degree: degree.name().to_owned(),
                name: name.clone(),
                term,
                base: i < base,
                chosen: 0,
                lowest: value,
                mean: 0.0,
                highest: value,
            };
            let known = all.entry(name).or_insert(new);
            known.chosen += 1;
            known.mean += (value - known.mean) / known.chosen as f64;
            (known.lowest, known.highest) = (known.lowest.min(value), known.highest.max(value));
        }
    }
    let mut terms: Vec<AverageTerm> = all.into_values().collect();
    terms.sort_by(|a, b| b.base.cmp(&a.base).then(b.chosen.cmp(&a.chosen)).then(a.name.cmp(&b.name)));
    terms
}

impl ModelDocument {
    /// The model that a search found for `vessel`, whose terms are the base structure.
    pub fn searched(vessel: &Vessel, found: &Searched) -> Self {
        let mut model = Self::of_search(vessel, &found.model, &found.delivered, found.samples);
        for degree in &mut model.degrees {
            degree.parameters = resampled(std::mem::take(&mut degree.parameters), found);
            // Parameters that others are tied to are still estimated.
            let targets: Vec<String> = degree.parameters.iter().filter_map(|p| p.tied_to.clone()).collect();
            let combined = |parameter: &&mut ModelParameter| {
                found.combined.contains(&parameter.name)
                    && parameter.tied_to.is_none()
                    && !targets.contains(&parameter.name)
            };
            degree.parameters.iter_mut().filter(combined).for_each(|parameter| parameter.fixed = true);
        }
        let left_out = found.nested.search.as_ref();
        Self {
            left_out_rmse: left_out.map(|left_out| [left_out.rmse_u, left_out.rmse_v, left_out.rmse_r]),
            rejected: Some(rejected(&found.nested)),
            statements: [&found.statements[..], &[verdict(&found.nested)]].concat(),
            ..model
        }
    }

    /// The model with the structure `model`, as `delivered` after a fit to `samples` samples.
    fn of_search(vessel: &Vessel, model: &Model, delivered: &Delivered, samples: u64) -> Self {
        let made = (Estimator::OutputError, MeanRemoval::Complete);
        let document = Self::with_degrees(vessel, made, delivered, |d| degree(vessel, d, model, delivered));
        Self { samples, ..document }
    }
}

/// The same parameters with the bootstrap over recordings.
pub(super) fn resampled(mut parameters: Vec<ModelParameter>, found: &Searched) -> Vec<ModelParameter> {
    let all = found.resampled.as_ref().map(|resampled| &resampled.parameters);
    for parameter in parameters.iter_mut().filter(|parameter| !parameter.fixed) {
        // A tied parameter follows the other one.
        let (name, factor) = match &parameter.tied_to {
            Some(other) => (other, parameter.factor.unwrap_or(1.0)),
            None => (&parameter.name, 1.0),
        };
        let Some(ends) = all.and_then(|all| all.get(name)) else { continue };
        let [low, high] = [ends.low, ends.high].map(|end| factor * end);
        (parameter.low, parameter.high) = (Some(low.min(high)), Some(low.max(high)));
    }
    parameters
}

/// Whether left-out recordings reject the model: it diverges on them, is no better than their mean, or is worse than
/// the structure that the search began with.
fn rejected(nested: &NestedScore) -> bool {
    let useless = nested.search.as_ref().is_none_or(|e| e.fits().iter().flatten().any(|fit| *fit <= 0.0));
    let worse = nested.margin.as_ref().and_then(|margin| margin.interval[1]).is_some_and(|high| high < 0.0);
    useless || worse
}

fn verdict(nested: &NestedScore) -> String {
    let verdict = if rejected(nested) { "rejected" } else { "not rejected" };
    format!("{verdict} by the recordings that were left out of the search")
}

fn degree(vessel: &Vessel, degree: DegreeOfFreedom, model: &Model, delivered: &Delivered) -> ModelDegree {
    let (d, Delivered { constant, increment_std, output_rmse, .. }) = (degree as usize, delivered);
    ModelDegree {
        name: degree.name().to_owned(),
        state: degree.state().to_owned(),
        unit: degree.unit().to_owned(),
        parameters: parameters(vessel, d, model, delivered),
        constant: constant[d],
        constant_least_squares: None,
        increment_std: increment_std[d],
        output_rmse: output_rmse.map(|rmse| rmse[d]),
    }
}

/// The terms of degree of freedom `d` of the structure `model`.
pub(super) fn parameters(
    vessel: &Vessel,
    d: usize,
    model: &Model,
    delivered: &Delivered,
) -> Vec<ModelParameter> {
    let (layout, known) = (model.layout(), vessel.model.layout().terms(d));
    let units = model.parameter_units();
    let covariance = delivered.covariance.as_ref();
    let error = |name: &str| covariance?.standard_error(name);
    let degree = &model.degrees[d];
    let parameter = |i: usize| {
        let value = delivered.theta[layout.terms(d).start + i];
        let at_bound = degree.at_bound(i, value);
        ModelParameter {
            name: degree.parameters[i].clone(),
            term: degree.terms[i].text.clone(),
            unit: units[layout.terms(d).start + i].clone(),
            value,
            standard_error: error(&degree.parameters[i]).filter(|_| !at_bound),
            bounds: bounds(vessel, d, i),
            at_bound,
            truth: known.clone().nth(i).and_then(|known| vessel.value[known]),
            ..ModelParameter::default()
        }
    };
    // The base's terms come first, in their order in the file.
    let names: Vec<&str> = vessel.model.parameter_names().collect();
    let theta = base(vessel, model, delivered);
    let written = vessel.written(DegreeOfFreedom::ALL[d]).into_iter().map(|written| match written {
        Written::Estimated(place) => parameter(place - known.start),
        Written::Constrained(constrained) => {
            ModelParameter::constrained(vessel, constrained, &theta, |to| error(names[to]))
        }
    });
    written.chain((known.len()..degree.terms.len()).map(parameter)).collect()
}

/// The estimates of the parameters of the base structure.
fn base(vessel: &Vessel, model: &Model, delivered: &Delivered) -> Vec<f64> {
    let (all, nominal) = (model.layout(), vessel.model.layout());
    let degree = |d: usize| delivered.theta[all.terms(d)][..nominal.terms(d).len()].to_vec();
    [0, 1, 2].map(degree).concat()
}
