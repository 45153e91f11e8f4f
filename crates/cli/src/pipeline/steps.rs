//! The stages of a study, in order: their command lines and what they write.

use std::collections::BTreeMap;
use std::path::Path;

use files::{Error, read_hand_written};
use refusal::{Invalid, foreign, nearest};
use study::invalid;

/// A stage of a study. In its words and outputs `\0study`, `\0dictionary`, `\0logs` and `\0out` stand for the study's folder, its
/// maneuvers, its logs and its results: no name and no line of a study has a byte 0, so that nothing else is ever replaced.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyStep {
    /// Its name in the study, such as `design`.
    pub name: String,
    /// Its command line without the program: what is a path and not an output is an input.
    pub words: Vec<String>,
    /// What it writes, its main file first.
    pub outputs: Vec<String>,
    /// Whether the study goes on where it is refused.
    pub is_optional: bool,
}

/// A stage called `name` with this `line` and `flags`, which writes `outputs` below the folder of the results.
fn step(name: &str, line: &str, flags: &str, outputs: &[&str]) -> StudyStep {
    let outputs: Vec<String> = outputs.iter().map(|name| format!("\0out/{name}")).collect();
    let words = line.split_whitespace().chain(flags.split_whitespace()).chain(["--out", &outputs[0]]);
    let words = words.map(str::to_owned).collect();
    StudyStep { name: name.to_owned(), words, outputs, is_optional: false }
}

impl StudyStep {
    /// The paths that it reads.
    pub fn inputs(&self) -> impl Iterator<Item = &str> {
        let words = self.words.iter().map(String::as_str);
        words.filter(|word| word.starts_with('\0') && !self.outputs.iter().any(|output| output == word))
    }
}

/// What is done with a study, and what it has besides the usual files.
pub struct StudyShape {
    /// Names of the files `plan.toml` and `plan-<name>.toml`, without `.toml`.
    pub plans: Vec<String>,
    /// Whether it has published results to compare with.
    pub has_reference: bool,
    /// Whether `new` wrote what its next trial may consist of.
    pub has_next: bool,
    /// Whether its next trial is planned on a chart.
    pub next_is_charted: bool,
    /// Whether its ship is described by forces, which are fitted by output error, with priors.
    pub is_of_forces: bool,
    /// How many recordings its logs are.
    pub recordings: usize,
}

/// Fewest recordings for a search, as many as it has folds.
pub(crate) const SEARCHED: usize = 6;

const SHIP: &str = "--vessel \0study/vessel.toml";
const HELM: &str = "--dictionary \0dictionary";
const SEA: &str = "--campaign \0study/campaign.toml";
const MADE: &str = "--trajectories \0out/dictionary.parquet";
const DESIGN: &str = "--design \0out/design.json";

/// The stages of a study that is simulated.
pub fn simulated(settings: &StudySettings, shape: &StudyShape) -> Vec<StudyStep> {
    let get = |key| settings.get(key);
    // Where a study does not say others: the best in nine of ten cases measured.
    let usual = format!("{SEA} --estimator output-error");
    let (information, arranged) = (settings.or("MOMENTS_FLAGS", &usual), &design_flags(settings));
    let mut steps = vec![
        step("dictionary", &format!("simulate dictionary {SHIP} {HELM}"), "", &["dictionary.parquet"]),
        step("moments", &format!("moments {SHIP} {MADE}"), information, &["moments.json"]),
        step("design", "design --moments \0out/moments.json", arranged, &["design.json"]),
        step("validation", &format!("simulate validation {SHIP} {SEA}"), "", &["validation.parquet"]),
    ];
    // One-step predictions need terms per sample.
    let estimator =
        if shape.is_of_forces { "--estimator output-error" } else { "--estimator prediction-error" };
    let whole = format!("{SHIP} {HELM} {SEA} {DESIGN}");
    if get("MONTE_CARLO").is_empty() {
        steps.push(step("campaign", &format!("simulate campaign {whole}"), "", &["campaign.parquet"]));
        steps.extend(estimated("", "campaign.parquet", settings, estimator));
    } else {
        let line = format!("monte-carlo {whole} --keep estimates");
        steps.push(step("monte-carlo", &line, settings.or("ESTIMATE_FLAGS", estimator), &["tally.json"]));
    }
    shape.plans.iter().for_each(|name| steps.extend(planned(name, settings, estimator)));
    let length_m = get("LENGTH_M");
    if !length_m.is_empty() {
        let line = format!("validate merit {SHIP} {HELM} {MADE} --length-m {length_m}");
        steps.push(step("merit", &line, "", &["merit.json"]));
    }
    let line = format!("report --study \0study {HELM} --results \0out");
    steps.push(step("report", &line, "", &["report.html", "explore.html"]));
    steps
}

