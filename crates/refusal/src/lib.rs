//! The one form of a refusal: what is wrong, what was found, what was expected, and the remedy, in one line;
//! and choices by name. Files are read [`strictly`]: duplicate keys and unnamed values are refused.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod bounded;
mod choices;
mod invalid;
mod listed;
mod names;
mod nearest;
mod numbers;
mod some_of;
mod strict;

pub use bounded::{fitted, foreign, one_line, shortened, with_remedy};
pub use invalid::Invalid;
pub use listed::{listed, names_in};
pub use names::check_name;
pub use nearest::{gone, nearest, suggestion};
pub use numbers::{check_numbers, check_ranges};
pub use some_of::some_of;
pub use strict::strictly;
