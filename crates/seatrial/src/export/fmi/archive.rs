//! The unit as one file: a ZIP archive with the same bytes for the same contents.

use std::io::{Cursor, Write};

use refusal::Invalid;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::sources::{LIBRARY, PLATFORM};
use crate::export::portable::Portable;

impl Portable {
    /// The unit, with the `library` built from its sources, if there is one.
    pub(crate) fn unit(&self, library: Option<Vec<u8>>) -> Result<Vec<u8>, Invalid> {
        let mut files = vec![("modelDescription.xml".to_owned(), self.description().into_bytes())];
        let built = PLATFORM.zip(library);
        files.extend(
            built.map(|(platform, bytes)| (format!("binaries/{platform}/{}.{LIBRARY}", self.base), bytes)),
        );
        let sources = self.unit_sources().into_iter();
        files.extend(sources.map(|(name, text)| (format!("sources/{name}"), text.into_bytes())));
        packed(&files).map_err(|e| {
            let expected = "contents that fit into an archive";
            Invalid::new("functional mock-up unit", e.to_string(), expected, "export to c instead")
        })
    }
}

/// No clock is read: every file is dated 1980, the earliest date of such archives.
fn packed(files: &[(String, Vec<u8>)]) -> zip::result::ZipResult<Vec<u8>> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        archive.start_file(name.as_str(), options)?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}