/// Flags of the design: those of the study beside the usual ones, unless it says what moments or design are for. What the search for
/// an order does not keep takes its place.
fn design_flags(settings: &StudySettings) -> String {
    let given = settings.get("DESIGN_FLAGS");
    let has = |flags: &[&str]| given.split([' ', '=']).any(|word| flags.contains(&word));
    if !settings.get("MOMENTS_FLAGS").is_empty() || has(&["--for", "--criterion", "--figures"]) {
        return given.to_owned();
    }
    let order = match has(&["--segments", "--available", "--most-maneuvers", "--mean-removal", "--arrange"]) {
        true => String::new(),
        false => format!("--arrange {SHIP} {HELM} "),
    };
    format!("--for output-error --criterion d {order}{given}")
}

/// Estimates of the runs in `table` by `usual`, below the results' folder `below`, and their scores.
fn estimated(below: &str, table: &str, settings: &StudySettings, usual: &str) -> [StudyStep; 2] {
    let file = |name: &str| format!("{below}{name}");
    let [estimates, estimate, scores, validation] =
        ["estimates.parquet", "estimate.json", "scores.parquet", "validation.json"].map(file);
    let fit = format!("estimate {SHIP} --trajectories \0out/{}", file(table));
    let score =
        format!("validate {SHIP} {SEA} --estimates \0out/{estimates} --validation \0out/validation.parquet");
    let usual = format!("{SEA} {usual}");
    let (prefix, flags) = (below.replace('/', "-"), settings.or("ESTIMATE_FLAGS", &usual));
    [
        step(&format!("{prefix}estimate"), &fit, flags, &[&estimates, &estimate]),
        step(&format!("{prefix}validate"), &score, "", &[&scores, &validation]),
    ]
}

/// The layout on the chart of `name`.toml; that of plan.toml is also simulated, estimated and scored.
fn planned(name: &str, settings: &StudySettings, estimator: &str) -> Vec<StudyStep> {
    let main = if name == "plan" { "plan.json".to_owned() } else { format!("{name}/plan.json") };
    let line = format!("plan {SHIP} {MADE} {HELM} {DESIGN}");
    let mut plan = step(name, &line, settings.get("PLAN_FLAGS"), &[&main]);
    // The name may have blanks.
    plan.words.extend(["--config".to_owned(), format!("\0study/{name}.toml")]);
    let mut steps = vec![plan];
    if name == "plan" {
        let line = format!("simulate plan {SHIP} {SEA} --plan \0out/plan.json");
        steps.push(step("planned", &line, "", &["planned/trajectories.parquet"]));
        steps.extend(estimated("planned/", "trajectories.parquet", settings, estimator));
    }
    steps
}

/// The logs of a study whose instruments are simulated.
pub fn simulated_logs() -> [StudyStep; 2] {
    let logs = format!("simulate logs {SHIP} {HELM} --logs \0study/logs.toml");
    let dictionary = format!("simulate dictionary {SHIP} {HELM}");
    [
        step("logs", &logs, "", &["logs/simulated.json"]),
        // The maneuvers as they are meant, for the report
        step("dictionary", &dictionary, "", &["measured/dictionary.parquet"]),
    ]
}

const LOGGED: &str = "--vessel \0study/vessel.toml --trajectories \0out/measured/trajectories.parquet";
const RECORDED: &str = "--recordings \0out/measured/ingest.json";

/// The stages of a study with logs.
pub fn measured(settings: &StudySettings, shape: &StudyShape, usual_selection: &str) -> Vec<StudyStep> {
    let ingest = format!("ingest --config \0study/ingest.toml {SHIP} --logs \0logs");
    let recordings = ["measured/trajectories.parquet", "measured/ingest.json"];
    let mut steps = vec![step("ingest", &ingest, "", &recordings)];
    steps.extend(match settings.get("ESTIMATOR").is_empty() && shape.recordings >= SEARCHED {
        true => searched(settings, shape),
        false => pooled(settings, shape),
    });
    if !settings.get("SELECTED").is_empty() {
        steps.extend(selected(settings, shape, usual_selection));
    }
    if shape.has_next || !settings.get("NEXT").is_empty() {
        steps.extend(next_trial(settings, shape));
    }
    let length_m = settings.get("LENGTH_M");
    if shape.is_of_forces || !length_m.is_empty() {
        let flags = if length_m.is_empty() { String::new() } else { format!("--length-m {length_m}") };
        steps.push(step("merit", &format!("validate merit {LOGGED}"), &flags, &["measured/merit.json"]));
    }
    let line = "report --study \0study --results \0out/measured";
    steps.push(step("report", line, "", &["measured/report.html", "measured/explore.html"]));
    steps
}

