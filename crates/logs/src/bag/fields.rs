//! Paths to the fields of a message, and the shape of its values.

use refusal::Invalid;

use crate::bag::effort::Effort;

/// What is wrong with a message: found, expected.
pub(crate) type Wrong = (String, String);

/// A step of a path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Step {
    /// To a field.
    Name(String),
    /// To an element of a list.
    Index(usize),
}

/// The steps of a path such as `position[2].x`; `None` where it is not a path.
pub(crate) fn steps(path: &str) -> Option<Vec<Step>> {
    let mut steps = Vec::new();
    for part in path.split('.') {
        let (name, mut rest) = part.split_at(part.find('[').unwrap_or(part.len()));
        if name.is_empty() {
            return None;
        }
        steps.push(Step::Name(name.to_owned()));
        while !rest.is_empty() {
            let (index, after) = rest.strip_prefix('[')?.split_once(']')?;
            steps.push(Step::Index(index.parse().ok()?));
            rest = after;
        }
    }
    Some(steps)
}

/// The shape of a value of a message.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Shape {
    Number(Primitive),
    Text,
    /// Bytes without a meaning, which the end of a message may lack.
    Padding(usize),
    Fields(Vec<(String, Shape)>),
    /// Elements of one shape: a fixed number, or as many as a count before them states.
    List(Box<Shape>, Option<usize>),
}

/// A number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Primitive {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

/// Most names to search for the one that was meant.
const MOST_NAMES: usize = 1000;

impl Shape {
    /// How many fields and lists it has.
    pub(crate) fn fields(&self) -> usize {
        1 + match self {
            Self::Fields(fields) => fields.iter().map(|(_, shape)| shape.fields()).sum(),
            Self::List(of, _) => of.fields(),
            Self::Number(_) | Self::Text | Self::Padding(_) => 0,
        }
    }
}

/// The paths to the numbers of `shape`; of a list all elements if they are `few` at most, else the first.
///
/// # Errors
/// More paths, to anything or to nothing, than `effort` allows.
pub(crate) fn leaves(shape: &Shape, few: usize, effort: &Effort) -> Result<Vec<String>, Invalid> {
    let mut found = Vec::new();
    collect(shape, "", few, effort, &mut found)?;
    Ok(found)
}

fn collect(
    shape: &Shape,
    path: &str,
    few: usize,
    effort: &Effort,
    found: &mut Vec<String>,
) -> Result<(), Invalid> {
    effort.text(path.len())?;
    match shape {
        _ if found.len() >= MOST_NAMES => Ok(()),
        Shape::Number(_) => {
            effort.keep(path.len())?;
            found.push(path.to_owned());
            Ok(())
        }
        Shape::Text | Shape::Padding(_) => Ok(()),
        Shape::Fields(fields) => fields.iter().try_for_each(|(name, shape)| {
            let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            collect(shape, &path, few, effort, found)
        }),
        Shape::List(of, len) => {
            let listed = len.filter(|len| *len <= few).unwrap_or(1);
            (0..listed).try_for_each(|i| collect(of, &format!("{path}[{i}]"), few, effort, found))
        }
    }
}
