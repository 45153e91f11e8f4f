//! Unknowns that searches estimate in addition to the parameters of the vessel.

/// Unknowns that estimates by simulation and prediction include in addition to the parameters of the vessel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdditionalUnknowns {
    /// Constant forces.
    pub intercepts: Intercepts,
    /// A current, for output error only.
    pub current: UnknownCurrent,
    /// A wind, for output error only.
    pub wind: UnknownWind,
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
        /// It stays, and keeps its direction from the bow.
        Body = "body",
        /// It changes evenly with time, over ground.
        Drifting = "drifting",
    }
}

refusal::choices! {
    /// A wind of unknown direction.
    pub enum UnknownWind {
        /// None, or one that terms of measured channels tell of.
        None = "none",
        /// It pushes steadily in one direction over ground, along and across the vessel as she turns.
        Earth = "earth",
    }
}

impl Default for AdditionalUnknowns {
    fn default() -> Self {
        Self { intercepts: Intercepts::Each, current: UnknownCurrent::None, wind: UnknownWind::None }
    }
}