/// The model that recordings are searched for; of a ship with forces the average with these.
fn searched(settings: &StudySettings, shape: &StudyShape) -> Vec<StudyStep> {
    let (core, delivered) = match shape.is_of_forces {
        true => ("--core", "average.json"),
        false => ("", "model.json"),
    };
    let model = |name: &str, below: &str, more: &str| {
        let file = |name: &str| format!("measured/{below}{name}");
        let files = ["search.json", "model.json", "average.json"].map(file);
        let count = if shape.is_of_forces { 3 } else { 2 };
        let outputs: Vec<&str> = files.iter().take(count).map(String::as_str).collect();
        let line = format!("estimate search {LOGGED} {RECORDED} {core} {more}");
        step(name, &line, settings.get("SEARCH_FLAGS"), &outputs)
    };
    let mut steps = vec![model("model", "", "")];
    let test = settings.get("TEST");
    let left = shape.recordings.saturating_sub(test.split(',').count());
    // The second model is not judged by itself: fewer folds do.
    if !test.is_empty() && left >= SEARCHED {
        steps.push(model("test-model", "test/", &format!("--folds 3 --leave-out {test}")));
        steps.push(compared(settings, test, delivered));
    }
    steps
}

/// The vessel's own model of recordings; by its core, where no estimator is set.
fn pooled(settings: &StudySettings, shape: &StudyShape) -> Vec<StudyStep> {
    let fit = Fit::of(settings, shape);
    let cross = step(
        "cross",
        &format!("validate cross {LOGGED} {RECORDED} {}", fit.in_turns),
        settings.get("CROSS_FLAGS"),
        &["measured/crossval.json"],
    );
    let mut steps = vec![fit.step("pool", "", &fit.bootstrap), cross];
    let test = settings.get("TEST");
    if !test.is_empty() {
        steps.push(fit.step("test-pool", "test/", &format!("--leave-out {test}")));
        steps.push(compared(settings, test, "model.json"));
    }
    steps
}

/// How recordings are fitted.
struct Fit {
    estimator: String,
    flags: String,
    /// Those of `flags` that fits without a recording take, too.
    in_turns: String,
    bootstrap: String,
    /// Whether the model alone is written, without a table of estimates.
    is_model_alone: bool,
}

impl Fit {
    fn of(settings: &StudySettings, shape: &StudyShape) -> Self {
        if shape.is_of_forces {
            return Self {
                estimator: settings.or("ESTIMATOR", "output-error").to_owned(),
                flags: settings.get("POOL_FLAGS").to_owned(),
                in_turns: String::new(),
                bootstrap: String::new(),
                is_model_alone: true,
            };
        }
        let flags = settings.or("POOL_FLAGS", "--nominal least-squares").to_owned();
        let bootstrap = format!("--bootstrap {}", settings.or("BOOTSTRAP", "1000"));
        match settings.get("ESTIMATOR") {
            "" => {
                let flags = format!("--core {flags}");
                let in_turns = format!("{flags} --estimators {FEW}");
                Self { estimator: FEW.to_owned(), flags, in_turns, bootstrap, is_model_alone: false }
            }
            estimator => {
                let (estimator, in_turns) = (estimator.to_owned(), flags.clone());
                Self { estimator, flags, in_turns, bootstrap, is_model_alone: false }
            }
        }
    }

    /// The fit with `more` flags, whose results are below the folder `below` of the measured ones.
    fn step(&self, name: &str, below: &str, more: &str) -> StudyStep {
        let [table, model] =
            ["estimates.parquet", "model.json"].map(|name| format!("measured/{below}{name}"));
        let outputs: &[&str] = if self.is_model_alone { &[&model] } else { &[&table, &model] };
        let line = format!("estimate pool {LOGGED} {RECORDED} --estimator {} {}", self.estimator, self.flags);
        step(name, &line, more, outputs)
    }
}

/// The estimator of a core from few recordings.
const FEW: &str = "prediction-error";

/// The `model` of the recordings that are not in `test`, tried on those that are.
fn compared(settings: &StudySettings, test: &str, model: &str) -> StudyStep {
    let line = format!(
        "validate compare --model \0out/measured/test/{model} --trajectories \0out/measured/trajectories.parquet {RECORDED} --runs \
         {test}"
    );
    step("compare", &line, settings.get("TEST_FLAGS"), &["measured/compare.json"])
}

