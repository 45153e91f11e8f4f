refusal::choices! {
    /// How instruments are formed.
    pub enum InstrumentKind {
        /// The nominal model simulated over the run's inputs from the run's initial state.
        Nominal = "nominal",
        /// The measured regressors themselves: least squares.
        Regressors = "regressors",
    }
}
