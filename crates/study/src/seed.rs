use artifact::Provenance;

/// Name of the setting that holds the seed which runs were simulated with.
pub const SEED: &str = "seed";

/// The seed that runs were simulated with; none of measured ones.
pub fn seed(provenance: &Provenance) -> Option<u64> {
    provenance.settings.get(SEED)?.as_u64()
}

/// Notes in `provenance` the seed that its input `of` was simulated with.
pub fn note_seed(of: &Provenance, provenance: &mut Provenance) {
    if let Some(seed) = of.settings.get(SEED) {
        provenance.settings.insert(SEED.into(), seed.clone());
    }
}
