//! Writing and reading JSON documents.

use std::collections::BTreeMap;
use std::path::PathBuf;

use files::{
    Digest, Document, Error, Loaded, Result, Units, commit, json_schema, read_document, read_part,
    stage_document,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::sample::{Design, design, folder, names, provenance, refusal, shard};

fn write(folder: &TempDir) -> PathBuf {
    let path = folder.path().join("design.json");
    commit(vec![stage_document(&path, &provenance(), &design()).unwrap()]).unwrap();
    path
}

/// Reads the document after `change`, unsealed unless the change seals it.
fn changed(change: impl FnOnce(&mut Value)) -> Result<Loaded<Design>> {
    let folder = folder();
    let path = write(&folder);
    let mut value: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    value["seal"] = Value::Null;
    change(&mut value);
    std::fs::write(&path, serde_json::to_string_pretty(&value).unwrap()).unwrap();
    read_document(&path)
}

#[test]
fn what_is_written_is_read_back() {
    let folder = folder();
    let path = write(&folder);
    let loaded: Loaded<Design> = read_document(&path).unwrap();
    assert_eq!(loaded.data, design());
    assert_eq!(loaded.data.gap.to_bits(), (-0.0_f64).to_bits());
    assert_eq!(loaded.provenance, provenance());
    assert_eq!(loaded.digest, Digest::of_file(&path).unwrap());
    assert_eq!(names(&folder), ["design.json"]);
}

#[test]
fn the_envelope_is_as_documented() {
    let folder = folder();
    let text = std::fs::read_to_string(write(&folder)).unwrap();
    let value: serde_json::Map<String, Value> = serde_json::from_str(&text).unwrap();
    let keys: Vec<&str> = value.keys().map(String::as_str).collect();
    assert_eq!(keys, ["schema", "producer", "seal", "inputs", "settings", "units", "data"]);
    assert_eq!(value["schema"], "design/2");
    assert_eq!(value["units"], json!({"gap": "1", "rows": "m", "shares": "1"}));
    let blank = text.replace(value["seal"].as_str().unwrap(), &format!("blake3:{}", "0".repeat(64)));
    assert_eq!(value["seal"], Digest::of_bytes(blank.as_bytes()).to_string());
}

#[test]
fn a_shard_is_kept() {
    let folder = folder();
    let path = folder.path().join("d.json");
    commit(vec![stage_document(&path, &shard(2, 3), &design()).unwrap()]).unwrap();
    assert_eq!(read_part::<Design>(&path).unwrap().provenance, shard(2, 3));
    let refused = read_document::<Design>(&path).unwrap_err().to_string();
    assert!(refused.contains("shard 2/3") && refused.contains("--gather"), "{refused}");
}

#[test]
fn an_unsealed_document_is_read() {
    let loaded = changed(|value| value["data"]["gap"] = json!(0.25)).unwrap();
    assert_eq!(loaded.data.gap, 0.25);
}

#[test]
fn an_edited_document_needs_its_seal_taken_off() {
    let folder = folder();
    let path = write(&folder);
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("\"starts\": null", "\"starts\": 7")).unwrap();
    let line = refusal(read_document::<Design>(&path));
    assert!(
        line.contains("design.json: seal: found a digest that differs")
            && line.contains("set \"seal\" to null"),
        "{line}"
    );
}

#[test]
fn another_kind_or_version_is_refused() {
    let found = |id: Value| refusal(changed(|value| value["schema"] = id));
    assert!(
        found(json!("design/3"))
            .contains("schema: found design/3, expected design/2; upgrade seatrial or write the")
    );
    assert!(found(json!("design/1")).contains("found design/1, expected design/2; write the file again"));
    assert!(
        found(json!("moments/2")).contains("found moments/2, expected design/2; name a file of kind design")
    );
    assert!(found(json!(5)).contains("found no schema id, expected design/2"));
    let line = refusal(changed(|value| *value = json!({"a": 1})));
    assert!(line.contains("found no schema id"), "{line}");
}

#[test]
fn the_version_is_told_before_the_contents() {
    let line = refusal(changed(|value| *value = json!({"schema": "design/3", "new": {}})));
    assert!(line.contains("found design/3"), "{line}");
}

