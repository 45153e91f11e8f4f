//! From a message's bytes to the values of the wanted fields.

use refusal::{Invalid, foreign, nearest};

use super::cdr::{Cursor, Node};
use super::definition::definition;
use super::fields::{Step, Wrong, leaves, steps};
use super::json;
use crate::columns::some_of;

/// Decodes the messages of a channel.
pub(super) enum Decoder {
    /// CDR, the encoding of ROS 2, by the definition of the message.
    Cdr(Node),
    /// JSON: the paths to the fields, and whether each was found in any message.
    Json(Vec<(Vec<Step>, bool)>),
}

impl Decoder {
    /// A decoder for the fields at `paths` of messages of `topic`; `schema` is name, encoding and text.
    ///
    /// # Errors
    /// An unknown encoding, an unreadable definition, a missing field.
    pub(super) fn new(
        topic: &str,
        encoding: &str,
        schema: Option<(&str, &str, &[u8])>,
        paths: &[String],
    ) -> Result<Self, Invalid> {
        let steps = paths.iter().map(|path| steps(path).ok_or_else(|| no_path(path)));
        let steps = steps.collect::<Result<Vec<_>, _>>()?;
        let (name, kind, text) = schema.unwrap_or(("", "", &[]));
        match (encoding, kind) {
            ("json", _) => Ok(Self::Json(steps.into_iter().map(|steps| (steps, false)).collect())),
            ("cdr", "ros2msg") => {
                let text = String::from_utf8_lossy(text);
                let shape = definition(name, &text).map_err(|found| {
                    let expected = "a definition as `ros2 interface show` has it";
                    let remedy = "record the bag with its message definitions";
                    let thing = format!("schema `{}` of topic `{}`", foreign(name), foreign(topic));
                    Invalid::new(thing, found, expected, remedy)
                })?;
                let wanted: Vec<(usize, &[Step])> = steps.iter().map(Vec::as_slice).enumerate().collect();
                Node::new(&shape, &wanted).map(Self::Cdr).map_err(|slot| {
                    let known = leaves(&shape);
                    let path = &paths[slot];
                    let near = nearest(path, known.iter().map(String::as_str));
                    let remedy = near
                        .map_or("correct it".to_owned(), |near| format!("did you mean `{}`?", foreign(near)));
                    let expected = format!("a number in {}: {}", foreign(name), some_of(&known, path));
                    let thing = format!("column of topic `{}`", foreign(topic));
                    Invalid::new(thing, format!("`{path}`"), expected, remedy)
                })
            }
            _ => Err(Invalid::new(
                format!("encoding of topic `{}`", foreign(topic)),
                format!("messages in `{}` with a schema in `{}`", foreign(encoding), foreign(kind)),
                "cdr with ros2msg, or json",
                "convert the bag, or export the topic as CSV or Parquet",
            )),
        }
    }

    /// Puts the fields of the message `data` into `row`; absent ones leave it unchanged.
    pub(super) fn decode(&mut self, data: &[u8], row: &mut [f64]) -> Result<(), Wrong> {
        match self {
            Self::Cdr(node) => {
                let mut cursor = Cursor::new(data)?;
                node.read(&mut cursor, row).ok_or_else(|| {
                    (format!("{} bytes", data.len()), "a message as long as its definition says".to_owned())
                })
            }
            Self::Json(paths) => json::decode(data, paths, row),
        }
    }

    /// Refuses a field that none of the messages had.
    pub(super) fn check_found(&self, paths: &[String], messages: usize) -> Result<(), Invalid> {
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

fn no_path(path: &str) -> Invalid {
    let expected = "a path such as `twist.twist.linear.x` or `position[2]`";
    Invalid::new("column", format!("`{path}`"), expected, "correct it")
}
