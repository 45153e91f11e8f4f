use files::Provenance;

/// Name of the setting with the seed of simulated runs.
pub const SEED: &str = "seed";

/// The seed of simulated runs; `None` for measured ones.
pub fn seed(provenance: &Provenance) -> Option<u64> {
    provenance.settings.get(SEED)?.as_u64()
}

/// Notes in `provenance` the seed of its simulated input `of`.
pub fn note_seed(of: &Provenance, provenance: &mut Provenance) {
    if let Some(seed) = of.settings.get(SEED) {
        provenance.settings.insert(SEED.into(), seed.clone());
    }
}
