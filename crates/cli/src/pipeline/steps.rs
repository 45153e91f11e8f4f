//! The stages of a study, in order: their command lines and what they write.

use estimation::Estimator;
use study::documents::ModelStructure;

use crate::commands::{SEARCHED, usual_structure};
use crate::pipeline::settings::StudySettings;

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
fn step(name: &str, line: &str, flags: Vec<String>, outputs: &[&str]) -> StudyStep {
    let outputs: Vec<String> = outputs.iter().map(|name| format!("\0out/{name}")).collect();
    let words = line.split_whitespace().map(str::to_owned).chain(flags);
    let words = words.chain(["--out".to_owned(), outputs[0].clone()]).collect();
    StudyStep { name: name.to_owned(), words, outputs, is_optional: false }
}

/// No flags.
const NONE: Vec<String> = Vec::new();

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
    /// Whether its model has regressors; else it is fitted by output error, with priors.
    pub has_regressors: bool,
    /// How many recordings its logs are.
    pub recordings: usize,
}

const SHIP: &str = "--vessel \0study/vessel.toml";
const HELM: &str = "--dictionary \0dictionary";
const SEA: &str = "--campaign \0study/campaign.toml";
const MADE: &str = "--trajectories \0out/dictionary.parquet";
const DESIGN: &str = "--design \0out/design.json";

/// The stages of a study that is simulated.
pub fn simulated(settings: &StudySettings, shape: &StudyShape) -> Vec<StudyStep> {
    let dictionary = format!("simulate dictionary {SHIP} {HELM}");
    let mut steps = vec![
        step("dictionary", &dictionary, NONE, &["dictionary.parquet"]),
        step("moments", &format!("moments {SHIP} {MADE}"), information(settings), &["moments.json"]),
        step("design", "design --moments \0out/moments.json", arranged(settings), &["design.json"]),
        step("validation", &format!("simulate validation {SHIP} {SEA}"), NONE, &["validation.parquet"]),
    ];
    // One-step predictions need terms per sample.
    let estimator =
        if shape.has_regressors { "--estimator prediction-error" } else { "--estimator output-error" };
    let whole = format!("{SHIP} {HELM} {SEA} {DESIGN}");
    if let Some(asked) = &settings.monte_carlo {
        let line = format!("monte-carlo {whole} --keep estimates");
        steps.push(step("monte-carlo", &line, asked.over(estimator), &["validation.json"]));
    } else {
        steps.push(step("campaign", &format!("simulate campaign {whole}"), NONE, &["campaign.parquet"]));
        steps.extend(estimated("", "campaign.parquet", settings, estimator));
    }
    shape.plans.iter().for_each(|name| steps.extend(planned(name, settings, estimator)));
    if let Some(asked) = &settings.merit {
        let line = format!("validate merit {SHIP} {HELM} {MADE}");
        steps.push(step("merit", &line, asked.over(""), &["merit.json"]));
    }
    let line = format!("report --study \0study {HELM} --results \0out");
    steps.push(step("report", &line, NONE, &["report.html"]));
    steps
}

/// Flags of the moments. Where a study does not say others: for the best estimator in nine of ten cases measured.
fn information(settings: &StudySettings) -> Vec<String> {
    let asked = &settings.moments;
    let estimator = asked.value("estimator");
    if asked.has(&["nominal", "keep"]) && estimator.is_none() {
        return asked.over("");
    }
    // Other criteria than the paper's predict errors by the disturbances.
    let predicts = settings.design.value("criterion").is_some_and(|name| name != "d-hessian");
    match estimator.is_some_and(|name| name != Estimator::OutputError.name()) && !predicts {
        true => asked.over(""),
        false => asked.over(&format!("{SEA} --estimator output-error")),
    }
}

/// Flags of the design: those of the study over the usual ones, unless it says what moments or design are for. What the search for
/// an order does not keep takes its place.
fn arranged(settings: &StudySettings) -> Vec<String> {
    let asked = &settings.design;
    let is_told = !settings.moments.is_empty() || asked.has(&["for", "criterion", "figures"]);
    let others = ["segments", "available", "most-maneuvers", "mean-removal"];
    let usual = match (is_told, asked.has(&others)) {
        (true, _) => "",
        (false, true) => "--for output-error --criterion d",
        (false, false) => "--for output-error --criterion d --arrange",
    };
    with_ship(asked.over(usual), &format!("{SHIP} {HELM}"))
}

/// `flags` of a design, and the `ship` where its maneuvers are arranged.
fn with_ship(mut flags: Vec<String>, ship: &str) -> Vec<String> {
    if flags.iter().any(|flag| flag == "--arrange") {
        flags.extend(ship.split_whitespace().map(str::to_owned));
    }
    flags
}

