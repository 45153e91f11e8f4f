//! Tables whose rows are computed block by block, in shards that can be gathered.

use std::path::{Path, PathBuf};

use files::{
    Columns, Document, EncodedBlock, Error, Provenance, Shard, Staged, TableReader, TableWriter, check_given,
    check_settings, commit, commit_with_document, gather, shards_of,
};
use serde_json::json;

use crate::failure::Failure;
use crate::ordered::ordered;
use crate::stage::Summary;

/// A table that is complete but not published, and its contents.
pub struct Made<R> {
    /// The table.
    pub table: Staged,
    /// Its provenance.
    pub provenance: Provenance,
    /// Its rows.
    pub rows: Vec<R>,
}

impl<R: Send + 'static> Made<R> {
    /// Joins the files of all `shards` and reads their rows. `given`: the inputs and settings of the whole.
    ///
    /// # Errors
    /// Files that are not shards of one table, or not all of them; shards of other inputs or settings.
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
    ///
    /// # Errors
    /// Output that fails.
    pub fn publish_shard(self, shard: Shard, things: &str) -> Result<Summary, Failure> {
        let (out, count) = (self.table.path().to_owned(), self.rows.len());
        commit(vec![self.table])?;
        Ok(Summary::of(&out, format!("{count} {things}, shard {shard}"), json!({things: count})))
    }

    /// Computes the rows of every block of this shard in parallel. The whole table names the document that
    /// [`publish`] writes next to it.
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

/// The rows of the files of all `shards` of a table, for work with the provenance `given`, which must have the same
/// settings.
///
/// # Errors
/// Files that are not shards of one table, or not all of them; shards of other inputs or settings.
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
