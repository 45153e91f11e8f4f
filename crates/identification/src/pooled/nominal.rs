use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Options, fit};
use crate::{MeanRemoval, Sums};

/// Where the model comes from that instruments are simulated with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NominalSource {
    /// The nominal values of the vessel.
    Given,
    /// The least-squares fit of the same data.
    LeastSquares,
    /// A previous estimate.
    Estimate,
}

impl NominalSource {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Given, Self::LeastSquares, Self::Estimate];

    /// As in files.
    pub fn name(self) -> &'static str {
        ["given", "least-squares", "estimate"][self as usize]
    }
}

impl fmt::Display for NominalSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The model that instruments are simulated with: known now, or to be fitted to whatever data is used.
#[derive(Clone, Debug, PartialEq)]
pub enum NominalModel {
    /// θ: surge, sway, yaw.
    Known(Vec<f64>),
    /// The least-squares fit.
    Fitted,
}

impl NominalModel {
    /// θ and intercepts, with the least-squares `sums` of the data at hand. `None` where those identify no model.
    pub fn parameters(&self, sums: &[&Sums], removal: MeanRemoval) -> Option<(Vec<f64>, [f64; 3])> {
        match self {
            Self::Known(theta) => Some((theta.clone(), [0.0; 3])),
            Self::Fitted => {
                let options = Options { removal, prior: None, most: f64::INFINITY };
                let fits = fit(sums, &options).map(|degree| degree.solution);
                let theta: Option<Vec<Vec<f64>>> =
                    fits.iter().map(|s| s.as_ref().map(|s| s.theta.clone())).collect();
                Some((theta?.concat(), fits.map(|s| s.map_or(0.0, |s| s.intercept))))
            }
        }
    }
}
