//! The files of a study: their locations, and a list of those that were read.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use files::{Changes, Digest, Document, Error, Loaded, MIXED, Provenance, TableReader, read_document};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use study::documents::Reference;
use study::files::{DictionaryFile, Vessel, read_any_vessel, read_reference};
use study::role_of;

/// The locations of a study's files.
pub struct Sources {
    /// The hand-written files.
    pub study: PathBuf,
    /// The maneuvers, if not the study's own `dictionary.toml`.
    pub dictionary: Option<PathBuf>,
    /// The folder that the stages wrote into.
    pub results: PathBuf,
    /// Results of other studies whose estimators are to be shown side by side.
    pub scenarios: Vec<PathBuf>,
    /// Whether files of different studies may be shown together; the page says so.
    pub allow_mixed: bool,
    /// Changes to values of the hand-written files when the results were made.
    pub changes: Changes,
}

/// A file that may be missing.
pub(super) fn existing(path: PathBuf) -> Option<PathBuf> {
    Some(path).filter(|path| files::exists(path))
}

/// A document with its provenance; `None` if there is no file.
pub(super) fn document_at<D: Document>(path: PathBuf) -> Result<Option<Loaded<D>>, Error> {
    existing(path).map(read_document).transpose()
}

/// Reads files, lists them, and checks that they belong together.
pub(super) struct Loader<'a> {
    pub(super) sources: &'a Sources,
    pub(super) files: Vec<(String, String, String)>,
    /// Provenance of the study's files: its hand-written files, its design, and so on.
    known: Provenance,
    /// The same for each folder below the results, which has its own estimates and scores.
    below: BTreeMap<PathBuf, Provenance>,
}

impl<'a> Loader<'a> {
    pub(super) fn new(sources: &'a Sources) -> Self {
        let (allow_mixed, changes) = (sources.allow_mixed, sources.changes.clone());
        let known = Provenance { allow_mixed, changes, ..Provenance::default() };
        Self { sources, files: Vec::new(), known, below: BTreeMap::new() }
    }

    /// The roles that several files have, if that is allowed.
    pub(super) fn mixed(&self) -> Vec<String> {
        let all = std::iter::once(&self.known).chain(self.below.values());
        let roles = all.filter_map(|known| known.settings.get(MIXED)?.as_array()).flatten();
        let names: BTreeSet<&str> = roles.filter_map(|role| role.as_str()).collect();
        names.into_iter().map(str::to_owned).collect()
    }

    pub(super) fn note(&mut self, name: &str, what: &str, digest: Digest) {
        self.files.push((name.to_owned(), what.to_owned(), digest.to_string()));
    }

    /// Notes a file of the results and refuses it if it was made from other files than the previous ones.
    pub(super) fn made(
        &mut self,
        name: &str,
        what: &str,
        digest: Digest,
        from: &Provenance,
    ) -> Result<(), Error> {
        self.note(name, what, digest);
        let path = self.sources.results.join(name);
        self.known(name).made(role_of(name), &path, digest, from)
    }

    /// The provenance of the folder of `name`.
    fn known(&mut self, name: &str) -> &mut Provenance {
        match Path::new(name).parent().filter(|folder| *folder != Path::new("")) {
            None => &mut self.known,
            Some(folder) => self.below.entry(folder.to_owned()).or_insert_with(|| {
                let mut known = self.known.clone();
                known.forget(&["estimates", "validation"]);
                known
            }),
        }
    }

    pub(super) fn vessel(&mut self) -> Result<Option<Vessel>, Error> {
        let Some(path) = existing(self.sources.study.join("vessel.toml")) else { return Ok(None) };
        let vessel = read_any_vessel(&path, &mut self.known)?;
        self.read("vessel.toml", "model structure and parameters");
        Ok(Some(vessel))
    }

    /// The maneuvers; a named file must exist.
    pub(super) fn dictionary(&mut self) -> Result<Option<DictionaryFile>, Error> {
        match &self.sources.dictionary {
            Some(path) => self.toml_at(path, "dictionary.toml", "the maneuvers").map(Some),
            None => self.toml("dictionary.toml", "the maneuvers"),
        }
    }

    pub(super) fn toml<T: DeserializeOwned + JsonSchema>(
        &mut self,
        name: &str,
        what: &str,
    ) -> Result<Option<T>, Error> {
        existing(self.sources.study.join(name)).map(|path| self.toml_at(&path, name, what)).transpose()
    }

    fn toml_at<T: DeserializeOwned + JsonSchema>(
        &mut self,
        path: &Path,
        name: &str,
        what: &str,
    ) -> Result<T, Error> {
        let value = self.known.read_toml(role_of(name), name.trim_end_matches(".toml"), path)?;
        self.read(name, what);
        Ok(value)
    }

    /// Notes the hand-written file `name`, which has been read.
    fn read(&mut self, name: &str, what: &str) {
        if let Some(digest) = self.known.inputs.get(role_of(name)) {
            self.note(name, what, *digest);
        }
    }

    /// The published results.
    pub(super) fn reference(&mut self) -> Result<Option<Reference>, Error> {
        let Some(path) = existing(self.sources.study.join("reference.toml")) else { return Ok(None) };
        let reference = read_reference(&path, role_of("reference.toml"), &mut self.known)?;
        self.read("reference.toml", "published results, to compare with");
        Ok(Some(reference))
    }

    pub(super) fn document<D: Document>(&mut self, name: &str, what: &str) -> Result<Option<D>, Error> {
        Ok(self.loaded(name, what)?.map(|loaded| loaded.data))
    }

    /// A document with its provenance.
    pub(super) fn loaded<D: Document>(&mut self, name: &str, what: &str) -> Result<Option<Loaded<D>>, Error> {
        let loaded = document_at::<D>(self.sources.results.join(name))?;
        if let Some(loaded) = &loaded {
            self.made(name, what, loaded.digest, &loaded.provenance)?;
            if let Some(estimates) = loaded.members.get("estimates.parquet") {
                let path = self.sources.results.join(name);
                self.known(name).written("estimates", &path, *estimates)?;
            }
        }
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
        self.made(name, what, reader.digest(), reader.provenance())?;
        Ok(Some(reader))
    }
}
