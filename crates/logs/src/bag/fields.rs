//! Paths to the fields of a message, and the shape of its values.

/// What is wrong with a message: found, expected.
pub(super) type Wrong = (String, String);

/// A step of a path.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    /// To a field.
    Name(String),
    /// To an element of a list.
    Index(usize),
}

/// The steps of a path such as `position[2].x`; `None` where it is not a path.
pub(super) fn steps(path: &str) -> Option<Vec<Step>> {
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
pub(super) enum Shape {
    Number(Primitive),
    Text,
    Fields(Vec<(String, Shape)>),
    /// Elements of one shape: a fixed number, or as many as a count before them states.
    List(Box<Shape>, Option<usize>),
}

/// A number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Primitive {
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

/// The paths to the numbers of `shape`; of a list, only its first element.
pub(super) fn leaves(shape: &Shape) -> Vec<String> {
    let mut found = Vec::new();
    collect(shape, "", &mut found);
    found
}

fn collect(shape: &Shape, path: &str, found: &mut Vec<String>) {
    match shape {
        _ if found.len() >= MOST_NAMES => {}
        Shape::Number(_) => found.push(path.to_owned()),
        Shape::Text => {}
        Shape::Fields(fields) => {
            for (name, shape) in fields {
                let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                collect(shape, &path, found);
            }
        }
        Shape::List(of, _) => collect(of, &format!("{path}[0]"), found),
    }
}
