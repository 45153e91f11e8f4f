//! The one form of a refusal: what is wrong, what was found, what was expected, and the remedy, in one line;
//! and choices by name. Files are read [`strictly`]: duplicate keys and unnamed values are refused.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod bounded;
mod choices;
mod invalid;
mod nearest;
mod strict;

pub use bounded::{fitted, foreign, one_line, shortened, with_remedy};
pub use invalid::{Invalid, check_name, check_numbers, check_ranges};
pub use nearest::{gone, listed, names_in, nearest, some_of, suggestion};
pub use strict::strictly;
