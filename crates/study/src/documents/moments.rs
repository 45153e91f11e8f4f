use std::collections::BTreeMap;

use artifact::Document;
use design::Degree;
use identification::{InstrumentKind, Noise};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trial::moments::{self, Expected, FreeRunModel, Moments};
use vessel::{Invalid, Source};

/// `moments.json`: the lifted moment matrices of every maneuver.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MomentsDocument {
    /// Name of the vessel.
    pub vessel: String,
    /// Sampling rate \[Hz\].
    pub sample_rate_hz: f64,
    /// What the instruments are made of.
    pub instruments: InstrumentKind,
    /// What each row and column of the matrices stands for.
    pub degrees: Vec<DegreeStructure>,
    /// One entry per maneuver, in the dictionary's order.
    pub maneuvers: Vec<ManeuverMoments>,
    /// What the matrices `B` were computed from, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disturbances: Option<ExpectedDisturbances>,
    /// What the matrices `F` and `P` of an output-error estimate are about, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_error: Option<OutputErrorModel>,
}

/// The model whose free simulation the information of an output-error estimate is about.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputErrorModel {
    /// Which parameters it has.
    pub simulated_with: Source,
    /// These parameters, in units of the state's increment per unit of the term.
    pub parameters: BTreeMap<String, f64>,
    /// Rows and columns of the matrices: the parameters of surge, `intercept (surge)`, then sway and yaw.
    pub rows: Vec<String>,
    /// Mean of SᵀS over the validation maneuvers, row-major, S = ∂x/∂θ̃ summed over the states: the variance of a free run's
    /// error is tr(cov G).
    #[serde(rename = "G", default, skip_serializing_if = "Option::is_none")]
    pub g: Option<Vec<f64>>,
}

/// What one maneuver tells an output-error estimate, per sample: matrices with `rows` of the model, row-major.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
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

/// The disturbances that an estimate's covariance is predicted from, white per sample.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpectedDisturbances {
    /// Standard deviation of the measured surge speed \[m/s\].
    pub std_u_m_s: f64,
    /// Standard deviation of the measured sway speed \[m/s\].
    pub std_v_m_s: f64,
    /// Standard deviation of the measured yaw rate \[rad/s\].
    pub std_r_rad_s: f64,
    /// Standard deviation of each component of the current in body axes \[m/s\].
    pub current_std_m_s: f64,
    /// Which parameters the residual was linearised with.
    pub linearised_at: Source,
    /// These parameters, in units of the state's increment per unit of the term.
    pub parameters: BTreeMap<String, f64>,
    /// The nominal parameters, in the same units.
    pub nominal: BTreeMap<String, f64>,
}

/// One degree of freedom of the model structure.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DegreeStructure {
    /// `surge`, `sway` or `yaw`.
    pub name: String,
    /// Regressors φ in order, followed by the intercept `1`.
    pub regressors: Vec<String>,
    /// Parameters θ in order (one fewer than regressors).
    pub parameters: Vec<String>,
}

/// The moments of one maneuver.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ManeuverMoments {
    /// Name in the dictionary.
    pub name: String,
    /// Number of regression pairs N.
    pub samples: u64,
    /// One matrix per degree of freedom.
    pub degrees: Vec<DegreeMoments>,
    /// For an output-error estimate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_error: Option<OutputErrorMoments>,
}

/// M = mean of φ̃ ζ̃ᵀ = [[X̄, Ȳ], [Z̄ᵀ, 1]] of one maneuver and degree of freedom.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
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
    /// Middle matrix of the estimate's covariance A⁻¹BA⁻ᵀ/N, A = Mᵀ: B = (1/N) Σ ζ̃ E[εε] ζ̃ᵀ, row-major, shape as `M`,
    /// rows and columns by instrument; in units of instrument i times instrument j times the state's variance.
    #[serde(rename = "B", default, skip_serializing_if = "Option::is_none")]
    pub b: Option<Vec<f64>>,
}

impl Document for MomentsDocument {
    const ID: &'static str = "moments";
    const VERSION: u32 = 1;
    const UNITS: &'static [(&'static str, &'static str)] = &[
        ("sample_rate_hz", "Hz"),
        ("samples", "1"),
        ("shape", "1"),
        ("M", "unit of regressor i times unit of instrument j"),
        ("nonstationarity", "1"),
    ];
}

