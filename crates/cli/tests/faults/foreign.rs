//! Foreign documents and tables: texts and sizes without bounds.

use std::fs::{self, File};

use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader, ParquetMetaDataWriter};
use tempfile::TempDir;

use crate::places::unsealed;
use crate::support::{DESIGN, MOMENTS, Ran, put, run, with};

/// Must be refused in one line below 500 characters without invisible characters.
#[track_caller]
fn refused_shortly(ran: Ran, pieces: &[&str]) {
    let told = ran.refuses(3, pieces).stderr;
    assert!(
        told.chars().count() < 500 && !told.contains('\u{202e}'),
        "{} characters: {told}",
        told.chars().count()
    );
}

/// The moments with `from` replaced, not sealed.
fn moments(from: &str, to: &str) -> TempDir {
    let folder = with(&["moments.json"]);
    let text = String::from_utf8(unsealed(&fs::read(folder.path().join("moments.json")).unwrap())).unwrap();
    assert!(text.contains(from), "{from}");
    put(&folder, "moments.json", &text.replacen(from, to, 1));
    folder
}

#[test]
fn texts_of_a_million_characters_are_told_in_few() {
    let long = "x\u{202e}\n".replace('\n', "\\n").repeat(300_000);
    for (from, to) in [
        ("\"data\": {", format!("\"data\": {{\"{long}\": 1,")),
        ("\"data\": {", format!("\"{long}\": 1, \"data\": {{")),
        ("\"data\": {", format!("\"data\": \"{long}\", \"x\": {{")),
        ("\"schema\": \"", format!("\"schema\": \"{long}")),
        ("\"schema\": \"moments/", format!("\"schema\": \"moments/{long}")),
        ("\"units\": {", format!("\"units\": {{\"{long}\": \"m\",")),
        ("\"inputs\": {", format!("\"inputs\": {{\"{long}\": 1,")),
    ] {
        refused_shortly(run(&moments(from, &to), DESIGN), &["moments.json"]);
        let said = run(&moments(from, &to), "verify .");
        let longest = said.stdout.lines().chain(said.stderr.lines()).map(|line| line.chars().count()).max();
        assert!(longest < Some(500), "{longest:?}");
    }
    let folder = with(&["moments.json"]);
    for line in
        [format!("[{long}]\n"), format!("\"{long}\" = 1\n"), format!("x = \"{long}\"\n"), long.clone()]
    {
        put(&folder, "campaign.toml", &line);
        let line = "simulate validation --vessel vessel.toml --campaign campaign.toml --out v.parquet";
        refused_shortly(run(&folder, line), &["campaign.toml"]);
    }
}

#[test]
fn documents_larger_than_memory_are_refused_before_they_are_read() {
    let folder = with(&["moments.json"]);
    let text = unsealed(&fs::read(folder.path().join("moments.json")).unwrap());
    let text = String::from_utf8(text).unwrap();
    // A gigabyte of objects in 8 MB of text.
    let heavy = format!("\"data\": [{}0], \"x\": ", "{},".repeat(2_500_000));
    put(&folder, "heavy.json", &text.replacen("\"data\": ", &heavy, 1));
    let line = "design --moments heavy.json --out design.json --memory-mib 64";
    refused_shortly(run(&folder, line), &["heavy.json: contents", "of --memory-mib"]);
    File::create(folder.path().join("large.json")).unwrap().set_len(1 << 36).unwrap();
    for line in [line.replace("heavy", "large"), "verify . --memory-mib 64".to_owned()] {
        let ran = run(&folder, &line);
        let told = format!("{}{}", ran.stdout, ran.stderr);
        assert!(told.contains("large.json: file: found 68719476736 bytes"), "{ran}");
        assert_eq!(ran.code, Some(3), "{ran}");
    }
    File::create(folder.path().join("large.toml")).unwrap().set_len(1 << 36).unwrap();
    let line =
        "simulate validation --vessel large.toml --campaign campaign.toml --out v.parquet --memory-mib 64";
    refused_shortly(run(&folder, line), &["large.toml: file: found 68719476736 bytes"]);
}

/// The footer of a table, and where it begins.
fn footer(bytes: &[u8]) -> (usize, ParquetMetaData) {
    let end = bytes.len() - 8;
    let length = u32::from_le_bytes(bytes[end..end + 4].try_into().unwrap()) as usize;
    (end - length, ParquetMetaDataReader::decode_metadata(&bytes[end - length..end]).unwrap())
}

fn dictionary() -> (TempDir, Vec<u8>) {
    let folder = with(&["dictionary.parquet"]);
    let bytes = unsealed(&fs::read(folder.path().join("dictionary.parquet")).unwrap());
    (folder, bytes)
}

#[test]
fn damaged_pages_are_a_damaged_table_and_no_fault_of_the_disk() {
    let (folder, bytes) = dictionary();
    let end = footer(&bytes).0;
    let mut refusals = 0;
    for i in 0..60 {
        let mut damaged = bytes.clone();
        let at = 4 + (end - 4) * i / 60;
        damaged[at] ^= [0xff, 0x01, 0x80][i % 3];
        fs::write(folder.path().join("dictionary.parquet"), damaged).unwrap();
        let ran = run(&folder, MOMENTS);
        assert!(matches!(ran.code, Some(0 | 3)), "{ran}");
        refusals += usize::from(ran.code == Some(3));
    }
    assert!(refusals > 0, "no damage was seen");
}

#[test]
fn a_table_that_lies_about_its_rows_takes_no_memory() {
    let (folder, bytes) = dictionary();
    let (body, metadata) = footer(&bytes);
    for rows in [1 << 31, 1 << 40, i64::MAX - 1] {
        let group = metadata.row_group(0);
        let group = group.clone().into_builder().set_num_rows(rows).build().unwrap();
        let lying = metadata.clone().into_builder().set_row_groups(vec![group]).build();
        let mut damaged = bytes[..body].to_vec();
        ParquetMetaDataWriter::new(&mut damaged, &lying).finish().unwrap();
        fs::write(folder.path().join("dictionary.parquet"), damaged).unwrap();
        refused_shortly(run(&folder, &format!("{MOMENTS} --memory-mib 512")), &["dictionary.parquet"]);
    }
}

/// A footer with more blocks than its length allows.
#[test]
fn a_footer_that_lies_about_its_blocks_takes_no_memory() {
    let (folder, bytes) = dictionary();
    let (body, metadata) = footer(&bytes);
    let end = bytes.len() - 8;
    let mut lying = bytes[body..end].to_vec();
    // The list of blocks is the field after the number of rows.
    let mut before = vec![0x16];
    let mut rows = 2 * u64::try_from(metadata.file_metadata().num_rows()).unwrap();
    while rows > 0x7f {
        before.push(rows as u8 | 0x80);
        rows >>= 7;
    }
    before.extend([rows as u8, 0x19]);
    let at = lying.windows(before.len()).position(|window| window == before).unwrap() + before.len();
    assert!(lying[at] & 0x0f == 0x0c && lying[at] < 0xf0, "a short list of structs");
    lying.splice(at..=at, [0xfc, 0xff, 0xff, 0xff, 0xff, 0x07]);
    let mut damaged = bytes[..body].to_vec();
    damaged.extend(&lying);
    damaged.extend((lying.len() as u32).to_le_bytes());
    damaged.extend(b"PAR1");
    fs::write(folder.path().join("dictionary.parquet"), damaged).unwrap();
    refused_shortly(
        run(&folder, MOMENTS),
        &["dictionary.parquet: contents", "lengths that do not fit its bytes"],
    );
}
