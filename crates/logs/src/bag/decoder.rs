//! From a message's bytes to the values of the wanted fields.

use std::cell::Cell;
use std::collections::BTreeMap;

use refusal::{Invalid, foreign, nearest, some_of};
use serde_json::Value;

use crate::bag::Effort;
use crate::bag::binary::{Cursor, Node};
use crate::bag::definition::{Dialect, PathStep, Primitive, Shape, Wrong, definition, known, leaves, steps};

/// Bytes of a field of a message while its shape is known.
const FIELD_BYTES: usize = 128;

/// Decodes the messages of a channel.
pub(crate) enum Decoder {
    /// CDR, the encoding of ROS 2, by the definition of the message.
    Cdr(Node),
    /// Values without gaps, as ROS 1 and ULog have them, by the definition of the message.
    Packed(Node),
    /// JSON: the paths to the fields, and whether each was found in any message.
    Json(Vec<(Vec<PathStep>, bool)>),
}

impl Decoder {
    /// A decoder for the fields at `paths` of messages of `topic`; `schema` is name, encoding and text.
    pub(crate) fn new(
        topic: &str,
        encoding: &str,
        schema: Option<(&str, &str, &[u8])>,
        paths: &[String],
        effort: &Effort,
    ) -> Result<Self, Invalid> {
        let steps = paths.iter().map(|path| steps(path).ok_or_else(|| no_path(path)));
        let steps = steps.collect::<Result<Vec<_>, _>>()?;
        if encoding == "json" {
            return Ok(Self::Json(steps.into_iter().map(|steps| (steps, false)).collect()));
        }
        let schema = schema.unwrap_or(("", "", &[]));
        let shape = shape(topic, encoding, schema, effort)?;
        let wanted: Vec<(usize, &[PathStep])> = steps.iter().map(Vec::as_slice).enumerate().collect();
        let node = Node::new(&shape, &wanted).map_err(|slot| {
            let known = leaves(&shape, 1, effort).unwrap_or_default();
            let path = &paths[slot];
            let near = nearest(path, known.iter().map(String::as_str));
            let remedy =
                near.map_or("correct it".to_owned(), |near| format!("did you mean `{}`?", foreign(near)));
            let expected = format!("a number in {}: {}", foreign(schema.0), some_of(&known, path));
            let thing = format!("column of topic `{}`", foreign(topic));
            Invalid::new(thing, format!("`{path}`"), expected, remedy)
        })?;
        Ok(if encoding == "cdr" { Self::Cdr(node) } else { Self::Packed(node) })
    }

    /// Puts the fields of the message `data` into `row`; absent ones leave it unchanged.
    pub(crate) fn decode(&mut self, data: &[u8], row: &mut [f64], effort: &Effort) -> Result<(), Wrong> {
        effort.earn(data.len());
        let (node, mut cursor) = match self {
            Self::Cdr(node) => (node, Cursor::cdr(data, effort)?),
            Self::Packed(node) => (node, Cursor::packed(data, effort)),
            Self::Json(paths) => return self::decode(data, paths, row, effort),
        };
        node.read(&mut cursor, row).ok_or_else(|| match effort.is_spent() {
            true => (
                format!("elements without end in {} bytes", data.len()),
                "elements that take bytes".to_owned(),
            ),
            false => (format!("{} bytes", data.len()), "a message as long as its definition says".to_owned()),
        })
    }

    /// Refuses a field that none of the messages had.
    pub(crate) fn check_found(&self, paths: &[String], messages: usize) -> Result<(), Invalid> {
        let Self::Json(fields) = self else { return Ok(()) };
        match fields.iter().zip(paths).find(|((_, is_found), _)| messages > 0 && !is_found) {
            Some((_, path)) => {
                let counted = format!("`{path}` in none of {messages} messages");
                Err(Invalid::new("column", counted, "a field of the messages", "correct the path"))
            }
            None => Ok(()),
        }
    }
}

