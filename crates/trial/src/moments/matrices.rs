use std::collections::{BTreeMap, HashMap};

use estimation::prediction_weights;
use maneuver::Generator;
use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::{Model, Source, Vessel};

use super::{by_name, rows};

/// The moments of one maneuver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ManeuverMoments {
    /// Name in the dictionary.
    pub name: String,
    /// Number of regression pairs N.
    pub samples: u64,
    /// One matrix per degree of freedom; none of a ship with forces.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub degrees: Vec<DegreeMoments>,
    /// For an output-error estimate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_error: Option<OutputErrorMoments>,
}

/// M = mean of φ̃ ζ̃ᵀ = \[\[X̄, Ȳ\], \[Z̄ᵀ, 1\]\] of one maneuver and degree of freedom.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DegreeMoments {
    /// `surge`, `sway` or `yaw`.
    pub name: String,
    /// Rows and columns of `M`.
    pub shape: [u64; 2],
    /// Row-major entries; row i belongs to regressor i, column j to instrument j.
    #[serde(rename = "M")]
    pub m: Vec<f64>,
    /// Largest change of an entry between the first and the second half of the maneuver, relative to the
    /// root mean squares of its regressor and instrument: 0 is stationary, 1 is not at all.
    pub nonstationarity: f64,
    /// Middle matrix of the estimate's covariance A⁻¹BA⁻ᵀ/N, A = Mᵀ: B = (1/N) Σ ζ̃ E\[εε\] ζ̃ᵀ, row-major, shape as `M`,
    /// rows and columns by instrument; in units of instrument i times instrument j times the state's variance.
    #[serde(rename = "B", default, skip_serializing_if = "Option::is_none")]
    pub b: Option<Vec<f64>>,
}

/// What one maneuver tells an output-error estimate, per sample: matrices with `rows` of the model, row-major.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputErrorMoments {
    /// Mean of SᵀWS, W the channels' weights 1/variance: Fisher's information where only white measurement errors disturb.
    #[serde(rename = "F")]
    pub f: Vec<f64>,
    /// What measurement errors add to the middle matrix of the covariance F⁻¹(E + P)F⁻¹/N; F where there is none.
    #[serde(rename = "E", default, skip_serializing_if = "Option::is_none")]
    pub e: Option<Vec<f64>>,
    /// What the current adds.
    #[serde(rename = "P", default, skip_serializing_if = "Option::is_none")]
    pub p: Option<Vec<f64>>,
}

impl ManeuverMoments {
    /// Refuses fewer samples than a degree of freedom of `model` has unknowns.
    ///
    /// # Errors
    /// Names the maneuver.
    pub fn check_length(&self, model: &Model) -> Result<(), Invalid> {
        let unknowns = model.degrees.iter().map(|d| d.terms.len() + 1).max().unwrap_or(0);
        if self.samples as usize >= unknowns {
            return Ok(());
        }
        Err(Invalid::new(
            format!("maneuver `{}`", self.name),
            format!("{} samples", self.samples),
            format!("at least {unknowns}, the unknowns of a degree of freedom"),
            "lengthen the maneuver",
        ))
    }

    /// Adds the moments of more samples of the same maneuver.
    pub fn pool(&mut self, more: &Self) {
        let samples = self.samples + more.samples;
        let share = more.samples as f64 / samples.max(1) as f64;
        let towards = |mine: &mut [f64], other: &[f64]| {
            mine.iter_mut().zip(other).for_each(|(m, o)| *m += share * (o - *m));
        };
        for (degree, other) in self.degrees.iter_mut().zip(&more.degrees) {
            towards(&mut degree.m, &other.m);
            if let (Some(meat), Some(other)) = (&mut degree.b, &other.b) {
                towards(meat, other);
            }
            degree.nonstationarity = degree.nonstationarity.max(other.nonstationarity);
        }
        if let (Some(mine), Some(other)) = (&mut self.output_error, &more.output_error) {
            towards(&mut mine.f, &other.f);
            for (matrix, other) in [(&mut mine.e, &other.e), (&mut mine.p, &other.p)] {
                if let (Some(matrix), Some(other)) = (matrix, other) {
                    towards(matrix, other);
                }
            }
        }
        self.samples = samples;
    }
}

/// Moments by maneuver, in order of first appearance.
#[derive(Clone, Debug, Default)]
pub struct Pool {
    maneuvers: Vec<ManeuverMoments>,
    places: HashMap<String, usize>,
}

impl Pool {
    /// Adds the moments of a run, `pooled` with others of the same maneuver or not.
    ///
    /// # Errors
    /// A second run of a maneuver that is not pooled.
    pub fn add(&mut self, pooled: bool, more: ManeuverMoments) -> Result<(), Invalid> {
        match self.places.get(&more.name).and_then(|place| self.maneuvers.get_mut(*place)) {
            None => {
                self.places.insert(more.name.clone(), self.maneuvers.len());
                self.maneuvers.push(more);
            }
            Some(known) if pooled => known.pool(&more),
            Some(_) => {
                let (thing, expected) = (format!("maneuver `{}`", more.name), "one run per maneuver");
                return Err(Invalid::new(thing, "two runs of it", expected, "name each maneuver once"));
            }
        }
        Ok(())
    }

    /// All maneuvers.
    ///
    /// # Errors
    /// One with fewer samples than a degree of freedom of `model` has unknowns.
    pub fn finish(self, model: &Model) -> Result<Vec<ManeuverMoments>, Invalid> {
        self.maneuvers.iter().try_for_each(|maneuver| maneuver.check_length(model))?;
        Ok(self.maneuvers)
    }
}

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
        let g = validation.map(|all| validation_weights(model, &theta, all)).transpose()?.flatten();
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
        let weights = prediction_weights(model, theta, run.initial, &model.undisturbed(&run.inputs))
            .ok_or_else(|| Unpredictable::Vessel(what()))?;
        sum.iter_mut().zip(&weights).for_each(|(s, o)| *s += o);
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
