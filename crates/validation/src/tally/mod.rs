//! Statistics of many scores, as counts and exact sums: they do not depend on the order or grouping of merges, and
//! their memory does not grow with the number of runs.

mod counted;
mod exact;
mod histogram;

pub use counted::{Bounds, Counted, Errors, PairCounts, Tally};
pub use exact::ExactSum;
pub use histogram::{Histogram, QUANTILE_ERROR};
