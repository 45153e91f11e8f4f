//! Parquet as other programs write it: times and numbers of any type, compressed in any way.

use std::fs;
use std::sync::Arc;

use parquet::basic::{BrotliLevel, Compression, ZstdLevel};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::{ByteArray, FixedLenByteArray, Int96};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

use crate::known::*;
use crate::runner::*;
use crate::silent::{Faulty, none_is_silent};

/// A column.
enum Of {
    I32(Vec<i32>),
    I64(Vec<i64>),
    I96(Vec<Int96>),
    F64(Vec<f64>),
    Bytes(Vec<ByteArray>),
    Fixed(Vec<FixedLenByteArray>),
}

fn table(types: &[&str], columns: &[Of], compression: Compression) -> Vec<u8> {
    let fields: String = types.iter().map(|kind| format!("REQUIRED {kind};")).collect();
    let schema = Arc::new(parse_message_type(&format!("message log {{ {fields} }}")).unwrap());
    let properties = WriterProperties::builder().set_compression(compression).build();
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties)).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for column in columns {
        let mut chunk = group.next_column().unwrap().unwrap();
        let written = match (chunk.untyped(), column) {
            (ColumnWriter::Int32ColumnWriter(to), Of::I32(values)) => to.write_batch(values, None, None),
            (ColumnWriter::Int64ColumnWriter(to), Of::I64(values)) => to.write_batch(values, None, None),
            (ColumnWriter::Int96ColumnWriter(to), Of::I96(values)) => to.write_batch(values, None, None),
            (ColumnWriter::DoubleColumnWriter(to), Of::F64(values)) => to.write_batch(values, None, None),
            (ColumnWriter::ByteArrayColumnWriter(to), Of::Bytes(values)) => {
                to.write_batch(values, None, None)
            }
            (ColumnWriter::FixedLenByteArrayColumnWriter(to), Of::Fixed(values)) => {
                to.write_batch(values, None, None)
            }
            _ => panic!("a column of another type"),
        };
        written.unwrap();
        chunk.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
    bytes
}

/// Seconds since 1970 of the first row.
const START: i64 = 1_744_373_300;

/// What is said of a time's type, and the times.
fn times(kind: &str) -> (String, Of) {
    let of = |per_second: i64, start: i64| Of::I64((0..=60).map(|k| (start + k) * per_second).collect());
    let evening = 86_400 - 30;
    match kind {
        "ms" => ("INT64 t (TIMESTAMP(MILLIS,true))".into(), of(1000, START)),
        "us" => ("INT64 t (TIMESTAMP(MICROS,true))".into(), of(1_000_000, START)),
        "ns" => ("INT64 t (TIMESTAMP(NANOS,false))".into(), of(1_000_000_000, START)),
        "time" => {
            let times = (0..=60).map(|k| ((evening + k) % 86_400) * 1_000_000).collect();
            ("INT64 t (TIME(MICROS,true))".into(), Of::I64(times))
        }
        "int96" => {
            let moment = |k: i64| {
                let (day, ns) = ((START + k) / 86_400 + 2_440_588, (START + k) % 86_400 * 1_000_000_000);
                let mut moment = Int96::new();
                moment.set_data(ns as u32, (ns >> 32) as u32, day as u32);
                moment
            };
            ("INT96 t".into(), Of::I96((0..=60).map(moment).collect()))
        }
        _ => ("INT32 t (DATE)".into(), Of::I32((0..=60).collect())),
    }
}

/// The healthy motion with these times; `numbers` says how column `i` is stored.
fn motion_with(time: (String, Of), compression: Compression) -> Vec<u8> {
    let column = |i: usize| rows(60).iter().map(|row| row[i]).collect::<Vec<f64>>();
    let mut types = vec![time.0];
    types.extend(COLUMNS.map(|name| format!("DOUBLE {name}")));
    let types: Vec<&str> = types.iter().map(String::as_str).collect();
    let columns: Vec<Of> = [time.1].into_iter().chain((0..6).map(|i| Of::F64(column(i)))).collect();
    table(&types, &columns, compression)
}

