/// The norm of a covariance matrix that is minimised.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Norm {
    /// log det: D-optimality.
    #[default]
    LogDet,
    /// log of the trace: A-optimality.
    Trace,
}
