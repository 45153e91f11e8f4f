//! Small logs and charts in every supported format, and the stages that read them: foreign files are read within
//! limits of time and memory, whatever their contents.

use std::fs;
use std::path::Path;
use std::sync::{Arc, LazyLock};

use parquet::basic::{Compression, GzipLevel, ZstdLevel};
use parquet::data_type::DoubleType;
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaDataReader, ParquetMetaDataWriter};
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use tempfile::TempDir;

use crate::damage::{Draw, damaged, damaged_bytes};
use crate::grounds::{Ground, Stage, files, stage};
use crate::made::catalogue;
use crate::places::Place;
use crate::planned::{ISLAND, SMALL};
use crate::support::{DICTIONARY, craft, put, repository, run};

/// Processor time of a case \[s\].
const SECONDS: u32 = 5;

const fn log(line: &'static str, reads: &'static [&'static str]) -> Stage {
    stage(line, "t.parquet", ["", ""], reads)
}

const fn chart(line: &'static str, reads: &'static [&'static str]) -> Stage {
    stage(line, "plan.json", ["", ""], reads)
}

macro_rules! ingest {
    ($folder:literal, $($file:literal),+) => {
        log(
            concat!("ingest --config ", $folder, "/ingest.toml --logs ", $folder, " --memory-mib 256"),
            &[$(concat!($folder, "/", $file)),+],
        )
    };
}

macro_rules! plan {
    ($folder:literal, $($file:literal),+) => {
        chart(
            concat!(
                "plan --vessel vessel.toml --trajectories dictionary.parquet --time-limit-s 4 --memory-mib 512 --config ",
                $folder,
                "/plan.toml"
            ),
            &[$(concat!($folder, "/", $file)),+],
        )
    };
}

/// Mostly a data file is damaged, rarely its configuration.
static STAGES: [Stage; 22] = [
    ingest!("csv", "a.csv", "a.csv", "a.csv", "ingest.toml"),
    ingest!("dated", "a.csv", "a.csv", "ingest.toml"),
    ingest!("gz", "a.csv.gz"),
    ingest!("nmea", "a.nmea", "a.nmea", "a.nmea", "ingest.toml"),
    ingest!("plain", "a.parquet"),
    ingest!("snappy", "a.parquet"),
    ingest!("gzip", "a.parquet"),
    ingest!("zstd", "a.parquet"),
    ingest!("bag", "a.mcap", "a.mcap", "a.mcap", "ingest.toml"),
    ingest!("chunks", "a.mcap"),
    plan!("asc", "a.asc", "a.asc", "a.asc", "plan.toml"),
    plan!("projected", "a.tif"),
    plan!("degrees", "a.tif"),
    plan!("land", "a.geojson", "a.geojson", "plan.toml"),
    plan!("cell", "ZZ5BAY01.000", "ZZ5BAY01.000", "ZZ5BAY01.001", "ZZ5BAY01.002"),
    plan!("areas", "a.geojson"),
    plan!("set", "ENC_ROOT/CATALOG.031", "ENC_ROOT/CATALOG.031", "ENC_ROOT/ZZ5BAY01/ZZ5BAY01.001"),
    ingest!("ros1", "a.bag", "a.bag", "a.bag", "ingest.toml"),
    ingest!("ros2", "a.db3", "a.db3", "a.db3", "ingest.toml"),
    ingest!("px4", "a.ulg", "a.ulg", "a.ulg", "ingest.toml"),
    ingest!("checked", "a.parquet"),
    ingest!("closed", "a.mcap"),
];

/// The ground of all readers, made once.
pub static READERS: LazyLock<[Ground; 1]> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    logs(folder.path());
    charts(&folder);
    [Ground { stages: &STAGES, files: files(folder.path()), seconds: Some(SECONDS) }]
});

/// Writes a file below `folder`.
fn write(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, bytes).unwrap();
}

/// The logs: columns in SI units, one row per second.
const COLUMNS: [&str; 5] = ["t", "u", "v", "r", "n"];

fn rows() -> Vec<[f64; 5]> {
    let row = |second: i32| {
        let t = f64::from(second);
        [
            t,
            2.0 + 0.4 * (0.11 * t).sin(),
            0.2 * (0.17 * t).sin(),
            0.08 * (0.13 * t).cos(),
            8.0 + (0.3 * t).sin(),
        ]
    };
    (0..40).map(row).collect()
}

