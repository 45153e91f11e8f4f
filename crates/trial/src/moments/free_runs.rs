use std::collections::BTreeMap;

use estimation::prediction_weights;
use maneuver::Generator;
use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::{Model, Source, Vessel};

use super::{by_name, rows};

/// The model whose free simulation the information of an output-error estimate is about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FreeRunModel {
    /// Which parameters it has.
    pub simulated_with: Source,
    /// These parameters, in units of the state's increment per unit of the term.
    pub parameters: BTreeMap<String, f64>,
    /// Rows and columns of the matrices: the parameters of surge, `intercept (surge)`, then sway and yaw; of a ship with forces
    /// the free numbers alone.
    pub rows: Vec<String>,
    /// Mean of SᵀS over the validation maneuvers, row-major, S = ∂x/∂θ̃ summed over the states: the variance of a free run's
    /// error is tr(cov G).
    #[serde(rename = "G", default, skip_serializing_if = "Option::is_none")]
    pub g: Option<Vec<f64>>,
}

impl FreeRunModel {
    /// The model with the best known parameters of `vessel`, and the maneuvers of `validation`, if there are some.
    ///
    /// # Errors
    /// A maneuver that the model cannot hold, or that diverges.
    pub fn new(vessel: &Vessel, validation: Option<&Generator>) -> Result<Self, Unpredictable> {
        let (model, simulated_with) = (&vessel.model, vessel.best_known());
        let theta = vessel.parameters(simulated_with).map_err(Unpredictable::Vessel)?;
        let g =
            validation.map(|validation| validation_weights(model, &theta, validation)).transpose()?.flatten();
        Ok(Self { simulated_with, parameters: by_name(model, &theta), rows: rows(model), g })
    }
}

/// G of the maneuvers of `generator`, for the model with parameters `theta`; `None` where there are no samples.
fn validation_weights(
    model: &Model,
    theta: &[f64],
    generator: &Generator,
) -> Result<Option<Vec<f64>>, Unpredictable> {
    let n = model.layout().with_intercepts().parameters();
    let (mut sum, mut total) = (vec![0.0; n * n], 0.0);
    for (index, maneuver) in generator.maneuvers().iter().enumerate() {
        let samples = generator.samples(index).map_err(Unpredictable::Maneuver)?;
        let run = generator.realize(index, samples).map_err(Unpredictable::Maneuver)?;
        let what = || diverges(&format!("validation maneuver `{}`", maneuver.name));
        let own = prediction_weights(model, theta, run.initial, &model.undisturbed(&run.inputs))
            .ok_or_else(|| Unpredictable::Vessel(what()))?;
        sum.iter_mut().zip(&own).for_each(|(s, o)| *s += samples as f64 * o);
        total += samples as f64;
    }
    Ok((total > 0.0).then(|| sum.iter().map(|s| s / total).collect()))
}

/// Why free runs over validation maneuvers cannot be predicted, by the part at fault.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum Unpredictable {
    /// A validation maneuver that the model cannot hold.
    #[error("{0}")]
    Maneuver(Invalid),
    /// Parameters with which a maneuver diverges.
    #[error("{0}")]
    Vessel(Invalid),
}

/// The refusal of a vessel whose free simulation of `what` diverges.
pub(super) fn diverges(what: &str) -> Invalid {
    Invalid::new(
        format!("free simulation of {what}"),
        "one that diverges",
        "bounded motion",
        "take other parameters, or milder maneuvers",
    )
}
