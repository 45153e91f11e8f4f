//! What maneuvers tell about a model's parameters: moments of measured and simulated runs, pooled by maneuver, and the
//! dictionaries that designs choose from.

mod dictionary;
mod free_runs;
mod matrices;
mod prediction;
mod rivals;

use std::collections::BTreeMap;

use design::Degree;
use identification::{InstrumentKind, Noise};
use vessel::{DegreeOfFreedom, Invalid, Model, Source, Vessel};

pub use dictionary::{Estimated, malformed};
pub use free_runs::{FreeRunModel, Unpredictable};
pub use matrices::{DegreeMoments, ManeuverMoments, OutputErrorMoments, Pool};
pub use prediction::Prediction;

/// The moments of all maneuvers of a dictionary.
#[derive(Clone, Debug)]
pub struct Moments {
    /// Name of the vessel.
    pub vessel: String,
    /// Samples per second \[Hz\].
    pub sample_rate_hz: f64,
    /// What the instruments are made of.
    pub instruments: InstrumentKind,
    /// What each row and column of the matrices stands for: the regressors end with the intercept `1`.
    pub degrees: Vec<Degree>,
    /// One entry per maneuver, in the dictionary's order.
    pub maneuvers: Vec<ManeuverMoments>,
    /// What the matrices B are made of, where there are any.
    pub expected: Option<Expected>,
    /// What the matrices for output error are about, where there are any.
    pub output_error: Option<FreeRunModel>,
}

/// The disturbances that a covariance is predicted from, and the parameters that the residual is linearised with.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// Standard deviations, white per sample.
    pub noise: Noise,
    /// Which parameters the residual is linearised with.
    pub linearised_at: Source,
    /// These, by name.
    pub parameters: BTreeMap<String, f64>,
    /// The nominal ones, by name.
    pub nominal: BTreeMap<String, f64>,
}

impl Expected {
    /// `noise`, and the best known parameters of `vessel`.
    ///
    /// # Errors
    /// A vessel without parameters.
    pub fn new(vessel: &Vessel, noise: Noise) -> Result<Self, Invalid> {
        let linearised_at = vessel.best_known();
        let parameters = by_name(&vessel.model, &vessel.parameters(linearised_at)?);
        Ok(Self { noise, linearised_at, parameters, nominal: by_name(&vessel.model, &vessel.nominal) })
    }
}

/// `values` of the model's parameters by name.
fn by_name(model: &Model, values: &[f64]) -> BTreeMap<String, f64> {
    model.parameter_names().map(str::to_owned).zip(values.iter().copied()).collect()
}

/// The rows and columns of the moments of `model`.
pub fn structure(model: &Model) -> Vec<Degree> {
    let of = |(d, degree): (DegreeOfFreedom, &vessel::Degree)| Degree {
        name: d.name().to_owned(),
        regressors: degree.terms.iter().map(|t| t.text.clone()).chain(["1".to_owned()]).collect(),
        parameters: degree.parameters.clone(),
    };
    DegreeOfFreedom::ALL.into_iter().zip(&model.degrees).map(of).collect()
}

/// Names of the parameters with an intercept per degree of freedom, as the matrices for output error have them.
pub(crate) fn rows(model: &Model) -> Vec<String> {
    let of = |(d, degree): (DegreeOfFreedom, &vessel::Degree)| {
        degree.parameters.iter().cloned().chain([format!("intercept ({})", d.name())]).collect::<Vec<_>>()
    };
    DegreeOfFreedom::ALL.into_iter().zip(&model.degrees).flat_map(of).collect()
}
