//! JSON documents: an envelope with schema, provenance, seal and units around the data.
//!
//! A document vouches for the files of its set by their digests: they get their names first, the document last.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use refusal::{Invalid, foreign};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::access::{bytes_of, open_unobserved, read, wrote};
use crate::error::{Error, Result};
use crate::json::{first_not_finite, pretty};
use crate::provenance::{Provenance, Shard};
use crate::seal::{self, Digest, Header};
use crate::staged::{Staged, flush, folder_of, hold_names, is_inside};

/// The contents of a kind of JSON document.
///
/// Structs inside should refuse unknown fields (`#[serde(deny_unknown_fields)]`), so that a misspelt key is
/// reported with the nearest known one.
pub trait Document: Serialize + DeserializeOwned + JsonSchema {
    /// Name of this kind of document, like `design`.
    const ID: &'static str;
    /// Version of this kind of document, from 1.
    const VERSION: u32;
    /// Units of all numeric fields; the values of a map have the unit of the map's field.
    const UNITS: Units;

    /// Refuses meaningless values. Every reader of the document calls it.
    ///
    /// # Errors
    /// Names the value.
    fn check(&self) -> Result<(), Invalid> {
        Ok(())
    }
}

/// Units with the names of the fields that have them, blanks between: `("m/s", "std_u std_v")`.
pub type Units = &'static [(&'static str, &'static str)];

/// The unit of every numeric field of a kind of document, by the field's name.
pub fn units<D: Document>() -> BTreeMap<String, String> {
    let named = |&(unit, fields): &(&str, &'static str)| {
        let unit = unit.to_owned();
        fields.split(' ').map(move |field| (field.to_owned(), unit.clone()))
    };
    D::UNITS.iter().flat_map(named).collect()
}

/// A document as read from its file.
#[derive(Clone, Debug)]
pub struct Loaded<D> {
    /// The contents.
    pub data: D,
    /// Digest of the file.
    pub digest: Digest,
    /// Where the document comes from.
    pub provenance: Provenance,
    /// Digests of the files that were written together with it, by their names beside it.
    pub members: BTreeMap<String, Digest>,
}

/// The whole file.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Envelope<D> {
    /// Kind of document and its version.
    schema: String,
    /// Program that wrote the document, and its version.
    producer: String,
    /// BLAKE3 of the file with these 64 digits replaced by zeros; null if the document was edited by hand.
    #[serde(deserialize_with = "seal::required")]
    seal: Option<Digest>,
    /// Digests of the input files, by role.
    inputs: BTreeMap<String, Digest>,
    /// Digests of the files that the inputs were made of, by role.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    origins: BTreeMap<String, Digest>,
    /// Settings that determine the contents.
    settings: BTreeMap<String, Value>,
    /// Which part of the whole this is, if it is a part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    shard: Option<Shard>,
    /// Digests of the files that were written together with this one, by their names beside it.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub members: BTreeMap<String, Digest>,
    /// Unit of each numeric field, by field name.
    pub units: BTreeMap<String, String>,
    /// The contents.
    data: D,
}

impl<D> Envelope<D> {
    /// The contents of a file with this digest, and where they come from.
    pub fn loaded(self, digest: Digest) -> Loaded<D> {
        let Self { producer, inputs, origins, settings, shard, members, data, .. } = self;
        let provenance = Provenance { producer, inputs, origins, settings, shard, ..Provenance::default() };
        Loaded { data, digest, provenance, members }
    }
}

/// Writes a document beside its target, under a temporary name.
///
/// # Errors
/// [`Error::Refused`] if a number is NaN or infinite (with its field path) or the data cannot be
/// put into JSON; [`Error::Io`] if the file cannot be written.
pub fn stage_document<D: Document>(
    path: impl AsRef<Path>,
    provenance: &Provenance,
    data: &D,
) -> Result<Staged> {
    stage_set_document(path, provenance, data, &[])
}

/// As [`stage_document`], for a document that vouches for `files` of its set: it contains their digests,
/// which [`crate::read_document`] compares with the files beside it.
///
/// # Errors
/// As [`stage_document`]; [`Error::Io`] if one of `files` cannot be read.
pub fn stage_set_document<D: Document>(
    path: impl AsRef<Path>,
    provenance: &Provenance,
    data: &D,
    files: &[Staged],
) -> Result<Staged> {
    let path = path.as_ref();
    provenance.check_output(path)?;
    if let Some((field, value)) = first_not_finite(data) {
        let remedy = "leave the field out or correct the computation";
        return Err(Error::refuse(path, format!("data.{field}"), value, "a finite number", remedy));
    }
    let envelope = Envelope {
        schema: seal::schema_id(D::ID, D::VERSION),
        producer: provenance.producer.clone(),
        seal: Some(Digest::ZERO),
        inputs: provenance.inputs.clone(),
        origins: provenance.origins.clone(),
        settings: provenance.settings.clone(),
        shard: provenance.shard,
        members: member_digests(path, files)?,
        units: units::<D>(),
        data,
    };
    let value = serde_json::to_value(&envelope).map_err(|e| {
        Error::refuse(path, "data", e.to_string(), "data that JSON can hold", "report this to the developers")
    })?;
    Staged::bytes(path, &seal::sealed(path, pretty(&value))?)
}

