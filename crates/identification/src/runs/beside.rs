//! What searches take as unknown beside the parameters of the vessel.

/// What estimates by simulation and prediction take as unknown beside the parameters of the vessel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beside {
    /// A force that stays.
    pub intercepts: Intercepts,
    /// A current that stays, of output error alone.
    pub current: UnknownCurrent,
}

vessel::choices! {
    /// Forces that stay, which no term tells of.
    pub enum Intercepts {
        /// One for each degree of freedom.
        Each = "each",
        /// None: where disturbances are known to average out, or a current is the unknown, estimates are closer.
        None = "none",
    }
}

vessel::choices! {
    /// A current that stays over a run and is not known.
    pub enum UnknownCurrent {
        /// None: still water.
        None = "none",
        /// It keeps its direction over ground.
        Earth = "earth",
        /// It keeps its direction from the bow.
        Body = "body",
    }
}

impl Default for Beside {
    fn default() -> Self {
        Self { intercepts: Intercepts::Each, current: UnknownCurrent::None }
    }
}