#[test]
fn unknown_keys_are_refused_with_the_nearest() {
    let line = refusal(changed(|value| value["data"]["gapp"] = json!(1)));
    assert!(line.contains("key: found key `gapp` (line "), "{line}");
    assert!(
        line.contains("expected a known key: `shares`, `gap`, `rows`, `starts`; did you mean `gap`?"),
        "{line}"
    );
    let line = refusal(changed(|value| value["sale"] = json!(1)));
    assert!(line.contains("did you mean `seal`?"), "{line}");
}

#[test]
fn missing_and_mistyped_keys_are_refused() {
    let line = refusal(changed(|value| drop(value["data"].as_object_mut().unwrap().remove("gap"))));
    assert!(line.contains("found no key `gap` (line ") && line.contains("; add `gap`"), "{line}");
    let line = refusal(changed(|value| value["data"]["gap"] = json!("x")));
    assert!(
        line.contains("gap: found the text \"x\" (line ") && line.contains("expected a number"),
        "{line}"
    );
    let line = refusal(changed(|value| drop(value.as_object_mut().unwrap().remove("seal"))));
    assert!(line.contains("found no key `seal`"), "{line}");
    let line = refusal(changed(|value| value["seal"] = json!("blake3:12")));
    assert!(line.contains("`blake3:12` is not a digest"), "{line}");
}

#[test]
fn another_unit_is_refused() {
    let line = refusal(changed(|value| value["units"]["rows"] = json!("ft")));
    assert!(line.contains("units.rows: found ft, expected m; convert"), "{line}");
    assert!(
        refusal(changed(|value| value["units"]["x"] = json!("m")))
            .contains("units.x: found a unit, expected no such field")
    );
}

#[test]
fn a_truncated_document_is_told_with_its_line() {
    let folder = folder();
    let path = write(&folder);
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, &text[..text.len() / 2]).unwrap();
    let line = refusal(read_document::<Design>(&path));
    assert!(line.contains("JSON: found EOF while parsing") && line.contains("(line 10, column"), "{line}");
    assert!(line.contains("the file is truncated or damaged"), "{line}");
    std::fs::write(&path, b"{\n\"schema\": \"\xff\"}").unwrap();
    assert!(refusal(read_document::<Design>(&path)).contains("found a byte that is not UTF-8 (line 2)"));
    assert!(matches!(
        read_document::<Design>(folder.path().join("none")),
        Err(Error::Io { action: "read", .. })
    ));
}

#[test]
fn numbers_that_are_not_finite_are_refused_with_their_path() {
    let folder = folder();
    let path = folder.path().join("design.json");
    let mut data = design();
    data.rows[1][0] = f64::NAN;
    let line = refusal(stage_document(&path, &provenance(), &data));
    assert!(line.contains("design.json: data.rows[1][0]: found NaN, expected a finite number"), "{line}");
    let data = Design { shares: BTreeMap::from([("a".into(), f64::INFINITY)]), ..design() };
    assert!(refusal(stage_document(&path, &provenance(), &data)).contains("data.shares.a: found inf"));
    assert!(names(&folder).is_empty());
}

#[derive(Serialize, Deserialize, JsonSchema)]
struct Sealed {
    seal: String,
}

impl Document for Sealed {
    const ID: &'static str = "sealed";
    const VERSION: u32 = 1;
    const UNITS: Units = &[];
}

#[test]
fn a_seal_inside_the_data_does_not_confuse() {
    let folder = folder();
    let path = folder.path().join("s.json");
    let blank = format!("blake3:{}", "0".repeat(64));
    let mut from = provenance();
    from.producer = format!("\"seal\": \"{blank}\"");
    commit(vec![stage_document(&path, &from, &Sealed { seal: blank.clone() }).unwrap()]).unwrap();
    assert_eq!(read_document::<Sealed>(&path).unwrap().data.seal, blank);
}

#[test]
fn the_json_schema_tells_the_whole_file() {
    let schema = json_schema::<Design>();
    assert_eq!(schema["properties"]["schema"]["const"], "design/2");
    assert_eq!(schema["properties"]["units"]["const"]["rows"], "m");
    assert_eq!(schema["additionalProperties"], false);
    assert!(schema["required"].as_array().unwrap().contains(&json!("seal")));
    let text = schema.to_string();
    assert!(text.contains("shares") && text.contains("^blake3:[0-9a-f]{64}$"), "{text}");
    assert_eq!(schema, json_schema::<Design>());
}