/// Sub-experiments that are designed, picked and compared.
fn selected(settings: &StudySettings, shape: &StudyShape, usual_selection: &str) -> [StudyStep; 3] {
    let design = settings.get("DESIGN_FLAGS");
    // No more of a maneuver than was logged, unless the study says what is available.
    let stated = design.contains("--available");
    let within = if stated { "" } else { "--available \0out/measured/ingest.json" };
    let reference = if shape.has_reference { "--reference \0study/reference.toml" } else { "" };
    let (moments, flags) = (format!("moments {LOGGED}"), settings.get("MOMENTS_FLAGS"));
    let designed = format!("design --moments \0out/measured/moments.json {within}");
    let picked = format!("validate selection {LOGGED} --design \0out/measured/design.json {reference}");
    let picks = ["measured/selection.parquet", "measured/selection.json"];
    [
        step("moments", &moments, flags, &["measured/moments.json"]),
        step("design", &designed, design, &["measured/design.json"]),
        step("selection", &picked, settings.or("SELECTION_FLAGS", usual_selection), &picks),
    ]
}

/// The trial after this one: its design by the model that is delivered, what it promises and its plan. Of files that `new` wrote the
/// study goes on where a stage is refused.
fn next_trial(settings: &StudySettings, shape: &StudyShape) -> Vec<StudyStep> {
    const HELM: &str = "--dictionary \0study/next/dictionary.toml";
    const SEA: &str = "--campaign \0study/next/campaign.toml";
    const MADE: &str = "--trajectories \0out/measured/next/dictionary.parquet";
    const DESIGN: &str = "--design \0out/measured/next/design.json";
    // A model that is searched for anew has few terms, and keeps to what was logged.
    let is_searched = !settings.get("NEXT").is_empty();
    let (model, allowed) = match is_searched {
        true => ("--vessel \0out/measured/next/model.json", ""),
        false => ("--vessel \0out/measured/model.json", "--beyond-range"),
    };
    let search = format!("estimate search {LOGGED} {RECORDED}");
    // A fitted ship may not go straight ahead: that is said.
    let unreached = if is_searched { "" } else { "--allow-unreached" };
    let dictionary = format!("simulate dictionary {model} {HELM} {allowed} {unreached}");
    let moments = format!("moments {model} {MADE} {SEA} --estimator output-error --hold-unexcited");
    let design = "design --moments \0out/measured/next/moments.json --for output-error";
    let arranged = format!("--criterion d --arrange {model} {HELM}");
    let usual = match is_searched {
        true => "",
        // Sequences take long to judge for forces, and hardly tell the many terms of a search.
        false if shape.is_of_forces || shape.recordings >= SEARCHED => "--criterion d",
        false => &arranged,
    };
    let promised = format!("monte-carlo {model} {HELM} {SEA} {DESIGN} --estimator output-error");
    let outputs = ["measured/next/search.json", "measured/next/model.json"];
    let mut steps = vec![
        step("next-dictionary", &dictionary, "", &["measured/next/dictionary.parquet"]),
        step("next-moments", &moments, "", &["measured/next/moments.json"]),
        step("next-design", design, settings.or("NEXT_FLAGS", usual), &["measured/next/design.json"]),
    ];
    if is_searched {
        steps.insert(0, step("search", &search, settings.get("SEARCH_FLAGS"), &outputs));
        steps.push(step("next-monte-carlo", &promised, "", &["measured/next/tally.json"]));
    }
    if shape.next_is_charted {
        let line = format!("plan {model} {MADE} {HELM} {DESIGN} --config \0study/next/plan.toml {allowed}");
        steps.push(step("next-plan", &line, "", &["measured/next/plan.json"]));
    }
    steps.iter_mut().for_each(|step| step.is_optional = !is_searched);
    steps
}

/// What a study may set.
const KNOWN: &str = "DICTIONARY MOMENTS_FLAGS DESIGN_FLAGS ESTIMATE_FLAGS PLAN_FLAGS MONTE_CARLO LENGTH_M LOGS POOL_FLAGS \
     ESTIMATOR BOOTSTRAP CROSS_FLAGS TEST TEST_FLAGS SELECTION_FLAGS SELECTED NEXT SEARCH_FLAGS NEXT_FLAGS";

