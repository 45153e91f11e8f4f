use design::Status;

refusal::choices! {
    /// What is known of a design.
    pub enum DesignStatus {
        /// Proved global.
        Optimal = "optimal",
        /// First-order optimal, not proved global.
        Stationary = "stationary",
        /// The gap was not reached.
        Stalled = "stalled",
        /// Few or long maneuvers, see `restricted`.
        Restricted = "restricted",
        /// The least largest of the relative errors, see `accuracy`.
        LeastLargest = "least largest",
        /// One maneuver of refined inputs.
        Refined = "refined",
    }
}

impl From<Status> for DesignStatus {
    fn from(status: Status) -> Self {
        match status {
            Status::Optimal => Self::Optimal,
            Status::Stationary => Self::Stationary,
            Status::Stalled => Self::Stalled,
        }
    }
}
