//! All keys of `ingest.toml` as a JSON Schema and as a page, generated from the types that read it.

use std::fmt::Write;

use schemars::schema_for;
use serde_json::{Map, Value};

use super::IngestFile;

/// Tables of the file: their headers, and the definition with their keys.
const TABLES: [(&str, &str); 10] = [
    ("", ""),
    ("[velocities]", "VelocitySpec"),
    ("[[file]]", "FileSpec"),
    ("[file.time]", "TimeSpec"),
    ("[[file.channel]]", "ChannelSpec"),
    ("[[file.quaternion]]", "QuaternionSpec"),
    ("[[derived]]", "DerivedSpec"),
    ("[[thruster]]", "ThrusterSpec"),
    ("[thruster.table]", "TableSpec"),
    ("[[segment]]", "Interval"),
];

const HEAD: &str = "\
# Keys of ingest.toml

Written by `cargo run -q -p study --example write_schemas -- schemas` from the types that read the file; not to be edited. For editors
there is the same as a JSON Schema, [schemas/ingest-toml.schema.json](../schemas/ingest-toml.schema.json). [Your own
logs](own-logs.md) says what to do with them.
";

/// The page of all keys, docs/ingest-keys.md.
pub fn page() -> String {
    let schema = schema_for!(IngestFile).to_value();
    let mut page = HEAD.to_owned();
    for (heading, name) in TABLES {
        let table = if name.is_empty() { &schema } else { &schema["$defs"][name] };
        if !heading.is_empty() {
            let _ = write!(page, "\n## `{heading}`\n\n{}\n", text(table));
        }
        match table["oneOf"].as_array() {
            Some(variants) => variants.iter().for_each(|variant| {
                let kind = variant["properties"]["kind"]["const"].as_str().unwrap_or_default();
                let _ = write!(page, "\n`kind = \"{kind}\"`: {}\n", text(variant));
                keys(&mut page, variant, &schema);
            }),
            None => keys(&mut page, table, &schema),
        }
    }
    page
}

fn keys(page: &mut String, table: &Value, schema: &Value) {
    page.push_str("\n| key | takes | without it | meaning |\n|---|---|---|---|\n");
    let required: Vec<&str> =
        table["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    for (key, property) in table["properties"].as_object().unwrap_or(&Map::new()) {
        let without = match (required.contains(&key.as_str()), &property["default"]) {
            (true, _) => "refused".to_owned(),
            (false, Value::Null) => String::new(),
            (false, Value::Object(_)) => "as its keys say".to_owned(),
            (false, default) => format!("`{default}`"),
        };
        let _ = writeln!(page, "| `{key}` | {} | {without} | {} |", takes(property, schema), text(property));
    }
}

/// A description in one line, in a cell.
fn text(of: &Value) -> String {
    of["description"].as_str().unwrap_or_default().replace('\n', " ").replace('|', "\\|")
}

/// The values of a key, in words.
fn takes(property: &Value, schema: &Value) -> String {
    let name = |of: &Value| of["$ref"].as_str().and_then(|path| path.rsplit('/').next()).map(str::to_owned);
    if let Some(choices) = property["anyOf"].as_array() {
        return choices
            .iter()
            .find(|choice| choice["type"] != "null")
            .map_or(String::new(), |choice| takes(choice, schema));
    }
    if let Some(name) = name(property) {
        let heading =
            TABLES.iter().find(|(_, known)| *known == name).map(|(heading, _)| format!("`{heading}`"));
        return heading.unwrap_or_else(|| choices(&schema["$defs"][name.as_str()]));
    }
    let kind = match &property["type"] {
        Value::Array(kinds) => kinds[0].as_str(),
        kind => kind.as_str(),
    };
    match kind.unwrap_or_default() {
        "string" if property["maxLength"] == 1 => "a character".to_owned(),
        "string" if property["const"].is_string() => format!("`{}`", property["const"]),
        "string" => "text".to_owned(),
        "number" => "a number".to_owned(),
        "integer" => "a whole number".to_owned(),
        "boolean" => "`true` or `false`".to_owned(),
        "array" => match (property["minItems"].as_u64(), name(&property["items"])) {
            (_, Some(_)) => takes(&property["items"], schema),
            (Some(count), _) => format!("a list of {count} numbers"),
            _ => format!("a list: {}", takes(&property["items"], schema)),
        },
        _ => String::new(),
    }
}

/// The choices of a key, with their meanings if documented.
fn choices(of: &Value) -> String {
    let plain = of["enum"].as_array().into_iter().flatten();
    let documented = of["oneOf"].as_array().into_iter().flatten();
    let documented = documented.flat_map(|one| match one["const"].as_str() {
        Some(choice) => vec![choice.to_owned()],
        None => one["enum"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_str)
            .map(str::to_owned)
            .collect(),
    });
    let all: Vec<String> = plain.filter_map(Value::as_str).map(str::to_owned).chain(documented).collect();
    all.iter().map(|choice| format!("`\"{choice}\"`")).collect::<Vec<_>>().join(", ")
}
