//! Tables whose rows are computed block by block, in shards that can be gathered.

use std::path::{Path, PathBuf};

use artifact::{
    EncodedBlock, Error, Provenance, Staged, Table, TableReader, TableSchema, TableWriter, encode_block,
    gather,
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

impl<R: Send> Made<R> {
    /// Puts the files of all `shards` together and reads their rows.
    ///
    /// # Errors
    /// Files that are no shards of one table, or not all of them.
    pub fn gathered(
        shards: &[PathBuf],
        out: &Path,
        schema: &TableSchema,
        rows: impl FnOnce(&TableReader) -> Result<Vec<R>, Error>,
    ) -> Result<Self, Failure> {
        let table = gather(shards, out, schema.id, schema.version)?;
        let reader = TableReader::open(table.temporary(), schema.id, schema.version)?;
        reader.require(&schema.columns)?;
        Ok(Self { rows: rows(&reader)?, provenance: reader.provenance().clone(), table })
    }

    /// Computes the rows of every block of this shard in parallel; `encoded` makes a block of the table of them.
    ///
    /// # Errors
    /// The first failure of `rows`, in the order of blocks; output that fails.
    pub fn computed(
        out: &Path,
        schema: &TableSchema,
        provenance: Provenance,
        blocks: usize,
        rows: impl Fn(usize) -> Result<Vec<R>, Failure> + Sync,
        encoded: impl Fn(&[R]) -> Table + Sync,
    ) -> Result<Self, Failure> {
        let mut writer = TableWriter::create(out, schema, &provenance)?;
        let mut all = Vec::new();
        let work = |i: usize| {
            let own = rows(i)?;
            Ok((encode_block(schema, &encoded(&own))?, own))
        };
        let mine = provenance.shard.map_or(0..blocks, |shard| shard.range(blocks));
        ordered(mine, work, |(block, own): (EncodedBlock, Vec<R>)| {
            all.extend(own);
            Ok::<_, Failure>(writer.push(block)?)
        })?;
        Ok(Self { table: writer.finish()?, provenance, rows: all })
    }
}