fn read_with(time: &str, bytes: &[u8]) -> Made {
    // Numbers beyond those of 31 bits are tried, too.
    let config = table_config("*.parquet", time, "").replace("\"rpm\"", "\"rpm\", valid = [0.0, 5e9]");
    let folder = folder(&[("ingest.toml", &config)]);
    fs::write(folder.path().join("a.parquet"), bytes).unwrap();
    read(folder.path())
}

#[track_caller]
fn refused_with(time: &str, bytes: &[u8], pieces: &[&str]) {
    let folder = folder(&[("ingest.toml", &table_config("*.parquet", time, ""))]);
    fs::write(folder.path().join("a.parquet"), bytes).unwrap();
    refused_in(folder.path(), &[], pieces);
}

#[test]
fn the_type_of_a_column_of_times_tells_what_they_count() {
    for kind in ["ms", "us", "ns", "int96", "time"] {
        let bytes = motion_with(times(kind), Compression::UNCOMPRESSED);
        println!("{kind}");
        healthy(&read_with("unit = \"iso8601\"", &bytes), 61);
        let other = if kind == "ms" { "s" } else { "ms" };
        let pieces = ["a.parquet: column `t`", "by their type", "iso8601"];
        refused_with(&format!("unit = \"{other}\""), &bytes, &pieces);
        refused_with("format = \"%H:%M\"", &bytes, &pieces);
    }
    let own = motion_with(times("us"), Compression::UNCOMPRESSED);
    healthy(&read_with("unit = \"us\"", &own), 61);
    let days = motion_with(times("date"), Compression::UNCOMPRESSED);
    refused_with("unit = \"iso8601\"", &days, &["a.parquet: column `t`", "days without a time"]);
}

#[test]
fn times_as_clocks_showed_them_are_of_the_stated_zone() {
    // On 2025-10-26 at 01:00 UTC clocks in Helsinki were set back from 04:00 to 03:00.
    let shown = |first: i64| {
        let times = (0..=60).map(|k| (first + k) * 1_000_000_000).collect();
        motion_with(("INT64 t (TIMESTAMP(NANOS,false))".into(), Of::I64(times)), Compression::UNCOMPRESSED)
    };
    let zone = "unit = \"iso8601\", zone = \"Europe/Helsinki\"";
    let change = 1_761_440_400;
    healthy(&read_with(zone, &shown(change + 3600)), 61);
    refused_with(zone, &shown(change + 2 * 3600 - 30), &["line 31, column `t`", "showed twice"]);
}

#[test]
fn numbers_of_any_type_are_read() {
    let values = |i: usize| rows(60).into_iter().map(move |row| row[i]);
    let half = |value: f64| {
        // Numbers of 16 bits, from 2^-14 on.
        let (exponent, sign) = (value.abs().log2().floor(), u16::from(value < 0.0) << 15);
        let fraction = ((value.abs() / exponent.exp2() - 1.0) * 1024.0).round();
        let bits = if value == 0.0 { 0 } else { sign + ((exponent + 15.0) as u16 * 1024) + fraction as u16 };
        FixedLenByteArray::from(bits.to_le_bytes().to_vec())
    };
    let wide = |value: f64| ((value * 1e6).round() as i64).to_be_bytes().to_vec();
    let types = [
        "INT64 t (TIMESTAMP(MILLIS,true))",
        "INT32 u (DECIMAL(9,6))",
        "FIXED_LEN_BYTE_ARRAY (8) v (DECIMAL(18,6))",
        "FIXED_LEN_BYTE_ARRAY (2) r (FLOAT16)",
        "BINARY psi (DECIMAL(18,6))",
        "INT64 delta (DECIMAL(18,6))",
        "INT32 n (INTEGER(32,false))",
    ];
    let columns = [
        times("ms").1,
        Of::I32(values(0).map(|value| (value * 1e6).round() as i32).collect()),
        Of::Fixed(values(1).map(|value| wide(value).into()).collect()),
        Of::Fixed(values(2).map(half).collect()),
        Of::Bytes(values(3).map(|value| wide(value).into()).collect()),
        Of::I64(values(4).map(|value| (value * 1e6).round() as i64).collect()),
        Of::I32(values(5).map(|value| (value as u32).wrapping_add(3_000_000_000) as i32).collect()),
    ];
    let bytes = table(&types, &columns, Compression::UNCOMPRESSED);
    let made = read_with("unit = \"iso8601\"", &bytes);
    healthy(&made, 61);
    let delta = made.f64("delta");
    assert!((0..60).all(|k| (delta[k] - rudder(k as f64).to_radians()).abs() < 1e-7), "{delta:?}");
    let n = made.f64("n");
    assert!((0..60).all(|k| n[k] >= 5e7 && (n[k] * 60.0 - 3e9 - revolutions(k as f64)).abs() < 1.0), "{n:?}");
}

