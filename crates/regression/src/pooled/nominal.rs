use super::{Options, PooledSums, joined};

refusal::choices! {
    /// Where the model comes from that instruments are simulated with.
    pub enum NominalSource {
        /// The nominal values of the vessel.
        Given = "given",
        /// The least-squares fit of the same data.
        LeastSquares = "least-squares",
        /// A previous estimate.
        Estimate = "estimate",
    }
}

/// The model that instruments are simulated with: known, or to be fitted to the data that is used.
#[derive(Clone, Debug, PartialEq)]
pub enum NominalModel {
    /// θ: surge, sway, yaw; the model has its own intercepts.
    Known(Vec<f64>),
    /// The least-squares fit.
    Fitted,
}

impl NominalModel {
    /// θ and intercepts, with the least-squares `sums` of the data that is used. `None` if those identify no model.
    pub fn parameters(&self, sums: &PooledSums) -> Option<(Vec<f64>, [f64; 3])> {
        match self {
            Self::Known(theta) => Some((theta.clone(), [0.0; 3])),
            Self::Fitted => {
                let options = Options { removal: sums.removal(), prior: None, most: f64::INFINITY };
                joined(sums.fit(&options).each_ref().map(|degree| degree.solution.as_ref()))
            }
        }
    }
}
