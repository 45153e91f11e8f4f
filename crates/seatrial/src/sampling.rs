use std::path::Path;

use rayon::prelude::*;
use ship::engine::Run;
use ship::model::{Source, Vessel};
use study::files::read_model;
use study::trajectories::{Reacting, TrajectoryReader};
use trial::moments::{PlayedMotion, SampledShips, ShipSampler};

/// What ships with other parameters than `vessel` do with the inputs of a dictionary's simulated maneuvers. `None` where the
/// true parameters are known, the maneuvers were not simulated, or the vessel is a model in `file` without covariance.
///
/// # Errors
/// Files that cannot be read.
pub fn sampled_ships(
    file: &Path,
    vessel: &Vessel,
    reader: &TrajectoryReader,
) -> Result<Option<SampledShips>, files::Error> {
    let model = read_model(file)?;
    let is_known = vessel.best_known() == Source::Value || !reader.true_states();
    let covariance = model.as_ref().and_then(|model| model.covariance.as_ref());
    if is_known || covariance.is_some() != model.is_some() {
        return Ok(None);
    }
    let Some(sampler) = ShipSampler::new(vessel, covariance) else { return Ok(None) };
    let (reacting, mut all) = (Reacting::noted(reader.provenance()), Vec::new());
    let name = |run: &Run| run.segments.first().map_or(String::new(), |own| own.maneuver.clone());
    for block in 0..reader.blocks() {
        let mut runs = reader.runs(block)?;
        runs.retain(|run| !reacting.has(&name(run), run.run));
        let found: Vec<PlayedMotion> = runs.par_iter().map(|run| sampler.play(run)).collect();
        all.extend(found);
    }
    Ok(Some(sampler.found(all)))
}
