//! Damaged files of both kinds: every flipped byte and every truncation is refused, none panics.

use std::fs::OpenOptions;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use files::{Error, Result, TableReader, commit, read_document, stage_document};

use crate::sample::{Design, design, folder, provenance, refusal, shard, write};

/// Reads all that a file holds.
fn read_table(path: &Path) -> Result<()> {
    let reader = TableReader::open(path, "trajectories", 2)?;
    let names: Vec<&str> = reader.columns().iter().map(|column| column.name.as_str()).collect();
    (0..reader.blocks()).try_for_each(|i| reader.read_block(i, &names).map(drop))
}

fn read_design(path: &Path) -> Result<()> {
    read_document::<Design>(path).map(drop)
}

/// Reads `bytes` and returns the refusal.
fn refused(path: &Path, bytes: &[u8], read: fn(&Path) -> Result<()>) -> Option<String> {
    std::fs::write(path, bytes).unwrap();
    refused_as_it_is(path, read)
}

fn refused_as_it_is(path: &Path, read: fn(&Path) -> Result<()>) -> Option<String> {
    match read(path) {
        Ok(()) => None,
        Err(error @ Error::Refused { .. }) => Some(error.to_string()),
        Err(other) => panic!("{other}"),
    }
}

/// Calls `check` with the file as it is once byte `at` has been flipped by `mask`, for every byte.
fn with_every_flip(path: &Path, masks: &[u8], check: impl Fn(usize, u8)) {
    let whole = std::fs::read(path).unwrap();
    let mut file = OpenOptions::new().write(true).open(path).unwrap();
    let mut put = |at: usize, byte: u8| {
        file.seek(SeekFrom::Start(at as u64)).unwrap();
        file.write_all(&[byte]).unwrap();
    };
    for (at, byte) in whole.iter().enumerate() {
        for mask in masks {
            put(at, byte ^ mask);
            check(at, *mask);
        }
        put(at, *byte);
    }
}

fn every_damage_is_refused(path: &Path, read: fn(&Path) -> Result<()>) {
    let whole = std::fs::read(path).unwrap();
    assert_eq!(refused(path, &whole, read), None);
    with_every_flip(path, &[0x01, 0x20, 0xff], |at, mask| {
        let line = refused_as_it_is(path, read).unwrap_or_else(|| panic!("byte {at} ^ {mask} passed"));
        assert!(!line.contains('\n'), "{line}");
    });
    for length in 0..whole.len() {
        let line = refused(path, &whole[..length], read);
        // A document's last byte is a line break that no reader of JSON misses: the seal does.
        assert!(line.is_some(), "the first {length} bytes passed");
    }
    for extra in [&b"\n"[..], b" ", b"x", &whole.clone()] {
        assert!(
            refused(path, &[&whole, extra].concat(), read).is_some(),
            "{} more bytes passed",
            extra.len()
        );
    }
}

#[test]
fn law_every_damage_to_a_table_is_refused() {
    let folder = folder();
    every_damage_is_refused(&write(&folder, "t.parquet", &shard(1, 2), 0..2), read_table);
}

#[test]
fn law_every_damage_to_a_document_is_refused() {
    let folder = folder();
    let path = folder.path().join("design.json");
    commit(vec![stage_document(&path, &provenance(), &design()).unwrap()]).unwrap();
    every_damage_is_refused(&path, read_design);
}

#[test]
fn a_flipped_value_is_told_by_the_seal() {
    let folder = folder();
    let path = write(&folder, "t.parquet", &provenance(), 0..2);
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[50] ^= 4;
    std::fs::write(&path, bytes).unwrap();
    let line = refusal(TableReader::open(&path, "trajectories", 2));
    let expected = "t.parquet: seal: found a digest that differs from the file's bytes, expected blake3:";
    assert!(line.contains(expected), "{line}");
    assert!(line.ends_with("write it again (or, if you edited it by hand, set \"seal\" to null)"), "{line}");
}

/// The seal taken out of a table, the value's length kept by spaces, which JSON allows.
fn unseal(bytes: &mut [u8]) {
    let start = bytes.windows(8).position(|window| window == b"\"seal\":\"").unwrap() + 7;
    bytes[start..start + 73].fill(b' ');
    bytes[start..start + 4].copy_from_slice(b"null");
}

#[test]
fn an_unsealed_table_is_read() {
    let folder = folder();
    let path = write(&folder, "t.parquet", &provenance(), 0..2);
    let mut bytes = std::fs::read(&path).unwrap();
    unseal(&mut bytes);
    assert_eq!(refused(&path, &bytes, read_table), None);
}

#[test]
fn damage_to_an_unsealed_table_never_panics() {
    let folder = folder();
    let path = write(&folder, "t.parquet", &provenance(), 0..2);
    let mut whole = std::fs::read(&path).unwrap();
    unseal(&mut whole);
    std::fs::write(&path, &whole).unwrap();
    with_every_flip(&path, &[0x01, 0x80, 0xff], |_, _| {
        let _ = read_table(&path);
    });
}
