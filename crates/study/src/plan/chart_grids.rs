//! Charts that are grids, which are only read near the area.

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use chart::{Grid, GridDeclaration, Reading, Unread};
use files::{Digesting, Error, Provenance};

use super::chart_beside::check_beside;
use super::chart_file::{bytes, note};
use super::chart_text::chart_text;

/// The format of a grid.
#[derive(Clone, Copy)]
pub(super) enum GridFormat {
    Ascii,
    Tiff,
}

impl GridFormat {
    /// By the file's extension; `None` if it is not a grid.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "asc" => Some(Self::Ascii),
            "tif" | "tiff" => Some(Self::Tiff),
            _ => None,
        }
    }

    /// Reads a grid, and notes the digest of its file.
    pub fn read(
        self,
        path: &Path,
        declared: &GridDeclaration,
        reading: &Reading,
        provenance: &mut Provenance,
    ) -> Result<Result<Grid, Unread>, Error> {
        check_beside(path, declared)?;
        Ok(match self {
            Self::Ascii => {
                let length = std::fs::metadata(path).map_or(0, |about| about.len()) as f64;
                if length > reading.bytes {
                    let found = format!("{length} bytes of text");
                    return Ok(Err(Unread::TooLarge { found, bytes: length }));
                }
                let text = chart_text(bytes(path, provenance)?).map_err(|e| Error::invalid(path, e))?;
                Grid::from_ascii(&text, declared, &Reading { bytes: reading.bytes - length, ..*reading })
            }
            Self::Tiff => Grid::from_tiff(BufReader::new(open(path, provenance)?), declared, reading),
        })
    }
}

/// Refuses a file of NetCDF, classic or in HDF5, whatever its name.
pub(super) fn refuse_netcdf(path: &Path) -> Result<(), Error> {
    const SIGNATURES: [&[u8]; 4] = [b"CDF\x01", b"CDF\x02", b"CDF\x05", b"\x89HDF\r\n\x1A\n"];
    let mut first = Vec::new();
    files::open(path)?.take(8).read_to_end(&mut first).map_err(|e| Error::io(path, "read", e))?;
    if !SIGNATURES.iter().any(|signature| first.starts_with(signature)) {
        return Ok(());
    }
    let expected = "GeoTIFF (.tif), ESRI ASCII (.asc), GeoJSON, or a cell of an electronic chart (.000)";
    let named = path.with_extension("tif");
    let tiff = if named == path { path.with_extension("geo.tif") } else { named };
    let remedy = format!("convert it: `gdal_translate {} {}`", path.display(), tiff.display());
    Err(Error::refuse(path, "chart", "NetCDF", expected, remedy))
}

/// Opens the file of a chart, and notes its digest.
fn open(path: &Path, provenance: &mut Provenance) -> Result<File, Error> {
    let failed = |e| Error::io(path, "read", e);
    let mut file = files::open(path)?;
    let digest = Digesting::new(&file).digest().map_err(failed)?;
    file.rewind().map_err(failed)?;
    note(path, digest, provenance);
    Ok(file)
}
