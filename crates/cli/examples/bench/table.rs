//! Writing and reading trajectories.

use std::path::Path;

use files::{Column, Provenance, Table, TableReader, TableSchema, TableWriter, commit, encode_block};
use serde_json::{Value, json};
use ship::engine::Streams;
use study::trajectories::{ID, Layout, VERSION};

use crate::paper::Paper;
use crate::timing::fastest;

const ROWS: usize = 1_000_000;
const BLOCK: usize = 65_000;

/// Turns of writing and of reading, the best of which counts.
const TURNS: usize = 7;

/// Seconds to write and to read a million rows of trajectories.
pub fn measure(paper: &Paper) -> anyhow::Result<Value> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("trajectories.parquet");
    let schema = Layout::new(&paper.vessel.model).schema();
    let names: Vec<&str> = schema.columns.iter().map(|c| c.name.as_str()).collect();
    let tables = blocks();
    let (write_s, ()) = fastest(TURNS, || write_blocks(&path, &schema, &tables))?;
    let (read_s, rows) = fastest(TURNS, || {
        let reader = TableReader::open(&path, ID, VERSION)?;
        let mut rows = 0;
        for i in 0..reader.blocks() {
            rows += reader.read_block(i, &names)?.columns[5].as_f64().map_or(0, <[f64]>::len);
        }
        Ok(rows)
    })?;
    anyhow::ensure!(rows == ROWS, "{rows} rows read");
    Ok(json!({
        "rows": ROWS,
        "raw_bytes": ROWS * (8 * 13 + 4 * 5),
        "write_s": write_s,
        "read_s": read_s,
        "file_bytes": std::fs::metadata(&path)?.len(),
    }))
}

/// Writes that table, so that a peer is measured on the same rows.
pub fn write(paper: &Paper, path: &Path) -> anyhow::Result<()> {
    write_blocks(path, &Layout::new(&paper.vessel.model).schema(), &blocks())
}

fn write_blocks(path: &Path, schema: &TableSchema, tables: &[Table]) -> anyhow::Result<()> {
    let mut writer = TableWriter::create(path, schema, &Provenance::default())?;
    for table in tables {
        writer.push(encode_block(schema, table)?)?;
    }
    Ok(commit(vec![writer.finish()?])?)
}

fn blocks() -> Vec<Table> {
    (0..ROWS).step_by(BLOCK).map(|start| block(start, BLOCK.min(ROWS - start))).collect()
}

/// Rows as a campaign has them: runs of 1001 samples; 3 piecewise constant inputs, 6 noisy and 4 smooth columns.
fn block(start: usize, rows: usize) -> Table {
    let streams = Streams::new(1, "table");
    let row = |f: fn(usize) -> f64| Column::f64((start..start + rows).map(f).collect());
    let integer = |f: fn(usize) -> usize| Column::i32((start..start + rows).map(|r| f(r) as i32).collect());
    let text = |labels: &[&str], every: usize| {
        let codes = (start..start + rows).map(|r| (r / every % labels.len()) as u32).collect();
        Column::text(labels.iter().map(|l| (*l).to_owned()).collect(), codes)
    };
    let noise = |channel: u32| {
        let mut values = vec![0.0; rows];
        streams.normals(start as u32, channel, &mut values);
        Column::f64(values)
    };
    let maneuvers = ["decelerate", "zig-zag-slow-steep", "zig-zag-fast-steep", "spiral-fast"];
    let input = |every: usize| {
        let values = (start..start + rows).map(|r| (r / every % 7) as f64 * 250.0).collect();
        Column::nullable_f64(values, (start..start + rows).map(|r| r % 1001 != 1000).collect())
    };
    let mut columns = vec![
        text(&["optimized", "random"], 500_500),
        integer(|r| r / 1001),
        integer(|r| r % 1001 / 250),
        text(&maneuvers, 250),
        integer(|r| r % 1001),
        row(|r| (r % 1001) as f64 / 8.0),
        input(200),
        input(40),
        input(40),
    ];
    columns.extend((0..6).map(noise));
    columns.push(row(|r| (r as f64 * 1e-3).sin()));
    columns.push(row(|r| (r as f64 * 2e-3).cos()));
    columns.push(row(|r| (r % 1001) as f64 * 1e-2));
    Table { columns }
}
