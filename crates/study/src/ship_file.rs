//! A ship with forces as she is written: in a `vessel.toml`, as a preset, or in the `model.json` of a fit.

use std::path::Path;

use files::{Error, Provenance, read_document};
use ship::model::VesselFile;

use crate::documents::{FittedParameter, ModelDocument};

/// A ship as written.
#[derive(Clone, Debug)]
pub struct ShipFile {
    /// The file; estimates of a fit stand as nominal values.
    pub file: VesselFile,
    /// The free numbers of a fit.
    pub fitted: Option<Vec<FittedParameter>>,
}

/// The ship at `path`, a file in TOML or JSON, or else the preset of this name. Notes the digest of a file.
///
/// # Errors
/// A file that is refused; a model without forces.
pub fn read_ship(path: &Path, provenance: &mut Provenance) -> Result<ShipFile, Error> {
    match path.extension().and_then(|own| own.to_str()) {
        Some("json") => {
            let model = read_document::<ModelDocument>(path)?;
            provenance.written("vessel", path, model.digest)?;
            let file = model.data.forces_file().map_err(|e| crate::invalid(path, &e))?;
            Ok(ShipFile { file, fitted: model.data.forces.map(|own| own.parameters) })
        }
        Some("toml") => Ok(ShipFile { file: provenance.read_toml("vessel", "vessel", path)?, fitted: None }),
        _ => {
            let preset = Some(path.to_string_lossy().into_owned());
            Ok(ShipFile { file: VesselFile { preset, ..VesselFile::default() }, fitted: None })
        }
    }
}
