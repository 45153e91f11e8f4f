use artifact::Provenance;

refusal::choices! {
    /// What data are labelled as where they are not those of a real ship.
    pub enum DataLabel {
        /// Made of simulated logs.
        SimulatedLogs = "simulated logs",
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
