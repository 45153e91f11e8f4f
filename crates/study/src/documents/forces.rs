//! Forces that were fitted, criticised and searched for, within `model.json` and `estimate.json`.

use estimation::criticism::Criticism;
use estimation::pooled::Covariance;
use refusal::{Invalid, strictly};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::forces::Description;
use ship::model::{Vessel, VesselFile};

/// Forces that were fitted to recordings: the ship as written before the fit, and her free numbers after it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FittedForces {
    /// The ship as a `vessel.toml` has her, with her numbers before the fit and their priors.
    pub description: String,
    /// The free numbers.
    pub parameters: Vec<FittedParameter>,
    /// Covariance of the free numbers, in the systems that they were written in; 0 at bounds.
    pub covariance: Covariance,
    /// Square root of the largest over the smallest eigenvalue of what the recordings tell, in correlations; null where they
    /// leave a direction open.
    pub condition: Option<f64>,
    /// Length of the windows \[s\].
    pub window_s: f64,
    /// Number of windows.
    pub windows: u64,
    /// Pieces of the windows that count as independent in standard errors.
    pub pieces: u64,
    /// Whether every window has a start of its own, or starts at its first measured sample.
    pub unknown_starts: bool,
    /// Whether each row of inputs acted during its whole sample, as in simulated runs; those of logs are linear between samples.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub held_inputs: bool,
    /// Weight of the priors.
    pub prior_weight: f64,
    /// The mean of Huber's function of the windows' RMS errors in standard deviations, with what the priors add.
    pub cost: f64,
    /// Steps of the search.
    pub steps: u64,
    /// What the recordings know of sway and yaw: sums of terms along what was sailed; null where nothing was turned.
    #[serde(default)]
    pub sailed: Option<SailedSums>,
    /// The publication of captive values, if they were given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub captive_source: Option<String>,
    /// What is wrong with the ship by these recordings; null where that was not asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub criticism: Option<Criticism>,
}

/// Sums of terms of sway and yaw where v is a multiple of r L, in the prime system, with a yaw rate of 1 there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SailedSums {
    /// v over r L as sailed, by least squares over all samples.
    pub drift: f64,
    /// The sums.
    pub sums: Vec<SailedSum>,
}

/// A sum of the terms of one order along what was sailed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SailedSum {
    /// `sway` or `yaw`.
    pub degree: String,
    /// 1 for linear terms, 3 for cubic ones.
    pub order: u32,
    /// The free numbers in it.
    pub terms: Vec<String>,
    /// The sum.
    pub value: f64,
    /// Its standard error, from the covariance of the numbers.
    pub standard_error: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
    /// Its standard deviation by the priors alone; null where a number has none.
    pub prior_deviation: Option<f64>,
    /// The sum of captive values, where all of them were given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub captive: Option<CaptiveValue>,
}

/// A value of captive tests beside an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CaptiveValue {
    /// The value, in the prime system where there is one, else in SI units.
    pub value: f64,
    /// Whether it lies within the estimate's 95 % interval; null where that has none.
    pub within: Option<bool>,
}

/// A free number after the fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FittedParameter {
    /// Its name.
    pub name: String,
    /// Its unit as written; `1` in the prime system.
    pub unit: String,
    /// The estimate.
    pub value: f64,
    /// Its standard error; null at a bound.
    pub standard_error: Option<f64>,
    /// Its value before the fit.
    pub prior: f64,
    /// Standard deviation of its prior; null without one.
    pub prior_deviation: Option<f64>,
    /// How much of the estimate is the prior's: 0 none, 1 all.
    pub prior_share: f64,
    /// By what the recordings' standard error grows because other parameters are unknown; null where they leave a direction
    /// open.
    pub inflation: Option<f64>,
    /// Whether recordings hardly tell it from others: then sums of terms are known, this number alone is not.
    pub entangled: bool,
    /// The estimate in SI units.
    pub si_value: f64,
    /// Its SI unit.
    pub si_unit: String,
    /// Its 95 % interval in SI units; null at a bound.
    #[serde(default)]
    pub si_interval: Option<[f64; 2]>,
    /// The estimate in the prime system; null where it has none.
    pub prime_value: Option<f64>,
    /// Its 95 % interval in the prime system.
    #[serde(default)]
    pub prime_interval: Option<[f64; 2]>,
    /// The value of captive tests, where it was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub captive: Option<CaptiveValue>,
    /// Its true value, where the logs were simulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub truth: Option<f64>,
}

impl FittedForces {
    /// `description` as text.
    ///
    /// # Errors
    /// One that cannot be written.
    pub fn text(description: &Description) -> Result<String, Invalid> {
        toml::to_string(description).map_err(|e| {
            Invalid::new("the ship", e.to_string(), "a ship that TOML can state", "report this as a defect")
        })
    }

    /// The ship as written.
    ///
    /// # Errors
    /// A text that is none.
    pub fn description(&self) -> Result<Description, Invalid> {
        let read = toml::Deserializer::parse(&self.description).and_then(strictly);
        read.map_err(|e: toml::de::Error| {
            let given = e.message().to_owned();
            Invalid::new("data.forces.description", given, "a ship with forces", "estimate the model again")
        })
    }

    /// The ship as a file, with the estimates as her nominal values.
    pub(super) fn file(&self) -> Result<VesselFile, Invalid> {
        Ok(VesselFile {
            nominal: self.parameters.iter().map(|p| (p.name.clone(), p.value)).collect(),
            ..VesselFile::of_forces(self.description()?)
        })
    }
}

/// The lag of an input \[s\] where it is not that of a thruster, which describes it itself.
pub(super) fn own_lag(vessel: &Vessel, input: usize) -> Option<f64> {
    let lag_s = Some(vessel.actuators[input].lag_s).filter(|lag| *lag > 0.0)?;
    let driven = vessel.model.has_own_lag(input, &vessel.nominal);
    (!driven).then_some(lag_s)
}