#[test]
fn files_compressed_in_any_way_are_read() {
    let zstd = Compression::ZSTD(ZstdLevel::default());
    let brotli = Compression::BROTLI(BrotliLevel::default());
    for compression in [Compression::SNAPPY, Compression::LZ4_RAW, zstd, brotli] {
        println!("{compression}");
        healthy(&read_with("unit = \"iso8601\"", &motion_with(times("us"), compression)), 61);
    }
}

#[test]
fn damaged_pages_are_refused_as_damaged() {
    let zstd = Compression::ZSTD(ZstdLevel::default());
    for compression in [Compression::SNAPPY, zstd, Compression::BROTLI(BrotliLevel::default())] {
        let whole = motion_with(times("us"), compression);
        for place in (40..whole.len() / 2).step_by(97) {
            let mut bytes = whole.clone();
            bytes[place..place + 8].iter_mut().for_each(|byte| *byte ^= 0xA5);
            let folder = folder(&[("ingest.toml", &table_config("*.parquet", "unit = \"iso8601\"", ""))]);
            fs::write(folder.path().join("a.parquet"), bytes).unwrap();
            let ran = run(folder.path(), &["--config", "ingest.toml", "--out", "t.parquet"]);
            assert!(matches!(ran.code, Some(0 | 3)), "{place}: {}", ran.stderr);
        }
    }
}

#[test]
fn law_a_fault_of_a_table_in_parquet_is_never_silent() {
    let tally = none_is_silent(112, |draw| {
        let kinds = [("MILLIS", 1000_i64), ("MICROS", 1_000_000), ("NANOS", 1_000_000_000)];
        let (kind, per_second) = kinds[draw.below(3)];
        let (at, count, column) = (draw.between(1, 54), draw.between(1, 6), draw.below(6));
        let mut times: Vec<i64> = (0..=60).map(|k| (START + k) * per_second).collect();
        let mut columns: [Vec<f64>; 6] = std::array::from_fn(|i| rows(60).iter().map(|row| row[i]).collect());
        let fault = draw.below(6);
        match fault {
            0 => {
                drop(times.drain(at..at + count));
                columns.iter_mut().for_each(|own| drop(own.drain(at..at + count)));
            }
            1 => times[at..at + count + 1].reverse(),
            2 => times[at] = times[at - 1],
            3 => times[at] = [0, i64::MIN, i64::MAX][count % 3],
            4 => columns[column][at] = [f64::NAN, f64::INFINITY, -1e38, 65535.0, -9999.0, 1e300][count % 6],
            _ => times.iter_mut().for_each(|t| *t /= 1000),
        }
        let mut types = vec![format!("INT64 t (TIMESTAMP({kind},true))")];
        types.extend(COLUMNS.map(|name| format!("DOUBLE {name}")));
        let types: Vec<&str> = types.iter().map(String::as_str).collect();
        let all: Vec<Of> = [Of::I64(times)].into_iter().chain(columns.map(Of::F64)).collect();
        let log = table(&types, &all, Compression::UNCOMPRESSED);
        let policy = ["", "non_monotonic = \"drop\"", "non_monotonic = \"sort\""][draw.below(3)];
        let config = table_config("*.parquet", "unit = \"iso8601\"", policy);
        let named = &[
            "splits",
            "backwards",
            "sorted",
            "repeated",
            "unset",
            "time",
            "no value",
            "y_",
            "psi",
            "delta",
            "n ",
        ];
        Faulty::new(&config, "a.parquet", log, 61)
            .named(named)
            .what(format!("{kind}, fault {fault}, row {at}, {count}"))
    });
    assert!(tally.refused > 0 && tally.counted > 0, "{tally:?}");
}
