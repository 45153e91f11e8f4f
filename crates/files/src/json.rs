//! JSON texts: readable ones, and numbers that JSON cannot hold, which serde_json would write as null.

use std::fmt::Display;

use refusal::PathStep;
use serde::ser::{self, Serialize, Serializer};
use serde_json::Value;

/// The field path and value of the first number in `data` that is not finite,
/// like `("maneuvers[2].gap", "NaN")`.
pub(crate) fn first_not_finite(data: &impl Serialize) -> Option<(String, String)> {
    let mut check = FiniteCheck::default();
    match data.serialize(&mut check) {
        Err(Stop::NotFinite(value)) => Some((check.path(), value.to_string())),
        Ok(()) | Err(Stop::Other) => None,
    }
}

/// A serializer that writes nothing and tracks its path.
#[derive(Default)]
struct FiniteCheck {
    steps: Vec<PathStep>,
}

/// Why the check ended early.
#[derive(Debug, thiserror::Error)]
#[error("stopped")]
enum Stop {
    NotFinite(f64),
    /// The data's own serializer failed; the real serializer will report that.
    Other,
}

impl FiniteCheck {
    fn path(&self) -> String {
        let mut path = String::new();
        for step in &self.steps {
            match step {
                PathStep::Key(name) if path.is_empty() => path.push_str(name),
                PathStep::Key(name) => path.extend([".", name]),
                PathStep::Item(index) => path.push_str(&format!("[{index}]")),
            }
        }
        path
    }

    /// Visits `value` under `step`; on an error the step stays, so that the path can be reported.
    fn visit<T: Serialize + ?Sized>(&mut self, step: PathStep, value: &T) -> Result<(), Stop> {
        self.steps.push(step);
        value.serialize(&mut *self)?;
        self.steps.pop();
        Ok(())
    }
}

impl ser::Error for Stop {
    fn custom<T: Display>(_: T) -> Self {
        Self::Other
    }
}

/// Inside a list, a map or a struct.
struct Level<'a> {
    check: &'a mut FiniteCheck,
    index: usize,
    key: String,
}

impl Level<'_> {
    fn item<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Stop> {
        let step = PathStep::Item(self.index);
        self.index += 1;
        self.check.visit(step, value)
    }
}

macro_rules! nothing_to_find {
    ($($name:ident($($type:ty),*)),* $(,)?) => {
        $(fn $name(self $(, _: $type)*) -> Result<(), Stop> { Ok(()) })*
    };
}

macro_rules! levels {
    ($($name:ident($($type:ty),*)),* $(,)?) => {
        $(fn $name(self $(, _: $type)*) -> Result<Level<'a>, Stop> {
            Ok(Level { check: self, index: 0, key: String::new() })
        })*
    };
}

impl<'a> Serializer for &'a mut FiniteCheck {
    type Ok = ();
    type Error = Stop;
    type SerializeSeq = Level<'a>;
    type SerializeTuple = Level<'a>;
    type SerializeTupleStruct = Level<'a>;
    type SerializeTupleVariant = Level<'a>;
    type SerializeMap = Level<'a>;
    type SerializeStruct = Level<'a>;
    type SerializeStructVariant = Level<'a>;

