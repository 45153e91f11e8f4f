//! Tables whose rows are computed block by block, in shards that can be gathered.

use std::path::{Path, PathBuf};

use artifact::{
    Columns, Document, EncodedBlock, Error, Provenance, Staged, TableReader, TableWriter, check_given,
    commit, commit_with_document, gather,
};

use crate::failure::Failure;
use crate::ordered::ordered;

/// A table that is complete but not published, and what is in it.
pub struct Made<R> {
    /// The table.
    pub table: Staged,
    /// Where it comes from.
    pub provenance: Provenance,
    /// Its rows.
    pub rows: Vec<R>,
}

impl<R: Send + 'static> Made<R> {
    /// Puts the files of all `shards` together and reads their rows. `given`: the inputs and settings that the whole is to be
    /// told with.
    ///
    /// # Errors
    /// Files that are no shards of one table, or not all of them; shards of other inputs or settings.
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
        let open = |path: &PathBuf| TableReader::open(path, schema.id, schema.version);
        let mut readers = shards.iter().map(open).collect::<Result<Vec<_>, _>>()?;
        readers.sort_by_key(|reader| reader.provenance().shard);
        readers.iter().try_for_each(|reader| {
            reader.require(&schema.columns)?;
            check_given(&mut given, reader.path(), reader.provenance())
        })?;
        let all = readers.iter().map(rows).collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
        let first = readers.first().map(|reader| reader.provenance().clone()).unwrap_or_default();
        let mut provenance = Provenance { shard: None, ..first };
        provenance.accept_label(&given);
        Ok(Self { rows: all, provenance, table })
    }

    /// Computes the rows of every block of this shard in parallel. The whole table names the document that [`publish`] puts
    /// beside it.
    ///
    /// # Errors
    /// The first failure of `rows`, in the order of blocks; output that fails.
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
            let own = rows(i)?;
            Ok((columns.encode(&own)?, own))
        };
        let mine = provenance.shard.map_or(0..blocks, |shard| shard.range(blocks));
        ordered(mine, work, |(block, own): (EncodedBlock, Vec<R>)| {
            all.extend(own);
            Ok::<_, Failure>(writer.push(block)?)
        })?;
        Ok(Self { table: writer.finish()?, provenance, rows: all })
    }
}

/// Gives `table` its name, and where it is whole, `document` beside it.
///
/// # Errors
/// Output that fails.
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
