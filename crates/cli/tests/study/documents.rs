//! Contracts of the JSON documents: units, schemas, no unknown fields.

use std::collections::BTreeSet;

use serde_json::{Value, json};
use study::documents::schemas;

use crate::support::*;

/// A study whose design has whole segments, so that no field is absent.
fn folder() -> tempfile::TempDir {
    let folder = with(&MADE);
    run(&folder, &format!("{DESIGN} --segments 5 --segment-samples 200")).succeeds();
    folder
}

const DOCUMENTS: [&str; 4] = ["moments.json", "design.json", "estimate.json", "validation.json"];

/// The path of every number in `value`: the names of fields, without places in lists.
fn numbers(value: &Value, path: &mut Vec<String>, found: &mut BTreeSet<Vec<String>>) {
    match value {
        Value::Number(_) => drop(found.insert(path.clone())),
        Value::Array(items) => items.iter().for_each(|item| numbers(item, path, found)),
        Value::Object(fields) => {
            for (name, field) in fields {
                path.push(name.clone());
                numbers(field, path, found);
                path.pop();
            }
        }
        _ => {}
    }
}

/// The entry of `units` that holds for the number at `path`: `parent.field`, `field`, or for a map's values the map.
fn entry(units: &Value, path: &[String]) -> Option<String> {
    let (last, above) = path.split_last()?;
    let dotted = above.last().map(|parent| format!("{parent}.{last}"));
    let candidates = dotted.into_iter().chain([last.clone()]).chain(above.last().cloned());
    candidates.into_iter().find(|name| units[name].is_string())
}

fn without_unit(document: &Value) -> Vec<String> {
    let mut found = BTreeSet::new();
    numbers(&document["data"], &mut Vec::new(), &mut found);
    let strange = found.iter().filter(|path| entry(&document["units"], path).is_none());
    strange.map(|path| path.join(".")).collect()
}

#[test]
fn every_number_has_a_unit() {
    let folder = folder();
    for name in DOCUMENTS {
        let document = json(&folder, name);
        assert_eq!(without_unit(&document), Vec::<String>::new(), "{name}: numbers without unit");
    }
}

#[test]
fn a_number_without_unit_is_found() {
    let units = json!({"gap": "1", "shares": "1", "bounds.error": "m"});
    let data =
        json!({"gap": 1, "shares": {"a": 1}, "bounds": {"error": 1}, "list": [{"deep": 2.5}], "error": 1});
    assert_eq!(without_unit(&json!({"units": units, "data": data})), ["error", "list.deep"]);
}

/// Fields that only some flags write have units too, in the schema.
#[test]
fn every_unit_is_that_of_a_number() {
    let folder = folder();
    for name in DOCUMENTS {
        let document = json(&folder, name);
        let mut found = BTreeSet::new();
        numbers(&document["data"], &mut Vec::new(), &mut found);
        let used: BTreeSet<String> =
            found.iter().filter_map(|path| entry(&document["units"], path)).collect();
        let units: BTreeSet<String> = document["units"].as_object().unwrap().keys().cloned().collect();
        let id = document["schema"].as_str().unwrap().split('/').next().unwrap().to_owned();
        let schemas = study::documents::schemas();
        let schema = &schemas.iter().find(|(known, _)| *known == id).unwrap().1["$defs"];
        let known = |unit: &String| {
            let field = format!("\"{}\":", unit.rsplit('.').next().unwrap());
            schema.to_string().contains(&field)
        };
        assert!(used.is_subset(&units), "{name}: {used:?}");
        let strange: Vec<&String> = units.difference(&used).filter(|unit| !known(unit)).collect();
        assert!(strange.is_empty(), "{name}: {strange:?}");
    }
}

#[test]
fn json_schemas_are_those_of_the_documents() {
    let folder = repository().join("schemas");
    let remedy = "run `make schemas`, or `cargo run -p seatrial-cli --example write_schemas -- schemas`";
    for (id, schema) in schemas() {
        let path = folder.join(format!("{id}.schema.json"));
        let text =
            std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}; {remedy}", path.display()));
        let kept: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(kept, schema, "{} has drifted; {remedy}", path.display());
    }
    // The schemas of hand-written files are checked with the files; but its keys are the flags of the stages.
    for (name, text) in cli::pipeline::starting::schemas().iter().filter(|(name, _)| name.contains("/study-"))
    {
        assert!(
            std::fs::read_to_string(repository().join(name)).is_ok_and(|kept| kept == *text),
            "{name} has drifted; {remedy}"
        );
    }
    let of_document = |file: &std::fs::DirEntry| !file.file_name().to_string_lossy().contains("-toml.");
    let kept = std::fs::read_dir(&folder).unwrap().flatten().filter(of_document).count();
    assert_eq!(kept, schemas().len(), "schemas/ has a file of no document; {remedy}");
}

