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

/// `parts`, of which the longest are shortened so that all of them have at most `most` characters together.
pub(crate) fn fitted<const N: usize>(parts: [&str; N], most: usize) -> [String; N] {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn foreign_text_is_short_and_turns_nothing_around() {
        assert_eq!(foreign("a\u{202e}b\nc"), "a b c");
        let long = foreign(&"x".repeat(1_000_000));
        assert_eq!((long.chars().count(), long.ends_with('…')), (80, true));
        assert_eq!(foreign(&"é".repeat(80)), "é".repeat(80));
    }

    #[test]
    fn the_longest_parts_give_way() {
        let long = "y".repeat(1000);
        let [short, cut] = fitted(["abc", &long], 100);
        assert_eq!((short.as_str(), cut.chars().count()), ("abc", 97));
        let all = fitted([&long, &long, &long, "z"], 300);
        assert!(all.iter().map(|part| part.chars().count()).sum::<usize>() <= 300 && all[3] == "z");
        assert_eq!(fitted(["a", "b"], 10), ["a", "b"]);
    }
}
