//! Optimal shares of an experiment over candidate information matrices.
//!
//! Candidate q has one information matrix M_q,b per block b (a block is a degree of freedom of the model; this crate
//! knows only matrices). The D-criterion of shares w on the simplex is Σ_b log|det Σ_q w_q M_q,b|.
//!
//! ```
//! use design::{Candidates, Options, Status, solve};
//! // Two straight lines through measured points at −1 and 1: each takes half of the time.
//! let mut candidates = Candidates::new(vec![2]);
//! candidates.push(&[1.0, -1.0, -1.0, 1.0])?;
//! candidates.push(&[1.0, 1.0, 1.0, 1.0])?;
//! let design = solve(&candidates, &Options::default())?;
//! assert!((design.shares[0] - 0.5).abs() < 1e-9);
//! assert_eq!(design.status, Status::Optimal);
//! # Ok::<(), design::Error>(())
//! ```
//!
//! Sources: Kiefer & Wolfowitz 1960 (certificate), Fedorov 1972, Yu 2011 (multiplicative algorithm), Pukelsheim &
//! Rieder 1992 (rounding).

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod active_set;
mod candidates;
mod certificate;
mod counts;
mod covariance;
mod criterion;
mod design;
mod dictionary;
mod segments;
mod select;
mod shortest;
mod spectrum;
mod streamed;

pub use active_set::ActiveSetNewton;
pub use candidates::{Candidates, Error, Evaluation, Objective};
pub use certificate::{Bounds, is_concave};
pub use counts::{CountOptions, Counted, Method, apportion, count_segments};
pub use covariance::{Covariance, CovariancePoint};
pub use criterion::{CovarianceCriterion, Criterion, CriterionName, FigureErrors, Predicted, WeightedFigure};
pub use design::{
    Design, Options, Start, Status, solve, solve_covariance, solve_covariance_among, solve_covariance_from,
    solve_within,
};
pub use dictionary::{AccuracyOf, Degree, Dictionary, NoDesign, OutOfReach, Scarce, Wanted};
pub use segments::{Available, Length, Segments, Stock, Whole, counted};
pub use select::{Restricted, Selected, select};
pub use shortest::{
    Accuracy, AccuracyPoint, Errors, MOST, Question, Rivals, Shortest, error_of, holds_from, promised_error,
};
pub use spectrum::Norm;
pub use streamed::{Blocks, Streamed, solve_streamed};
