use crate::shortened;

/// Longer words are not compared.
const MOST: usize = 200;

/// The name of `known` most like `word`, regardless of case: by Jaro–Winkler, then by the fewest edits (the
/// first of equals).
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = shortened(word, MOST).to_lowercase();
    let mut best: Option<((f64, usize), &str)> = None;
    for candidate in known {
        let lower = shortened(candidate, MOST).to_lowercase();
        let found = (strsim::jaro_winkler(&word, &lower), strsim::levenshtein(&word, &lower));
        if best.is_none_or(|(top, _)| found.0 > top.0 || (found.0 == top.0 && found.1 < top.1)) {
            best = Some((found, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}
