//! The schemas of hand-written files: kept in `schemas/`, named by every file of a study, and right about them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde_json::Value;
use study::files::{file_name, kind_of, schemas};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// Where `value` is not as `schema` says, which may refer to definitions of `root`; none if it is.
fn wrong(root: &Value, schema: &Value, value: &Value, at: &str) -> Option<String> {
    let refuse = |why: String| Some(format!("{at}: {why}"));
    if let Some(name) = schema["$ref"].as_str() {
        let definition = &root["$defs"][name.strip_prefix("#/$defs/").unwrap()];
        if let Some(why) = wrong(root, definition, value, at) {
            return Some(why);
        }
    }
    for key in ["oneOf", "anyOf"] {
        let Some(all) = schema[key].as_array() else { continue };
        let whys: Vec<_> = all.iter().map(|own| wrong(root, own, value, at)).collect();
        let fit = whys.iter().filter(|why| why.is_none()).count();
        if fit == 0 || key == "oneOf" && fit > 1 {
            return refuse(format!("{fit} of {} kinds fit: {whys:?}", all.len()));
        }
    }
    let is = |name: &str| match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        "null" => value.is_null(),
        other => panic!("{other}"),
    };
    let types = match &schema["type"] {
        Value::Array(all) => all.iter().map(|own| own.as_str().unwrap()).collect(),
        Value::String(one) => vec![one.as_str()],
        _ => vec![],
    };
    if !types.is_empty() && !types.into_iter().any(is) {
        return refuse(format!("found {value}, expected {}", schema["type"]));
    }
    if !schema["const"].is_null() && schema["const"] != *value {
        return refuse(format!("found {value}, expected {}", schema["const"]));
    }
    if schema["enum"].as_array().is_some_and(|all| !all.contains(value)) {
        return refuse(format!("found {value}, expected one of {}", schema["enum"]));
    }
    if value.is_number() && !within(schema, value.as_f64().unwrap()) {
        return refuse(format!("found {value}, beyond the bounds"));
    }
    if let Some(all) = value.as_array() {
        let ends = ["minItems", "maxItems"].map(|key| schema[key].as_u64());
        if ends[0].is_some_and(|n| (all.len() as u64) < n) || ends[1].is_some_and(|n| all.len() as u64 > n) {
            return refuse(format!("found {} items", all.len()));
        }
        if schema["items"].is_object() {
            let mut places = all.iter().enumerate();
            return places.find_map(|(i, own)| wrong(root, &schema["items"], own, &format!("{at}[{i}]")));
        }
    }
    let own = value.as_object()?;
    let required = schema["required"].as_array().into_iter().flatten().map(|key| key.as_str().unwrap());
    if let Some(missing) = required.into_iter().find(|key| !own.contains_key(*key)) {
        return refuse(format!("`{missing}` is missing"));
    }
    own.iter().find_map(|(key, value)| {
        let place = format!("{at}.{key}");
        match (&schema["properties"][key], &schema["additionalProperties"]) {
            (Value::Null, Value::Bool(false)) => Some(format!("{place}: no such key")),
            (Value::Null, more @ Value::Object(_)) => wrong(root, more, value, &place),
            (known @ Value::Object(_), _) => wrong(root, known, value, &place),
            _ => None,
        }
    })
}

fn within(schema: &Value, number: f64) -> bool {
    let bound =
        |key: &str, fits: fn(f64, f64) -> bool| schema[key].as_f64().is_none_or(|end| fits(number, end));
    bound("minimum", |a, b| a >= b)
        && bound("maximum", |a, b| a <= b)
        && bound("exclusiveMinimum", |a, b| a > b)
        && bound("exclusiveMaximum", |a, b| a < b)
}

fn schema_of(kind: &str) -> Value {
    schemas().into_iter().find(|(own, _)| *own == kind).unwrap().1
}

/// What is wrong with the text of a file.
fn wrong_in(kind: &str, text: &str) -> Option<String> {
    let schema = schema_of(kind);
    let value = serde_json::to_value(text.parse::<toml::Table>().unwrap()).unwrap();
    wrong(&schema, &schema, &value, kind)
}

fn toml_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            toml_files(&path, found);
        // Whose keys are the flags of the stages, which this room does not know
        } else if path.extension().is_some_and(|own| own == "toml") && !path.ends_with("study.toml") {
            found.push(path);
        }
    }
}

#[test]
fn schemas_are_kept() {
    for (kind, schema) in schemas() {
        let path = repository().join("schemas").join(file_name(kind));
        let kept = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let kept: Value = serde_json::from_str(&kept).unwrap();
        assert!(kept == schema, "{} has drifted; run `make schemas`", path.display());
    }
}

/// The files of all studies name their schemas, which are right about them.
#[test]
fn files_of_studies_are_as_their_schemas_say() {
    let mut files = Vec::new();
    ["pipelines", "fixtures"].iter().for_each(|own| toml_files(&repository().join(own), &mut files));
    let mut seen = BTreeSet::new();
    for path in &files {
        let text = std::fs::read_to_string(path).unwrap();
        let kind =
            kind_of(&path.file_name().unwrap().to_string_lossy()).unwrap_or_else(|| panic!("{path:?}"));
        seen.insert(kind);
        assert_eq!(wrong_in(kind, &text), None, "{}", path.display());
        if path.starts_with(repository().join("pipelines")) {
            let named = text
                .lines()
                .next()
                .unwrap()
                .strip_prefix("#:schema ")
                .map(|own| path.parent().unwrap().join(own));
            let named = named.unwrap_or_else(|| panic!("{}: no #:schema", path.display()));
            assert_eq!(named.canonicalize().unwrap(), repository().join("schemas").join(file_name(kind)));
        }
    }
    assert!(files.len() > 40 && seen.len() > 6, "{} {seen:?}", files.len());
}

