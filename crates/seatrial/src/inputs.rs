//! Files that stages read. Each is noted, with its digest, in the provenance of what is made of it.

use std::path::Path;

use artifact::{Document, Provenance, read_document, read_toml};
use serde::de::DeserializeOwned;
use study::trajectories::{Layout, TrajectoryReader, label};
use vessel::{Run, Vessel};

use crate::failure::Failure;

/// Reads a document as the input `key`.
///
/// # Errors
/// A file that is refused.
pub fn document<D: Document>(path: &Path, key: &str, provenance: &mut Provenance) -> Result<D, Failure> {
    let loaded = read_document::<D>(path)?;
    provenance.made(key, path, loaded.digest, &loaded.provenance)?;
    Ok(loaded.data)
}

/// Reads a hand-written file as the input `key`.
///
/// # Errors
/// A file that is refused.
pub fn toml<T: DeserializeOwned>(path: &Path, key: &str, provenance: &mut Provenance) -> Result<T, Failure> {
    let (file, digest) = read_toml(path)?;
    provenance.written(key, path, digest)?;
    Ok(file)
}

/// Opens trajectories of `vessel` as the input `key`.
///
/// # Errors
/// A file that is refused, or is a shard.
pub fn trajectories(
    path: &Path,
    key: &str,
    vessel: &Vessel,
    provenance: &mut Provenance,
) -> Result<TrajectoryReader, Failure> {
    let reader = TrajectoryReader::open(path, &Layout::new(&vessel.model), vessel.sample_rate_hz)?;
    reader.whole()?;
    provenance.made(key, path, reader.digest(), reader.provenance())?;
    Ok(reader)
}

/// All runs of trajectories, which are the input `key`.
///
/// # Errors
/// See [`trajectories`]; a block that is damaged.
pub fn runs(
    path: &Path,
    key: &str,
    vessel: &Vessel,
    provenance: &mut Provenance,
) -> Result<Vec<Run>, Failure> {
    let reader = trajectories(path, key, vessel, provenance)?;
    let blocks: Vec<Vec<Run>> = (0..reader.blocks()).map(|i| reader.runs(i)).collect::<Result<_, _>>()?;
    Ok(blocks.concat())
}

/// Those of measured trajectories. What is made of them is labelled as made of simulated logs, if they are.
///
/// # Errors
/// See [`runs`].
pub fn labelled_runs(path: &Path, vessel: &Vessel, provenance: &mut Provenance) -> Result<Vec<Run>, Failure> {
    let runs = runs(path, "trajectories", vessel, provenance)?;
    label(runs.iter().map(|run| run.design.as_str()), provenance);
    Ok(runs)
}
