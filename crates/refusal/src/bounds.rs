//! The bounds of numbers are declared with their fields: a value is held against the schema of its type before it is read.
//!
//! A field has `#[schemars(range(min = 0.0, max = 1e4))]`, or `extend("exclusiveMinimum" = 0.0)`, `"x-infinite" = true`. Its unit
//! is what its name ends with, or `x-unit`; `x-expected` replaces what is valid, `x-remedy` how to correct it.

use schemars::{JsonSchema, schema_for};
use serde::Serialize;
use serde::de::{Deserialize, DeserializeOwned, Deserializer, Error};
use serde_json::Value;

use crate::words::short;
use crate::{Contents, Invalid, PathStep, Unreadable, foreign};

/// Reads `T` from `deserializer`. A list in place of a table is refused, because its values would be
/// identified by position alone; so are a key that occurs twice, because the first value would be lost, and
/// surplus values of a list, and a number outside the bounds that `T` declares for it.
///
/// # Errors
/// These, and those of `T`.
pub fn strictly<'de, T: DeserializeOwned + JsonSchema, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<T, D::Error> {
    Contents::deserialize(deserializer)?.read().map_err(D::Error::custom)
}

/// Refuses the first number of `value`, however it came about, outside the bounds that its type declares.
///
/// # Errors
/// Names the number; a value that TOML cannot state.
pub fn check_bounds<T: Serialize + JsonSchema>(value: &T) -> Result<(), Invalid> {
    let unstated =
        |e: String| Invalid::new("file", e, "values that TOML can state", "report this as a defect");
    let written = toml::Value::try_from(value).map_err(|e| unstated(e.to_string()))?;
    let contents = Contents::deserialize(written).map_err(|e| unstated(e.to_string()))?;
    let outside = contents.check_bounds::<T>();
    outside.map_err(|fault| fault.invalid.map_or_else(|| unstated(fault.message), |invalid| *invalid))
}

impl Contents {
    /// As `T`, see [`strictly`].
    ///
    /// # Errors
    /// What is wrong, and the way to it.
    pub fn read<T: DeserializeOwned + JsonSchema>(&self) -> Result<T, Unreadable> {
        self.check_bounds::<T>()?;
        T::deserialize(self)
    }

    /// Refuses the first number outside the bounds that `T` declares for it. What is not of `T` is left to its reader.
    fn check_bounds<T: JsonSchema>(&self) -> Result<(), Unreadable> {
        let whole = schema_for!(T).to_value();
        let mut way = Vec::new();
        within(self, &whole, &whole, &mut way).map_err(|(found, schema)| {
            let key_of =
                |step: &PathStep| if let PathStep::Key(key) = step { Some(key.clone()) } else { None };
            let key = way.iter().rev().find_map(key_of).unwrap_or_default();
            let expected = bounds(&key, schema).unwrap_or("a finite number".to_owned());
            let remedy = schema["x-remedy"].as_str().unwrap_or("correct it");
            let invalid = Invalid::new(self.named(&way), found, expected, remedy);
            Unreadable { message: invalid.to_string(), way, is_key: true, invalid: Some(Box::new(invalid)) }
        })
    }

    /// The value at the end of `way` as a message names it: its keys, and the item of a list that they stand in.
    fn named(&self, way: &[PathStep]) -> String {
        let (mut value, mut list, mut item, mut keys) = (Some(self), "", None, Vec::new());
        for step in way {
            value = match step {
                PathStep::Key(key) => {
                    keys.push(key.as_str());
                    value.and_then(|value| value.entry(key))
                }
                PathStep::Item(place) => {
                    let below = if let Some(Self::List(items)) = value { items.get(*place) } else { None };
                    if matches!(below, Some(Contents::Table(_))) {
                        let name = ["name", "channel", "run", "parameter", "file"]
                            .iter()
                            .find_map(|key| below?.entry(key)?.text());
                        let name = name
                            .map_or_else(|| (place + 1).to_string(), |name| format!("`{}`", foreign(name)));
                        (list, item) = (keys.last().copied().unwrap_or("item"), Some(name));
                        keys.clear();
                    }
                    below
                }
            };
        }
        let keys = keys.join(".");
        item.map_or_else(
            || format!("`{keys}`"),
            |item| format!("`{keys}` of {} {item}", list.replace('_', " ")),
        )
    }

    fn entry(&self, key: &str) -> Option<&Self> {
        let Self::Table(entries) = self else { return None };
        entries.iter().find(|(name, _)| name == key).map(|(_, value)| value)
    }

    fn text(&self) -> Option<&str> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }

    /// As a number, and as a message shows it.
    fn number(&self) -> Option<(f64, String)> {
        match self {
            Self::Signed(number) => Some((*number as f64, number.to_string())),
            Self::Whole(number) => Some((*number as f64, number.to_string())),
            Self::Real(number) => Some((*number, short(*number))),
            _ => None,
        }
    }

    /// Whether `schema`, one of several, is meant for it: by its type, and a table by its constants and keys.
    fn is_meant(&self, schema: &Value, whole: &Value) -> bool {
        let schema = resolved(schema, whole);
        let kinds: &[&str] = match self {
            Self::Nothing => &["null"],
            Self::Truth(_) => &["boolean"],
            Self::Signed(_) | Self::Whole(_) => &["integer", "number"],
            Self::Real(_) => &["number"],
            Self::Text(_) => &["string"],
            Self::List(_) => &["array"],
            Self::Table(_) => &["object"],
        };
        let fits =
            |value: &Value, part: &Self| value["const"].as_str().is_none_or(|text| part.text() == Some(text));
        let mut properties = schema["properties"].as_object().into_iter().flatten();
        let mut required = listed(&schema["required"]).filter_map(Value::as_str);
        (schema["type"].is_null() || kinds.iter().any(|kind| is(schema, kind)))
            && fits(schema, self)
            && properties.all(|(key, value)| self.entry(key).is_none_or(|part| fits(value, part)))
            && required.all(|key| self.entry(key).is_some())
    }
}

