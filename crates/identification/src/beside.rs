//! What searches take as unknown beside the parameters of the vessel.

/// What estimates by simulation and prediction take as unknown beside the parameters of the vessel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beside {
    /// A force that stays.
    pub intercepts: Intercepts,
    /// A current, of output error alone.
    pub current: UnknownCurrent,
    /// A wind, of output error alone.
    pub wind: UnknownWind,
}

refusal::choices! {
    /// Forces that stay, which no term tells of.
    pub enum Intercepts {
        /// One for each degree of freedom.
        Each = "each",
        /// None: where disturbances are known to average out, or a current is the unknown, estimates are closer.
        None = "none",
    }
}

refusal::choices! {
    /// A current that is not known.
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
    /// A wind whose direction is not known.
    pub enum UnknownWind {
        /// None, or one that terms of measured channels tell of.
        None = "none",
        /// It pushes steadily in one direction over ground, along and across the vessel as she turns.
        Earth = "earth",
    }
}

impl Default for Beside {
    fn default() -> Self {
        Self { intercepts: Intercepts::Each, current: UnknownCurrent::None, wind: UnknownWind::None }
    }
}