#[test]
fn wrong_keys_types_and_values_are_not_as_the_schemas_say() {
    let text = |path: &str| std::fs::read_to_string(repository().join("pipelines").join(path)).unwrap();
    for (kind, path, from, to, place) in [
        ("vessel", "smoke/vessel.toml", "preset =", "preses =", "vessel.preses"),
        ("dictionary", "smoke/dictionary.toml", "period_s", "period", "dictionary.maneuver"),
        ("dictionary", "smoke/dictionary.toml", "name = \"", "nome = \"", "dictionary.maneuver"),
        ("campaign", "smoke/campaign.toml", "std_m_s", "std_kn", "campaign.current"),
        (
            "campaign",
            "smoke/campaign.toml",
            "realizations = 40",
            "realizations = \"40\"",
            "campaign.realizations",
        ),
        (
            "campaign",
            "smoke/campaign.toml",
            "realizations = 40",
            "realizations = -4",
            "campaign.realizations",
        ),
        ("campaign", "smoke/campaign.toml", "kind = \"white\"", "kind = \"wite\"", "campaign.current"),
        ("plan", "helsinki/plan.toml", "west_deg", "west", "plan.area"),
        ("plan", "helsinki/plan.toml", "headings = 8", "headings = 8.5", "plan.headings"),
        ("campaign", "smoke/campaign.toml", "rounds = 2", "round = 2", "campaign.rounds"),
        ("ingest", "kvlcc2/ingest.toml", "[[file]]", "[[files]]", "ingest"),
        ("logs", "model-ship/logs.toml", "[gnss]", "[gps]", "logs"),
    ] {
        let right = text(path);
        assert!(right.contains(from), "{path}: {from}");
        assert_eq!(wrong_in(kind, &right), None);
        let why = wrong_in(kind, &right.replacen(from, to, 1)).unwrap_or_else(|| panic!("{path}: {to}"));
        assert!(why.starts_with(place), "{why}");
    }
}

/// All schemas of a key.
fn of_key<'a>(schema: &'a Value, key: &str, found: &mut Vec<&'a Value>) {
    match schema {
        Value::Object(parts) => {
            found.extend(parts.get("properties").and_then(|all| all.get(key)));
            parts.values().for_each(|part| of_key(part, key, found));
        }
        Value::Array(parts) => parts.iter().for_each(|part| of_key(part, key, found)),
        _ => {}
    }
}

/// The refusal of a file's text, by the reader of its kind.
fn refused(kind: &str, text: &str) -> Option<String> {
    fn read<T: serde::de::DeserializeOwned + schemars::JsonSchema>(text: &str) -> Option<String> {
        files::parse_toml::<T>(text, "file.toml").err().map(|e| e.to_string())
    }
    match kind {
        "vessel" => read::<ship::model::VesselFile>(text),
        "dictionary" => read::<maneuver::DictionaryFile>(text),
        "campaign" => read::<study::campaign_file::CampaignFile>(text),
        "plan" => read::<study::plan::PlanFile>(text),
        "logs" => read::<study::logs_file::LogsFile>(text),
        "reference" => read::<study::documents::Reference>(text),
        "ingest" => read::<study::ingest_file::IngestFile>(text),
        _ => None,
    }
}

/// Every number of the studies' files that has a bound is put just beyond it: the reader names the key, the number and the line.
#[test]
fn law_a_number_beyond_its_bound_is_refused_with_its_line() {
    let (mut files, mut stepped) = (Vec::new(), BTreeSet::new());
    toml_files(&repository().join("pipelines"), &mut files);
    for path in &files {
        let kind = kind_of(&path.file_name().unwrap().to_string_lossy()).unwrap();
        let (text, schema) = (std::fs::read_to_string(path).unwrap(), schema_of(kind));
        let right = refused(kind, &text);
        assert_eq!(right, None, "{}", path.display());
        for (place, line) in text.lines().enumerate() {
            let Some((key, value)) = line.split_once(" = ") else { continue };
            let value = value.split(" #").next().unwrap().trim();
            let Ok(number) = value.parse::<f64>() else { continue };
            let mut all = Vec::new();
            of_key(&schema, key, &mut all);
            let ends = ["minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum"];
            let ends = all.iter().flat_map(|one| ends.iter().filter_map(|end| one[*end].as_f64()));
            let beyond = ends.flat_map(|end| [end, end - 1.0, end + 1.0, end - end.abs(), 2.0 * end]);
            let wrong = beyond.filter(|beyond| all.iter().all(|one| !within(one, *beyond)));
            // A number that is to be whole and is not has another refusal.
            let wrong = wrong.filter(|beyond| number.fract() != 0.0 || beyond.fract() == 0.0);
            for beyond in wrong.collect::<Vec<_>>() {
                let written =
                    if value.contains(['.', 'e']) { format!("{beyond:?}") } else { beyond.to_string() };
                let changed: Vec<String> = text
                    .lines()
                    .enumerate()
                    .map(|(i, own)| if i == place { format!("{key} = {written}") } else { own.to_owned() })
                    .collect();
                let said =
                    refused(kind, &changed.join("\n")).unwrap_or_else(|| panic!("{kind}: {key} = {written}"));
                let line = format!("(line {}, column 1), expected ", place + 1);
                assert!(said.contains(&line) && said.contains(key), "{key} = {written}: {said}");
                stepped.insert((kind, key.to_owned()));
            }
        }
    }
    assert!(stepped.len() > 40, "{} {stepped:?}", stepped.len());
}
