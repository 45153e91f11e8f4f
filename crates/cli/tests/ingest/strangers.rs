//! Files of unsupported formats, under any name.

use std::fs;

use crate::known::*;
use crate::runner::*;

/// The first bytes of other formats, and their names.
fn strangers() -> Vec<(Vec<u8>, &'static str)> {
    let filled = |head: &[u8]| [head, &[7; 600]].concat();
    let mut tar = vec![b'a'; 700];
    tar[257..262].copy_from_slice(b"ustar");
    vec![
        (filled(b"#ROSBAG V2.0\n"), "a ROS 1 bag"),
        (filled(b"SQLite format 3\0"), "SQLite"),
        (filled(b"ULog\x01\x12\x35\x01"), "ULog of PX4"),
        (filled(b"\xA3\x95\x80\x80"), "ArduPilot"),
        (filled(b"MATLAB 5.0 MAT-file, Platform"), "MATLAB"),
        (filled(b"MATLAB 7.3 MAT-file, Platform"), "version 7.3"),
        (filled(b"\x89HDF\r\n\x1a\n"), "HDF5"),
        (filled(b"CDF\x01"), "NetCDF"),
        (filled(b"PK\x03\x04\x14\0\x06\0[Content_Types].xml"), "Excel"),
        (filled(b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"), "Excel"),
        (filled(b"PK\x03\x04\x14\0a.csv"), "zip"),
        (filled(b"\x1F\x8B\x08"), "gzip"),
        (filled(b"\x28\xB5\x2F\xFD"), "zstd"),
        (filled(b"BZh91AY"), "bzip2"),
        (filled(b"\xFD7zXZ\0"), "xz"),
        (filled(b"7z\xBC\xAF\x27\x1C"), "7-Zip"),
        (tar, "tar"),
        (filled(b"\xD4\xC3\xB2\xA1"), "pcap"),
        (filled(b"Obj\x01"), "Avro"),
        (filled(b"ARROW1\0\0"), "Arrow"),
        (filled(b"%PDF-1.7"), "PDF"),
        (b"<!DOCTYPE html>\n<html><body>404</body></html>".to_vec(), "HTML"),
        (b"<?xml version=\"1.0\"?>\n<gpx></gpx>".to_vec(), "XML"),
        (b"{\"t\": [0, 1], \"u\": [1, 2]}".to_vec(), "JSON"),
        (b"[{\"t\": 0}]".to_vec(), "JSON"),
        (b"(1436509052.249713) can0 044#2A366C2BBA\n".to_vec(), "candump"),
        (b"A173321.107 23FF7 1F513 012F3070002F30709F\n".to_vec(), "NMEA 2000 as text"),
        (filled(b"\x10\x02\x93"), "NMEA 2000"),
        ("t,u\n0,1\n".chars().flat_map(|c| (c as u32).to_le_bytes()).collect(), "UTF-32"),
        (filled(b"PAR1"), "a Parquet file"),
        (filled(b"\x89MCAP0\r\n"), "a bag of MCAP"),
    ]
}

#[test]
fn formats_that_are_not_read_are_refused_by_their_names() {
    let config = table_config("a.csv", "unit = \"s\"", "");
    let folder = folder(&[("ingest.toml", &config)]);
    for (bytes, name) in strangers() {
        fs::write(folder.path().join("a.csv"), bytes).unwrap();
        refused_in(
            folder.path(),
            &[],
            &["a.csv: format: found", name, "expected text with a row per line (CSV)"],
        );
    }
}

#[test]
fn formats_that_are_not_read_are_none_of_the_others_either() {
    for (name, extra) in [("a.parquet", ""), ("a.mcap", "topic = \"/s\"\n"), ("a.csv.gz", "")] {
        let config = table_config(name, "unit = \"s\"", "").replace("time =", &format!("{extra}time ="));
        let folder = folder(&[("ingest.toml", &config)]);
        for (bytes, called) in strangers().into_iter().take(4) {
            fs::write(folder.path().join(name), bytes).unwrap();
            refused_in(folder.path(), &[], &[&format!("{name}: format: found"), called]);
        }
        fs::write(folder.path().join(name), "t,u\n0,1\n").unwrap();
        refused_in(folder.path(), &[], &[&format!("{name}: format: found")]);
    }
}

#[test]
fn lines_of_other_formats_before_the_header_are_passed_over() {
    let config = table_config("a.csv", "unit = \"s\"", "").replace("time =", "skip_lines = 1\ntime =");
    let table = "{\"ship\": \"a\"}\n".to_owned() + &csv(60, |k| k.to_string());
    healthy(&read(folder(&[("ingest.toml", &config), ("a.csv", &table)]).path()), 61);
}
