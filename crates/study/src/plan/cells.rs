//! Files of charts, and cells of electronic ones with the updates that stand beside them.

use std::path::{Path, PathBuf};

use artifact::{Digest, Error, Provenance};
use chart::{PolygonLayer, Rules, Tally};
use enc::{Cell, Feature};

use crate::documents::{PlanChart, PlanChartClass};

/// The bytes of a chart's file, whose digest is noted.
pub(super) fn bytes(path: &Path, provenance: &mut Provenance) -> Result<Vec<u8>, Error> {
    let bytes = std::fs::read(path).map_err(|e| Error::io(path, "read", e))?;
    let name = path.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
    provenance.inputs.insert(format!("chart:{name}"), Digest::of_bytes(&bytes));
    Ok(bytes)
}

/// Whether a file is the base of a cell, by its name.
pub(super) fn is_cell(path: &Path) -> bool {
    path.extension().is_some_and(|suffix| suffix == "000")
}

/// A cell, its updates applied, by the rules of its classes; and what became of its objects.
///
/// # Errors
/// Files that cannot be read, or are refused; each names itself.
pub(super) fn cell(
    path: &Path,
    rules: &Rules,
    provenance: &mut Provenance,
) -> Result<(PolygonLayer, PlanChart), Error> {
    let mut cell = Cell::read(&bytes(path, provenance)?).map_err(|e| Error::invalid(path, e))?;
    for update in updates(path)? {
        cell.update(&bytes(&update, provenance)?).map_err(|e| Error::invalid(&update, e))?;
    }
    let objects = cell.features().map_err(|e| Error::invalid(path, e))?;
    let (scale, identity) = (cell.scale(), cell.identity().clone());
    // Large, and not needed any more.
    drop(cell);
    let (layer, told) = of_objects(path, &objects, Some(scale), rules)?;
    let told = PlanChart {
        edition: Some(identity.edition),
        update: Some(identity.update.into()),
        issued: Some(identity.issued),
        scale: Some(scale.into()),
        ..told
    };
    Ok((layer, told))
}

/// Objects as a layer, and what became of them.
pub(super) fn of_objects(
    path: &Path,
    objects: &[Feature],
    scale: Option<u32>,
    rules: &Rules,
) -> Result<(PolygonLayer, PlanChart), Error> {
    let (layer, tallies) =
        PolygonLayer::from_objects(objects, scale, rules).map_err(|e| Error::invalid(path, e))?;
    let of = |tally: Tally| PlanChartClass {
        objects: tally.objects,
        avoided: tally.avoided,
        maneuvers_avoid: tally.maneuvers_avoid,
        ignored: tally.ignored,
    };
    let told = PlanChart {
        file: path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned()),
        edition: None,
        update: None,
        issued: None,
        scale: None,
        classes: tallies.into_iter().map(|(class, tally)| (class, of(tally))).collect(),
        depths: None,
    };
    Ok((layer, told))
}

/// Files of the same name whose suffix is a number above 0, in its order.
fn updates(path: &Path) -> Result<Vec<PathBuf>, Error> {
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(|e| Error::io(folder, "read", e))? {
        let own = entry.map_err(|e| Error::io(folder, "read", e))?.file_name();
        let name = Path::new(&own);
        let suffix = name.extension().and_then(|suffix| suffix.to_str()).unwrap_or_default();
        let number = suffix.len() == 3 && suffix.bytes().all(|b| b.is_ascii_digit()) && suffix != "000";
        if number && name.file_stem() == path.file_stem() {
            all.push(path.with_file_name(name));
        }
    }
    all.sort();
    Ok(all)
}
