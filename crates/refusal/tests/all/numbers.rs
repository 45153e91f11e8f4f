//! Numbers within ranges.

use refusal::{check_ranges, strictly};
use schemars::JsonSchema;
use serde::Deserialize;

#[test]
fn numbers_beyond_their_range_are_refused_with_it() {
    let check = |value| check_ranges([("window_s", value, 1e-6..=1e7, "s")]).map_err(|e| e.to_string());
    assert_eq!(check(3.0), Ok(()));
    let message = check(1.8446744073709552e19).unwrap_err();
    assert_eq!(message, "`window_s`: found 1.8446744073709552e19, expected 1e-6 to 1e7 s; correct it");
    assert!(check(f64::NAN).unwrap_err().contains("found NaN"));
    assert!(check(-1.0).unwrap_err().contains("found -1,"));
}

#[derive(Debug, Deserialize, JsonSchema)]
#[allow(dead_code)]
struct Ship {
    #[schemars(range(max = 400.0), extend("exclusiveMinimum" = 0.0))]
    length_m: Option<f64>,
    #[schemars(range(min = 1, max = 9))]
    #[serde(default)]
    count: u8,
    #[serde(default)]
    #[schemars(length(max = 3))]
    rudder: Vec<Rudder>,
    #[serde(default)]
    free: f64,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase")]
#[allow(dead_code)]
enum Rudder {
    Single {
        name: String,
        #[schemars(range(min = 0.0), extend("x-unit" = "m²", "x-remedy" = "leave it out"))]
        area: f64,
    },
    Double {
        #[schemars(inner(range(min = -2.0, max = 2.0)))]
        y_m: [f64; 2],
    },
}

/// The number, its place by its keys and the item that has it, and its bounds with their unit.
#[test]
fn numbers_beyond_the_bounds_of_their_type_are_refused_with_them() {
    let read = |text: &str| {
        strictly::<Ship, _>(&mut serde_json::Deserializer::from_str(text)).map_err(|e| e.to_string())
    };
    for (text, said) in [
        (r#"{"length_m": 400}"#, ""),
        (r#"{"length_m": null, "count": 9}"#, ""),
        (r#"{"length_m": 0}"#, "`length_m`: found 0, expected above 0 m, at most 400 m; correct it"),
        (r#"{"length_m": 400.5}"#, "`length_m`: found 400.5, expected above 0 m, at most 400 m; correct it"),
        (r#"{"count": 0}"#, "`count`: found 0, expected a whole number from 1 to 9; correct it"),
        (r#"{"count": 1.5}"#, "invalid type: floating point `1.5`, expected u8"),
        (
            r#"{"rudder": [{"kind": "double", "y_m": [-2, 2]}, {"kind": "single", "name": "port", "area": -1}]}"#,
            "`area` of rudder `port`: found -1, expected 0 m² or more; leave it out",
        ),
        (
            r#"{"rudder": [{"kind": "double", "y_m": [-2, 3]}]}"#,
            "`y_m` of rudder 1: found 3, expected -2 to 2 m; correct it",
        ),
        (r#"{"rudder": [1, 2, 3, 4]}"#, "`rudder`: found 4, expected at most 3 of them; correct it"),
    ] {
        let found = read(text).err().unwrap_or_default();
        assert!(found.starts_with(said) && found.is_empty() == said.is_empty(), "{text}: {found}");
    }
}
