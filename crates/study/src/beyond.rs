//! Warnings about simulations that leave the range of the data that the model was fitted on.

use std::path::Path;

use files::Error;
use ship::engine::Run;
use validation::comparison::{Counter, Outside, Validity};

use crate::files::read_model;
use crate::trajectories::{Layout, TrajectoryReader};

/// Warnings about the runs in `out` that the model in the file `model` simulated, at its own rate or at `rate_hz`; empty for a
/// vessel.toml.
///
/// # Errors
/// Files that cannot be read.
pub fn beyond(model: &Path, out: &Path, rate_hz: Option<f64>) -> Result<Vec<String>, Error> {
    let Some(model) = read_model(model)? else { return Ok(Vec::new()) };
    let vessel = model.vessel().map_err(|e| crate::invalid(out, &e))?;
    let (layout, rate_hz) = (Layout::new(&vessel.model), rate_hz.unwrap_or(vessel.sample_rate_hz));
    let reader = TrajectoryReader::open(out, &layout, rate_hz)?;
    let (mut counter, mut validity) = (Counter::new(&model.covered), None);
    let mut magnitudes = model.magnitudes;
    // A disturbance with a stated value in simulations is not too small.
    for channel in magnitudes.iter_mut().flat_map(|known| &mut known.channels) {
        let place = vessel.model.variables.iter().position(|variable| variable.name == channel.name);
        if place.is_some_and(|place| vessel.model.simulated.contains_key(&place)) {
            channel.low = 0.0;
        }
    }
    for block in 0..reader.blocks() {
        let runs = reader.runs(block)?;
        runs.iter().for_each(|run| counter.add(&run.exogenous, &run.measured));
        let views = runs.iter().map(Run::view);
        let own = magnitudes.as_ref().and_then(|known| Validity::of(known, views, rate_hz));
        validity = Validity::together(validity, own);
    }
    let stretches = validity.as_ref().and_then(Validity::statement);
    Ok(stretches.into_iter().chain(counter.outside().iter().map(Outside::statement)).collect())
}
