//! The files of a study: where they are, and a list of those that were read.

use std::path::{Path, PathBuf};

use artifact::{Digest, Document, Error, Loaded, Provenance, TableReader, read_document, read_toml};
use serde::de::DeserializeOwned;
use study::files::read_vessel;
use vessel::{DictionaryFile, Vessel};

/// Where a study's files are.
pub struct Sources {
    /// The hand-written files.
    pub study: PathBuf,
    /// The maneuvers, where they are not the study's own `dictionary.toml`.
    pub dictionary: Option<PathBuf>,
    /// What the stages wrote.
    pub results: PathBuf,
    /// Results of other studies whose estimators are to be shown side by side.
    pub scenarios: Vec<PathBuf>,
}

/// A file that may be missing.
pub(super) fn existing(path: PathBuf) -> Option<PathBuf> {
    Some(path).filter(|path| path.exists())
}

/// A document with where it comes from; none where there is no file.
pub(super) fn document_at<D: Document>(path: PathBuf) -> Result<Option<Loaded<D>>, Error> {
    existing(path).map(read_document).transpose()
}

/// Reads files and keeps a list of them.
pub(super) struct Loader<'a> {
    pub(super) sources: &'a Sources,
    pub(super) files: Vec<(String, String, String)>,
}

impl Loader<'_> {
    pub(super) fn note(&mut self, name: &str, what: &str, digest: Digest) {
        self.files.push((name.to_owned(), what.to_owned(), digest.to_string()));
    }

    pub(super) fn vessel(&mut self) -> Result<Option<Vessel>, Error> {
        let Some(path) = existing(self.sources.study.join("vessel.toml")) else { return Ok(None) };
        let vessel = read_vessel(&path, &mut Provenance::default())?;
        self.note("vessel.toml", "model structure and parameters", Digest::of_file(&path)?);
        Ok(Some(vessel))
    }

    /// The maneuvers; a file that was named must be there.
    pub(super) fn dictionary(&mut self) -> Result<Option<DictionaryFile>, Error> {
        match &self.sources.dictionary {
            Some(path) => self.toml_at(path, "dictionary.toml", "the maneuvers").map(Some),
            None => self.toml("dictionary.toml", "the maneuvers"),
        }
    }

    pub(super) fn toml<T: DeserializeOwned>(&mut self, name: &str, what: &str) -> Result<Option<T>, Error> {
        existing(self.sources.study.join(name)).map(|path| self.toml_at(&path, name, what)).transpose()
    }

    fn toml_at<T: DeserializeOwned>(&mut self, path: &Path, name: &str, what: &str) -> Result<T, Error> {
        let (value, digest) = read_toml(path)?;
        self.note(name, what, digest);
        Ok(value)
    }

    pub(super) fn document<D: Document>(&mut self, name: &str, what: &str) -> Result<Option<D>, Error> {
        Ok(self.loaded(name, what)?.map(|loaded| loaded.data))
    }

    /// A document with where it comes from.
    pub(super) fn loaded<D: Document>(&mut self, name: &str, what: &str) -> Result<Option<Loaded<D>>, Error> {
        let loaded = document_at::<D>(self.sources.results.join(name))?;
        loaded.iter().for_each(|loaded| self.note(name, what, loaded.digest));
        Ok(loaded)
    }

    /// A table of the results.
    pub(super) fn table(
        &mut self,
        name: &str,
        what: &str,
        (id, version): (&'static str, u32),
    ) -> Result<Option<TableReader>, Error> {
        let Some(path) = existing(self.sources.results.join(name)) else { return Ok(None) };
        let reader = TableReader::open(&path, id, version)?;
        self.note(name, what, reader.digest());
        Ok(Some(reader))
    }
}
