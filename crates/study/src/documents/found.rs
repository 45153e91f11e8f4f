//! Models from a search for their structure.

use estimation::Estimator;
use estimation::pooled::Delivered;
use estimation::search::{NestedScore, Searched};
use regression::MeanRemoval;
use ship::model::{DegreeOfFreedom, Model, Vessel, Written};

use super::model::{ModelDegree, ModelDocument, ModelParameter, bounds};

impl ModelDocument {
    /// The model that a search found for `vessel`, whose terms are the base structure.
    pub fn searched(vessel: &Vessel, found: &Searched) -> Self {
        let mut model = Self::found(vessel, &found.model, &found.delivered, found.samples);
        for degree in &mut model.degrees {
            degree.parameters = resampled(std::mem::take(&mut degree.parameters), found);
            // Parameters that others are tied to are still estimated.
            let targets: Vec<String> =
                degree.parameters.iter().filter_map(|own| own.tied_to.clone()).collect();
            let combined = |own: &&mut ModelParameter| {
                found.combined.contains(&own.name) && own.tied_to.is_none() && !targets.contains(&own.name)
            };
            degree.parameters.iter_mut().filter(combined).for_each(|own| own.fixed = true);
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
    pub(super) fn found(vessel: &Vessel, model: &Model, delivered: &Delivered, samples: u64) -> Self {
        let made = (Estimator::OutputError, MeanRemoval::Complete);
        let own = Self::with_degrees(vessel, made, delivered, |d| degree(vessel, d, model, delivered));
        Self { samples, ..own }
    }
}

/// The same parameters with the bootstrap over recordings.
pub(super) fn resampled(mut parameters: Vec<ModelParameter>, found: &Searched) -> Vec<ModelParameter> {
    let all = found.resampled.as_ref().map(|resampled| &resampled.parameters);
    for own in parameters.iter_mut().filter(|parameter| !parameter.fixed) {
        // A tied parameter follows the other one.
        let (name, factor) = match &own.tied_to {
            Some(other) => (other, own.factor.unwrap_or(1.0)),
            None => (&own.name, 1.0),
        };
        let Some(ends) = all.and_then(|all| all.get(name)) else { continue };
        let [low, high] = [ends.low, ends.high].map(|end| factor * end);
        (own.low, own.high) = (Some(low.min(high)), Some(low.max(high)));
    }
    parameters
}

/// Whether left-out recordings reject the model: it diverges on them, is no better than their mean, or is worse than
/// the structure that the search began with.
fn rejected(nested: &NestedScore) -> bool {
    let useless = nested.search.as_ref().is_none_or(|own| own.fits().iter().flatten().any(|fit| *fit <= 0.0));
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
        Written::Constrained(own) => ModelParameter::constrained(vessel, own, &theta, |to| error(names[to])),
    });
    written.chain((known.len()..degree.terms.len()).map(parameter)).collect()
}

/// The estimates of the parameters of the base structure.
fn base(vessel: &Vessel, model: &Model, delivered: &Delivered) -> Vec<f64> {
    let (all, own) = (model.layout(), vessel.model.layout());
    let degree = |d: usize| delivered.theta[all.terms(d)][..own.terms(d).len()].to_vec();
    [0, 1, 2].map(degree).concat()
}
