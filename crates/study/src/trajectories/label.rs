use std::fmt;

use artifact::Provenance;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What data are labelled as where they are not those of a real ship.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum DataLabel {
    /// Made of simulated logs.
    #[serde(rename = "simulated logs")]
    SimulatedLogs,
}

impl fmt::Display for DataLabel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

impl DataLabel {
    /// Labels what is written with `provenance`.
    pub fn label(self, provenance: &mut Provenance) {
        provenance.settings.insert("data".into(), self.to_string().into());
    }
}

/// Labels what is made of runs of these designs as made of simulated logs, if one of them is. Runs of simulated logs have
/// the label for the name of their design.
pub fn label<'a>(designs: impl IntoIterator<Item = &'a str>, provenance: &mut Provenance) {
    let simulated = DataLabel::SimulatedLogs.to_string();
    if designs.into_iter().any(|design| design == simulated) {
        DataLabel::SimulatedLogs.label(provenance);
    }
}
