use crate::model::{Constrained, Degree};

/// What a kind of model gives a vessel.
#[derive(Default)]
pub(crate) struct Parts {
    pub degrees: [Degree; 3],
    pub value: Vec<Option<f64>>,
    pub nominal: Vec<f64>,
    pub constrained: Vec<Constrained>,
}
