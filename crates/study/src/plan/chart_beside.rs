//! Metadata that GDAL writes next to a grid if the grid's own format does not support it.

use std::ffi::OsString;
use std::io::Read;
use std::path::{Path, PathBuf};

use chart::{DepthUnit, GridDeclaration, GridKind};
use files::Error;

/// Maximum bytes of such a file that are read.
const MOST: u64 = 1 << 20;

/// Refuses a grid with an `.aux.xml` that has a scale, or a unit that is not declared.
pub(super) fn check_beside(path: &Path, declared: &GridDeclaration) -> Result<(), Error> {
    let beside = PathBuf::from([path.as_os_str(), ".aux.xml".as_ref()].into_iter().collect::<OsString>());
    if !files::exists(&beside) {
        return Ok(());
    }
    let mut bytes = Vec::new();
    let read = files::open(&beside)?.take(MOST).read_to_end(&mut bytes);
    read.map_err(|e| Error::io(&beside, "read", e))?;
    let text = String::from_utf8_lossy(&bytes);
    for (tag, usual) in [("Scale", 1.0), ("Offset", 0.0)] {
        if let Some(own) = text_of(&text, tag).filter(|own| own.parse() != Ok(usual)) {
            let found = format!("{} beside the grid", refusal::foreign(own));
            let remedy = "write both into one file, for instance with `gdal_translate -of GTiff`";
            return Err(Error::refuse(&beside, tag, found, format!("{usual}, or none"), remedy));
        }
    }
    let Some(own) = text_of(&text, "UnitType").filter(|text_of| !text_of.is_empty()) else { return Ok(()) };
    let (unit, usual) = (DepthUnit::of_text(own), declared.unit.unwrap_or(DepthUnit::Metre));
    if declared.kind == GridKind::LandMask || unit == Some(usual) {
        return Ok(());
    }
    let found = format!("`{}` beside the grid", refusal::foreign(own));
    let expected = format!("`{}`, or the same as `depth_unit`", usual.name());
    Err(Error::refuse(&beside, "UnitType", found, expected, "say `depth_unit` in its [[chart]]"))
}

/// The text between two tags.
fn text_of<'t>(text: &'t str, tag: &str) -> Option<&'t str> {
    let (_, rest) = text.split_once(&format!("<{tag}>"))?;
    rest.split_once(&format!("</{tag}>")).map(|(own, _)| own.trim())
}