/// Estimates of the runs in `table` by the `usual` estimator, below the results' folder `below`, and their scores.
fn estimated(below: &str, table: &str, settings: &StudySettings, usual: &str) -> [StudyStep; 2] {
    let file = |name: &str| format!("{below}{name}");
    let [estimates, estimate, scores, validation] =
        ["estimates.parquet", "estimate.json", "scores.parquet", "validation.json"].map(file);
    let fit = format!("estimate {SHIP} --trajectories \0out/{}", file(table));
    let score =
        format!("validate {SHIP} {SEA} --estimates \0out/{estimates} --validation \0out/validation.parquet");
    let asked = &settings.estimate;
    // The sea is for those that search.
    let searches = |name| Estimator::OF_RUNS.iter().any(|e| e.searches() && e.name() == name);
    let sea = if asked.value("estimator").is_none_or(|all| all.split(',').any(searches)) { SEA } else { "" };
    let usual = format!("{sea} {usual}");
    let prefix = below.replace('/', "-");
    [
        step(&format!("{prefix}estimate"), &fit, asked.over(&usual), &[&estimates, &estimate]),
        step(&format!("{prefix}validate"), &score, NONE, &[&scores, &validation]),
    ]
}

/// The layout on the chart of `name`.toml; that of plan.toml is also simulated, estimated and scored.
fn planned(name: &str, settings: &StudySettings, estimator: &str) -> Vec<StudyStep> {
    let main = if name == "plan" { "plan.json".to_owned() } else { format!("{name}/plan.json") };
    let line = format!("plan {SHIP} {MADE} {HELM} {DESIGN}");
    let mut plan = step(name, &line, settings.plan.over(""), &[&main]);
    // The name may have blanks.
    plan.words.extend(["--config".to_owned(), format!("\0study/{name}.toml")]);
    let mut steps = vec![plan];
    if name == "plan" {
        let line = format!("simulate plan {SHIP} {SEA} --plan \0out/plan.json");
        steps.push(step("planned", &line, NONE, &["planned/trajectories.parquet"]));
        steps.extend(estimated("planned/", "trajectories.parquet", settings, estimator));
    }
    steps
}

/// The logs of a study whose instruments are simulated.
pub fn simulated_logs() -> [StudyStep; 2] {
    let logs = format!("simulate logs {SHIP} {HELM} --logs \0study/logs.toml");
    let dictionary = format!("simulate dictionary {SHIP} {HELM}");
    [
        step("logs", &logs, NONE, &["logs/simulated.json"]),
        // The maneuvers as they are meant, for the report
        step("dictionary", &dictionary, NONE, &["measured/dictionary.parquet"]),
    ]
}

const LOGGED: &str = "--vessel \0study/vessel.toml --trajectories \0out/measured/trajectories.parquet";

/// The stages of a study with logs, of which sub-experiments are picked if that is `selected`.
pub fn measured(
    settings: &StudySettings,
    shape: &StudyShape,
    selected: Option<Vec<String>>,
) -> Vec<StudyStep> {
    let ingest = format!("ingest --config \0study/ingest.toml {SHIP} --logs \0logs");
    let recordings = ["measured/trajectories.parquet", "measured/ingest.json"];
    let mut steps = vec![step("ingest", &ingest, NONE, &recordings)];
    steps.extend(modelled(settings, shape));
    if let Some(flags) = selected {
        steps.extend(picked(settings, shape, flags));
    }
    if shape.has_next || settings.search_next {
        steps.extend(next_trial(settings, shape));
    }
    if !shape.has_regressors || settings.merit.is_some() {
        let flags = settings.merit.as_ref().map_or(NONE, |asked| asked.over(""));
        steps.push(step("merit", &format!("validate merit {LOGGED}"), flags, &["measured/merit.json"]));
    }
    let line = "report --study \0study --results \0out/measured";
    steps.push(step("report", line, NONE, &["measured/report.html"]));
    steps
}

