//! A folder that the stages wrote into.

use std::path::{Component, Path, PathBuf};

use files::{Document, Error, Loaded, Provenance, TableReader};
use serde_json::Value;
use study::documents::{Reference, ValidationDocument};
use study::files::{read_campaign, read_reference};
use study::trajectories;

use crate::loader::{document_at, existing};

/// Folders with the documents read there, and the names of those without.
type Read<D> = (Vec<(PathBuf, Loaded<D>)>, Vec<String>);

/// The folders with a document `name`, and the names of those without.
pub(super) fn documents<D: Document>(folders: &[PathBuf], name: &str) -> Result<Read<D>, Error> {
    let (mut found, mut missing) = (Vec::new(), Vec::new());
    for folder in folders {
        match document_at(folder.join(name))? {
            Some(document) => found.push((folder.clone(), document)),
            None => missing.push(label(folder)),
        }
    }
    Ok((found, missing))
}

/// A note on what is not in the table.
pub(super) fn left_out(missing: &[String], why: &str) -> String {
    if missing.is_empty() { String::new() } else { format!("\nNot here: {} ({why}).\n", missing.join(", ")) }
}

/// A study's name: its folder below `out`, without common parts.
pub(super) fn label(folder: &Path) -> String {
    let names = folder.components().filter_map(|component| match component {
        Component::Normal(name) => name.to_str(),
        _ => None,
    });
    names.filter(|name| !["out", "trials", "seeds", "measured"].contains(name)).collect::<Vec<_>>().join(" ")
}

/// The seed of the simulated trials in `folder`.
pub(super) fn seed(folder: &Path) -> Result<Option<u64>, Error> {
    let mut names = ["campaign.parquet", "trajectories.parquet"].into_iter();
    let Some(path) = names.find_map(|name| existing(folder.join(name))) else {
        // Trials in memory leave no table.
        let validation = document_at::<ValidationDocument>(folder.join("validation.json"))?;
        return Ok(validation.and_then(|loaded| loaded.data.seed));
    };
    Ok(seed_of(TableReader::open(&path, trajectories::ID, trajectories::VERSION)?.provenance()))
}

/// The seed in the provenance of a file.
pub(super) fn seed_of(provenance: &Provenance) -> Option<u64> {
    provenance.settings.get("seed").and_then(Value::as_u64)
}

/// The length \[s\] of the trials of the study `name`, whose folder is in `written`; `None` of a plan's, which are of another length.
pub(super) fn length_s(written: Option<&Path>, name: &str) -> Result<Option<f64>, Error> {
    let path = written.and_then(|written| existing(written.join(name).join("campaign.toml")));
    let campaign = path.map(|path| read_campaign(&path, &mut Provenance::default())).transpose()?;
    Ok(campaign.map(|campaign| campaign.duration_s))
}

/// The published results of the study `name`, whose folder is in `written`.
pub(super) fn reference(written: Option<&Path>, name: &str) -> Result<Option<Reference>, Error> {
    let study = name.split(' ').next().unwrap_or(name);
    let path = written.map(|written| written.join(study).join("reference.toml"));
    path.and_then(existing)
        .map(|path| read_reference(&path, "reference", &mut Provenance::default()))
        .transpose()
}