/// How to read the columns from files `pattern`.
fn config(pattern: &str, time: &str, file: &str) -> String {
    let channel = |(column, channel, unit): (&str, &str, &str)| {
        format!("[[file.channel]]\ncolumn = \"{column}\"\nchannel = \"{channel}\"\nunit = \"{unit}\"\n")
    };
    let channels =
        [("u", "y_u", "m/s"), ("v", "y_v", "m/s"), ("r", "y_r", "rad/s"), ("n", "n", "1/s")].map(channel);
    format!(
        "sample_rate_hz = 1.0\nmax_gap_s = 2.5\n[[file]]\npattern = [\"{pattern}\"]\ntime = {{ {time} }}\n{file}{}",
        channels.concat()
    )
}

fn logs(folder: &Path) {
    let line = |t: &str, row: &[f64; 5]| format!("{t},{},{},{},{}\n", row[1], row[2], row[3], row[4]);
    let header = COLUMNS.join(",") + "\n";
    let csv = rows().iter().map(|row| line(&row[0].to_string(), row)).collect::<String>();
    write(folder, "csv/a.csv", header.clone() + &csv);
    write(folder, "csv/ingest.toml", config("*.csv", "column = \"t\", unit = \"s\"", ""));
    let dated =
        rows().iter().map(|row| line(&format!("2025-04-11T09:08:{:02}Z", row[0]), row)).collect::<String>();
    write(folder, "dated/a.csv", header.clone() + &dated);
    write(folder, "dated/ingest.toml", config("*.csv", "column = \"t\", unit = \"iso8601\"", ""));
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    std::io::Write::write_all(&mut packed, (header + &csv).as_bytes()).unwrap();
    write(folder, "gz/a.csv.gz", packed.finish().unwrap());
    write(folder, "gz/ingest.toml", config("*.csv.gz", "column = \"t\", unit = \"s\"", ""));
    let survey = repository().join("fixtures/field/survey");
    let sentences = fs::read_to_string(survey.join("line.nmea")).unwrap();
    let few: Vec<&str> = sentences.lines().take(400).collect();
    write(folder, "nmea/a.nmea", few.join("\r\n"));
    write(folder, "nmea/ingest.toml", fs::read(survey.join("ingest.toml")).unwrap());
    for (name, compression) in [
        ("plain", Compression::UNCOMPRESSED),
        ("snappy", Compression::SNAPPY),
        ("gzip", Compression::GZIP(GzipLevel::default())),
        ("zstd", Compression::ZSTD(ZstdLevel::default())),
    ] {
        write(folder, &format!("{name}/a.parquet"), parquet(compression));
        let config = config("*.parquet", "column = \"t\", unit = \"s\"", "");
        write(folder, &format!("{name}/ingest.toml"), config);
    }
    write(folder, "checked/a.parquet", with_page_checksums(&parquet(Compression::UNCOMPRESSED)));
    write(folder, "checked/ingest.toml", config("*.parquet", "column = \"t\", unit = \"s\"", ""));
    let time = ["column = \"log_time\"", "topic = \"/speeds\"\n"];
    for (name, is_checked) in [("bag", false), ("closed", true)] {
        write(folder, &format!("{name}/a.mcap"), bag(is_checked));
        write(folder, &format!("{name}/ingest.toml"), config("*.mcap", time[0], time[1]));
    }
    write(
        folder,
        "chunks/a.mcap",
        fs::read(repository().join("fixtures/field/robot/short-lz4.mcap")).unwrap(),
    );
    write(folder, "chunks/ingest.toml", config("*.mcap", time[0], time[1]));
    robots(folder);
}

/// Bags of the field, each with the `ingest.toml` that was made for it.
fn robots(folder: &Path) {
    let field = repository().join("fixtures/field");
    for (set, name, end) in
        [("ros1", "short-lz4.bag", "bag"), ("ros2", "mission_0.db3", "db3"), ("px4", "mission.ulg", "ulg")]
    {
        write(folder, &format!("{set}/a.{end}"), fs::read(field.join(set).join(name)).unwrap());
        let text = fs::read_to_string(field.join(set).join("ingest.toml")).unwrap();
        write(folder, &format!("{set}/ingest.toml"), text.replace("{run}_*.db3", "{run}.db3"));
    }
}

