//! Message definitions as bags hold them: the message's own fields, then those of each type that it uses,
//! with a line of `=` and `MSG: package/Type` before each.
//! <https://docs.ros.org/en/rolling/Concepts/Basic/About-Interfaces.html>

use std::cell::Cell;
use std::collections::BTreeMap;

use refusal::foreign;

use crate::bag::effort::Effort;
use crate::bag::fields::{Primitive, Shape};

/// Depth of nested types beyond which a definition is taken to be recursive.
const DEEPEST: usize = 32;

/// Most fields of a message, including those of nested types wherever they are used.
const MOST_FIELDS: usize = 20_000;

/// Most types of a definition.
const MOST_TYPES: usize = 2000;

/// Most bytes of a definition.
pub(crate) const LONGEST: usize = 1 << 20;

/// Most elements of a list whose length the definition states.
const MOST_ELEMENTS: usize = 1 << 27;

/// Names of the numeric types.
const NUMBERS: [(&str, Primitive); 13] = [
    ("bool", Primitive::U8),
    ("byte", Primitive::U8),
    ("char", Primitive::U8),
    ("uint8", Primitive::U8),
    ("int8", Primitive::I8),
    ("uint16", Primitive::U16),
    ("int16", Primitive::I16),
    ("uint32", Primitive::U32),
    ("int32", Primitive::I32),
    ("uint64", Primitive::U64),
    ("int64", Primitive::I64),
    ("float32", Primitive::F32),
    ("float64", Primitive::F64),
];

/// Whose definitions they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dialect {
    /// Times are numbers of the language.
    Ros1,
    /// Times are messages.
    Ros2,
}

/// The types of a definition.
struct Types<'a> {
    dialect: Dialect,
    effort: &'a Effort,
    /// The lines of each `package/Type`.
    lines: BTreeMap<String, Vec<&'a str>>,
    /// How many more fields are allowed.
    left: Cell<usize>,
}

/// The shape of messages of type `name` by the definition in `text`.
///
/// # Errors
/// Why it cannot be read.
pub(crate) fn definition(name: &str, text: &str, dialect: Dialect, effort: &Effort) -> Result<Shape, String> {
    if text.len() > LONGEST {
        return Err(format!("{} bytes, which are more than {LONGEST}", text.len()));
    }
    let mut all = vec![(short(name), Vec::new())];
    for line in text.lines().map(str::trim) {
        if let Some(next) = line.strip_prefix("MSG:") {
            all.push((short(next.trim()), Vec::new()));
        } else if let Some((_, lines)) = all.last_mut().filter(|_| !line.starts_with("==")) {
            lines.push(line);
        }
    }
    if all.len() > MOST_TYPES {
        return Err(format!("{} types, which are more than {MOST_TYPES}", all.len()));
    }
    // The first of several with one name counts.
    let lines = all.into_iter().rev().collect();
    let types = Types { dialect, effort, lines, left: Cell::new(MOST_FIELDS) };
    types.shape(&short(name), DEEPEST)
}

/// Seconds and nanoseconds, called as in ROS 2.
fn time(kind: Primitive) -> Shape {
    Shape::Fields(["sec", "nanosec"].map(|name| (name.to_owned(), Shape::Number(kind))).to_vec())
}

/// `package/Type` of `package/msg/Type`.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

