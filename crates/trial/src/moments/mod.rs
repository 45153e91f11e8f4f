//! The information of maneuvers about a model's parameters: moments of measured and simulated runs, pooled by
//! maneuver, and the dictionaries that designs choose from.

mod criteria;
mod dictionary;
mod free_runs;
mod matrices;
mod physical;
mod prediction;
mod prior;
mod rivals;
mod sampled;

use std::collections::BTreeMap;

pub use criteria::{CriterionOf, NoCriterion};
use design::{Degree, NoDesign};
pub use dictionary::{Estimated, leading, malformed};
pub use free_runs::{FreeRunModel, Unpredictable};
pub use matrices::{DegreeMoments, ManeuverMoments, OutputErrorMoments, Pool};
pub use physical::{ForcesPrediction, numbers};
pub use prediction::Prediction;
pub use prior::PriorInformation;
use refusal::Invalid;
use regression::{InstrumentKind, Noise};
pub use sampled::{
    MissedAim, PlayedMotion, Promise, SampledFrom, SampledShips, ShipSampler, UnreachedMotion,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::{DegreeOfFreedom, Model, Source, Vessel};

/// The lifted moment matrices of every maneuver.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct Moments {
    /// Name of the vessel.
    pub vessel: String,
    /// Sampling rate \[Hz\].
    pub sample_rate_hz: f64,
    /// What the instruments are made of; a ship with forces has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instruments: Option<InstrumentKind>,
    /// What each row and column of the matrices stands for. Of a ship with forces one block of its free numbers, without
    /// intercepts.
    pub degrees: Vec<Degree>,
    /// One entry per maneuver, in the dictionary's order.
    pub maneuvers: Vec<ManeuverMoments>,
    /// Parameters that no maneuver excites apart from the others, which are held at their values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held: Vec<HeldParameter>,
    /// Where the maneuvers leave what the logs of the model cover, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beyond: Vec<String>,
    /// What the matrices `B` were computed from, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disturbances: Option<Expected>,
    /// What the matrices `F` and `P` of an output-error estimate are about, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_error: Option<FreeRunModel>,
    /// What is known of the ship before the trial: by the fit of her model, or by the priors of her forces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior: Option<PriorInformation>,
    /// What ships with other parameters do, where the true ones are not known and the maneuvers were simulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sampled: Option<SampledShips>,
}

/// A parameter that is held at its value, since no maneuver excites it apart from the others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeldParameter {
    /// Its name.
    pub parameter: String,
    /// `surge`, `sway` or `yaw`.
    pub degree: String,
    /// Its term.
    pub term: String,
}

impl HeldParameter {
    /// Those of `all`, in words.
    pub fn words(all: &[Self]) -> String {
        let one = |own: &Self| format!("`{}` (`{}` in {})", own.parameter, own.term, own.degree);
        let (names, are) =
            (all.iter().map(one).collect::<Vec<_>>().join(", "), if all.len() > 1 { "are" } else { "is" });
        format!(
            "no maneuver excites {names} apart from the others: {are} held at the model's values, and nothing is learnt about them"
        )
    }
}

impl Moments {
    /// A parameter that no mixture of the maneuvers excites apart from the others; `None` where all are, or where its degree
    /// of freedom has no other.
    ///
    /// # Errors
    /// As [`Moments::dictionary`].
    pub fn unexcited(&self, estimated: Estimated) -> Result<Option<HeldParameter>, Invalid> {
        let Err(NoDesign::Unexcited { degree, parameter, regressor }) =
            self.dictionary(estimated)?.check_excited()
        else {
            return Ok(None);
        };
        let is_only = self.degrees.iter().any(|own| own.parameters == [parameter.as_str()]);
        Ok((!is_only).then_some(HeldParameter { parameter, degree, term: regressor }))
    }
}