/// What a value may refer to, and what stands for it in the words of a [`crate::pipeline::StudyStep`].
const REFERENCES: [(&str, &str); 5] = [
    ("$(STUDY)", "\0study"),
    ("$(DICTIONARY)", "\0dictionary"),
    ("$(LOGS)", "\0logs"),
    ("$(MEASURED)", "\0out/measured"),
    ("$(OUT)", "\0out"),
];

/// The settings of a study, by their names.
#[derive(Debug, Default)]
pub struct StudySettings(BTreeMap<String, String>);

impl StudySettings {
    /// Reads `study.mk` in the folder `study`; none if it is absent.
    pub fn read(study: &Path) -> Result<Self, Error> {
        let file = study.join("study.mk");
        let mut settings = Self::default();
        if !file.exists() {
            return Ok(settings);
        }
        // A line that ends with a backslash goes on in the next one.
        let text = read_hand_written(&file)?.replace("\\\n", " ");
        for line in text.lines() {
            settings.take(line).map_err(|wrong| invalid(&file, &wrong))?;
        }
        Ok(settings)
    }

    /// Sets what `given` says, as a line of study.mk would at its end: `NAME=VALUE`.
    pub fn set(&mut self, given: &str) -> Result<(), Invalid> {
        let (name, value) = given.split_once('=').ok_or_else(|| not_a_setting(given))?;
        self.put(name.trim(), None, value)
    }

    /// The value of `name`, empty if it is not set.
    pub fn get(&self, name: &str) -> &str {
        self.0.get(name).map_or("", String::as_str)
    }

    /// The value of `name`, or `usual` if it is not set.
    pub fn or<'a>(&'a self, name: &str, usual: &'a str) -> &'a str {
        self.0.get(name).map_or(usual, String::as_str)
    }

    /// These settings with sub-experiments designed, picked and compared, as studies on simulated logs have them.
    #[must_use]
    pub fn selecting(&self) -> Self {
        let mut settings = self.0.clone();
        settings.insert("SELECTED".to_owned(), "yes".to_owned());
        Self(settings)
    }

    fn take(&mut self, line: &str) -> Result<(), Invalid> {
        let line = line.split('#').next().unwrap_or_default().trim();
        // The kind of a study is known by its files: what make includes for it says nothing more.
        let included = line.strip_prefix("include ").map(str::trim);
        if line.is_empty() || matches!(included, Some("pipelines/measured.mk" | "pipelines/simulated.mk")) {
            return Ok(());
        }
        let (name, value) = line.split_once('=').ok_or_else(|| not_a_setting(line))?;
        let kind = name.chars().next_back().filter(|last| [':', '?', '+'].contains(last));
        self.put(name.trim_end_matches([':', '?', '+']).trim(), kind, value)
    }

    /// Sets `name` to `value`: `kind` `?` only if it is not set, `+` behind what it is set to.
    fn put(&mut self, name: &str, kind: Option<char>, value: &str) -> Result<(), Invalid> {
        let known = KNOWN.split(' ');
        if !known.clone().any(|known| known == name) {
            let meant = nearest(name, known).map_or(String::new(), |near| format!(" (did you mean {near}?)"));
            let remedy = format!("correct or remove it{meant}");
            let (thing, expected) = (format!("`{}`", foreign(name)), KNOWN.replace(' ', ", "));
            return Err(Invalid::new(thing, "a setting of no stage", expected, remedy));
        }
        if value.contains('\0') {
            return Err(Invalid::new(format!("`{name}`"), "a byte 0", "text", "remove it"));
        }
        let value = resolved(name, value.trim())?;
        let known = self.0.get(name).cloned();
        let value = match (kind, known) {
            (Some('?'), Some(known)) => known,
            (Some('+'), Some(known)) => format!("{known} {value}"),
            _ => value,
        };
        self.0.insert(name.to_owned(), value);
        Ok(())
    }
}

fn not_a_setting(line: &str) -> Invalid {
    let expected = "settings such as `DESIGN_FLAGS = --minimal-s 60`, and comments";
    Invalid::new("line", format!("`{}`", foreign(line)), expected, "correct or remove it")
}

/// `value` without references to other settings.
fn resolved(name: &str, value: &str) -> Result<String, Invalid> {
    let value = REFERENCES.iter().fold(value.to_owned(), |value, (from, to)| value.replace(from, to));
    if !value.contains('$') {
        return Ok(value);
    }
    let known = REFERENCES.map(|(name, _)| name).join(", ");
    let remedy = "write the value out";
    Err(Invalid::new(format!("`{name}`"), format!("`{}`", foreign(&value)), known, remedy))
}
