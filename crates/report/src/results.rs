//! The results of many studies as tables in Markdown, for documentation: every number is one of a document.

use std::path::{Component, Path, PathBuf};

use files::{Document, Error, Loaded, Provenance, TableReader};
use serde_json::Value;
use study::documents::{
    Bounds, DesignScores, EstimateDocument, Estimator, EstimatorScore, EstimatorScores, PublishedShare,
    Quantiles, Reference, SimulatedLogsDocument, TrialsInRounds, ValidationDocument,
};
use study::files::{read_campaign, read_reference};
use study::trajectories;

use crate::loader::{document_at, existing};
use crate::number::{exact, or_dash, percent, percent_within, published, three, three_or_dash, three_within};

/// Folders that the stages wrote into. Missing ones are reported.
#[derive(Clone, Debug, Default)]
pub struct Folders {
    /// Folder of the studies' hand-written files, one per study: their reference.toml has published results.
    pub written: Option<PathBuf>,
    /// Simulated trials of designs: validation.json, estimate.json.
    pub studies: Vec<PathBuf>,
    /// The same, with a comparison of estimators.
    pub scenarios: Vec<PathBuf>,
    /// For each scenario, in a subfolder, estimates with a current as an unknown: validation.json, estimate.json.
    pub unknown: Vec<PathBuf>,
    /// Trials in rounds: validation.json.
    pub rounds: Vec<PathBuf>,
    /// Picks of sub-experiments: picks/validation.json.
    pub selections: Vec<PathBuf>,
    /// Measured logs: estimate.json with scores of recordings left out.
    pub logs: Vec<PathBuf>,
}

/// The requested tables, a section each.
///
/// # Errors
/// An existing document is refused.
pub fn tables(folders: &Folders) -> Result<String, Error> {
    let sections = [
        designs_section(&folders.studies, folders.written.as_deref())?,
        estimators_section(&folders.scenarios)?,
        unknown_section(&folders.unknown)?,
        rounds_section(&folders.rounds)?,
        selections_section(&folders.selections, folders.written.as_deref())?,
        logs_section(&folders.logs)?,
    ];
    Ok(format!("{HEAD}\n{}", sections.into_iter().flatten().collect::<Vec<_>>().join("\n")))
}

const HEAD: &str = "# Results

Written by `make results` from the documents of the studies; not to be edited. In brackets stands the 95 % confidence
interval of what endless trials would give: of 100 studies, each with other noise, the intervals of about 95 hold it. The value of a
repeated study falls into the interval printed here less often, some 83 times of 100. A dash stands where a document has none.
";

/// Shares of good models and median errors, by study and design.
fn designs_section(folders: &[PathBuf], written: Option<&Path>) -> Result<Option<String>, Error> {
    let (read, missing) = validations(folders, "", |of| of.scored)?;
    let (mut rows, mut bounds, mut used) = (Vec::new(), Vec::new(), String::new());
    for (folder, Loaded { data: validation, .. }) in &read {
        let (name, seed) = (label(folder), seed(folder)?);
        let of = (name.clone(), length_s(written, &name)?);
        let reference = reference(written, &name)?;
        let Bounds { parameter_error, simulation_error } = validation.bounds;
        bounds.push(format!("{name} {} and {}", exact(parameter_error), exact(simulation_error)));
        if let Some(use_of) = reference.as_ref().and_then(|r| r.used.as_ref()) {
            used += &format!("\nOf the published numbers of {name}: {use_of}\n");
        }
        let published = |design: &str| reference.as_ref()?.designs.get(design).copied();
        rows.extend(validation.designs.iter().map(|d| (of.clone(), seed, d, published(&d.design))));
    }
    let table = MarkdownTable::of(rows)
        .column("study", |((name, _), ..)| name.clone())
        .column("length, s", |((_, length_s), ..)| or_dash(length_s.map(exact)))
        .column("design", |(_, _, d, _)| d.design.clone())
        .column("trials", |(_, _, d, _)| d.runs.to_string())
        .column("seed", |(_, seed, ..)| or_dash(*seed))
        .column("parameter error below the bound", |(_, _, d, published)| {
            share(d.parameter_error_share, d.parameter_error_share_interval)
                + &published_share(published.map(|p| p.parameter_error_share))
        })
        .column("simulation error below the bound", |(_, _, d, published)| {
            share(d.simulation_error_share, d.simulation_error_share_interval)
                + &published_share(published.map(|p| p.simulation_error_share))
        })
        .column("median parameter error", |(_, _, d, _)| median(&d.parameter_error))
        .column("median simulation error", |(_, _, d, _)| median(&d.simulation_error));
    let note = left_out(&missing, "not computed");
    if read.iter().any(|(_, v)| v.data.designs.iter().any(|d| d.design == "practice")) {
        used = format!("\n{PRACTICE}\n{used}");
    }
    Ok(table.text().map(|table| {
        let bounds = bounds.join(", ");
        format!("## Designs\n\n{table}\nBounds on parameter and simulation error: {bounds}.\n{used}{note}")
    }))
}

