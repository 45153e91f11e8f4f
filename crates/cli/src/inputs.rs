//! Files that stages read. Each is noted, with its digest, in the provenance of the outputs.

use std::ops::Range;
use std::path::{Path, PathBuf};

use files::{
    Columns, Document, EncodedBlock, Error, Provenance, Shard, Staged, TableReader, TableWriter, Work,
    check_given, check_settings, commit, commit_with_document, gather, read_document, shards_of,
};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::json;
use ship::engine::Run;
use ship::model::Vessel;
use study::trajectories::{KeptRuns, Layout, TrajectoryReader};
use study::{Doubtful, LoggedHelm, carry_contradicting};

use crate::cli::budget;
use crate::failure::Failure;
use crate::stage::Summary;

/// Reads a document as the input `key`.
pub fn document<D: Document>(path: &Path, key: &str, provenance: &mut Provenance) -> Result<D, Failure> {
    let loaded = read_document::<D>(path)?;
    provenance.made(key, path, loaded.digest, &loaded.provenance)?;
    Ok(loaded.data)
}

/// Reads the hand-written file usually called `<key>.toml` as the input `key`.
pub fn toml<T>(path: &Path, key: &str, provenance: &mut Provenance) -> Result<T, Failure>
where
    T: DeserializeOwned + JsonSchema,
{
    Ok(provenance.read_toml(key, key, path)?)
}

/// Opens trajectories of `vessel` as the input `key`.
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
    carry_contradicting(reader.provenance(), provenance);
    LoggedHelm::of(reader.provenance()).note(provenance);
    Ok(reader)
}

/// Refuses trajectories if their `found` needs too many `bytes` of memory.
pub fn fits(file: &Path, found: &str, bytes: f64) -> Result<(), Failure> {
    let remedy = "cut it into smaller files, or raise --memory-mib";
    Ok(budget().memory(Work { file, thing: "rows", found, remedy }, bytes)?)
}

/// All runs of the input `trajectories`.
pub fn runs(path: &Path, vessel: &Vessel, provenance: &mut Provenance) -> Result<Vec<Run>, Failure> {
    all(path, &trajectories(path, "trajectories", vessel, provenance)?, vessel)
}

/// Whether trajectories were simulated: they have true states, and their inputs are held during samples.
pub fn are_simulated(path: &Path, vessel: &Vessel) -> Result<bool, Failure> {
    Ok(TrajectoryReader::open(path, &Layout::new(&vessel.model), vessel.sample_rate_hz)?.true_states())
}

/// All runs of `reader`, which reads `path`.
pub fn all(path: &Path, reader: &TrajectoryReader, vessel: &Vessel) -> Result<Vec<Run>, Failure> {
    let (rows, _) = reader.rows();
    // The runs, their parts, and the segments of these.
    let bytes = 4.0 * rows as f64 * Layout::new(&vessel.model).run_bytes();
    fits(path, &format!("{rows} rows"), bytes)?;
    Ok(reader.all()?)
}

/// Runs to be pooled, kept in their file.
pub fn kept_runs(path: &Path, vessel: &Vessel, provenance: &mut Provenance) -> Result<KeptRuns, Failure> {
    let reader = trajectories(path, "trajectories", vessel, provenance)?;
    Ok(KeptRuns::new(reader, &Layout::new(&vessel.model), 0.25 * budget().bytes())?)
}

/// A table that is complete but not published, and its contents.
pub struct Made<R> {
    pub(crate) table: Staged,
    pub(crate) provenance: Provenance,
    pub(crate) rows: Vec<R>,
}

