//! `ingest.json` as a document.

use files::units;
use serde_json::Value;
use study::documents::{IngestDocument, schemas};

use crate::runner::*;

/// The names of all fields that hold numbers, or lists of numbers.
fn numeric(value: &Value, name: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(name.to_owned()),
        Value::Array(items) => items.iter().for_each(|item| numeric(item, name, found)),
        Value::Object(fields) => fields.iter().for_each(|(name, field)| numeric(field, name, found)),
        _ => {}
    }
}

#[test]
fn every_number_has_a_unit() {
    let made = ingest(&repository("fixtures/logs"), &["--config", "ingest.toml"]);
    let mut found = Vec::new();
    numeric(&serde_json::to_value(&made.summary).unwrap(), "", &mut found);
    // Rows have the unit of their count.
    let rows = [
        "read",
        "empty",
        "cut",
        "without_time",
        "repeated",
        "backwards",
        "spread",
        "wrong_checksums",
        "late",
    ];
    let units = units::<IngestDocument>();
    for name in found.iter().filter(|name| !rows.contains(&name.as_str())) {
        assert!(units.contains_key(name), "`{name}` has no unit");
    }
    assert!(found.iter().any(|name| name == "lag_s") && units.contains_key("rows"));
}

#[test]
fn its_schema_is_kept() {
    let kept = std::fs::read_to_string(repository("schemas/ingest.schema.json")).unwrap();
    let (_, schema) = schemas().into_iter().find(|(id, _)| *id == "ingest").unwrap();
    let kept: Value = serde_json::from_str(&kept).unwrap();
    assert_eq!(kept, schema, "it has drifted; run `make schemas`");
}

#[test]
fn its_schema_names_every_key_of_the_file() {
    let out = tempfile::tempdir().unwrap();
    let target = out.path().join("trajectories.parquet");
    let ran =
        run(&repository("fixtures/logs"), &["--config", "ingest.toml", "--out", target.to_str().unwrap()]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let text = std::fs::read_to_string(out.path().join("ingest.json")).unwrap();
    let document: Value = serde_json::from_str(&text).unwrap();
    let (_, schema) = schemas().into_iter().find(|(id, _)| *id == "ingest").unwrap();
    for (key, _) in document.as_object().unwrap() {
        assert!(schema["properties"][key].is_object(), "{key}");
    }
    assert_eq!(schema["properties"]["units"]["const"], document["units"]);
    assert_eq!(schema["properties"]["schema"]["const"], document["schema"]);
}

#[test]
fn the_page_of_its_keys_is_kept() {
    let page = std::fs::read_to_string(repository("docs/ingest-keys.md")).unwrap();
    assert!(page == study::ingest_file::page(), "docs/ingest-keys.md has drifted; run `make schemas`");
    // Of every table that there is.
    for key in [
        "`nanoseconds`",
        "`tolerance`",
        "`tail_s`",
        "`topic`",
        "`forces`",
        "`maneuver_from_file`",
        "`from_s`",
    ] {
        assert!(page.contains(&format!("| {key} |")), "{key}");
    }
}
