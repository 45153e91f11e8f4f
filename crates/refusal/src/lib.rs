//! The one form of a refusal: what is wrong, what was found, what was expected, and the remedy, in one line; and choices that
//! are expected by their names. Files are read [`strictly`]: what they say twice or without its name is refused.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod bounded;
mod choices;
mod invalid;
mod names;
mod nearest;
mod numbers;
mod strict;

pub use bounded::{foreign, one_line, shortened};
pub use invalid::Invalid;
pub use names::check_name;
pub use nearest::nearest;
pub use numbers::{check_numbers, check_ranges};
pub use strict::strictly;
