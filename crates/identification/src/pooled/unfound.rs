use std::fmt;

use refusal::listed;
use thiserror::Error;

use crate::Estimator;

/// That a search led nowhere, from whatever it began with.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub struct Unfound {
    /// What was asked for.
    pub estimator: Estimator,
    /// Of which the free simulation diverges with the estimate that the search began with; none where a parameter has no effect
    /// of its own.
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
