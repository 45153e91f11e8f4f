use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The criteria by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CriterionName {
    /// log|det| of the information matrix (the paper's).
    DHessian,
    /// log det of the estimate's covariance.
    D,
    /// Sum of the variances.
    A,
    /// Sum of the variances relative to the parameters' squares.
    ARelative,
    /// Variance of free runs over the validation maneuvers.
    V,
    /// Sum of the variances of figures of merit relative to their squares.
    Figures,
}

impl CriterionName {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::DHessian, Self::D, Self::A, Self::ARelative, Self::V, Self::Figures];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        ["d-hessian", "d", "a", "a-relative", "v", "figures"][self as usize]
    }

    /// The name in reports.
    pub fn title(self) -> &'static str {
        let titles =
            ["D", "covariance D", "covariance A", "covariance relative A", "covariance V", "figures"];
        titles[self as usize]
    }

    /// Its meaning in one line.
    pub fn description(self) -> &'static str {
        match self {
            Self::DHessian => "log|det| of the information matrix (the paper's)",
            Self::D => "log det of the estimate's covariance",
            Self::A => "Sum of the variances",
            Self::ARelative => "Sum of the variances relative to the parameters' squares",
            Self::V => "Variance of free runs over the validation maneuvers (with --for output-error)",
            Self::Figures => {
                "Sum of the variances of figures of merit relative to their squares (with --figures)"
            }
        }
    }
}