/// JSON Schema of the whole file, envelope and data.
pub fn json_schema<D: Document>() -> Value {
    let mut schema = schemars::schema_for!(Envelope<D>).to_value();
    schema["title"] = format!("{} document", D::ID).into();
    schema["properties"]["schema"]["const"] = seal::schema_id(D::ID, D::VERSION).into();
    schema["properties"]["units"]["const"] = serde_json::json!(units::<D>());
    schema["required"] =
        serde_json::json!(["schema", "producer", "seal", "inputs", "settings", "units", "data"]);
    schema
}

/// Digests of `files` by their names beside `document`.
fn member_digests(document: &Path, files: &[Staged]) -> Result<BTreeMap<String, Digest>> {
    let folder = folder_of(document);
    let member = |file: &Staged| {
        let name = file.path().strip_prefix(folder).unwrap_or(file.path());
        Ok((name.to_string_lossy().into_owned(), file.digest()?))
    };
    files.iter().map(member).collect()
}

/// The files that the existing `document` vouches for and that are not among the new `files`.
fn earlier_members(document: &Path, files: &[Staged]) -> Vec<PathBuf> {
    let is_document = document.extension().is_some_and(|end| end == "json");
    let header = || {
        let file = open_unobserved(document).ok().filter(|_| is_document)?;
        serde_json::from_slice::<Header>(&bytes_of(document, file).ok()?).ok()
    };
    let is_new = |name: &Path| files.iter().any(|new| new.path().file_name() == name.file_name());
    let gone = |(name, digest): (String, Digest)| {
        let name = Some(Path::new(&name)).filter(|name| is_inside(name) && !is_new(name))?;
        let file = folder_of(document).join(name);
        Digest::of_own(&file).is_ok_and(|current| current == digest).then_some(file)
    };
    header().map(Header::members).into_iter().flatten().filter_map(gone).collect()
}

/// Refuses a document if the files beside it are not those written with it. A missing file is accepted.
/// `known` are digests of files that need not be read again.
///
/// # Errors
/// Names the first differing file, or one in another folder.
pub fn check_members(
    document: &Path,
    members: &BTreeMap<String, Digest>,
    known: impl Fn(&Path) -> Option<Digest>,
) -> Result<()> {
    for (name, digest) in members {
        if !is_inside(Path::new(name)) {
            let (found, expected) = (format!("`{}`", foreign(name)), "files beside the document");
            let remedy = "write the document again: it names files of other folders";
            return Err(Error::refuse(document, "members", found, expected, remedy));
        }
        let member = folder_of(document).join(name);
        if known(&member).or_else(|| Digest::of_file(&member).ok()).is_some_and(|current| current != *digest)
        {
            return Err(mixed(&member, document));
        }
    }
    Ok(())
}

/// Refuses the table at `path`, whose digest is `digest`, if the document of this name beside it was not written
/// with it.
pub(crate) fn check_companion(path: &Path, digest: Digest, companion: Option<&str>) -> Result<()> {
    let inside = companion.filter(|name| is_inside(Path::new(name)));
    let Some(document) = inside.map(|name| folder_of(path).join(name)) else { return Ok(()) };
    let Ok(bytes) = read(&document) else { return Ok(()) };
    let Ok(header) = serde_json::from_slice::<Header>(&bytes) else { return Ok(()) };
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    if header.members().get(&*name) == Some(&digest) { Ok(()) } else { Err(mixed(path, &document)) }
}

fn mixed(file: &Path, document: &Path) -> Error {
    let other = format!("another file than the one written with {}", document.display());
    let remedy = "run the stage that writes both again, or keep them in folders of their own";
    Error::refuse(file, "digest", other, "the files of one run of a stage", remedy)
}

/// Gives every file its name, in order, replacing files of the same name. The last one is the document that vouches for the
/// others, if there is one, and the one that tools wait for (make): what the document of this name vouched for before, and does
/// not now, is removed.
///
/// If a process ends between two renames, or one fails, the document refuses the files that are not its own. The stage is then to
/// be run again.
///
/// # Errors
/// [`Error::Refused`] if two files have the same target; [`Error::Io`] if one cannot be renamed.
pub fn commit(mut files: Vec<Staged>) -> Result<()> {
    refuse_same_targets(&files)?;
    let folders: BTreeSet<PathBuf> = files.iter().map(|file| folder_of(file.path()).to_owned()).collect();
    files.iter().for_each(|file| wrote(file.path()));
    let Some(last) = files.pop() else { return Ok(()) };
    let earlier = earlier_members(last.path(), &files);
    // No signal comes in between.
    let held = hold_names();
    files.into_iter().try_for_each(Staged::rename)?;
    earlier.iter().for_each(|file| drop(fs::remove_file(file)));
    last.rename()?;
    drop(held);
    folders.iter().for_each(|folder| flush(folder));
    Ok(())
}

/// Gives `member` its name, and its name to the document beside it, which contains `data` and vouches for it.
///
/// # Errors
/// See [`stage_set_document`] and [`commit`].
pub fn commit_with_document<D: Document>(
    member: Staged,
    document: &Path,
    provenance: &Provenance,
    data: &D,
) -> Result<()> {
    let mut files = vec![member];
    files.push(stage_set_document(document, provenance, data, &files)?);
    commit(files)
}

fn refuse_same_targets(files: &[Staged]) -> Result<()> {
    for (i, file) in files.iter().enumerate() {
        if files[..i].iter().any(|other| other.path() == file.path()) {
            let (found, expected) = ("two files of this name", "one file per name");
            return Err(Error::refuse(file.path(), "output", found, expected, "name another output"));
        }
    }
    Ok(())
}