#[test]
fn schemas_name_every_field_and_refuse_others() {
    let folder = folder();
    // The stages of other documents have the same test with their own.
    let made = |id: &str| DOCUMENTS.contains(&format!("{id}.json").as_str());
    for (id, schema) in schemas().into_iter().filter(|(id, _)| made(id)) {
        let document = json(&folder, &format!("{id}.json"));
        let known: BTreeSet<&String> = schema["properties"].as_object().unwrap().keys().collect();
        let strange = document.as_object().unwrap().keys().find(|key| !known.contains(key));
        assert_eq!(strange, None, "{id}");
        assert_eq!(schema["additionalProperties"], false, "{id}");
        assert_eq!(schema["properties"]["schema"]["const"], document["schema"], "{id}");
        assert_eq!(schema["properties"]["units"]["const"], document["units"], "{id}");
    }
}

#[test]
fn documents_edited_by_hand_are_read_with_the_seal_removed_and_refused_with_it() {
    let folder = folder();
    let mut moments = json(&folder, "moments.json");
    moments["data"]["vessel"] = "another name".into();
    put(&folder, "moments.json", &moments.to_string());
    refused(&folder, 3, DESIGN, &["moments.json", "seal", "differs", "set \"seal\" to null"]);
    moments["seal"] = Value::Null;
    put(&folder, "moments.json", &moments.to_string());
    run(&folder, DESIGN).succeeds();
}

#[test]
fn unknown_and_missing_fields_and_other_units_are_refused() {
    let folder = folder();
    let mut original = json(&folder, "moments.json");
    original["seal"] = Value::Null;
    let refuse = |change: fn(&mut Value), pieces: &[&str]| {
        let mut document = original.clone();
        change(&mut document);
        put(&folder, "moments.json", &format!("{document:#}"));
        refused(&folder, 3, DESIGN, &[&["moments.json"], pieces].concat());
    };
    refuse(|d| d["data"]["vesel"] = "x".into(), &["`vesel`", "did you mean `vessel`?"]);
    refuse(
        |d| drop(d["data"].as_object_mut().unwrap().remove("vessel")),
        &["no key `vessel`", "add `vessel`"],
    );
    refuse(|d| d["units"]["sample_rate_hz"] = "rpm".into(), &["units.sample_rate_hz", "rpm", "Hz"]);
    refuse(|d| drop(d["units"].as_object_mut().unwrap().remove("samples")), &["units.samples", "no unit"]);
    refuse(
        |d| d["data"]["maneuvers"][0]["degrees"][0]["M"] = json!([1.0]),
        &["moments of `decelerate`", "1 entries"],
    );
    refuse(|d| d["data"]["maneuvers"] = json!([]), &["data.maneuvers", "none", "at least one"]);
    refuse(|d| d["data"]["maneuvers"][0]["samples"] = json!(-1), &["samples", "-1"]);
    refuse(|d| d["data"]["degrees"] = json!([]), &["moments.json"]);
    refuse(|d| d["data"]["degrees"][0]["parameters"] = json!([]), &["surge", "0 parameters"]);
    refuse(|d| d["data"]["degrees"][1]["regressors"] = json!([]), &["sway", "0 regressors"]);
    refuse(|d| d["data"]["maneuvers"][1]["name"] = "decelerate".into(), &["`decelerate`", "twice"]);
}

#[test]
fn shares_that_are_no_shares_are_refused() {
    let folder = folder();
    let mut design = json(&folder, "design.json");
    design["seal"] = Value::Null;
    for (shares, pieces) in [
        (json!({}), ["sum of `data.shares`", "found 0, expected 1"]),
        (json!({"accelerate": 0.0}), ["sum of `data.shares`", "expected 1"]),
        (json!({"accelerate": 0.5, "decelerate": 0.4}), ["sum of `data.shares`", "0.9"]),
        (json!({"accelerate": -0.5, "decelerate": 1.5}), ["`accelerate`", "-0.5"]),
        (json!({"accelerate": 1e300}), ["`accelerate`", "from 0 to 1"]),
    ] {
        design["data"]["shares"] = shares;
        put(&folder, "design.json", &design.to_string());
        refused(&folder, 3, CAMPAIGN, &[&["design.json"], &pieces[..]].concat());
    }
}
