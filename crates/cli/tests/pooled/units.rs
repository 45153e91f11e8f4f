use std::collections::BTreeSet;
use std::fs;

use serde_json::Value;

use crate::support::*;
use crate::{CROSS, POOL, SELECTION, picking};

/// Names of the fields that hold numbers, those of maps by the map's.
fn numbers(value: &Value, name: &str, maps: &[&str], found: &mut BTreeSet<String>) {
    match value {
        Value::Number(_) => drop(found.insert(name.to_owned())),
        Value::Array(items) => items.iter().for_each(|item| numbers(item, name, maps, found)),
        Value::Object(fields) => {
            for (key, field) in fields {
                let quantile = key.starts_with('q') || key.starts_with("median");
                let own = maps.contains(&name) || quantile || ["min", "max"].contains(&key.as_str());
                numbers(field, if own { name } else { key }, maps, found);
            }
        }
        _ => {}
    }
}

#[test]
fn every_number_has_a_unit_and_every_unit_a_number() {
    let folder = picking();
    run(&folder, &format!("{POOL} --runs random/0,random/1 --bootstrap 9 --out estimates.parquet"))
        .succeeds();
    run(&folder, &format!("{CROSS} --estimator ls,iv --out scores.json")).succeeds();
    fs::copy(repository().join("pipelines/model-ship/reference.toml"), folder.path().join("reference.toml"))
        .unwrap();
    run(&folder, &format!("{SELECTION} --reference reference.toml --out scores.parquet")).succeeds();
    for name in ["estimate.json", "scores.json", "validation.json"] {
        let document = json(&folder, name);
        let mut found = BTreeSet::new();
        numbers(&document["data"], "", &["counts", "available"], &mut found);
        let units: BTreeSet<String> = document["units"].as_object().unwrap().keys().cloned().collect();
        let strange: Vec<&String> = found.difference(&units).collect();
        assert!(strange.is_empty(), "{name}: {strange:?} without unit");
        // Fields that may be null are numbers elsewhere. Of estimates most parts are absent here: the schema has them.
        let elsewhere = ["ratio_q90"];
        let unused: Vec<&String> =
            units.difference(&found).filter(|unit| !elsewhere.contains(&unit.as_str())).collect();
        // Other sections have numbers of their own.
        let has_sections = name == "validation.json" || document["schema"] == "estimate/2";
        assert!(unused.is_empty() || has_sections, "{name}: units of nothing: {unused:?}");
    }
}