/// The shape of messages of `topic` in `encoding`; the schema is name, encoding and text.
pub(crate) fn shape(
    topic: &str,
    encoding: &str,
    (name, kind, text): (&str, &str, &[u8]),
    effort: &Effort,
) -> Result<Shape, Invalid> {
    effort.text(text.len())?;
    let text = String::from_utf8_lossy(text);
    let made = match (encoding, kind) {
        ("cdr", "ros2msg") => definition(name, &text, Dialect::Ros2, effort),
        ("cdr", "" | "ros2idl") if !name.is_empty() => {
            let known = known(name).ok_or_else(|| undefined(topic, name, kind))?;
            definition(name, &known, Dialect::Ros2, effort)
        }
        ("ros1", "ros1msg") => definition(name, &text, Dialect::Ros1, effort),
        ("ulog", "ulog") => format(name, &text, effort),
        _ => return Err(unknown(topic, encoding, kind)),
    };
    let shape = made.map_err(|problem| {
        let expected = "a definition of each type in it, as the bag's recorder writes them";
        let remedy = "record the bag with its message definitions";
        let thing = format!("schema `{}` of topic `{}`", foreign(name), foreign(topic));
        Invalid::new(thing, problem, expected, remedy)
    })?;
    effort.keep(shape.fields() * FIELD_BYTES)?;
    Ok(shape)
}

fn undefined(topic: &str, name: &str, kind: &str) -> Invalid {
    let definition = if kind.is_empty() { "none in the bag".to_owned() } else { format!("one in {kind}") };
    let remedy = "convert it where its package is installed: `ros2 bag convert`, to the storage `mcap`";
    let thing = format!("definition of `{}` of topic `{}`", foreign(name), foreign(topic));
    Invalid::new(thing, definition, "one in ros2msg, or a common type", remedy)
}

fn unknown(topic: &str, encoding: &str, kind: &str) -> Invalid {
    Invalid::new(
        format!("encoding of topic `{}`", foreign(topic)),
        format!("messages in `{}` with a schema in `{}`", foreign(encoding), foreign(kind)),
        "cdr with ros2msg, or json",
        "convert the bag, or export the topic as CSV or Parquet",
    )
}

fn no_path(path: &str) -> Invalid {
    let expected = "a path such as `twist.twist.linear.x` or `position[2]`";
    Invalid::new("column", format!("`{path}`"), expected, "correct it")
}

/// How many times as many bytes a message takes as values.
const VALUES: usize = 16;

/// Puts the numbers at `paths` of the message `data` into `row`, and notes which paths were found.
fn decode(
    data: &[u8],
    paths: &mut [(Vec<PathStep>, bool)],
    row: &mut [f64],
    effort: &Effort,
) -> Result<(), Wrong> {
    let most = effort.largest / VALUES;
    if data.len() > most {
        return Err((format!("{} bytes", data.len()), format!("at most {most} in JSON")));
    }
    let message: Value = serde_json::from_slice(data)
        .map_err(|error| (foreign(&error.to_string()), "a message in JSON".to_owned()))?;
    for ((path, is_found), cell) in paths.iter_mut().zip(row) {
        let Some(value) = path.iter().try_fold(&message, step) else { continue };
        *is_found = true;
        *cell = match value {
            Value::Number(number) => number.as_f64().unwrap_or(f64::NAN),
            Value::Bool(is) => f64::from(u8::from(*is)),
            Value::Null => f64::NAN,
            other => return Err((format!("`{}`", foreign(&other.to_string())), "a number".to_owned())),
        };
    }
    Ok(())
}

/// The paths to the numbers of the message `data`; of a list the first `few` elements.
pub(crate) fn json_leaves(data: &[u8], few: usize) -> Vec<String> {
    fn collect(value: &Value, path: &str, few: usize, all: &mut Vec<String>) {
        match value {
            Value::Number(_) if all.len() < MOST_FIELDS => all.push(path.to_owned()),
            Value::Array(list) => list
                .iter()
                .take(few)
                .enumerate()
                .for_each(|(i, value)| collect(value, &format!("{path}[{i}]"), few, all)),
            Value::Object(fields) => {
                fields.iter().filter(|(name, _)| !name.contains(['.', '['])).for_each(|(name, value)| {
                    collect(value, format!("{path}.{name}").trim_start_matches('.'), few, all)
                })
            }
            _ => {}
        }
    }
    let mut all = Vec::new();
    serde_json::from_slice(data).into_iter().for_each(|value: Value| collect(&value, "", few, &mut all));
    all
}

fn step<'a>(value: &'a Value, step: &PathStep) -> Option<&'a Value> {
    match step {
        PathStep::Name(name) => value.get(name),
        PathStep::Index(i) => value.get(i),
    }
}

