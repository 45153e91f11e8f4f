use std::fmt;

use refusal::listed;
use thiserror::Error;

use crate::Estimator;

/// A search failed from all starts.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub struct Unfound {
    /// The requested estimator.
    pub estimator: Estimator,
    /// The recordings whose free simulation with the search's start diverges; empty if a parameter has no effect of
    /// its own.
    pub recordings: Vec<String>,
}

impl fmt::Display for Unfound {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let name = self.estimator.name();
        match self.recordings.as_slice() {
            [] => write!(f, "{name}: a parameter has no effect of its own on simulations"),
            all => write!(
                f,
                "{name}: free simulations diverge from every start that was tried, short windows among them: of {}",
                listed(all)
            ),
        }
    }
}