impl From<Moments> for MomentsDocument {
    fn from(from: Moments) -> Self {
        let degrees = from.degrees;
        Self {
            vessel: from.vessel,
            sample_rate_hz: from.sample_rate_hz,
            instruments: from.instruments,
            maneuvers: from.maneuvers.into_iter().map(|m| ManeuverMoments::of(m, &degrees)).collect(),
            disturbances: from.expected.map(Into::into),
            output_error: from.output_error.map(Into::into),
            degrees: degrees.into_iter().map(DegreeStructure::of).collect(),
        }
    }
}

impl MomentsDocument {
    /// What the document says.
    ///
    /// # Errors
    /// A matrix of another shape than its degree of freedom has.
    pub fn moments(&self) -> Result<Moments, Invalid> {
        Ok(Moments {
            vessel: self.vessel.clone(),
            sample_rate_hz: self.sample_rate_hz,
            instruments: self.instruments,
            degrees: self.degrees.iter().cloned().map(Degree::from).collect(),
            maneuvers: self.maneuvers.iter().map(ManeuverMoments::moments).collect::<Result<_, _>>()?,
            expected: self.disturbances.clone().map(Into::into),
            output_error: self.output_error.clone().map(Into::into),
        })
    }
}

impl DegreeStructure {
    fn of(Degree { name, regressors, parameters }: Degree) -> Self {
        Self { name, regressors, parameters }
    }
}

impl From<DegreeStructure> for Degree {
    fn from(DegreeStructure { name, regressors, parameters }: DegreeStructure) -> Self {
        Self { name, regressors, parameters }
    }
}

impl From<Expected> for ExpectedDisturbances {
    fn from(from: Expected) -> Self {
        let [std_u_m_s, std_v_m_s, std_r_rad_s] = from.noise.measurement;
        Self {
            std_u_m_s,
            std_v_m_s,
            std_r_rad_s,
            current_std_m_s: from.noise.current,
            linearised_at: from.linearised_at,
            parameters: from.parameters,
            nominal: from.nominal,
        }
    }
}

impl From<ExpectedDisturbances> for Expected {
    fn from(from: ExpectedDisturbances) -> Self {
        let measurement = [from.std_u_m_s, from.std_v_m_s, from.std_r_rad_s];
        Self {
            noise: Noise { measurement, current: from.current_std_m_s },
            linearised_at: from.linearised_at,
            parameters: from.parameters,
            nominal: from.nominal,
        }
    }
}

impl From<FreeRunModel> for OutputErrorModel {
    fn from(FreeRunModel { simulated_with, parameters, rows, g }: FreeRunModel) -> Self {
        Self { simulated_with, parameters, rows, g }
    }
}

impl From<OutputErrorModel> for FreeRunModel {
    fn from(OutputErrorModel { simulated_with, parameters, rows, g }: OutputErrorModel) -> Self {
        Self { simulated_with, parameters, rows, g }
    }
}

impl ManeuverMoments {
    fn of(from: moments::ManeuverMoments, degrees: &[Degree]) -> Self {
        let degree = |(degree, own): (&Degree, moments::DegreeMoments)| DegreeMoments {
            name: degree.name.clone(),
            shape: [own.m.len().isqrt() as u64; 2],
            m: own.m,
            nonstationarity: own.nonstationarity,
            b: own.b,
        };
        let output_error = |moments::OutputErrorMoments { f, e, p }: moments::OutputErrorMoments| {
            OutputErrorMoments { f, e, p }
        };
        Self {
            name: from.name,
            samples: from.samples,
            degrees: degrees.iter().zip(from.degrees).map(degree).collect(),
            output_error: from.output_error.map(output_error),
        }
    }

    fn moments(&self) -> Result<moments::ManeuverMoments, Invalid> {
        let degree = |own: &DegreeMoments| {
            let [rows, columns] = own.shape;
            if rows != columns || rows.checked_mul(columns) != Some(own.m.len() as u64) {
                let found = format!("{} entries in {}", own.m.len(), own.name);
                return Err(moments::malformed(&self.name, &found));
            }
            let (m, b) = (own.m.clone(), own.b.clone());
            Ok(moments::DegreeMoments { m, nonstationarity: own.nonstationarity, b })
        };
        let output_error = |o: &OutputErrorMoments| {
            let OutputErrorMoments { f, e, p } = o.clone();
            moments::OutputErrorMoments { f, e, p }
        };
        Ok(moments::ManeuverMoments {
            name: self.name.clone(),
            samples: self.samples,
            degrees: self.degrees.iter().map(degree).collect::<Result<_, _>>()?,
            output_error: self.output_error.as_ref().map(output_error),
        })
    }
}