/// What the design of that name is.
const PRACTICE: &str = "Practice is today's practice: the maneuvers of the dictionary, one after another, for the same \
     seconds and by the same estimator. Dashes stand where they tell no model, since some parameter is not excited.";

/// The published share.
fn published_share(share: Option<PublishedShare>) -> String {
    match share {
        Some(PublishedShare::Value(value)) => format!("; published {}", published(value)),
        Some(PublishedShare::Above { above }) => format!("; published > {}", published(above)),
        None => String::new(),
    }
}

/// Folders with the documents read there, and the names of those without.
type Read<D> = (Vec<(PathBuf, Loaded<D>)>, Vec<String>);

/// The folders with a document `name`, and the names of those without.
fn documents<D: Document>(folders: &[PathBuf], name: impl AsRef<Path>) -> Result<Read<D>, Error> {
    let (mut read, mut missing) = (Vec::new(), Vec::new());
    for folder in folders {
        match document_at(folder.join(name.as_ref()))? {
            Some(document) => read.push((folder.clone(), document)),
            None => missing.push(label(folder)),
        }
    }
    Ok((read, missing))
}

/// What `section` takes of `validation.json` in the folder `below` each of `folders`.
fn validations<S>(
    folders: &[PathBuf],
    below: &str,
    section: fn(ValidationDocument) -> Option<S>,
) -> Result<Read<S>, Error> {
    let (all, mut missing) =
        documents::<ValidationDocument>(folders, &Path::new(below).join("validation.json"))?;
    let mut read = Vec::new();
    for (folder, Loaded { data, digest, provenance, members }) in all {
        match section(data) {
            Some(data) => read.push((folder, Loaded { data, digest, provenance, members })),
            None => missing.push(label(&folder)),
        }
    }
    Ok((read, missing))
}

/// A note on what is not in the table.
fn left_out(missing: &[String], why: &str) -> String {
    if missing.is_empty() { String::new() } else { format!("\nNot here: {} ({why}).\n", missing.join(", ")) }
}

/// A study's name: its folder below `out`, without common parts.
fn label(folder: &Path) -> String {
    let names = folder.components().filter_map(|component| match component {
        Component::Normal(name) => name.to_str(),
        _ => None,
    });
    names.filter(|name| !["out", "trials", "seeds", "measured"].contains(name)).collect::<Vec<_>>().join(" ")
}

/// The seed of the simulated trials in `folder`.
fn seed(folder: &Path) -> Result<Option<u64>, Error> {
    let mut names = ["campaign.parquet", "trajectories.parquet"].into_iter();
    let Some(path) = names.find_map(|name| existing(folder.join(name))) else {
        // Trials in memory leave no table.
        let validation = document_at::<ValidationDocument>(folder.join("validation.json"))?;
        return Ok(validation.and_then(|loaded| loaded.data.scored?.seed));
    };
    Ok(seed_of(TableReader::open(&path, trajectories::ID, trajectories::VERSION)?.provenance()))
}

/// The seed in the provenance of a file.
fn seed_of(provenance: &Provenance) -> Option<u64> {
    provenance.settings.get("seed").and_then(Value::as_u64)
}

/// The length \[s\] of the trials of the study `name`, whose folder is in `written`; `None` of a plan's, which are of another length.
fn length_s(written: Option<&Path>, name: &str) -> Result<Option<f64>, Error> {
    let path = written.and_then(|written| existing(written.join(name).join("campaign.toml")));
    let campaign = path.map(|path| read_campaign(&path, &mut Provenance::default())).transpose()?;
    Ok(campaign.map(|campaign| campaign.duration_s))
}

/// The published results of the study `name`, whose folder is in `written`.
fn reference(written: Option<&Path>, name: &str) -> Result<Option<Reference>, Error> {
    let study = name.split(' ').next().unwrap_or(name);
    let path = written.map(|written| written.join(study).join("reference.toml"));
    path.and_then(existing)
        .map(|path| read_reference(&path, "reference", &mut Provenance::default()))
        .transpose()
}