/// A schema, or what it refers to.
fn resolved<'a>(schema: &'a Value, whole: &'a Value) -> &'a Value {
    let target = schema["$ref"].as_str().and_then(|to| whole.pointer(to.trim_start_matches('#')));
    target.map_or(schema, |target| resolved(target, whole))
}

/// Fails at the first number outside of its bounds, with what was found and the schema that does not allow it; `way` then
/// leads there.
fn within<'a>(
    contents: &Contents,
    schema: &'a Value,
    whole: &'a Value,
    way: &mut Vec<PathStep>,
) -> Result<(), (String, &'a Value)> {
    // A number that should be whole and is not is its reader's.
    let read = contents.number().filter(|(number, _)| !is(schema, "integer") || number.fract() == 0.0);
    if let Some((number, found)) = read {
        let [least, greatest] = ends(schema);
        let above = |(end, is_valid): (f64, bool)| number > end || is_valid && number == end;
        let below = |(end, is_valid): (f64, bool)| number < end || is_valid && number == end;
        let is_number = number.is_finite() || schema["x-infinite"] == true && !number.is_nan();
        if !(least.is_none_or(above) && greatest.is_none_or(below) && (is_number || !is(schema, "number"))) {
            return Err((found, schema));
        }
    }
    if let Contents::List(items) = contents
        && most_items(schema).is_some_and(|most| items.len() as u64 > most)
    {
        return Err((items.len().to_string(), schema));
    }
    if schema.get("$ref").is_some() {
        within(contents, resolved(schema, whole), whole, way)?;
    }
    listed(&schema["allOf"]).try_for_each(|part| within(contents, part, whole, way))?;
    for key in ["oneOf", "anyOf"] {
        if let Some(meant) = listed(&schema[key]).find(|one| contents.is_meant(one, whole)) {
            within(contents, meant, whole, way)?;
        }
    }
    let mut below = |step: PathStep, value: &Contents, schema: Option<&'a Value>| {
        let Some(schema) = schema else { return Ok(()) };
        way.push(step);
        within(value, schema, whole, way)?;
        way.pop();
        Ok(())
    };
    match contents {
        Contents::Table(entries) => entries.iter().try_for_each(|(key, value)| {
            let of_key = schema["properties"].get(key).or_else(|| schema.get("additionalProperties"));
            below(PathStep::Key(key.clone()), value, of_key)
        }),
        Contents::List(items) => items.iter().enumerate().try_for_each(|(place, item)| {
            let of_place = schema["prefixItems"].get(place).or_else(|| schema.get("items"));
            below(PathStep::Item(place), item, of_place)
        }),
        _ => Ok(()),
    }
}

fn listed(list: &Value) -> impl Iterator<Item = &Value> {
    list.as_array().into_iter().flatten()
}

/// Whether `schema` is of a type.
fn is(schema: &Value, kind: &str) -> bool {
    schema["type"] == kind || listed(&schema["type"]).any(|one| one == kind)
}

/// The most items of a list, if their number is not fixed.
fn most_items(schema: &Value) -> Option<u64> {
    schema["maxItems"].as_u64().filter(|_| schema["maxItems"] != schema["minItems"])
}

/// The least and the greatest number of a schema, each with whether it is valid itself.
fn ends(schema: &Value) -> [Option<(f64, bool)>; 2] {
    [["minimum", "exclusiveMinimum"], ["maximum", "exclusiveMaximum"]].map(|[with, without]| {
        let end = |key: &str, is_valid| schema[key].as_f64().map(|end| (end, is_valid));
        end(without, false).or_else(|| end(with, true))
    })
}

/// What `schema`, that of the value of `key`, allows, in words with its unit; `None` where it has no bounds.
pub fn bounds(key: &str, schema: &Value) -> Option<String> {
    if let Some(words) = schema["x-expected"].as_str() {
        return Some(words.to_owned());
    }
    if let Some(most) = most_items(schema) {
        return Some(format!("at most {most} of them"));
    }
    let of_name = || UNITS.iter().find(|(end, _)| key.ends_with(end)).map(|(_, unit)| *unit);
    let unit = schema["x-unit"].as_str().or_else(of_name).unwrap_or_default();
    let whole = if is(schema, "integer") { "a whole number from " } else { "" };
    let number = |end: f64| format!("{} {unit}", short(end)).trim_end().to_owned();
    let from = |(end, is_valid)| match is_valid {
        true => format!("{} or more", number(end)),
        false => format!("above {}", number(end)),
    };
    let to = |(end, is_valid)| format!("{} {}", if is_valid { "at most" } else { "below" }, number(end));
    Some(match ends(schema) {
        [Some((least, true)), None] if !whole.is_empty() => format!("{whole}{least}"),
        [Some((least, true)), Some((greatest, true))] => {
            format!("{whole}{} to {}", short(least), number(greatest))
        }
        [Some(least), Some(greatest)] => format!("{}, {}", from(least), to(greatest)),
        [Some(least), None] => from(least),
        [None, Some(greatest)] => to(greatest),
        [None, None] => return None,
    })
}

/// Ends of names, and the units that they mean: the longer ones first.
const UNITS: [(&str, &str); 9] = [
    ("_m_s2", "m/s²"),
    ("_rad_s", "rad/s"),
    ("_kg_m3", "kg/m³"),
    ("_m_s", "m/s"),
    ("_deg", "°"),
    ("_rad", "rad"),
    ("_hz", "Hz"),
    ("_m", "m"),
    ("_s", "s"),
];
