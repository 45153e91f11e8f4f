//! The number of sub-experiments of each maneuver that `validate selection` picks.

use std::collections::BTreeMap;
use std::path::Path;

use files::Provenance;
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
    study::selection::counts_of(&design, available).map_err(|e| Failure::invalid(path, &e))
}
