//! From a message's bytes to the values of the wanted fields.

use refusal::{Invalid, foreign, nearest, some_of};

use crate::bag::binary::{Cursor, Node};
use crate::bag::definition::{Dialect, definition};
use crate::bag::effort::Effort;
use crate::bag::fields::{Shape, Step, Wrong, leaves, steps};
use crate::bag::formats::format;
use crate::bag::json;
use crate::bag::known::known;

/// Bytes of a field of a message while its shape is known.
const FIELD_BYTES: usize = 128;

/// Decodes the messages of a channel.
pub(crate) enum Decoder {
    /// CDR, the encoding of ROS 2, by the definition of the message.
    Cdr(Node),
    /// Values without gaps, as ROS 1 and ULog have them, by the definition of the message.
    Packed(Node),
    /// JSON: the paths to the fields, and whether each was found in any message.
    Json(Vec<(Vec<Step>, bool)>),
}

impl Decoder {
    /// A decoder for the fields at `paths` of messages of `topic`; `schema` is name, encoding and text.
    ///
    /// # Errors
    /// An unknown encoding, an unreadable definition, a missing field.
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
        let wanted: Vec<(usize, &[Step])> = steps.iter().map(Vec::as_slice).enumerate().collect();
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
            Self::Json(paths) => return json::decode(data, paths, row, effort),
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
        let Self::Json(found) = self else { return Ok(()) };
        match found.iter().zip(paths).find(|((_, found), _)| messages > 0 && !found) {
            Some((_, path)) => {
                let found = format!("`{path}` in none of {messages} messages");
                Err(Invalid::new("column", found, "a field of the messages", "correct the path"))
            }
            None => Ok(()),
        }
    }
}

/// The shape of messages of `topic` in `encoding`; the schema is name, encoding and text.
///
/// # Errors
/// An unknown encoding, a definition that is missing or cannot be read.
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
    let shape = made.map_err(|found| {
        let expected = "a definition of each type in it, as the bag's recorder writes them";
        let remedy = "record the bag with its message definitions";
        let thing = format!("schema `{}` of topic `{}`", foreign(name), foreign(topic));
        Invalid::new(thing, found, expected, remedy)
    })?;
    effort.keep(shape.fields() * FIELD_BYTES)?;
    Ok(shape)
}

fn undefined(topic: &str, name: &str, kind: &str) -> Invalid {
    let found = if kind.is_empty() { "none in the bag".to_owned() } else { format!("one in {kind}") };
    let remedy = "convert it where its package is installed: `ros2 bag convert`, to the storage `mcap`";
    let thing = format!("definition of `{}` of topic `{}`", foreign(name), foreign(topic));
    Invalid::new(thing, found, "one in ros2msg, or a common type", remedy)
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
