//! The maneuvers of a plan that react to the ship.

use std::collections::BTreeMap;
use std::path::Path;

use files::{Error, Provenance};
use plan::voyage::Brief;
use ship::engine::Helm;

use crate::files::read_dictionary;

/// The commands of the maneuvers that `brief` names and that depend on the ship's motion, by name, as `dictionary.toml` at `path`
/// states them; none without that file.
///
/// # Errors
/// A dictionary that is refused, or another one than the runs are of.
pub fn programs(
    path: Option<&Path>,
    brief: &Brief,
    provenance: &mut Provenance,
) -> Result<BTreeMap<String, Helm>, Error> {
    let Some(path) = path else { return Ok(BTreeMap::new()) };
    let generator = read_dictionary(path, &brief.vessel, provenance)?;
    // A task that names none is refused where its pieces are cut.
    let named = brief.named().unwrap_or_default();
    let runs = named.iter().filter_map(|own| brief.run(&own.name));
    let mut programs = BTreeMap::new();
    for run in runs {
        let name = &run.segments[0].maneuver;
        let index = generator.maneuvers().iter().position(|own| own.name == *name);
        let program = index.map_or(Ok(None), |index| generator.program(index, run.samples()));
        if let Some(helm) = program.map_err(|e| crate::invalid(path, &e))? {
            programs.insert(name.clone(), helm);
        }
    }
    Ok(programs)
}
