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

mod estimate;
mod lane_sums;
mod meat;
pub mod pooled;
mod prefiltered;
pub mod runs;
mod solve;
mod spans;
mod sums;

pub use estimate::{Estimate, Instruments, Outcome};
pub use lane_sums::{ManeuverMoments, moments};
pub use meat::{Noise, meat};
pub use prefiltered::{BLOCKS, estimate_prefiltered, jackknife};
pub use runs::InstrumentKind;
pub use solve::{Direction, Equations, Excitation, bounded};
pub use sums::{Batch, DegreeSums, Known, MeanRemoval, Sums};
