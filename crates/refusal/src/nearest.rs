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
