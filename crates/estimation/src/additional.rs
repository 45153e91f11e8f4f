//! Unknowns that searches estimate in addition to the parameters of the vessel.

/// Unknowns that estimates by simulation and prediction include in addition to the parameters of the vessel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdditionalUnknowns {
    /// Constant forces.
    pub intercepts: Intercepts,
    /// A current, for output error only.
    pub current: UnknownCurrent,
}

refusal::choices! {
    /// Constant forces that no term describes.
    pub enum Intercepts {
        /// One for each degree of freedom.
        Each = "each",
        /// None: where disturbances are known to average out, or a current is the unknown, estimates are closer.
        None = "none",
    }
}

refusal::choices! {
    /// An unknown current.
    pub enum UnknownCurrent {
        /// None: still water.
        None = "none",
        /// It stays, and keeps its direction over ground.
        Earth = "earth",
    }
}

impl Default for AdditionalUnknowns {
    fn default() -> Self {
        Self { intercepts: Intercepts::Each, current: UnknownCurrent::None }
    }
}
