//! The one form of a refusal: what is wrong, what was found, what was expected, and the remedy, in one line;
//! and choices by name. Files are read [`strictly`]: duplicate keys and unnamed values are refused.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod bounds;
mod contents;
mod invalid;
mod words;

pub use bounds::{bounds, check_bounds, strictly};
pub use contents::{Contents, PathStep, Unreadable};
pub use invalid::{Invalid, check_name, check_numbers, check_ranges};
pub use words::{
    fitted, foreign, gone, listed, names_in, nearest, one_line, shortened, some_of, suggestion, with_remedy,
};
