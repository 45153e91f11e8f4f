//! The number of sub-experiments of each maneuver that `validate selection` picks.

use std::collections::BTreeMap;
use std::path::Path;

use artifact::Provenance;
use study::documents::DesignDocument;

use crate::failure::Failure;
use crate::inputs;

/// The number of sub-experiments of each maneuver to pick: from `--counts label=n`, or from `design.json`, and no
/// more than available.
///
/// # Errors
/// Usage: an invalid count, or one for an unknown maneuver. Refused: a design without counts; more than available.
pub fn counts(
    design: Option<&Path>,
    written: &[String],
    available: &BTreeMap<String, u64>,
    provenance: &mut Provenance,
) -> Result<BTreeMap<String, u64>, Failure> {
    let Some(path) = design else {
        return study::selection::counts(written, available).map_err(Failure::Usage);
    };
    let design: DesignDocument = inputs::document(path, "design", provenance)?;
    let Some(counts) = design.counts else {
        let remedy = "make it with `design --segments`, or name --counts";
        return Err(Failure::refuse(path, "counts", "none", "those of whole segments", remedy));
    };
    for (name, count) in counts.iter().filter(|(_, count)| **count > 0) {
        let there = available.get(name).copied().unwrap_or(0);
        if *count > there {
            let found = format!("{count} of `{name}`");
            let remedy = "bound the design by what there is, or name --counts";
            return Err(Failure::refuse(path, "counts", &found, &format!("at most {there}"), remedy));
        }
    }
    Ok(counts.into_iter().filter(|(_, count)| *count > 0).collect())
}
