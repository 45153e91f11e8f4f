//! Patterns of file names: `*` for anything but `/`, and `{name}` for a part that is asked for.

/// A piece of a pattern.
#[derive(Clone, Debug, PartialEq)]
enum Piece {
    Text(String),
    /// Anything, perhaps nothing.
    Any,
    /// At least one character, to be known by this name.
    Named(String),
}

/// A pattern of file names.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern(Vec<Piece>);

impl Pattern {
    /// Parses a pattern in which `*` alone is special.
    pub fn glob(text: &str) -> Self {
        let mut pieces = Vec::new();
        for (i, part) in text.split('*').enumerate() {
            if i > 0 {
                pieces.push(Piece::Any);
            }
            push_text(&mut pieces, part);
        }
        Self(pieces)
    }

    /// Parses a template in which `*` and `{name}` are special; none where a brace is unclosed or its name empty.
    pub fn template(text: &str) -> Option<Self> {
        let mut pieces = Vec::new();
        let mut rest = text;
        while let Some(open) = rest.find('{') {
            pieces.extend(Self::glob(&rest[..open]).0);
            let (name, after) = rest[open + 1..].split_once('}')?;
            if name.is_empty() || name.contains('{') {
                return None;
            }
            pieces.push(Piece::Named(name.to_owned()));
            rest = after;
        }
        pieces.extend(Self::glob(rest).0);
        Some(Self(pieces))
    }

    /// Whether a part is called `name`.
    pub fn names(&self, name: &str) -> bool {
        self.0.iter().any(|piece| matches!(piece, Piece::Named(known) if known == name))
    }

    /// Whether `text` fits.
    pub fn fits(&self, text: &str) -> bool {
        fit(&self.0, text, &mut Vec::new())
    }

    /// The part called `name` where `text` fits; named parts are as short as can be.
    pub fn part<'a>(&self, text: &'a str, name: &str) -> Option<&'a str> {
        let mut parts = Vec::new();
        if !fit(&self.0, text, &mut parts) {
            return None;
        }
        parts.into_iter().find(|(known, _)| known == name).map(|(_, part)| part)
    }
}

fn push_text(pieces: &mut Vec<Piece>, text: &str) {
    if !text.is_empty() {
        pieces.push(Piece::Text(text.to_owned()));
    }
}

/// Whether `text` fits `pieces`; named parts are added to `parts` in order.
fn fit<'a>(pieces: &[Piece], text: &'a str, parts: &mut Vec<(String, &'a str)>) -> bool {
    let Some((piece, rest)) = pieces.split_first() else { return text.is_empty() };
    let (least, name) = match piece {
        Piece::Text(known) => {
            return text.strip_prefix(known.as_str()).is_some_and(|after| fit(rest, after, parts));
        }
        Piece::Any => (0, None),
        Piece::Named(name) => (1, Some(name)),
    };
    let ends = text.char_indices().map(|(i, _)| i).chain([text.len()]);
    for end in ends.skip(least) {
        if text[..end].contains('/') {
            return false;
        }
        let known = parts.len();
        parts.extend(name.map(|name| (name.clone(), &text[..end])));
        if fit(rest, &text[end..], parts) {
            return true;
        }
        parts.truncate(known);
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_stop_at_folders() {
        assert!(Pattern::glob("zig*_*.csv").fits("zigzag_1.csv"));
        assert!(Pattern::glob("*").fits("a{b}"));
        assert!(!Pattern::glob("*.csv").fits("a/b.csv"));
        assert!(!Pattern::glob("*.csv").fits("b.csv.gz"));
    }

    #[test]
    fn named_parts_are_found() {
        let template = Pattern::template("{kind}_*.csv").unwrap();
        assert_eq!(template.part("turn_14-Oct_2.csv", "kind"), Some("turn"));
        assert_eq!(template.part("_x.csv", "kind"), None);
        let template = Pattern::template("{kind}/*_{run}.csv.gz").unwrap();
        assert_eq!(template.part("zigzag/port_7.csv.gz", "run"), Some("7"));
        assert_eq!(template.part("zigzag/7.csv.gz", "kind"), None);
        assert!(Pattern::template("{kind").is_none() && Pattern::template("{}x").is_none());
        assert!(template.names("kind") && !template.names("kinds"));
    }
}