fn parquet(compression: Compression) -> Vec<u8> {
    let columns = COLUMNS.map(|name| format!("required double {name};")).concat();
    let schema = Arc::new(parse_message_type(&format!("message schema {{ {columns} }}")).unwrap());
    let properties = WriterProperties::builder().set_compression(compression).set_dictionary_enabled(false);
    let properties =
        properties.set_statistics_enabled(EnabledStatistics::None).set_offset_index_disabled(true).build();
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, properties.into()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for place in 0..COLUMNS.len() {
        let values: Vec<f64> = rows().iter().map(|row| row[place]).collect();
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<DoubleType>().write_batch(&values, None, None).unwrap();
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
    bytes
}

/// A table of uncompressed columns of one page, each with the checksum that other programs give it.
fn with_page_checksums(bytes: &[u8]) -> Vec<u8> {
    let end = bytes.len() - 8;
    let footer = end - u32::from_le_bytes(bytes[end..end + 4].try_into().unwrap()) as usize;
    let metadata = ParquetMetaDataReader::decode_metadata(&bytes[footer..end]).unwrap();
    let mut made = bytes[..4].to_vec();
    let column = |column: &ColumnChunkMetaData| {
        let (start, length) = (column.data_page_offset() as usize, column.compressed_size() as usize);
        let (header, page) = bytes[start..start + length].split_at(length - 8 * rows().len());
        let at = made.len();
        // Behind the kind of page and two sizes, before what is special to data.
        made.extend([&header[..8], &[0x15]].concat());
        assert_eq!(header[8], 0x2c, "{header:?}");
        let crc = crc(page) as i32;
        let mut crc = ((crc << 1) ^ (crc >> 31)) as u32;
        while crc >= 0x80 {
            made.push(crc as u8 | 0x80);
            crc >>= 7;
        }
        made.extend([&[crc as u8, 0x1c], &header[9..], page].concat());
        let length = (made.len() - at) as i64;
        let column = column.clone().into_builder().set_data_page_offset(at as i64);
        column.set_total_compressed_size(length).set_total_uncompressed_size(length).build().unwrap()
    };
    let group = metadata.row_group(0).clone();
    let columns = group.columns().iter().map(column).collect();
    let group = group.into_builder().set_column_metadata(columns).build().unwrap();
    let metadata = metadata.into_builder().set_row_groups(vec![group]).build();
    ParquetMetaDataWriter::new(&mut made, &metadata).finish().unwrap();
    made
}

fn crc(bytes: &[u8]) -> u32 {
    let mut crc = flate2::Crc::new();
    crc.update(bytes);
    crc.sum()
}

/// A bag without chunks: no checksum hides damage, unless one of all messages `is_checked`.
fn bag(is_checked: bool) -> Vec<u8> {
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let record = |kind: u8, body: Vec<u8>| [&[kind][..], &(body.len() as u64).to_le_bytes(), &body].concat();
    let definition = "# Speeds\nfloat64 u\nfloat64 v\nfloat64 r\nfloat64 n\nstd/Part[2] parts\nstring name\n\
                      ================================================================================\n\
                      MSG: std/Part\nuint8 kind\nfloat32[] values\n";
    let mut bytes = b"\x89MCAP0\r\n".to_vec();
    bytes.extend(record(1, [text("ros2"), text("a test")].concat()));
    let schema = [&[1, 0][..], &text("std/Speeds"), &text("ros2msg"), &text(definition)].concat();
    bytes.extend(record(3, schema));
    bytes.extend(record(4, [&[1, 0, 1, 0][..], &text("/speeds"), &text("cdr"), &[0; 4]].concat()));
    for (i, row) in rows().iter().enumerate() {
        let mut data = vec![0, 1, 0, 0];
        row[1..].iter().for_each(|value| data.extend(value.to_le_bytes()));
        // Two parts of a kind, padding, and a value each; a name with its end.
        data.extend([1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 128, 63, 2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 64]);
        data.extend([2, 0, 0, 0, b'a', 0]);
        let time = (1_744_362_500_000_000_000 + i as u64 * 1_000_000_000).to_le_bytes();
        let message = [&[1, 0][..], &(i as u32).to_le_bytes(), &time, &time, &data].concat();
        bytes.extend(record(5, message));
    }
    let crc = if is_checked { crc(&bytes) } else { 0 };
    bytes.extend(record(15, crc.to_le_bytes().to_vec()));
    bytes.extend(record(2, vec![0; 20]));
    bytes.extend(b"\x89MCAP0\r\n");
    bytes
}

/// A start without enough depth: the plan is refused as soon as its chart is read.
fn plan_toml(chart: &str) -> String {
    let chart = SMALL.replace("file = \"land.geojson\"\nkind = \"land\"", chart);
    let deep = "margin_m = 20.0\ntransit_depth_m = 500.0\ntrial_depth_m = 500.0";
    chart.replace("margin_m = 20.0", deep).replace("longitude_deg = 24.985", "longitude_deg = 25.0")
}

fn charts(folder: &TempDir) {
    let (top, fixtures) = (folder.path(), repository().join("fixtures/charts"));
    fs::copy(repository().join("pipelines/helsinki/vessel.toml"), top.join("vessel.toml")).unwrap();
    fs::copy(
        repository().join("fixtures/dictionaries/dictionary-zig-zags.toml"),
        top.join("dictionary.toml"),
    )
    .unwrap();
    run(folder, DICTIONARY).succeeds();
    for (name, file, fixture, keys) in [
        ("projected", "a.tif", "grids/depth_utm.tif", "kind = \"depth\""),
        ("degrees", "a.tif", "grids/elevation_point.tif", "kind = \"elevation\""),
        ("cell", "ZZ5BAY01.000", "enc/ZZ5BAY01.000", ""),
        ("areas", "a.geojson", "enc/ZZ5BAY01_DEPARE.geojson", "kind = \"depth\""),
    ] {
        write(top, &format!("{name}/{file}"), fs::read(fixtures.join(fixture)).unwrap());
        write(top, &format!("{name}/plan.toml"), plan_toml(&format!("file = \"{file}\"\n{keys}")));
    }
    for update in ["001", "002"] {
        let bytes = fs::read(fixtures.join(format!("enc/ZZ5BAY01.{update}"))).unwrap();
        write(top, &format!("cell/ZZ5BAY01.{update}"), bytes);
    }
    let mut listed = vec![("CATALOG.031".to_owned(), String::new())];
    for suffix in ["000", "001", "002"] {
        let bytes = fs::read(fixtures.join(format!("enc/ZZ5BAY01.{suffix}"))).unwrap();
        listed.push((format!("ZZ5BAY01\\ZZ5BAY01.{suffix}"), format!("{:08X}", chart::enc::crc(&bytes))));
        write(top, &format!("set/ENC_ROOT/ZZ5BAY01/ZZ5BAY01.{suffix}"), bytes);
    }
    let listed: Vec<(&str, &str)> = listed.iter().map(|(file, crc)| (file.as_str(), crc.as_str())).collect();
    write(top, "set/ENC_ROOT/CATALOG.031", catalogue(&listed));
    write(top, "set/plan.toml", plan_toml("file = \"ENC_ROOT\""));
    write(top, "land/a.geojson", ISLAND);
    write(top, "land/plan.toml", plan_toml("file = \"a.geojson\"\nkind = \"land\""));
    write(top, "asc/a.asc", crate::grounds::grid());
    write(top, "asc/plan.toml", plan_toml("file = \"a.asc\"\nkind = \"depth\"\ncrs = \"EPSG:32635\""));
    put(folder, "README", "Logs and charts of tests.\n");
}

/// A foreign file in place of `bytes`.
pub fn strange(draw: &mut Draw, name: &str, bytes: &[u8]) -> Vec<u8> {
    let is_text = [".csv", ".asc", ".toml", ".geojson"].iter().any(|end| name.ends_with(end));
    match draw.below(8) {
        0 => damaged_bytes(draw, bytes.to_vec()),
        _ if is_text => damaged(draw, name, bytes),
        _ if name.ends_with(".nmea") => with_checksums(&damaged(draw, "a.csv", bytes)),
        1..=3 => (0..=draw.below(8)).fold(bytes.to_vec(), |bytes, _| damaged_bytes(draw, bytes)),
        _ => (0..=draw.below(3)).fold(bytes.to_vec(), |bytes, _| with_number(draw, bytes)),
    }
}

/// A number that stands for a length, a count or a place becomes another.
fn with_number(draw: &mut Draw, mut bytes: Vec<u8>) -> Vec<u8> {
    const NUMBERS: [u64; 12] =
        [0, 1, 2, 0x7f, 0xff, 0xffff, 0x7fff_ffff, 0xffff_fff0, 0xffff_ffff, 1 << 32, 1 << 62, u64::MAX];
    let number = NUMBERS[draw.below(NUMBERS.len())];
    let width = [1, 2, 4, 8][draw.below(4)].min(bytes.len());
    let at = draw.below(bytes.len() + 1 - width);
    let (little, big) = (number.to_le_bytes(), number.to_be_bytes());
    let number = if draw.below(2) == 0 { &little[..width] } else { &big[8 - width..] };
    bytes[at..at + width].copy_from_slice(number);
    bytes
}

/// The sentences of a log with the checksums that they have now.
fn with_checksums(bytes: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(bytes);
    let line =
        |line: &str| match line.trim_end().rsplit_once('*').and_then(|(body, _)| body.strip_prefix('$')) {
            Some(body) => format!("${body}*{:02X}\r\n", body.bytes().fold(0, |sum, byte| sum ^ byte)),
            None => format!("{line}\n"),
        };
    text.lines().map(line).collect::<String>().into_bytes()
}

#[test]
fn healthy_logs_and_charts_of_every_format_are_read() {
    for stage in &STAGES {
        let place = Place::on(&READERS[0]);
        let line = stage.line_into("out/");
        let ended = crate::ends::wait(&place, crate::ends::start(&place, &line, ""));
        let code = ended.status.and_then(|status| status.code());
        if stage.out == "t.parquet" {
            assert_eq!(code, Some(0), "{line}: {}", ended.told);
        } else {
            assert!(
                matches!(code, Some(3 | 4)) && ended.told.contains("plan.toml: "),
                "{line}: {}",
                ended.told
            );
        }
    }
}

/// Folders of logs of which every byte that matters has a checksum.
const CHECKED: [&str; 4] = ["gz", "checked", "closed", "chunks"];

#[test]
fn law_flipped_bits_are_refused_or_change_nothing_where_there_is_a_checksum() {
    let mut place = Place::on(&READERS[0]);
    let mut silent = Vec::new();
    for (kind, folder) in CHECKED.into_iter().enumerate() {
        let stage = STAGES.iter().find(|stage| stage.reads[0].starts_with(&format!("{folder}/"))).unwrap();
        let (name, line) = (stage.reads[0], stage.line_into("out/"));
        let contents = |place: &Place| {
            let code = crate::ends::ends(place, &line).unwrap();
            let made = || craft::read(&place.path().join("out/t.parquet"), "trajectories").blocks;
            (code == 0).then(|| format!("{:?}", made()))
        };
        let healthy = contents(&place);
        assert!(healthy.is_some(), "{folder}");
        place.restore();
        let (mut refused, count) = (0, crate::asked().map_or(12, |cases| cases / 100));
        for case in 0..count {
            let mut draw = Draw::of(70 + kind as u64, case);
            let mut bytes = place.original(name).to_vec();
            let at = draw.below(bytes.len());
            bytes[at] ^= 1 << draw.below(8);
            place.put(name, &bytes);
            match contents(&place) {
                None => refused += 1,
                changed if changed != healthy => silent.push(format!("{name}, byte {at}")),
                _ => {}
            }
            place.restore();
        }
        println!("{name}: {refused} of {count} flipped bits refused");
        assert!(refused > 0, "{name}");
    }
    assert!(silent.is_empty(), "silent: {silent:?}");
}

/// Logs and charts that caused bugs of other tools or of this one, if available: each folder of SEATRIAL_CORPUS has
/// an `ingest.toml` or a `plan.toml`.
#[test]
fn what_is_kept_elsewhere_is_read_within_its_means() {
    let Ok(corpus) = std::env::var("SEATRIAL_CORPUS") else {
        return println!("nothing tried: SEATRIAL_CORPUS names no folder of cases");
    };
    let mut tally = crate::ends::Tally::default();
    for entry in fs::read_dir(corpus).unwrap() {
        let case = entry.unwrap().path();
        let config =
            ["ingest.toml", "plan.toml"].map(|name| case.join(name)).into_iter().find(|path| path.is_file());
        let Some(config) = config else { continue };
        let line = match config.ends_with("ingest.toml") {
            true => format!(
                "ingest --config {} --logs {} --memory-mib 256 --out out/t.parquet",
                config.display(),
                case.display()
            ),
            false => format!(
                "plan --vessel vessel.toml --trajectories dictionary.parquet --time-limit-s 4 --memory-mib 512 --config {} \
                 --out out/plan.json",
                config.display()
            ),
        };
        tally.case(&line, crate::ends::ends(&Place::on(&READERS[0]), &line));
    }
    tally.check("kept elsewhere");
}
