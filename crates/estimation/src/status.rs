refusal::choices! {
    /// What became of the estimate of a run, or of a degree of freedom.
    pub enum EstimateStatus {
        /// There is an estimate, and the run does not reject the model where it was asked.
        Identified = "identified",
        /// There is an estimate, but the run rejects the model: something is missing beyond chance.
        Rejected = "identified, model rejected",
        /// There is an estimate, but a free simulation of what it was estimated from diverges.
        Diverges = "estimated, simulation diverges",
        /// There is an estimate, whose errors follow no noise that is known here: its standard errors are approximate.
        Approximate = "identified, errors approximate",
        /// There is an estimate without standard errors: waves move the ship.
        Waves = "identified, waves: no errors",
        /// There is an estimate by instruments of the run's own model of least output error: the nominal one diverges.
        OwnInstruments = "identified, instruments by output error",
        /// A direction of the parameters is not excited.
        NotIdentifiable = "not identifiable",
        /// The search for an estimate did not converge.
        NotConverged = "not converged",
    }
}

impl EstimateStatus {
    /// Whether there is an estimate.
    pub fn estimated(self) -> bool {
        !matches!(self, Self::NotIdentifiable | Self::NotConverged)
    }
}

refusal::choices! {
    /// What became of a model that was to be simulated over validation data.
    pub enum ScoreStatus {
        /// It was simulated.
        Scored = "scored",
        /// Its simulation diverged.
        Diverged = "diverged",
        /// There is no model: a direction of the parameters is not excited.
        NotIdentifiable = "not identifiable",
        /// There is no model: the search for one did not converge.
        NotConverged = "not converged",
    }
}

impl ScoreStatus {
    /// Whether there is an estimate.
    pub fn estimated(self) -> bool {
        matches!(self, Self::Scored | Self::Diverged)
    }
}
