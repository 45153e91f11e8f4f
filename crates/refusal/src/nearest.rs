use crate::{foreign, nearest, shortened};

/// Longer words are not compared.
const MOST: usize = 200;

/// The name of `known` most like `word`, regardless of case: by Jaro–Winkler, then by the fewest edits (the
/// first of equals).
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = shortened(word, MOST).to_lowercase();
    let mut best: Option<((f64, usize), &str)> = None;
    for candidate in known {
        let lower = shortened(candidate, MOST).to_lowercase();
        let likeness = (strsim::jaro_winkler(&word, &lower), strsim::levenshtein(&word, &lower));
        if best.is_none_or(|(top, _)| likeness.0 > top.0 || (likeness.0 == top.0 && likeness.1 < top.1)) {
            best = Some((likeness, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

const NO_DRIFT: &str = "it is gone: take `--estimator prediction-error`, or `--unknown-current earth`";

const NO_SWEEP: &str =
    "it is gone: `make sweep` runs every cell of a grid by `seatrial run --set`, into sweep.csv";

/// Names that are known no more, each with the remedy.
const GONE: [(&str, &str); 7] = [
    ("refined-iv", "it is gone: take `output-error`"),
    ("--engine", "it is gone: leave it out, since every search is exhaustive"),
    ("sweep", NO_SWEEP),
    ("--sweep", NO_SWEEP),
    ("--unknown-current body", NO_DRIFT),
    ("--unknown-current drifting", NO_DRIFT),
    (
        "--unknown-wind",
        "it is gone: log the wind as a `[[measured]]` channel, or take `--estimator prediction-error`",
    ),
];

/// The remedy for `word`, if that is known no more.
pub fn gone(word: &str) -> Option<&'static str> {
    GONE.iter().find(|(gone, _)| *gone == word).map(|(_, remedy)| *remedy)
}

/// The remedy for `word`, which is none of the names `known`; `None` if nothing is like it.
pub fn suggestion<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let near = || nearest(word, known).map(|near| format!("did you mean `{near}`?"));
    gone(word).map(str::to_owned).or_else(near)
}

/// Names that a message lists at most.
const LISTED: usize = 12;

/// `names` for a message; of a long list, those most like `name`.
pub fn some_of(names: &[impl AsRef<str>], name: &str) -> String {
    let mut left: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    let total = left.len();
    if total <= LISTED {
        return left.iter().map(|name| format!("`{}`", foreign(name))).collect::<Vec<_>>().join(", ");
    }
    let mut listed = Vec::new();
    while let (true, Some(near)) = (listed.len() < LISTED, nearest(name, left.iter().copied())) {
        listed.push(format!("`{}`", foreign(near)));
        left.retain(|other| *other != near);
    }
    format!("{} and {} more", listed.join(", "), left.len())
}

/// `a`, `a and b`, `a, b and c`.
pub fn listed(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}

/// The names in `text`, which has commas between them: of pieces that are `known` only together one name, the longest.
pub fn names_in(text: &str, known: impl Fn(&str) -> bool) -> Vec<String> {
    let pieces: Vec<&str> = text.split(',').collect();
    let (mut names, mut rest) = (Vec::new(), pieces.as_slice());
    while let [first, ..] = rest {
        let joined = |n: usize| (n, rest[..n].join(",").trim().to_owned());
        let whole = (1..=rest.len()).rev().map(joined).find(|(_, name)| known(name));
        let (used, name) = whole.unwrap_or_else(|| (1, first.trim().to_owned()));
        names.push(name);
        rest = &rest[used..];
    }
    names
}