/// A table that is written column by column.
struct MarkdownTable<R> {
    heads: Vec<String>,
    rows: Vec<(R, Vec<String>)>,
}

impl<R> MarkdownTable<R> {
    /// A row for each of `rows`.
    fn of(rows: impl IntoIterator<Item = R>) -> Self {
        Self { heads: Vec::new(), rows: rows.into_iter().map(|row| (row, Vec::new())).collect() }
    }

    /// Adds a column with its head and its cells.
    fn column(mut self, head: &str, cell: impl Fn(&R) -> String) -> Self {
        self.heads.push(head.to_owned());
        self.rows.iter_mut().for_each(|(row, cells)| cells.push(cell(row)));
        self
    }

    /// The whole table, or `None` without rows.
    fn text(self) -> Option<String> {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let rows: String = self.rows.iter().map(|(_, cells)| line(cells)).collect();
        let head = format!("{}|{}\n", line(&self.heads), "---|".repeat(self.heads.len()));
        (!rows.is_empty()).then(|| head + &rows)
    }
}

/// A share and its interval; a dash if the document has none.
fn share(value: f64, interval: Option<[f64; 2]>) -> String {
    percent_within(value, interval) + if interval.is_some() { "" } else { " (–)" }
}

/// A quantile and its interval; a dash if the document has none.
fn quantile(value: Option<f64>, interval: Option<[Option<f64>; 2]>) -> String {
    three_within(value, interval) + if interval.is_some() { "" } else { " (–)" }
}

/// The median and its interval.
fn median(errors: &Quantiles) -> String {
    quantile(errors.median, errors.median_interval)
}

/// The design whose errors are in the table.
const DESIGN: &str = "optimized";

fn estimators_section(folders: &[PathBuf]) -> Result<Option<String>, Error> {
    let (read, missing) = validations(folders, "", |of| of.scored)?;
    let compared: Vec<&[EstimatorScores]> =
        read.iter().map(|(_, v)| v.data.compared.as_deref().unwrap_or_default()).collect();
    let given = |estimator: &Estimator| compared.iter().any(|scores| of(scores, *estimator).is_some());
    let estimators: Vec<Estimator> = Estimator::OF_RUNS.into_iter().filter(given).collect();
    let mut rows = Vec::new();
    for ((folder, _), scores) in read.iter().zip(&compared) {
        let scored: Vec<Option<&DesignScores>> =
            estimators.iter().map(|estimator| of(scores, *estimator)).collect();
        rows.push((label(folder), seed(folder)?, scored));
    }
    let table = MarkdownTable::of(rows)
        .column("scenario", |(name, ..)| name.clone())
        .column("trials", |(.., scored)| or_dash(scored.iter().flatten().next().map(|d| d.runs)))
        .column("seed", |(_, seed, _)| or_dash(*seed));
    let table = estimators.iter().enumerate().fold(table, |table, (i, estimator)| {
        let error = |scored: &[Option<&DesignScores>]| or_dash(scored[i].map(|d| median(&d.parameter_error)));
        table.column(&format!("`{estimator}`"), |(.., scored)| error(scored))
    });
    let note = left_out(&missing, "not computed");
    Ok(table.text().map(|table| {
        format!(
            "## Estimators\n\nMedian parameter error of the {DESIGN} trial; a trial without an estimate counts as infinite.\n\n{table}{note}"
        )
    }))
}

/// The errors of `estimator`.
fn of(scores: &[EstimatorScores], estimator: Estimator) -> Option<&DesignScores> {
    scores.iter().find(|s| s.estimator == estimator)?.designs.iter().find(|d| d.design == DESIGN)
}

