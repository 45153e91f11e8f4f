vessel::choices! {
    /// How the instruments' mean is removed: how many intercepts a degree of freedom has, none, one per segment or one.
    pub enum MeanRemoval {
        /// Not at all.
        None = "none",
        /// Segment by segment.
        Batch = "batch",
        /// Over the whole experiment.
        Complete = "complete",
    }
}
