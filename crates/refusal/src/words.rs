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
const SEARCHED: &str = "estimate.json has it: made again by: seatrial estimate --structure library";
const SAY_WHERE: &str =
    "it is gone: mend the log, or say where she is by `--done STEPS --from LON,LAT,HEADING`";
const SAY_ROLE: &str = "it is gone: the channel says it by its `role` in vessel.toml";
const NO_SWEEP: &str =
    "it is gone: `make sweep` runs every cell of a grid by `seatrial run --set`, into sweep.csv";

/// Names that are known no more, each with the remedy.
const GONE: &[(&str, &str)] = &[
    ("sequential", "it is gone: `monte-carlo` without a design takes the [rounds] of campaign.toml"),
    (
        "average/1",
        "model.json has the models that are averaged: made again by: seatrial estimate --structure average",
    ),
    ("crossval/1", "estimate.json has it: made again by: seatrial estimate --fit together --folds each"),
    (
        "design-update/1",
        "estimate.json has it: made again by: seatrial estimate --fit together --promised design.json",
    ),
    ("search/1", SEARCHED),
    ("search/2", SEARCHED),
    ("trust/1", "estimate.json has it: made again by: seatrial estimate --fit together"),
    ("pool", "it is gone: `estimate --fit together` makes one model of all runs"),
    ("search", "it is gone: `estimate --structure library` searches, `--structure few` for few terms"),
    ("cross", "it is gone: `estimate --fit together --folds each` scores recordings left out"),
    ("update", "it is gone: `estimate --fit together --promised design.json` compares"),
    (
        "--add-terms",
        "it is gone: `estimate --structure library` finds terms, or forces, that the vessel lacks",
    ),
    ("--core", "it is gone: `estimate --structure core`, or `--structure average` of a ship with forces"),
    ("--compact", "it is gone: `estimate --structure few`"),
    ("--covariance", "it is gone: `--keep covariance`"),
    ("--fold", "it is gone: `--folds` deals runs or recordings into so many"),
    ("--keep-first", "it is gone: take fewer --realizations"),
    ("--compiler", "it is gone: the variable CC names a compiler"),
    ("--config", "it is gone: trials in rounds are in [rounds] of campaign.toml"),
    ("--allow-mixed", "it is gone: `--allow mixed`"),
    ("--allow-doubtful", "it is gone: `--allow doubtful`"),
    ("--allow-unreached", "it is gone: `--allow unreached`"),
    ("--allow-unsafe", "it is gone: `--allow unsafe`"),
    ("--beyond-range", "it is gone: `--allow beyond-range`"),
    (
        "resume",
        "it is gone: `seatrial plan --rest-of plan.json --from LON,LAT,HEADING --done STEPS` plans the rest",
    ),
    ("follow", "it is gone: `seatrial plan --rest-of plan.json --from positions.csv` plans the rest"),
    ("--within-m", SAY_WHERE),
    ("--max-gap-s", SAY_WHERE),
    ("--export-problem", "it is gone: `--keep problem` writes problem.json beside the plan"),
    ("--positions", "it is gone: name the file by `--from`"),
    (
        "follow/1",
        "it is gone: `seatrial plan --rest-of plan.json --from positions.csv` writes a plan.json that has it",
    ),
    ("refined/1", "it is gone: `seatrial design --refine` writes a design.json that has it"),
    ("refine", "it is gone: `design --refine design.json` improves the input signals of that design"),
    ("--starts", "it is gone: a search starts at random places where its problem is not concave"),
    ("--tolerance", "it is gone: a search ends where rounding does, and its gap is stated"),
    ("--hold-unexcited", "it is gone: parameters that no maneuver excites are held and named"),
    (
        "--instruments",
        "it is gone: `--estimator ls` takes the regressors as instruments, `iv` those of the nominal model",
    ),
    ("--table", "it is gone: `--keep table` writes moments.parquet beside the document"),
    ("--recordings", "it is gone: an ingest.json beside the trajectories is read"),
    ("--terms", "it is gone: a table [candidates] in vessel.toml lists them"),
    ("--limits", "it is gone: a table [limits] in dictionary.toml states them"),
    ("--per-parameter", "it is gone: `--accuracy` is of all parameters together"),
    (
        "--minimal-s",
        "it is gone: `--most-maneuvers` limits how many; `--arrange` keeps pieces above 15 % of their maneuver",
    ),
    ("--noise", "it is gone: the current counts; make the moments with a campaign without one"),
    ("--iterations", "it is gone: begin again from the refined design.json and refined-dictionary.toml"),
    ("--compare", "it is gone: name all with `--estimator ls,iv,output-error,prediction-error`"),
    ("--estimators", "it is gone: `--estimator` takes several, with commas between them"),
    (
        "--criticise",
        "it is gone: runs are asked what the model lacks where --campaign states the disturbances",
    ),
    ("--no-criticism", "it is gone: every fit is criticised"),
    ("--model-of", "it is gone: `--runs optimized/3` estimates that run and delivers its model"),
    ("--prior-weight", "it is gone: `--prior 2` weighs the priors of a ship with forces"),
    ("--measured-starts", "it is gone: initial states are found with the parameters"),
    ("--rudder", SAY_ROLE),
    ("--propeller", SAY_ROLE),
    ("--ahead", SAY_ROLE),
    ("--astern", SAY_ROLE),
    ("--even", SAY_ROLE),
    ("--odd", SAY_ROLE),
    ("--port", SAY_ROLE),
    ("--starboard", SAY_ROLE),
    ("--thrust", SAY_ROLE),
    ("--wind", SAY_ROLE),
    ("--wind-from", SAY_ROLE),
    ("--every-s", "it is gone: the least of a search is found without it"),
    ("manual", "it is gone: `seatrial completions man FOLDER` writes the pages"),
    (
        "guess",
        "it is gone: `seatrial new my-ship --guess length_m=320,beam_m=58,draught_m=20.8,block=0.81` writes her study",
    ),
    ("scale", "it is gone: `seatrial new my-ship --vessel kvlcc2-l7 --scale length_m=320` writes her study"),
    ("--setting", "it is gone: set keys of study.toml, as in `--set study.design.segments=5`"),
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
    ("compare/1", "validation.json has it: made again by: seatrial validate --model"),
    ("selection/1", "validation.json has it: made again by: seatrial validate --design"),
    ("selection-realizations/1", "scores.parquet has it: made again by: seatrial validate --design"),
    ("sequential/1", "validation.json and scores.parquet have it: made again by: seatrial monte-carlo"),
    ("tally/1", "validation.json has it: made again by: seatrial monte-carlo"),
    ("compare", "it is gone: `validate --model model.json --trajectories …` tries a model on recordings"),
    ("selection", "it is gone: `validate --design design.json --trajectories …` compares picks"),
    ("--against", "it is gone: name other models by `--model` again"),
    ("--average", "it is gone: `estimate` delivers an average as a model"),
    ("--counts", "it is gone: a design.json by --design has the counts"),
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
