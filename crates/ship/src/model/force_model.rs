use crate::forces::Forces;

/// Forces that move a ship from sample to sample.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceModel {
    /// The forces.
    pub forces: Forces,
    /// From one sample to the next \[s\].
    pub sample_s: f64,
}
