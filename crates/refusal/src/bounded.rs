//! Keeps messages short and in one line, even if they quote foreign files.

/// Most characters that a message quotes from a foreign file.
const FOREIGN: usize = 80;

/// Text from a foreign file, as a message may quote it: in one line, at most 80 characters.
pub fn foreign(text: &str) -> String {
    shortened(&one_line(text), FOREIGN)
}

/// `text`, with `…` in place of its end where it has more than `most` characters.
pub fn shortened(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        None => text.to_owned(),
        Some(_) => text.chars().take(most.saturating_sub(1)).chain(['…']).collect(),
    }
}

/// A message, shortened before its last `, expected `, so that it keeps its remedy.
pub fn with_remedy(message: &str, most: usize) -> String {
    let at = message.rfind(", expected ").unwrap_or(message.len());
    let [found, remedy] = fitted([&message[..at], &message[at..]], most);
    found + &remedy
}

/// `parts`, of which the longest are shortened so that all of them have at most `most` characters together.
pub fn fitted<const N: usize>(parts: [&str; N], most: usize) -> [String; N] {
    let lengths = parts.map(|part| part.chars().count());
    if lengths.iter().sum::<usize>() <= most {
        return parts.map(str::to_owned);
    }
    let total = |cut: usize| lengths.iter().map(|length| (*length).min(cut)).sum::<usize>();
    let cut = (most / N..most).rev().find(|cut| total(*cut) <= most).unwrap_or(most / N);
    parts.map(|part| shortened(part, cut))
}

/// `text` with every run of line breaks, other control characters and invisible marks replaced by one space.
pub fn one_line(text: &str) -> String {
    let parts = text.split(|c: char| c.is_control() || is_unseen(c));
    parts.filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Line separators, marks that change the direction of writing, and zero-width characters.
fn is_unseen(c: char) -> bool {
    matches!(
        c,
        '\u{61c}' | '\u{200b}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}'
    )
}
