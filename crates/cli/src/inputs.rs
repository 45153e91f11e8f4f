//! Files that stages read. Each is noted, with its digest, in the provenance of the outputs.

use std::path::Path;

use files::{Document, Provenance, Work, read_document};
use serde::de::DeserializeOwned;
use ship::engine::Run;
use ship::model::Vessel;
use study::trajectories::{KeptRuns, Layout, TrajectoryReader};
use study::{Doubtful, LoggedHelm};

use crate::cli::budget;
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

/// Reads the hand-written file usually called `<key>.toml` as the input `key`.
///
/// # Errors
/// A file that is refused.
pub fn toml<T: DeserializeOwned>(path: &Path, key: &str, provenance: &mut Provenance) -> Result<T, Failure> {
    Ok(provenance.read_toml(key, key, path)?)
}

/// Opens trajectories of `vessel` as the input `key`.
///
/// # Errors
/// A file that is refused, is a shard or has no runs, or does not fit into memory.
pub fn trajectories(
    path: &Path,
    key: &str,
    vessel: &Vessel,
    provenance: &mut Provenance,
) -> Result<TrajectoryReader, Failure> {
    opened(path, key, vessel, provenance, TrajectoryReader::whole)
}

/// The same, refused if `check` fails.
fn opened(
    path: &Path,
    key: &str,
    vessel: &Vessel,
    provenance: &mut Provenance,
    check: fn(&TrajectoryReader) -> Result<(), files::Error>,
) -> Result<TrajectoryReader, Failure> {
    let reader = TrajectoryReader::open(path, &Layout::new(&vessel.model), vessel.sample_rate_hz)?;
    check(&reader)?;
    let (all, rows) = reader.rows();
    if all == 0 {
        let (expected, remedy) = ("at least one run", "write the trajectories again");
        return Err(Failure::refuse(path, "rows", "none", expected, remedy));
    }
    let at_once = rows as f64 * rayon::current_num_threads() as f64;
    let layout = Layout::new(&vessel.model);
    fits(path, &format!("a row group of {rows} rows"), at_once * layout.working_bytes())?;
    provenance.made(key, path, reader.digest(), reader.provenance())?;
    Doubtful::of(reader.provenance()).note(provenance);
    LoggedHelm::of(reader.provenance()).note(provenance);
    Ok(reader)
}

/// Refuses trajectories if their `found` needs too many `bytes` of memory.
///
/// # Errors
/// Not enough memory; names the limit.
pub fn fits(file: &Path, found: &str, bytes: f64) -> Result<(), Failure> {
    let remedy = "cut it into smaller files, or raise --memory-mib";
    Ok(budget().memory(Work { file, thing: "rows", found, remedy }, bytes)?)
}

/// All runs of the input `trajectories`.
///
/// # Errors
/// See [`trajectories`]; a block that is damaged.
pub fn runs(path: &Path, vessel: &Vessel, provenance: &mut Provenance) -> Result<Vec<Run>, Failure> {
    all(path, &trajectories(path, "trajectories", vessel, provenance)?, vessel)
}

/// Whether trajectories were simulated: they have true states, and their inputs are held during samples.
///
/// # Errors
/// A file that is refused.
pub fn are_simulated(path: &Path, vessel: &Vessel) -> Result<bool, Failure> {
    Ok(TrajectoryReader::open(path, &Layout::new(&vessel.model), vessel.sample_rate_hz)?.true_states())
}

/// All runs of `reader`, which reads `path`.
///
/// # Errors
/// They do not fit into memory; a block that is damaged.
pub fn all(path: &Path, reader: &TrajectoryReader, vessel: &Vessel) -> Result<Vec<Run>, Failure> {
    let (rows, _) = reader.rows();
    // The runs, their parts, and the segments of these.
    let bytes = 4.0 * rows as f64 * Layout::new(&vessel.model).run_bytes();
    fits(path, &format!("{rows} rows"), bytes)?;
    Ok(reader.all()?)
}

/// Runs to be pooled, kept in their file.
///
/// # Errors
/// See [`trajectories`].
pub fn kept_runs(path: &Path, vessel: &Vessel, provenance: &mut Provenance) -> Result<KeptRuns, Failure> {
    let reader = trajectories(path, "trajectories", vessel, provenance)?;
    Ok(KeptRuns::new(reader, &Layout::new(&vessel.model), 0.25 * budget().bytes())?)
}
