//! The table of realizations of a selection study.

use artifact::{Column, ColumnSpec, Kind, Table, TableReader, TableSchema};

use crate::estimates::{NOT_IDENTIFIABLE, labels, optional};
use crate::scores::{DIVERGED, SCORED};
use artifact::Error;

/// Schema id of the realizations of a selection study.
pub const ID: &str = "selection-realizations";
/// Version of the schema.
pub const VERSION: u32 = 1;

/// One realization.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// `optimized` or `random`.
    pub design: String,
    /// Its number.
    pub realization: i32,
    /// Numbers of the parts, in the order of the trajectories: `3 17 40`.
    pub picked: String,
    /// Whether there is a model.
    pub identified: bool,
    /// Over all parts: RMSE of u, v, r; absent where diverged.
    pub rmse: Option<[f64; 3]>,
    /// Norm of RMSE/std.
    pub error_norm: Option<f64>,
    /// The same over the parts that were not picked.
    pub left_out_rmse: Option<[f64; 3]>,
    /// The same.
    pub left_out_norm: Option<f64>,
}

/// The columns.
pub fn schema() -> TableSchema {
    let rmse = |name: &str, unit: &str| ColumnSpec::new(name, unit, Kind::F64, true);
    TableSchema {
        id: ID,
        version: VERSION,
        columns: vec![
            ColumnSpec::new("design", "1", Kind::Text, false),
            ColumnSpec::new("realization", "1", Kind::I32, false),
            ColumnSpec::new("picked", "1", Kind::Text, false),
            ColumnSpec::new("status", "1", Kind::Text, false),
            rmse("rmse_u", "m/s"),
            rmse("rmse_v", "m/s"),
            rmse("rmse_r", "rad/s"),
            rmse("error_norm", "1"),
            rmse("left_out_rmse_u", "m/s"),
            rmse("left_out_rmse_v", "m/s"),
            rmse("left_out_rmse_r", "rad/s"),
            rmse("left_out_error_norm", "1"),
        ],
    }
}

/// Rows as a block of the table.
pub fn table(rows: &[Row]) -> Table {
    let status = |r: &Row| match (r.identified, r.rmse) {
        (false, _) => NOT_IDENTIFIABLE,
        (true, None) => DIVERGED,
        (true, Some(_)) => SCORED,
    };
    let mut columns = vec![
        labels(rows.iter().map(|r| r.design.as_str())),
        Column::i32(rows.iter().map(|r| r.realization).collect()),
        labels(rows.iter().map(|r| r.picked.as_str())),
        labels(rows.iter().map(status)),
    ];
    columns.extend((0..3).map(|d| optional(rows.iter().map(|r| r.rmse.map(|e| e[d])))));
    columns.push(optional(rows.iter().map(|r| r.error_norm)));
    columns.extend((0..3).map(|d| optional(rows.iter().map(|r| r.left_out_rmse.map(|e| e[d])))));
    columns.push(optional(rows.iter().map(|r| r.left_out_norm)));
    Table { columns }
}

/// Reads the whole table.
///
/// # Errors
/// Missing columns, damaged blocks.
pub fn rows(reader: &TableReader) -> Result<Vec<Row>, Error> {
    let schema = schema();
    reader.require(&schema.columns)?;
    let names: Vec<&str> = schema.columns.iter().map(|c| c.name.as_str()).collect();
    let mut rows = Vec::with_capacity(reader.rows());
    for block in 0..reader.blocks() {
        let table = reader.read_block(block, &names)?;
        let text = |column: usize, row: usize| table.columns[column].text_at(row).unwrap_or("").to_owned();
        let number = |column: usize, row: usize| table.columns[column].value_at(row);
        let three = |first: usize, row: usize| -> Option<[f64; 3]> {
            Some([number(first, row)?, number(first + 1, row)?, number(first + 2, row)?])
        };
        rows.extend((0..reader.block_rows(block)).map(|row| Row {
            design: text(0, row),
            realization: table.columns[1].as_i32().map_or(0, |all| all[row]),
            picked: text(2, row),
            identified: text(3, row) != NOT_IDENTIFIABLE,
            rmse: three(4, row),
            error_norm: number(7, row),
            left_out_rmse: three(8, row),
            left_out_norm: number(11, row),
        }));
    }
    Ok(rows)
}
