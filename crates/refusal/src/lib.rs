//! The one form of a refusal: what is wrong, what was found, what was expected, and the remedy, in one line; and choices that
//! are expected by their names.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod choices;
mod invalid;
mod nearest;
mod numbers;

pub use invalid::{Invalid, one_line};
pub use nearest::nearest;
pub use numbers::check_numbers;
