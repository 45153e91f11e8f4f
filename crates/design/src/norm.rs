/// What of a covariance matrix is made small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Norm {
    /// log det: D-optimality.
    #[default]
    LogDet,
    /// log of the trace: A-optimality.
    Trace,
}
