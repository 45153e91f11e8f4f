refusal::choices! {
    /// What instruments are made of.
    pub enum InstrumentKind {
        /// The nominal model simulated over the run's inputs from the run's initial state.
        Nominal = "nominal",
        /// The measured regressors themselves: least squares.
        Regressors = "regressors",
    }
}
