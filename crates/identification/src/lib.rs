//! Estimation of a vessel's parameters from measured runs, and validation of the estimates.
//!
//! Per degree of freedom the increment of the measured state is regressed on the model's terms,
//! Δy(k) = y(k+1) − y(k) = φ(k)ᵀθ + c, with instruments ζ(k): the same terms of another signal, usually the nominal
//! model simulated over the same inputs. φ̃ = \[φ; 1\] and ζ̃ = \[ζ; 1\] are the lifted ones: an intercept c does what
//! subtracting the instruments' mean does. One pass over the data gives [`Sums`] that add over sub-experiments.
//!
//! Runs are computed [`numerics::LANES`] at a time. Symbols: see `docs/notation.md`.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod batch;
mod beside;
mod bounded;
pub mod criticism;
mod estimate;
mod estimator;
mod groups;
mod instrument_kind;
mod lags;
mod lane_sums;
mod mean_removal;
mod middle;
mod moments;
pub mod pooled;
pub mod predictor;
mod prefiltered;
mod quantiles;
mod recommendation;
pub mod refine;
mod registers;
mod repeated;
mod residual;
mod run_estimate;
pub mod runs;
mod sensitivity;
mod solve;
mod spans;
mod status;
mod sums;
pub mod terms;
mod validate;
mod validation_runs;

pub use batch::Batch;
pub use bounded::{Equations, bounded};
pub use estimate::{Estimate, Instruments, Outcome};
pub use estimator::Estimator;
pub use instrument_kind::InstrumentKind;
pub use mean_removal::MeanRemoval;
pub use middle::{Noise, middle};
pub use moments::{ManeuverMoments, moments};
pub use prefiltered::estimate_prefiltered;
pub use quantiles::{Quantiles, Share};
pub use recommendation::{Contender, MOST_WITHOUT_ESTIMATE, Other, PairedDifference, Recommendation};
pub use repeated::{RepeatedEstimates, TRUSTED, relative_norms};
pub use run_estimate::RunEstimate;
pub use sensitivity::{
    OutputInformation, Simulated, output_information, output_informations, prediction_weights,
};
pub use solve::{Direction, Excitation};
pub use status::{EstimateStatus, ScoreStatus};
pub use sums::{DegreeSums, Known, Sums};
pub use validate::{FreeRun, free_runs, parameter_error, rmse_norm};
pub use validation_runs::{Candidate, RunScore, ValidationRuns};