impl Types<'_> {
    fn shape(&self, name: &str, deep: usize) -> Result<Shape, String> {
        let lines = self.lines.get(name);
        let lines = lines.ok_or_else(|| format!("no definition of `{}`", foreign(name)))?;
        if deep == 0 {
            return Err(format!("`{}` within itself, or types more than {DEEPEST} deep", foreign(name)));
        }
        let package = name.split_once('/').map_or("", |(package, _)| package);
        let fields = lines.iter().filter_map(|line| self.field(line, package, deep).transpose());
        Ok(Shape::Fields(fields.collect::<Result<_, _>>()?))
    }

    /// The field on a line: `None` for blank lines, comments, and constants, which messages do not contain.
    fn field(&self, line: &str, package: &str, deep: usize) -> Result<Option<(String, Shape)>, String> {
        self.effort.text(line.len()).map_err(|_| "lines without end, types within types".to_owned())?;
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_whitespace();
        let (Some(kind), Some(name)) = (words.next(), words.next()) else {
            return if line.trim().is_empty() { Ok(None) } else { Err(format!("`{}`", foreign(line))) };
        };
        if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
            return Ok(None);
        }
        let left = self.left.get().checked_sub(1);
        self.left.set(left.ok_or_else(|| format!("more than {MOST_FIELDS} fields, types within types"))?);
        Ok(Some((name.to_owned(), self.kind(kind, package, deep)?)))
    }

    fn kind(&self, kind: &str, package: &str, deep: usize) -> Result<Shape, String> {
        if let Some((of, len)) = kind.strip_suffix(']').and_then(|kind| kind.rsplit_once('[')) {
            let fixed = !(len.is_empty() || len.starts_with("<="));
            let len = fixed.then(|| len.parse().map_err(|_| format!("`{}`", foreign(kind)))).transpose()?;
            if of.ends_with(']') || len.is_some_and(|len| !(1..=MOST_ELEMENTS).contains(&len)) {
                let lists = "lists have one length, from 1 on";
                return Err(format!("`{}`: {lists}", foreign(kind)));
            }
            return Ok(Shape::List(Box::new(self.kind(of, package, deep)?), len));
        }
        let kind = kind.split("<=").next().unwrap_or(kind);
        // A byte of ROS 1 has a sign.
        if self.dialect == Dialect::Ros1 && kind == "byte" {
            return Ok(Shape::Number(Primitive::I8));
        }
        if let Some((_, number)) = NUMBERS.iter().find(|(known, _)| *known == kind) {
            return Ok(Shape::Number(*number));
        }
        match kind {
            "string" => Ok(Shape::Text),
            "time" if self.dialect == Dialect::Ros1 => Ok(time(Primitive::U32)),
            "duration" if self.dialect == Dialect::Ros1 => Ok(time(Primitive::I32)),
            // Its length in bytes depends on the implementation.
            "wstring" => Err("a field of type `wstring`".to_owned()),
            kind if kind.contains('/') => self.shape(&short(kind), deep - 1),
            "Header" => self.shape("std_msgs/Header", deep - 1),
            kind => self.shape(&format!("{package}/{kind}"), deep - 1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn definition(name: &str, text: &str, dialect: Dialect) -> Result<Shape, String> {
        super::definition(name, text, dialect, &Effort::new(0.0))
    }

    #[test]
    fn comments_constants_defaults_and_types_of_other_packages_are_read() {
        let text = "# A pose\nstd_msgs/Header header\nuint8 OK=0\nint32 NONE = -1\nPoint[2] corners # two\nstring<=5 name \"x\"\n\
            float64[] weights\n================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n=====\n\
            MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n====\nMSG: geometry_msgs/Point\nfloat64 x\nfloat32 y 1.5\n";
        let shape = definition("geometry_msgs/msg/Thing", text, Dialect::Ros2).unwrap();
        let paths =
            ["header.stamp.sec", "header.stamp.nanosec", "corners[0].x", "corners[0].y", "weights[0]"];
        assert_eq!(crate::bag::fields::leaves(&shape, 1, &Effort::new(0.0)).unwrap(), paths);
        let circle = definition("a/A", "A next\n", Dialect::Ros2).unwrap_err();
        assert!(circle.contains("within itself"), "{circle}");
        assert!(definition("a/A", "B next\n", Dialect::Ros2).unwrap_err().contains("no definition of `a/B`"));
    }

    #[test]
    fn definitions_that_never_end_are_refused_by_what_they_exceed() {
        let twice = |deep: usize| {
            let of = |i: usize| format!("====\nMSG: a/T{i}\nT{} x\nT{} y\n", i + 1, i + 1);
            "T0 x\n".to_owned()
                + &(0..deep).map(of).collect::<String>()
                + &format!("====\nMSG: a/T{deep}\nint8 x\n")
        };
        assert!(definition("a/A", &twice(10), Dialect::Ros2).is_ok());
        for (text, said) in [
            (twice(28), "more than 20000 fields"),
            ("uint8".to_owned() + &"[2]".repeat(200_000) + " x\n", "one length"),
            ("uint8[0][4294967295] x\n".to_owned(), "one length"),
            ("uint8[0] x\n".to_owned(), "one length"),
            ("====\nMSG: a/B\n".repeat(3000), "3001 types"),
            ("#".repeat(LONGEST + 1), "more than 1048576"),
            ("B x\n".repeat(19_000) + "=\nMSG: a/B\n" + &"int8 A=1\n".repeat(50_000), "lines without end"),
        ] {
            let refused = definition("a/A", &text, Dialect::Ros2).unwrap_err();
            assert!(refused.contains(said) && refused.len() < 200, "{refused}");
        }
    }
}
