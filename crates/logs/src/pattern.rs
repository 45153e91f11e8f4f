//! Patterns of file names: `*` for anything but `/`, and `{name}` for a part to be extracted.

/// A token of a pattern.
#[derive(Clone, Debug, PartialEq)]
enum Token {
    Text(String),
    /// Anything, also nothing.
    Any,
    /// At least one character: the part to be extracted.
    Part,
    /// At least one character.
    Some,
}

/// A pattern in which only `*` is special.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern(Vec<Token>);

impl Pattern {
    /// Parses a pattern.
    pub fn new(text: &str) -> Self {
        Self(tokens(text))
    }

    /// Whether `text` fits.
    pub fn fits(&self, text: &str) -> bool {
        fit(&self.0, text).is_some()
    }
}

/// A pattern in which `*` and `{name}` are special, with one such part to be extracted.
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    text: String,
    tokens: Vec<Token>,
}

impl Template {
    /// Parses a template with a part called `name`; `None` where there is no such part, a brace is unclosed
    /// or its name empty.
    pub fn new(text: &str, name: &str) -> Option<Self> {
        let mut found = Vec::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once('{') {
            found.extend(tokens(before));
            let (named, after) = after.split_once('}')?;
            if named.is_empty() || named.contains('{') {
                return None;
            }
            let first = named == name && !found.contains(&Token::Part);
            found.push(if first { Token::Part } else { Token::Some });
            rest = after;
        }
        found.extend(tokens(rest));
        found.contains(&Token::Part).then(|| Self { text: text.to_owned(), tokens: found })
    }

    /// As written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The extracted part where `text` fits; parts are as short as possible.
    pub fn part<'a>(&self, text: &'a str) -> Option<&'a str> {
        fit(&self.tokens, text)?
    }
}

/// Texts, and [`Token::Any`] where stars are between them.
fn tokens(text: &str) -> Vec<Token> {
    let mut tokens = Vec::new();
    for (i, part) in text.split('*').enumerate() {
        tokens.extend((i > 0).then_some(Token::Any));
        tokens.extend((!part.is_empty()).then(|| Token::Text(part.to_owned())));
    }
    tokens
}

/// Whether `text` fits `tokens`, and then the extracted part.
fn fit<'a>(tokens: &[Token], text: &'a str) -> Option<Option<&'a str>> {
    let Some((token, rest)) = tokens.split_first() else { return text.is_empty().then_some(None) };
    if let Token::Text(known) = token {
        return fit(rest, text.strip_prefix(known.as_str())?);
    }
    let ends = text.char_indices().map(|(i, _)| i).chain([text.len()]);
    let ends = ends.skip(usize::from(*token != Token::Any)).take_while(|end| !text[..*end].contains('/'));
    let fitting = |end: usize| {
        let found = fit(rest, &text[end..])?;
        Some(if *token == Token::Part { Some(&text[..end]) } else { found })
    };
    ends.into_iter().find_map(fitting)
}
