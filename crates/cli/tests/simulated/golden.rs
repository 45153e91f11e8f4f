//! `cargo test -p seatrial-cli --test simulated -- --ignored` writes fixtures/golden/simulated-logs.json again.

use std::fs;

use serde_json::{Map, Value, json};

use crate::support::*;
use crate::told;

/// A number of a document by its JSON pointer.
const NUMBERS: [(&str, &str); 8] = [
    ("moments.json", "/data/maneuvers/0/degrees/0/M/0"),
    ("moments.json", "/data/maneuvers/4/degrees/1/M/0"),
    ("design.json", "/data/log_det"),
    ("design.json", "/data/shares/spiral-fast"),
    ("design.json", "/data/shares/decelerate"),
    ("validation.json", "/data/picks/std_u"),
    ("validation.json", "/data/picks/std_v"),
    ("validation.json", "/data/picks/std_r"),
];

fn numbers() -> Map<String, Value> {
    let of = |(file, pointer): (&str, &str)| {
        let value = told(file).pointer(pointer).unwrap_or_else(|| panic!("{file}: {pointer}")).clone();
        (format!("{file}{pointer}"), value)
    };
    NUMBERS.into_iter().map(of).collect()
}

fn path() -> std::path::PathBuf {
    repository().join("fixtures/golden/simulated-logs.json")
}

#[test]
fn golden_numbers_of_the_small_study() {
    let frozen: Map<String, Value> = serde_json::from_slice(&fs::read(path()).unwrap()).unwrap();
    let found = numbers();
    assert_eq!(frozen.len(), found.len());
    for (name, value) in &found {
        let (found, frozen) = (value.as_f64().unwrap(), frozen[name].as_f64().unwrap());
        // Shares come from a search that stops at a gap: they are accurate to its square root.
        let tolerance = if name.contains("shares") { 1e-6 } else { 1e-9 };
        assert!(
            (found - frozen).abs() <= tolerance * frozen.abs(),
            "{name}: found {found}, expected {frozen}"
        );
    }
}

#[test]
#[ignore = "writes the golden numbers"]
fn write() {
    fs::write(path(), format!("{:#}\n", json!(numbers()))).unwrap();
}