/// How well models predict measured recordings that were left out.
fn logs_section(folders: &[PathBuf]) -> Result<Option<String>, Error> {
    let (read, missing) = documents::<EstimateDocument>(folders, "estimate.json")?;
    let scores = read.iter().flat_map(|(folder, loaded)| {
        let all = loaded.data.left_out.iter();
        all.flat_map(move |scores| scores.estimators.iter().map(move |score| (folder, scores, score)))
    });
    let table = MarkdownTable::of(scores)
        .column("logs", |(folder, ..)| label(folder))
        .column("estimator", |(.., score)| format!("`{}`", score.name))
        .column("fit of surge, sway, yaw rate", |(.., score)| fits(score))
        .column("error norm", |(.., score)| three_or_dash(score.error_norm))
        .column("above the least", |(_, document, score)| {
            or_dash(document.difference(score.name).map(|d| three_within(d.median, Some(d.interval))))
        })
        .column("folds", |(_, document, _)| document.folds.to_string())
        .column("windows", |(_, document, _)| document.windows.to_string())
        .column("length", |(_, document, _)| {
            document.window_s.map_or("whole".to_owned(), |s| format!("{} s", exact(s)))
        });
    let note = left_out(&missing, "the logs were not there; see own-logs.md");
    let about = "Each recording is left out in turn and predicted by the model of the others. Fit: 100 (1 − RMSE/std), 0 is as good as the mean \
        of the data, 100 perfect. Above the least: how far the error norm of a recording lies above that by the estimator of \
        least median norm, median over the recordings with its 95 % interval; one that contains 0 tells no difference.";
    Ok((!folders.is_empty()).then(|| {
        let table = table.text().map_or(String::new(), |table| format!("\n{table}"));
        format!("## Measured logs\n\n{about}\n{table}{note}")
    }))
}

fn fits(score: &EstimatorScore) -> String {
    let fit = |fit: Option<f64>| or_dash(fit.map(|fit| format!("{fit:.1}")));
    match &score.errors {
        Some(e) => format!("{} / {} / {} %", fit(e.fit_u), fit(e.fit_v), fit(e.fit_r)),
        None => score.status.to_string(),
    }
}

/// Trials designed in rounds against trials designed once.
fn rounds_section(folders: &[PathBuf]) -> Result<Option<String>, Error> {
    let (read, missing) = validations(folders, "", |of| of.rounds)?;
    let mut text = String::new();
    for (folder, Loaded { data: document, provenance, .. }) in &read {
        text += &format!(
            "\n{}: {} maneuvers, {} realizations, seed {}.\n\n{}{}",
            label(folder),
            document.maneuvers,
            document.realizations,
            or_dash(seed_of(provenance)),
            errors(document).unwrap_or_default(),
            stopping(document).map_or(String::new(), |table| format!("\n{table}"))
        );
    }
    let note = left_out(&missing, "not computed");
    let about = "Median parameter error after equal time at sea, and the error in rounds over that of the trial designed once, pair by pair \
        (geometric mean). Then trials that stop when they promise the accuracy.";
    Ok((!read.is_empty()).then(|| format!("## Rounds\n\n{about}\n{text}{note}")))
}

/// A row per time, a column per arm.
fn errors(document: &TrialsInRounds) -> Option<String> {
    let times = MarkdownTable::of(document.gains.iter().enumerate())
        .column("after", |(_, gain)| format!("{} s", exact(gain.time_s)));
    let arms = document.arms.iter().fold(times, |table, arm| {
        table.column(arm.name.name(), |(i, _)| {
            or_dash(arm.points.get(*i).map(|point| quantile(point.median, point.median_interval)))
        })
    });
    let table = arms
        .column("rounds / once", |(_, gain)| {
            let ends =
                gain.low.zip(gain.high).map(|(low, high)| format!(" ({} to {})", three(low), three(high)));
            three_or_dash(gain.ratio) + &ends.unwrap_or(" (–)".to_owned())
        })
        .column("pairs", |(_, gain)| gain.pairs.to_string());
    table.text()
}

/// A row per arm that may stop.
fn stopping(document: &TrialsInRounds) -> Option<String> {
    let within = format!("within {}, of those promised", exact(document.accuracy));
    let table = MarkdownTable::of(&document.stopping)
        .column("", |arm| arm.arm.name().to_owned())
        .column("promised in time", |arm| format!("{} of {}", arm.stopped, document.realizations))
        .column("mean time", |arm| {
            let within = arm.mean_time_interval_s.map(|[low, high]| format!("{low:.0} to {high:.0}"));
            format!("{:.0} s ({})", arm.mean_time_s, or_dash(within))
        })
        .column(&within, |arm| {
            or_dash(arm.within_stopped.map(|value| share(value, arm.within_stopped_interval)))
        })
        .column("of all", |arm| share(arm.within, arm.within_interval))
        .column("error over promise, root mean square", |arm| {
            quantile(arm.rms_over_accuracy, arm.rms_over_accuracy_interval.map(|ends| ends.map(Some)))
        });
    table.text()
}

