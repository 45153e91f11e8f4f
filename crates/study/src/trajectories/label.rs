use files::Provenance;

refusal::choices! {
    /// What data are labelled as where they are not those of a real ship.
    pub enum DataLabel {
        /// Made of simulated logs.
        SimulatedLogs = "simulated logs",
    }
}

impl DataLabel {
    /// Adds the label to `provenance`.
    pub fn label(self, provenance: &mut Provenance) {
        provenance.settings.insert("data".into(), self.to_string().into());
    }
}

/// Adds the label of simulated logs to `provenance` if one of these designs has it. Runs of simulated logs have the
/// label as the name of their design.
pub fn label<'a>(designs: impl IntoIterator<Item = &'a str>, provenance: &mut Provenance) {
    let simulated = DataLabel::SimulatedLogs.to_string();
    if designs.into_iter().any(|design| design == simulated) {
        DataLabel::SimulatedLogs.label(provenance);
    }
}