/// The model of all recordings, and one without those of `test`, which it is tried on.
fn modelled(settings: &StudySettings, shape: &StudyShape) -> Vec<StudyStep> {
    let asked = &settings.estimate;
    let is_searched = match (asked.value("structure"), asked.has(&["estimator"])) {
        (Some(name), _) => !["own", "core"].contains(&name),
        (None, true) => false,
        (None, false) => {
            let usual = usual_structure(shape.recordings, shape.has_regressors);
            ![ModelStructure::Own, ModelStructure::Core].contains(&usual)
        }
    };
    // A search leaves recordings out by itself; the second model is not judged by itself, so that fewer folds do.
    let (judged, second) = match (is_searched, shape.has_regressors) {
        (true, _) => ("", "--folds 3"),
        (false, true) => ("--folds each --bootstrap 1000", ""),
        (false, false) => ("--folds each", ""),
    };
    let fit = |name: &str, below: &str, flags: Vec<String>| {
        let files = ["estimate.json", "model.json", "estimates.parquet"]
            .map(|name| format!("measured/{below}{name}"));
        let count = if is_searched || !shape.has_regressors { 2 } else { 3 };
        let outputs: Vec<&str> = files.iter().take(count).map(String::as_str).collect();
        step(name, &format!("estimate {LOGGED}"), flags, &outputs)
    };
    let mut steps = vec![fit("estimate", "", asked.over(judged))];
    let test = settings.test.join(",");
    let left = shape.recordings.saturating_sub(settings.test.len());
    if !test.is_empty() && (!is_searched || left >= SEARCHED) {
        let dropped: &[&str] = if is_searched { &[] } else { &["folds", "window-s", "bootstrap"] };
        let flags = asked.without(dropped).over(&format!("{second} --leave-out {test}"));
        steps.push(fit("test-estimate", "test/", flags));
        steps.push(compared(settings, &test));
    }
    steps
}

/// The model of the recordings that are not in `test`, tried on those that are.
fn compared(settings: &StudySettings, test: &str) -> StudyStep {
    let line = format!(
        "validate --model \0out/measured/test/model.json --trajectories \0out/measured/trajectories.parquet --runs \
         {test}"
    );
    step("compare", &line, settings.compare.over(""), &["measured/validation.json"])
}

/// Sub-experiments that are designed, picked with these `flags` and compared.
fn picked(settings: &StudySettings, shape: &StudyShape, flags: Vec<String>) -> [StudyStep; 3] {
    // No more of a maneuver than was logged.
    let designed = "design --moments \0out/measured/moments.json --available \0out/measured/ingest.json";
    let reference = if shape.has_reference { "--reference \0study/reference.toml" } else { "" };
    let picked = format!("validate {LOGGED} --design \0out/measured/design.json {reference}");
    let picks = ["measured/picks/scores.parquet", "measured/picks/validation.json"];
    let design = with_ship(settings.design.over(""), &format!("{SHIP} {HELM}"));
    [
        step("moments", &format!("moments {LOGGED}"), settings.moments.over(""), &["measured/moments.json"]),
        step("design", designed, design, &["measured/design.json"]),
        step("selection", &picked, flags, &picks),
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
    let is_searched = settings.search_next;
    let (model, allowed) = match is_searched {
        true => ("--vessel \0out/measured/next/model.json", ""),
        false => ("--vessel \0out/measured/model.json", "--allow=beyond-range"),
    };
    let search = format!("estimate {LOGGED}");
    // A fitted ship may not go straight ahead: that is said.
    let unreached = if is_searched { "" } else { "--allow=unreached" };
    let dictionary = format!("simulate dictionary {model} {HELM} {allowed} {unreached}");
    let moments = format!("moments {model} {MADE} {SEA} --estimator output-error");
    let design = "design --moments \0out/measured/next/moments.json --for output-error";
    let usual = match is_searched {
        true => "",
        // Sequences take long to judge for forces, and hardly tell the many terms of a search.
        false if !shape.has_regressors || shape.recordings >= SEARCHED => "--criterion d",
        false => "--criterion d --arrange",
    };
    let designed = with_ship(settings.next.over(usual), &format!("{model} {HELM}"));
    let promised = format!("monte-carlo {model} {HELM} {SEA} {DESIGN} --estimator output-error");
    let outputs = ["measured/next/estimate.json", "measured/next/model.json"];
    let mut steps = vec![
        step("next-dictionary", &dictionary, NONE, &["measured/next/dictionary.parquet"]),
        step("next-moments", &moments, NONE, &["measured/next/moments.json"]),
        step("next-design", design, designed, &["measured/next/design.json"]),
    ];
    if is_searched {
        steps.insert(0, step("search", &search, settings.search.over("--structure few"), &outputs));
        steps.push(step("next-monte-carlo", &promised, NONE, &["measured/next/validation.json"]));
    }
    if shape.next_is_charted {
        let line = format!("plan {model} {MADE} {HELM} {DESIGN} --config \0study/next/plan.toml {allowed}");
        steps.push(step("next-plan", &line, NONE, &["measured/next/plan.json"]));
    }
    steps.iter_mut().for_each(|step| step.is_optional = !is_searched);
    steps
}
