//! `moments.parquet`: the moments of too many maneuvers for a document.

use std::path::{Path, PathBuf};

use design::{Blocks, Candidates, Degree};
use files::{Columns, Error, TableReader};
use refusal::Invalid;
use trial::moments::{DegreeMoments, Estimated, ManeuverMoments, Moments};

use crate::beside;

/// Schema id.
pub const ID: &str = "moments-table";
/// Version of the schema.
pub const VERSION: u32 = 1;
/// Maneuvers per block.
pub const BLOCK: usize = 4096;

/// The table of the document `moments`.
pub fn table_of(moments: &Path) -> PathBuf {
    beside(moments, "moments.json", "moments.parquet")
}

/// The columns: a row per maneuver, the entries of M of every degree of freedom row by row.
pub fn columns(degrees: &[Degree]) -> Columns<ManeuverMoments> {
    let columns = Columns::<ManeuverMoments>::new(ID, VERSION)
        .text("maneuver", |r| &r.name, |r, name| r.name = name.to_owned())
        .number("samples", "1", |r| r.samples as f64, |r, samples| r.samples = samples as u64);
    degrees.iter().enumerate().fold(columns, |columns, (d, degree)| {
        let n = degree.regressors.len();
        let columns = columns.number(
            format!("nonstationarity_{}", degree.name),
            "1",
            move |r| r.degrees[d].nonstationarity,
            move |r, value| r.degrees[d].nonstationarity = value,
        );
        (0..n * n).fold(columns, |columns, e| {
            columns.number(
                format!("M_{}_{}_{}", degree.name, e / n + 1, e % n + 1),
                "unit of regressor i times unit of instrument j",
                move |r| r.degrees[d].m[e],
                move |r, value| r.degrees[d].m[e] = value,
            )
        })
    })
}

/// The moments of a table, block by block, as information of each maneuver for an estimate by instrumental variables.
pub struct MomentsTable {
    reader: TableReader,
    head: Moments,
    estimated: Estimated,
}

/// Why a block of the table cannot be read, or allows no design.
#[derive(Debug)]
pub enum TableError {
    /// It cannot be read, or is refused.
    Table(Error),
    /// No design.
    Design(design::Error),
}

impl From<design::Error> for TableError {
    fn from(error: design::Error) -> Self {
        Self::Design(error)
    }
}

impl MomentsTable {
    /// Opens the table of the document `moments`, which has `head` and lists no maneuver.
    ///
    /// # Errors
    /// No such table, or one with other columns; an estimate that needs more.
    pub fn open(moments: &Path, head: Moments, estimated: Estimated) -> Result<Self, Error> {
        let reader = TableReader::open(table_of(moments), ID, VERSION)?;
        reader.require(&columns(&head.degrees).schema().columns)?;
        if estimated == Estimated::OutputError {
            let (expected, remedy) = ("moments of a document", "run `moments` without --keep table");
            return Err(crate::refuse(reader.path(), "`--for output-error`", "a table", expected, remedy));
        }
        Ok(Self { reader, head, estimated })
    }

    /// The maneuvers of block `i`.
    fn maneuvers(&self, i: usize) -> Result<Vec<ManeuverMoments>, Error> {
        let of = |degree: &Degree| {
            let n = degree.regressors.len();
            let shape = [n as u64; 2];
            DegreeMoments {
                name: degree.name.clone(),
                shape,
                m: vec![0.0; n * n],
                nonstationarity: 0.0,
                b: None,
            }
        };
        let degrees = self.head.degrees.iter().map(of).collect();
        let blank = ManeuverMoments { name: String::new(), samples: 0, degrees, output_error: None };
        columns(&self.head.degrees).read_block(&self.reader, i, &blank)
    }

    /// The document's moments with these maneuvers of the table.
    ///
    /// # Errors
    /// A damaged block.
    pub fn with(&self, places: &[(usize, usize)]) -> Result<Moments, Error> {
        let mut moments = self.head.clone();
        for group in places.chunk_by(|a, b| a.0 == b.0) {
            let block = self.maneuvers(group[0].0)?;
            moments.maneuvers.extend(group.iter().filter_map(|(_, place)| block.get(*place).cloned()));
        }
        Ok(moments)
    }
}

impl Blocks for MomentsTable {
    type Error = TableError;

    fn blocks(&self) -> usize {
        self.reader.blocks()
    }

    fn block(&self, i: usize) -> Result<Candidates, TableError> {
        let maneuvers = self.maneuvers(i).map_err(TableError::Table)?;
        let moments = Moments { maneuvers, ..self.head.clone() };
        let refused = |e: Invalid| TableError::Table(crate::invalid(self.reader.path(), &e));
        Ok(moments.dictionary(self.estimated).map_err(refused)?.information)
    }
}
