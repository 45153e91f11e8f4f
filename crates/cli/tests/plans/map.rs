//! `map.json`: everything needed to draw the map again.

use std::collections::BTreeSet;

use files::{Document, json_schema, read_document};
use report::plan_map;
use serde_json::Value;
use study::documents::{MapClass, MapDocument, MapRaster, MapRuns};

use crate::planned::*;
use crate::support::*;

/// The small study on a land mask and depths of a grid, with all that a map may have.
fn everything() -> Planned {
    let grid = "file = \"land.geojson\"\nkind = \"land\"\n\n[[chart]]\nfile = \"depth.asc\"\nkind = \"depth\"\ncrs = \"WGS84\"\nopen_sea = true";
    let limit = "[[speed_limit]]\ncorners = [[25.0, 59.98], [25.03, 59.98], [25.03, 60.02], [25.0, 60.02]]\n\
                 max_speed_m_s = 1.6\n[start]";
    let folder = small_with(&[("file = \"land.geojson\"\nkind = \"land\"", grid), ("[start]", limit)]);
    let depth = |k: usize| if k % 60 > 45 { "3" } else { "20" };
    let row = (0..60).map(depth).collect::<Vec<_>>().join(" ");
    let head = "ncols 60\nnrows 40\nxllcorner 24.97\nyllcorner 59.98\ncellsize 0.001\nNODATA_value -9999\n";
    put(&folder, "depth.asc", &format!("{head}{}", format!("{row}\n").repeat(40)));
    run(&folder, PLAN).succeeds();
    Planned::of(&folder)
}

fn map(planned: &Planned) -> MapDocument {
    let folder = planned.study.with(&["map.json"]);
    read_document(folder.path().join("map.json")).unwrap().data
}

#[test]
fn law_the_map_drawn_from_its_document_is_the_one_that_was_written() {
    let [eight, four] = helsinki_planned();
    for planned in [eight, four, small_planned(), &everything()] {
        assert!(plan_map(&map(planned)).unwrap() == planned.text("map.svg"));
    }
}

#[test]
fn a_map_has_shades_limits_and_an_origin() {
    let planned = everything();
    let map = map(&planned);
    let cells = map.cells.as_ref().unwrap();
    let depths: Vec<(MapClass, Option<f64>)> = cells.classes.iter().map(|c| (c.class, c.least_m)).collect();
    assert_eq!(depths, [(MapClass::Depth, Some(3.0)), (MapClass::Depth, Some(20.0))]);
    assert_eq!((map.speed_limits.len(), map.areas.len(), map.margins.len()), (1, 1, 2));
    assert!(map.areas.iter().all(|area| area.class == MapClass::Land));
    // The origin is the centre of the area; the track begins where the plan does, and goes through every sample.
    assert!((map.longitude_deg - 25.0).abs() < 1e-9 && (map.latitude_deg - 60.0).abs() < 1e-9);
    let [start, goal] = [map.start.unwrap(), map.goal.unwrap()];
    let [first, .., last] = &planned.track.pose[..] else { panic!("no track") };
    assert_eq!([start.north_m, start.east_m], first[..2]);
    assert_eq!([goal.north_m, goal.east_m], last[..2]);
    let points: usize = map.tracks.iter().map(|own| own.line.east_m.len() - 1).sum();
    assert_eq!(points, planned.track.inputs.len());
    let numbers: Vec<u64> = map.tracks.iter().filter_map(|own| own.number).collect();
    assert_eq!(numbers, [1, 2]);
    assert_eq!(map.hulls.len(), 2);
}

#[test]
fn runs_that_do_not_fill_their_raster_are_refused_and_so_are_lines_with_a_loose_end() {
    let whole = map(small_planned());
    let refused = |change: &dyn Fn(&mut MapDocument), pieces: [&str; 2]| {
        let mut own = whole.clone();
        change(&mut own);
        let message = own.check().unwrap_err().to_string();
        assert!(pieces.iter().all(|piece| message.contains(piece)), "{message}");
    };
    whole.check().unwrap();
    refused(&|own| own.margins[0].runs.0.push(1), ["`runs`", "do not fill"]);
    refused(&|own| own.margins[1].runs = MapRuns(vec![u64::MAX, 2]), ["`runs`", "do not fill"]);
    refused(&|own| own.tracks[0].line.north_m.clear(), ["`north_m`", "as of `east_m`"]);
    refused(&|own| own.tracks[0].maneuver = Some("loop".into()), ["`maneuver`", "`loop`"]);
    let vast = MapRaster { columns: 1 << 20, rows: 1 << 20, ..whole.margins[0].raster };
    refused(
        &move |own| {
            own.margins[0].raster = vast;
            own.margins[0].runs = MapRuns(vec![1 << 40]);
        },
        ["`runs`", "at most"],
    );
}

/// The violations of `schema`, with the definitions `all`, in `value`.
fn broken(value: &Value, schema: &Value, all: &Value, path: &str) -> Vec<String> {
    if let Some(name) = schema["$ref"].as_str().and_then(|own| own.strip_prefix("#/$defs/")) {
        return broken(value, &all[name], all, path);
    }
    if let Some(any) = schema["anyOf"].as_array().or(schema["oneOf"].as_array()) {
        let fits = any.iter().any(|one| broken(value, one, all, path).is_empty());
        return if fits { Vec::new() } else { vec![format!("{path}: none of its kinds")] };
    }
    let kind = match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(number) if number.is_u64() => "integer",
        Value::Number(_) => "number",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    };
    let kinds: BTreeSet<&str> = match &schema["type"] {
        Value::String(one) => [one.as_str()].into(),
        Value::Array(any) => any.iter().filter_map(Value::as_str).collect(),
        _ => BTreeSet::new(),
    };
    let is_kind = kinds.is_empty() || kinds.contains(kind) || kind == "integer" && kinds.contains("number");
    let is_choice = schema["enum"].as_array().is_none_or(|choices| choices.contains(value))
        && (schema["const"].is_null() || schema["const"] == *value);
    let mut found = Vec::new();
    if !(is_kind && is_choice) {
        found.push(format!("{path}: {kind}"));
    }
    for item in value.as_array().into_iter().flatten() {
        found.extend(broken(item, &schema["items"], all, path));
    }
    for (key, field) in value.as_object().into_iter().flatten() {
        let own = schema["properties"].get(key).unwrap_or(&schema["additionalProperties"]);
        let path = format!("{path}.{key}");
        if own == &Value::Bool(false) {
            found.push(format!("{path}: unknown"));
        }
        found.extend(broken(field, own, all, &path));
    }
    let needed = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
    found.extend(needed.filter(|key| value.get(key).is_none()).map(|key| format!("{path}: no {key}")));
    found
}

#[test]
fn a_map_keeps_to_its_schema() {
    let schema = json_schema::<MapDocument>();
    for planned in [small_planned(), &everything()] {
        let whole: Value = serde_json::from_slice(planned.study.bytes("map.json")).unwrap();
        assert_eq!(broken(&whole, &schema, &schema["$defs"], ""), Vec::<String>::new());
        let mut other = whole.clone();
        other["data"]["frame"]["west_m"] = "0".into();
        other["data"]["strange"] = 1.into();
        assert_eq!(broken(&other, &schema, &schema["$defs"], "").len(), 2);
    }
}
