use thiserror::Error;

use crate::Error;
use crate::scarce::Scarce;
use crate::wanted::OutOfReach;

/// Why there is no design.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum NoDesign {
    /// A direction of the parameters that no maneuver excites.
    #[error("no maneuver excites `{parameter}` ({degree}) apart from the other parameters")]
    Unexcited {
        /// Degree of freedom.
        degree: String,
        /// The dominant parameter of the direction.
        parameter: String,
        /// The regressor of that parameter.
        regressor: String,
    },
    /// A singular covariance: the disturbances do not affect a parameter.
    #[error("the covariance gives `{parameter}` ({degree}) no variance of its own")]
    Singular {
        /// Degree of freedom.
        degree: String,
        /// The parameter.
        parameter: String,
    },
    /// Not enough of the maneuvers is available.
    #[error(transparent)]
    Scarce(#[from] Scarce),
    /// A standard error that the longest experiment cannot reach.
    #[error("{0}")]
    OutOfReach(OutOfReach),
    /// The problem or its search, without a parameter to name.
    #[error(transparent)]
    Search(Error),
}
