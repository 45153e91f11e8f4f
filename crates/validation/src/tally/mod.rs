//! What many scores say together, as counts and exact sums: merged in any order and any grouping they are the same, and they
//! take no more memory for more runs.

mod counted;
mod difference;
mod exact;
mod histogram;

pub use counted::{Bounds, Counted, Errors, PairCounts, Tally};
pub use difference::ShareDifference;
pub use exact::ExactSum;
pub use histogram::{Histogram, QUANTILE_ERROR};