    nothing_to_find! {
        serialize_bool(bool), serialize_i8(i8), serialize_i16(i16), serialize_i32(i32), serialize_i64(i64),
        serialize_i128(i128), serialize_u8(u8), serialize_u16(u16), serialize_u32(u32), serialize_u64(u64),
        serialize_u128(u128), serialize_char(char), serialize_str(&str), serialize_bytes(&[u8]),
        serialize_none(), serialize_unit(), serialize_unit_struct(&'static str),
        serialize_unit_variant(&'static str, u32, &'static str),
    }

    levels! {
        serialize_seq(Option<usize>), serialize_tuple(usize), serialize_tuple_struct(&'static str, usize),
        serialize_tuple_variant(&'static str, u32, &'static str, usize), serialize_map(Option<usize>),
        serialize_struct(&'static str, usize),
        serialize_struct_variant(&'static str, u32, &'static str, usize),
    }

    fn serialize_f32(self, value: f32) -> Result<(), Stop> {
        self.serialize_f64(f64::from(value))
    }

    fn serialize_f64(self, value: f64) -> Result<(), Stop> {
        if value.is_finite() { Ok(()) } else { Err(Stop::NotFinite(value)) }
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), Stop> {
        value.serialize(self)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Result<(), Stop> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<(), Stop> {
        self.visit(PathStep::Key(variant.to_owned()), value)
    }
}

macro_rules! visit_items {
    ($($kind:ident: $method:ident),* $(,)?) => {
        $(impl ser::$kind for Level<'_> {
            type Ok = ();
            type Error = Stop;

            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Stop> {
                self.item(value)
            }

            fn end(self) -> Result<(), Stop> {
                Ok(())
            }
        })*
    };
}

macro_rules! visit_fields {
    ($($kind:ident),*) => {
        $(impl ser::$kind for Level<'_> {
            type Ok = ();
            type Error = Stop;

            fn serialize_field<T: Serialize + ?Sized>(&mut self, key: &'static str, value: &T) -> Result<(), Stop> {
                self.check.visit(PathStep::Key(key.to_owned()), value)
            }

            fn end(self) -> Result<(), Stop> {
                Ok(())
            }
        })*
    };
}

visit_items!(
    SerializeSeq: serialize_element,
    SerializeTuple: serialize_element,
    SerializeTupleStruct: serialize_field,
    SerializeTupleVariant: serialize_field,
);
visit_fields!(SerializeStruct, SerializeStructVariant);

impl ser::SerializeMap for Level<'_> {
    type Ok = ();
    type Error = Stop;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), Stop> {
        self.key = match serde_json::to_value(key) {
            Ok(serde_json::Value::String(text)) => text,
            Ok(other) => other.to_string(),
            Err(_) => return Err(Stop::Other),
        };
        Ok(())
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Stop> {
        let key = std::mem::take(&mut self.key);
        self.check.visit(PathStep::Key(key), value)
    }

    fn end(self) -> Result<(), Stop> {
        Ok(())
    }
}

/// The readable text of `value`, ending in a line break: two spaces per level, lists of plain values on one line.
pub(crate) fn pretty(value: &Value) -> String {
    let mut text = String::new();
    write(&mut text, value, 0);
    text.push('\n');
    text
}

fn write(out: &mut String, value: &Value, depth: usize) {
    match value {
        Value::Array(items) if items.iter().any(is_nested) => {
            write_lines(out, ['[', ']'], items.iter().map(|item| (None, item)), depth);
        }
        Value::Array(items) => {
            let items: Vec<String> = items.iter().map(Value::to_string).collect();
            out.push_str(&format!("[{}]", items.join(", ")));
        }
        Value::Object(fields) if !fields.is_empty() => {
            let fields = fields.iter().map(|(key, value)| (Some(key.as_str()), value));
            write_lines(out, ['{', '}'], fields, depth);
        }
        plain => out.push_str(&plain.to_string()),
    }
}

fn is_nested(value: &Value) -> bool {
    value.is_array() || value.is_object()
}

fn write_lines<'a>(
    out: &mut String,
    [open, close]: [char; 2],
    entries: impl Iterator<Item = (Option<&'a str>, &'a Value)>,
    depth: usize,
) {
    out.push(open);
    for (i, (key, value)) in entries.enumerate() {
        out.push_str(if i == 0 { "\n" } else { ",\n" });
        out.push_str(&"  ".repeat(depth + 1));
        if let Some(key) = key {
            out.push_str(&Value::from(key).to_string());
            out.push_str(": ");
        }
        write(out, value, depth + 1);
    }
    out.push('\n');
    out.push_str(&"  ".repeat(depth));
    out.push(close);
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde_json::json;

    use super::*;

    #[derive(serde::Serialize)]
    enum Shape {
        Pair(f64, f64),
        Named { side: Option<f64> },
    }

    #[derive(serde::Serialize)]
    struct Data {
        shares: BTreeMap<&'static str, Vec<f64>>,
        shapes: Vec<Shape>,
        absent: Option<f64>,
    }

    fn data(share: f64, pair: f64, side: f64) -> Data {
        let shares = BTreeMap::from([("sine", vec![0.5, share])]);
        let shapes = vec![Shape::Pair(1.0, pair), Shape::Named { side: Some(side) }];
        Data { shares, shapes, absent: None }
    }

    #[test]
    fn the_path_of_the_first_is_reported() {
        let path = |data: Data| first_not_finite(&data).map(|(path, _)| path);
        assert_eq!(path(data(0.5, 1.0, 1.0)), None);
        assert_eq!(path(data(f64::NAN, f64::NAN, 1.0)).as_deref(), Some("shares.sine[1]"));
        assert_eq!(path(data(0.5, f64::INFINITY, 1.0)).as_deref(), Some("shapes[0][1]"));
        assert_eq!(path(data(0.5, 1.0, f64::NEG_INFINITY)).as_deref(), Some("shapes[1].side"));
    }

    #[test]
    fn rows_stay_on_one_line() {
        let value = json!({"a \"b\"": [[1, 2.5], [null, "x"]], "empty": {}, "none": [], "deep": {"c": true}});
        let expected = r#"{
  "a \"b\"": [
    [1, 2.5],
    [null, "x"]
  ],
  "empty": {},
  "none": [],
  "deep": {
    "c": true
  }
}
"#;
        assert_eq!(pretty(&value), expected);
        assert_eq!(serde_json::from_str::<Value>(expected).unwrap(), value);
    }
}