// Definitions of ULog: a line per message, `name:type field;type[3] field`.

/// Depth of nested types beyond which a definition is taken to be recursive.
const DEEPEST: usize = 16;

/// Most fields of a message, and most elements of a list.
const MOST_FIELDS: usize = 20_000;

/// Names of the numeric types.
const NUMBERS: [(&str, Primitive); 12] = [
    ("bool", Primitive::U8),
    ("char", Primitive::U8),
    ("uint8_t", Primitive::U8),
    ("int8_t", Primitive::I8),
    ("uint16_t", Primitive::U16),
    ("int16_t", Primitive::I16),
    ("uint32_t", Primitive::U32),
    ("int32_t", Primitive::I32),
    ("uint64_t", Primitive::U64),
    ("int64_t", Primitive::I64),
    ("float", Primitive::F32),
    ("double", Primitive::F64),
];

/// The shape of messages called `name` by the definitions in `text`.
fn format(name: &str, text: &str, effort: &Effort) -> Result<Shape, String> {
    // The first of several with one name counts.
    let known = text.lines().rev().filter_map(|line| line.split_once(':')).collect();
    Formats { known, effort, left: Cell::new(MOST_FIELDS) }.shape(name, DEEPEST)
}

struct Formats<'a> {
    /// The fields of each message.
    known: BTreeMap<&'a str, &'a str>,
    effort: &'a Effort,
    /// How many more fields are allowed.
    left: Cell<usize>,
}

impl Formats<'_> {
    fn shape(&self, name: &str, deep: usize) -> Result<Shape, String> {
        let fields = self.known.get(name);
        let fields = fields.ok_or_else(|| format!("no definition of `{}`", foreign(name)))?;
        if deep == 0 {
            return Err(format!("`{}` within itself, or types more than {DEEPEST} deep", foreign(name)));
        }
        self.effort.text(fields.len()).map_err(|_| "fields without end, types within types".to_owned())?;
        let fields = fields.split(';').filter(|field| !field.trim().is_empty());
        Ok(Shape::Fields(fields.map(|field| self.field(field, deep)).collect::<Result<_, _>>()?))
    }

    fn field(&self, field: &str, deep: usize) -> Result<(String, Shape), String> {
        let left = self.left.get().checked_sub(1);
        self.left.set(left.ok_or_else(|| format!("more than {MOST_FIELDS} fields, types within types"))?);
        let unreadable = || format!("`{}`", foreign(field));
        let (kind, name) = field.trim().split_once(' ').ok_or_else(unreadable)?;
        let (of, len) = match kind.strip_suffix(']').and_then(|kind| kind.split_once('[')) {
            Some((of, len)) => (of, Some(len.parse::<usize>().map_err(|_| unreadable())?)),
            None => (kind, None),
        };
        if len.is_some_and(|len| len > MOST_FIELDS) {
            return Err(unreadable());
        }
        // What fills up a message is left out at its end.
        if name.starts_with("_padding") {
            return Ok((name.to_owned(), Shape::Padding(len.unwrap_or(1))));
        }
        let one = match NUMBERS.iter().find(|(known, _)| *known == of) {
            Some((_, number)) => Shape::Number(*number),
            None => self.shape(of, deep - 1)?,
        };
        let shape = if len.is_some() { Shape::List(Box::new(one), len) } else { one };
        Ok((name.to_owned(), shape))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bag::definition::leaves;

    fn format(name: &str, text: &str) -> Result<Shape, String> {
        super::format(name, text, &Effort::new(0.0))
    }

    #[test]
    fn types_within_types_are_read_and_those_that_never_end_are_refused() {
        let text = "esc:float rpm;uint8_t[3] _padding0;\ntwo:uint64_t timestamp;esc[2] esc;bool ok\na:b x;\nb:a x;\n";
        assert_eq!(
            leaves(&format("two", text).unwrap(), 8, &Effort::new(0.0)).unwrap(),
            ["timestamp", "esc[0].rpm", "esc[1].rpm", "ok"]
        );
        for (name, said) in [("a", "within itself"), ("c", "no definition of `c`")] {
            let refused = format(name, text).unwrap_err();
            assert!(refused.contains(said), "{refused}");
        }
        assert!(format("a", "a:float[99999999] x;").is_err());
    }
}
