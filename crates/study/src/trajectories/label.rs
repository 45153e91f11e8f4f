use artifact::Provenance;

/// Design of runs from simulated logs, and what all that is made of them is labelled as.
pub const SIMULATED_LOGS: &str = "simulated logs";

/// Labels what is made of runs of these designs as made of simulated logs, if one of them is.
pub fn label<'a>(designs: impl IntoIterator<Item = &'a str>, provenance: &mut Provenance) {
    if designs.into_iter().any(|design| design == SIMULATED_LOGS) {
        provenance.settings.insert("data".into(), SIMULATED_LOGS.into());
    }
}