impl<R: Send + 'static> Made<R> {
    /// Joins the files of all `shards` and reads their rows. `given`: the inputs and settings of the whole.
    pub fn gathered(
        shards: &[PathBuf],
        [out, document]: [&Path; 2],
        columns: &Columns<R>,
        mut given: Provenance,
        rows: impl Fn(&TableReader) -> Result<Vec<R>, Error>,
    ) -> Result<Self, Failure> {
        let schema = columns.schema();
        let table = gather(shards, out, Some(document), schema.id, schema.version)?;
        // Read from the shards: a refusal names the one at fault.
        let readers = shards_of(shards, schema.id, schema.version)?;
        let all = of_shards(&readers, columns, &mut given, rows)?;
        let first = readers.first().map(|reader| reader.provenance().clone()).unwrap_or_default();
        let mut provenance = Provenance { shard: None, ..first };
        provenance.accept_label(&given);
        Ok(Self { rows: all, provenance, table })
    }

    /// Publishes the table of a shard, and reports the number of its rows, which are `things`.
    pub fn publish_shard(self, shard: Shard, things: &str) -> Result<Summary, Failure> {
        let (out, count) = (self.table.path().to_owned(), self.rows.len());
        commit(vec![self.table])?;
        Ok(Summary::of(&out, format!("{count} {things}, shard {shard}"), json!({things: count})))
    }

    /// Computes the rows of every block of this shard in parallel. The whole table names the document that
    /// [`publish`] writes next to it.
    pub fn computed(
        [out, document]: [&Path; 2],
        columns: &Columns<R>,
        provenance: Provenance,
        blocks: usize,
        rows: impl Fn(usize) -> Result<Vec<R>, Failure> + Sync,
    ) -> Result<Self, Failure> {
        let mut writer = TableWriter::create(out, columns.schema(), &provenance)?;
        if provenance.shard.is_none() {
            writer = writer.with_document(document);
        }
        let mut all = Vec::new();
        let work = |i: usize| {
            let rows_of_block = rows(i)?;
            Ok((columns.encode(&rows_of_block)?, rows_of_block))
        };
        let mine = provenance.shard.map_or(0..blocks, |shard| shard.range(blocks));
        ordered(mine, work, |(block, rows_of_block): (EncodedBlock, Vec<R>)| {
            all.extend(rows_of_block);
            Ok::<_, Failure>(writer.push(block)?)
        })?;
        Ok(Self { table: writer.finish()?, provenance, rows: all })
    }
}

/// The rows of the files of all `shards` of a table, for work with the provenance `given`, which must have the same
/// settings.
pub fn rows_of_shards<R: 'static>(
    shards: &[PathBuf],
    columns: &Columns<R>,
    given: &mut Provenance,
    rows: impl Fn(&TableReader) -> Result<Vec<R>, Error>,
) -> Result<Vec<R>, Failure> {
    let readers = shards_of(shards, columns.schema().id, columns.schema().version)?;
    let all = of_shards(&readers, columns, given, rows)?;
    readers.iter().try_for_each(|reader| check_settings(given, reader.path(), reader.provenance()))?;
    Ok(all)
}

fn of_shards<R: 'static>(
    readers: &[TableReader],
    columns: &Columns<R>,
    given: &mut Provenance,
    rows: impl Fn(&TableReader) -> Result<Vec<R>, Error>,
) -> Result<Vec<R>, Failure> {
    readers.iter().try_for_each(|reader| {
        reader.require(&columns.schema().columns)?;
        check_given(given, reader.path(), reader.provenance())
    })?;
    Ok(readers.iter().map(rows).collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

/// Publishes `table` and, if it is whole, `document` next to it.
pub fn publish<D: Document>(
    table: Staged,
    document: &Path,
    provenance: &Provenance,
    data: impl FnOnce() -> Result<D, Failure>,
) -> Result<(), Failure> {
    match provenance.shard {
        Some(_) => Ok(commit(vec![table])?),
        None => Ok(commit_with_document(table, document, provenance, &data()?)?),
    }
}

/// Calls `work` on every item in parallel and `fold` on the results in order. Only a few results per thread are held at
/// a time. Stops at the first failure in order.
pub fn ordered<T: Send, E: Send>(
    items: Range<usize>,
    work: impl Fn(usize) -> Result<T, E> + Sync,
    mut fold: impl FnMut(T) -> Result<(), E>,
) -> Result<(), E> {
    let window = 2 * rayon::current_num_threads();
    let mut start = items.start;
    while start < items.end {
        let end = (start + window).min(items.end);
        let results: Vec<Result<T, E>> = (start..end).into_par_iter().map(&work).collect();
        results.into_iter().try_for_each(|result| fold(result?))?;
        start = end;
    }
    Ok(())
}

/// Number of blocks of a table per block of the table computed from it, so that small rows do not end up in small
/// blocks.
const JOINED: usize = 8;

/// Number of joined blocks of `blocks`.
pub fn joined_blocks(blocks: usize) -> usize {
    blocks.div_ceil(JOINED)
}

/// Calls `work` in parallel on the blocks of joined block `i` and concatenates their rows.
pub fn joined<T: Send, E: Send>(
    i: usize,
    blocks: usize,
    work: impl Fn(usize) -> Result<Vec<T>, E> + Sync + Send,
) -> Result<Vec<T>, E> {
    let parts: Vec<Result<Vec<T>, E>> =
        (i * JOINED..blocks.min((i + 1) * JOINED)).into_par_iter().map(work).collect();
    let parts: Vec<Vec<T>> = parts.into_iter().collect::<Result<_, _>>()?;
    Ok(parts.into_iter().flatten().collect())
}
