//! Patterns of file names: `*` for anything but `/`, and `{name}` for a part that is asked for.

/// A piece of a pattern.
#[derive(Clone, Debug, PartialEq)]
enum Piece {
    Text(String),
    /// Anything, perhaps nothing.
    Any,
    /// At least one character: the part that is asked for.
    Part,
    /// At least one character.
    Some,
}

/// A pattern in which `*` alone is special.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern(Vec<Piece>);

impl Pattern {
    /// Parses a pattern.
    pub fn new(text: &str) -> Self {
        Self(pieces(text))
    }

    /// Whether `text` fits.
    pub fn fits(&self, text: &str) -> bool {
        fit(&self.0, text).is_some()
    }
}

/// A pattern in which `*` and `{name}` are special, and one such part is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    text: String,
    pieces: Vec<Piece>,
}

impl Template {
    /// Parses a template with a part called `name`; none where there is no such part, a brace is unclosed or its name empty.
    pub fn new(text: &str, name: &str) -> Option<Self> {
        let mut found = Vec::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once('{') {
            found.extend(pieces(before));
            let (named, after) = after.split_once('}')?;
            if named.is_empty() || named.contains('{') {
                return None;
            }
            let first = named == name && !found.contains(&Piece::Part);
            found.push(if first { Piece::Part } else { Piece::Some });
            rest = after;
        }
        found.extend(pieces(rest));
        found.contains(&Piece::Part).then(|| Self { text: text.to_owned(), pieces: found })
    }

    /// As written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The part that is asked for where `text` fits; parts are as short as can be.
    pub fn part<'a>(&self, text: &'a str) -> Option<&'a str> {
        fit(&self.pieces, text)?
    }
}

/// Texts, and [`Piece::Any`] where stars are between them.
fn pieces(text: &str) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for (i, part) in text.split('*').enumerate() {
        pieces.extend((i > 0).then_some(Piece::Any));
        pieces.extend((!part.is_empty()).then(|| Piece::Text(part.to_owned())));
    }
    pieces
}

/// Whether `text` fits `pieces`, and then the part that is asked for.
fn fit<'a>(pieces: &[Piece], text: &'a str) -> Option<Option<&'a str>> {
    let Some((piece, rest)) = pieces.split_first() else { return text.is_empty().then_some(None) };
    if let Piece::Text(known) = piece {
        return fit(rest, text.strip_prefix(known.as_str())?);
    }
    let ends = text.char_indices().map(|(i, _)| i).chain([text.len()]);
    let ends = ends.skip(usize::from(*piece != Piece::Any)).take_while(|end| !text[..*end].contains('/'));
    let fitting = |end: usize| {
        let found = fit(rest, &text[end..])?;
        Some(if *piece == Piece::Part { Some(&text[..end]) } else { found })
    };
    ends.into_iter().find_map(fitting)
}
