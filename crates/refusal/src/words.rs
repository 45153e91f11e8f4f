//! Words of messages: text of foreign files, short and in one line; names, and those most like a wrong one.

/// Text from a foreign file, as a message may quote it: in one line, at most 80 characters.
pub fn foreign(text: &str) -> String {
    shortened(&one_line(text), 80)
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

/// A number without long runs of zeros.
pub(crate) fn short(number: f64) -> String {
    let plain = number == 0.0 || !number.is_finite() || (1e-3..1e7).contains(&number.abs());
    if plain { number.to_string() } else { format!("{number:e}") }
}

/// Longer words are not compared.
const COMPARED: usize = 200;

/// The name of `known` most like `word`, regardless of case: by Jaro–Winkler, then by the fewest edits (the first of equals).
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = shortened(word, COMPARED).to_lowercase();
    let compared = |name: &'a str| {
        let lower = shortened(name, COMPARED).to_lowercase();
        (strsim::jaro_winkler(&word, &lower), strsim::levenshtein(&word, &lower), name)
    };
    let likest = known.into_iter().map(compared).reduce(|best, next| {
        if next.0 > best.0 || (next.0 == best.0 && next.1 < best.1) { next } else { best }
    });
    likest.map(|(.., name)| name)
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
    if left.len() <= LISTED {
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

/// An enum of choices with the same names in files, on the command line and on pages. Each name is stated
/// once, and so is its meaning: a variant's doc comment without the full stop is its line in `--help`.
///
/// Defines `ALL`, `name`, `description`, `Display` and the names for `serde` and `schemars`, which the caller must depend on.
#[macro_export]
macro_rules! choices {
    (
        $(#[$about:meta])*
        pub enum $Choices:ident {
            $($(#[doc = $line:literal])+ $Choice:ident = $name:literal,)+
        }
    ) => {
        $(#[$about])*
        #[derive(
            Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
        )]
        pub enum $Choices {
            $($(#[doc = $line])+ #[serde(rename = $name)] $Choice,)+
        }

        impl $Choices {
            /// All of them.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$Choice),+];

            /// Its name in files and on the command line.
            pub fn name(self) -> &'static str {
                [$($name),+][self as usize]
            }

            /// Its description in one line.
            pub fn description(self) -> &'static str {
                [$(concat!($($line),+)),+][self as usize].trim_start().trim_end_matches('.')
            }
        }

        impl std::fmt::Display for $Choices {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}