/// The disturbances that an estimate's covariance is predicted from, white per sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Expected {
    /// Standard deviation of the measured surge speed \[m/s\].
    pub std_u_m_s: f64,
    /// Standard deviation of the measured sway speed \[m/s\].
    pub std_v_m_s: f64,
    /// Standard deviation of the measured yaw rate \[rad/s\].
    pub std_r_rad_s: f64,
    /// Standard deviation of each component of the current in body axes \[m/s\].
    pub current_std_m_s: f64,
    /// Whether the campaign has a current that lasts, whose effect is not predicted.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub lasting_current_left_out: bool,
    /// Which parameters the residual was linearised with.
    pub linearised_at: Source,
    /// These parameters, in units of the state's increment per unit of the term.
    pub parameters: BTreeMap<String, f64>,
    /// The nominal parameters, in the same units.
    pub nominal: BTreeMap<String, f64>,
    /// Duration of a trial of the campaign \[s\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trial_s: Option<f64>,
}

impl Expected {
    /// `noise` over trials of `trial_s` seconds, and the best known parameters of `vessel`.
    ///
    /// # Errors
    /// A vessel without parameters.
    pub fn new(vessel: &Vessel, noise: Noise, trial_s: f64) -> Result<Self, Invalid> {
        let linearised_at = vessel.best_known();
        let parameters = by_name(&vessel.model, &vessel.parameters(linearised_at)?);
        let [std_u_m_s, std_v_m_s, std_r_rad_s] = noise.measurement;
        Ok(Self {
            std_u_m_s,
            std_v_m_s,
            std_r_rad_s,
            current_std_m_s: noise.current,
            lasting_current_left_out: false,
            linearised_at,
            parameters,
            nominal: by_name(&vessel.model, &vessel.nominal),
            trial_s: Some(trial_s),
        })
    }

    /// The standard deviations.
    pub(crate) fn noise(&self) -> Noise {
        let measurement = [self.std_u_m_s, self.std_v_m_s, self.std_r_rad_s];
        Noise { measurement, current: self.current_std_m_s }
    }
}

/// `values` of the model's parameters by name.
fn by_name(model: &Model, values: &[f64]) -> BTreeMap<String, f64> {
    model.parameter_names().map(str::to_owned).zip(values.iter().copied()).collect()
}

/// Refuses an estimated term 1: every degree of freedom of a design has an intercept already, whose error is
/// not counted.
///
/// # Errors
/// Names the parameter.
pub fn check_constants(model: &Model) -> Result<(), Invalid> {
    let constant = |degree: &ship::model::Degree| degree.constant().map(|i| degree.parameters[i].clone());
    match model.degrees.iter().find_map(constant) {
        None => Ok(()),
        Some(name) => Err(Invalid::new(
            format!("parameter `{name}`"),
            "the term `1`, which is estimated",
            "terms that a maneuver can excite: every run has an intercept of its own, and no design makes it better known",
            "give it its value and `fixed = true`, or remove it",
        )),
    }
}

/// The rows and columns of the moments of `model`.
pub fn structure(model: &Model) -> Vec<Degree> {
    let of = |(d, degree): (DegreeOfFreedom, &ship::model::Degree)| Degree {
        name: d.name().to_owned(),
        regressors: degree.terms.iter().map(|t| t.text.clone()).chain(["1".to_owned()]).collect(),
        parameters: degree.parameters.clone(),
    };
    DegreeOfFreedom::ALL.into_iter().zip(&model.degrees).map(of).collect()
}

/// Names of the parameters with an intercept per degree of freedom, in the order of output error's matrices.
pub(crate) fn rows(model: &Model) -> Vec<String> {
    let of = |(d, degree): (DegreeOfFreedom, &ship::model::Degree)| {
        degree.parameters.iter().cloned().chain([format!("intercept ({})", d.name())]).collect::<Vec<_>>()
    };
    DegreeOfFreedom::ALL.into_iter().zip(&model.degrees).flat_map(of).collect()
}
