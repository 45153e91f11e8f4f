//! Definitions of ULog: a line per message, `name:type field;type[3] field`.

use std::cell::Cell;
use std::collections::BTreeMap;

use refusal::foreign;

use crate::bag::effort::Effort;
use crate::bag::fields::{Primitive, Shape};

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
///
/// # Errors
/// Why it cannot be read.
pub(crate) fn format(name: &str, text: &str, effort: &Effort) -> Result<Shape, String> {
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
    use crate::bag::fields::leaves;

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