/// Models from sub-experiments that a design picked against random picks.
fn selections_section(folders: &[PathBuf], written: Option<&Path>) -> Result<Option<String>, Error> {
    let (read, missing) = validations(folders, "picks", |of| of.picks)?;
    let mut rows = Vec::new();
    let mut notes: Vec<String> = Vec::new();
    for (folder, Loaded { data: selection, .. }) in &read {
        let (name, seed) = (label(folder), seed_of_logs(folder)?);
        rows.extend(selection.designs.iter().map(|scores| (study(&name).to_owned(), seed, scores)));
        let published = reference(written, &name)?.and_then(|r| r.selection);
        let statements = published.map_or(Vec::new(), |published| published.statements);
        let statements =
            statements.into_iter().map(|said| format!("- Published of {}: {said}", study(&name)));
        let new: Vec<String> = statements.filter(|said| !notes.contains(said)).collect();
        notes.extend(new);
    }
    let plain = |value: Option<f64>| value.map_or("∞".to_owned(), three);
    let table = MarkdownTable::of(rows)
        .column("study", |(name, ..)| name.clone())
        .column("seed of the logs", |(_, seed, _)| or_dash(*seed))
        .column("picks", |(.., d)| d.design.clone())
        .column("realizations", |(.., d)| d.realizations.to_string())
        .column("median", |(.., d)| median(&d.overlapping.rmse_norm))
        .column("90 %", |(.., d)| plain(d.overlapping.rmse_norm.q90))
        .column("worst", |(.., d)| plain(d.overlapping.rmse_norm.max))
        .column("degenerate", |(.., d)| share(d.degenerate_share, d.degenerate_share_interval));
    let notes = if notes.is_empty() { String::new() } else { format!("\n{}\n", notes.join("\n")) };
    let note = left_out(&missing, "not computed");
    let about = "Norm of the RMSE of surge, sway and yaw rate (m/s, m/s, rad/s as numbers) over all sub-experiments, of models from as many \
        sub-experiments each: picked by the design's counts, or at random. ∞: its simulation diverges.";
    Ok(table.text().map(|table| format!("## Selected sub-experiments\n\n{about}\n\n{table}{notes}{note}")))
}

/// The study's name without the seed.
fn study(label: &str) -> &str {
    label.split(' ').next().unwrap_or(label)
}

/// The seed of simulated logs, which are next to the results from them.
fn seed_of_logs(folder: &Path) -> Result<Option<u64>, Error> {
    let path = folder.parent().unwrap_or(folder).join("logs/simulated.json");
    Ok(document_at::<SimulatedLogsDocument>(path)?.and_then(|logs| seed_of(&logs.provenance)))
}

/// Settings of estimates for unknowns, as flags of `estimate`.
const FLAGS: [(&str, &str); 2] = [("unknown_current", "--unknown-current"), ("intercepts", "--intercepts")];

fn unknown_section(folders: &[PathBuf]) -> Result<Option<String>, Error> {
    let (read, missing) = validations(folders, "", |of| of.scored)?;
    let mut rows = Vec::new();
    for (folder, validation) in &read {
        let estimate = document_at::<EstimateDocument>(folder.join("estimate.json"))?;
        let settings = estimate.map(|estimate| estimate.provenance.settings).unwrap_or_default();
        let setting = |name: &str| settings.get(name).and_then(Value::as_str);
        let flags = FLAGS.iter().filter_map(|(name, flag)| Some(format!(" {flag} {}", setting(name)?)));
        let way = format!("`{}{}`", setting("estimator").unwrap_or("–"), flags.collect::<String>());
        let scenario = folder.ancestors().nth(2).map(label);
        rows.extend(
            validation
                .data
                .designs
                .iter()
                .map(|design| (scenario.clone(), way.clone(), validation.data.seed, design)),
        );
    }
    rows.retain(|(.., design)| design.design == DESIGN);
    let table = MarkdownTable::of(rows)
        .column("scenario", |(scenario, ..)| or_dash(scenario.clone()))
        .column("trials", |(.., design)| design.runs.to_string())
        .column("seed", |(.., seed, _)| or_dash(*seed))
        .column("estimator", |(_, way, ..)| way.clone())
        .column("median parameter error", |(.., design)| median(&design.parameter_error))
        .column("without an estimate", |(.., design)| or_dash(design.without_estimate_share.map(percent)));
    let note = left_out(&missing, "not computed");
    Ok(table.text().map(|table| format!("## Current as an unknown\n\n{UNKNOWN}\n\n{table}{note}")))
}

const UNKNOWN: &str = "The same trials of the optimized design, estimated without being told of the disturbances (`estimate` without `--campaign`).";
