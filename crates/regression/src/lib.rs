//! Least squares and instrumental variables: per run, several at once, and pooled.
//!
//! Per degree of freedom the increment of the measured state is regressed on the model's terms, Δy(k) = y(k+1) − y(k)
//! = φ(k)ᵀθ + c, with instruments ζ(k): the same terms of another signal, usually the nominal model simulated with
//! the same inputs. φ̃ = \[φ; 1\] and ζ̃ = \[ζ; 1\] are augmented: an intercept c is equivalent to subtracting the
//! instruments' mean. One pass over the data gives [`Sums`], which add over sub-experiments.
//!
//! Runs are computed [`numerics::LANES`] at a time. Symbols: see `docs/notation.md`.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod batch;
mod bounded;
mod estimate;
mod groups;
mod instrument_kind;
mod jackknife;
mod lane_sums;
mod mean_removal;
mod middle;
mod moments;
mod moving_average;
pub mod pooled;
mod prefiltered;
mod residual;
pub mod runs;
mod solve;
mod spans;
mod sums;

pub use batch::Batch;
pub use bounded::{Equations, bounded};
pub use estimate::{Estimate, Instruments, Outcome};
pub use instrument_kind::InstrumentKind;
pub use jackknife::{BLOCKS, jackknife};
pub use mean_removal::MeanRemoval;
pub use middle::{Noise, middle};
pub use moments::{ManeuverMoments, moments};
pub use prefiltered::estimate_prefiltered;
pub use solve::{Direction, Excitation};
pub use sums::{DegreeSums, Known, Sums};
