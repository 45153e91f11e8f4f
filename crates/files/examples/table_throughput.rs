//! Writes and reads back a million rows on one thread, several times, and prints bytes of values per second of the best.
//!
//! `cargo run --release -p artifact --example table_throughput [FOLDER]`

use std::path::PathBuf;
use std::time::Instant;

use files::{Column, ColumnSpec, Kind, Provenance, Result, Table, TableReader, TableSchema, TableWriter};

const ROWS: usize = 1_000_000;
const BLOCK: usize = 1 << 16;
const FLOATS: usize = 13;
const INTEGERS: usize = 3;
const TEXTS: usize = 2;

/// The programs' own.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Turns, of which the best counts.
const TURNS: usize = 7;

fn main() -> Result<()> {
    let folder = std::env::args().nth(1).map_or_else(std::env::temp_dir, PathBuf::from);
    let path = folder.join("table_throughput.parquet");
    let schema = schema();
    let starts: Vec<usize> = (0..ROWS).step_by(BLOCK).collect();
    let tables: Vec<Table> = starts.iter().map(|&start| block(start, BLOCK.min(ROWS - start))).collect();
    let names: Vec<&str> = schema.columns.iter().map(|column| column.name.as_str()).collect();
    let mut best = [f64::INFINITY; 5];
    let mut note = |what: usize, clock: Instant| best[what] = best[what].min(clock.elapsed().as_secs_f64());
    for _ in 0..TURNS {
        let clock = Instant::now();
        tables.iter().try_for_each(|table| files::encode_block(&schema, table).map(drop))?;
        note(0, clock);
        let clock = Instant::now();
        let mut writer = TableWriter::create(&path, &schema, &Provenance::default())?;
        for table in &tables {
            writer.push(files::encode_block(&schema, table)?)?;
        }
        note(1, clock);
        files::commit(vec![writer.finish()?])?;
        note(2, clock);
        let clock = Instant::now();
        let reader = TableReader::open(&path, "throughput", 1)?;
        note(3, clock);
        for (i, written) in tables.iter().enumerate() {
            let table = reader.read_block(i, &names)?;
            assert_eq!(table.columns[0].len(), written.columns[0].len());
        }
        note(4, clock);
    }
    let told = ["encode", "encode, hash and write", "  and flush and rename", "open and check", "  and read"];
    told.iter().zip(best).for_each(|(what, seconds)| report(what, seconds));
    let size = std::fs::metadata(&path).map_or(0, |m| m.len());
    println!("file: {:.1} MB for {:.1} MB of values", size as f64 / 1e6, bytes() / 1e6);
    Ok(())
}

/// Bytes of values, a text counting as its 4-byte code.
fn bytes() -> f64 {
    (ROWS * (8 * FLOATS + 4 * INTEGERS + 4 * TEXTS)) as f64
}

fn report(what: &str, seconds: f64) {
    println!("{what}: {:.0} ms, {:.0} MB/s", seconds * 1e3, bytes() / seconds / 1e6);
}

fn schema() -> TableSchema {
    let spec = |prefix: &str, i: usize, kind: Kind| ColumnSpec {
        name: format!("{prefix}{i}"),
        unit: "1".to_owned(),
        kind,
        nullable: kind == Kind::F64 && i >= FLOATS - 3,
    };
    let floats = (0..FLOATS).map(|i| spec("x", i, Kind::F64));
    let integers = (0..INTEGERS).map(|i| spec("n", i, Kind::I32));
    let texts = (0..TEXTS).map(|i| spec("t", i, Kind::Text));
    TableSchema { id: "throughput", version: 1, columns: floats.chain(integers).chain(texts).collect() }
}

/// Smooth signals, every other one noisy; run, segment and sample numbers; labels of segments.
fn block(start: usize, rows: usize) -> Table {
    let mut noise = 0x9e37_79b9_7f4a_7c15_u64;
    let mut signal = |i: usize, row: usize| {
        noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let random = (noise >> 11) as f64 / (1_u64 << 53) as f64;
        (row as f64 * 1e-3 * (i + 1) as f64).sin() + if i.is_multiple_of(2) { random } else { 0.0 }
    };
    let float = |i: usize| {
        let values = (start..start + rows).map(|row| signal(i, row)).collect();
        let last = |row: usize| (start + row) % 1001 == 1000;
        match i >= FLOATS - 3 {
            true => Column::nullable_f64(values, (0..rows).map(|row| !last(row)).collect()),
            false => Column::f64(values),
        }
    };
    let mut columns: Vec<Column> = (0..FLOATS).map(float).collect();
    let integer =
        |f: &dyn Fn(usize) -> usize| Column::i32((start..start + rows).map(|row| f(row) as i32).collect());
    columns.extend([integer(&|row| row / 1001), integer(&|row| row / 200 % 5), integer(&|row| row % 1001)]);
    let labels = || (0..11).map(|i| format!("maneuver {i}")).collect();
    let text = |every: usize| {
        Column::text(labels(), (start..start + rows).map(|row| (row / every % 11) as u32).collect())
    };
    columns.extend([text(200), text(100_000)]);
    Table { columns }
}
