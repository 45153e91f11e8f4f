//! What files note of how their runs came about: doubtful recordings, helms that follow logged sensors, other rates, what
//! maneuvers reached.

use std::collections::BTreeMap;
use std::path::Path;

use estimation::Estimator;
use files::{Error, Provenance};
use maneuver::Generator;
use refusal::Invalid;
use serde_json::json;
use ship::model::Vessel;
use trial::campaign::{Maneuvers, Reached, Refusal};

use crate::documents::RecordingSummary;
use crate::tables::trajectories::{REACHED, Reacting};

/// The setting with recordings that are inconsistent, or of which much was left out: estimates do not use them by default.
const DOUBTFUL: &str = "doubtful";

/// The numbers of their runs, by the recordings' names. They are in the settings of trajectories and of the results
/// from these.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Doubtful(BTreeMap<String, Vec<i32>>);

impl Doubtful {
    /// The doubtful ones of `recordings`.
    pub fn among(recordings: &[RecordingSummary]) -> Self {
        let doubtful = recordings.iter().filter(|recording| !recording.doubtful.is_empty());
        let runs = |recording: &RecordingSummary| recording.runs.iter().map(|run| *run as i32).collect();
        Self(doubtful.map(|recording| (recording.name.clone(), runs(recording))).collect())
    }

    /// The doubtful recordings in `provenance`.
    pub fn of(provenance: &Provenance) -> Self {
        let noted = provenance.settings.get(DOUBTFUL).cloned();
        Self(noted.and_then(|noted| serde_json::from_value(noted).ok()).unwrap_or_default())
    }

    /// Notes them, if there are any, in `provenance`.
    pub fn note(&self, provenance: &mut Provenance) {
        if !self.0.is_empty() {
            provenance.settings.insert(DOUBTFUL.to_owned(), json!(self.0));
        }
    }

    /// Their names.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// Refuses an estimate from runs of `file`, if one of these is `used`.
    ///
    /// # Errors
    /// Names the recording.
    pub fn check(&self, file: &Path, used: impl Fn(i32) -> bool) -> Result<(), Error> {
        let doubtful = self.0.iter().filter(|(_, runs)| runs.iter().any(|run| used(*run)));
        let doubtful: Vec<&str> = doubtful.map(|(name, _)| name.as_str()).collect();
        let Some(first) = doubtful.first() else { return Ok(()) };
        let more =
            if doubtful.len() > 1 { format!(", as in {} more", doubtful.len() - 1) } else { String::new() };
        Err(Error::refuse(
            file,
            format!("recording `{first}`"),
            format!(
                "much that was left out, or a motion that contradicts itself{more}: see `doubtful` in ingest.json"
            ),
            "logs that agree with themselves",
            "correct the logs or ingest.toml, leave the recording out, or add --allow=doubtful",
        ))
    }
}

/// The setting with the names of recordings that contradict the others.
const CONTRADICTING: &str = "contradicting";

/// Notes those of `recordings` that contradict the others, if there are any, in `provenance`.
pub fn note_contradicting(recordings: &[RecordingSummary], provenance: &mut Provenance) {
    let names = recordings.iter().filter(|one| one.contradicts.is_some()).map(|one| one.name.as_str());
    let names: Vec<&str> = names.collect();
    if !names.is_empty() {
        provenance.settings.insert(CONTRADICTING.to_owned(), json!(names));
    }
}

/// Notes in `provenance` what is noted in `of`.
pub fn carry_contradicting(of: &Provenance, provenance: &mut Provenance) {
    let noted = of.settings.get(CONTRADICTING).cloned();
    provenance.settings.extend(noted.map(|noted| (CONTRADICTING.to_owned(), noted)));
}

/// What is noted in the `provenance` of trajectories, or of what was made of them, in words.
pub fn noted_contradicting(provenance: &Provenance) -> Option<String> {
    let names: Vec<String> = serde_json::from_value(provenance.settings.get(CONTRADICTING)?.clone()).ok()?;
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    contradicting(&names)
        .map(|words| format!("{words}: another ship, loading or sensor? --leave-out leaves them out"))
}

/// Recordings of these names, in words.
pub fn contradicting(names: &[&str]) -> Option<String> {
    let (first, more) = names.split_first()?;
    Some(match more.len() {
        0 => format!("recording `{first}` contradicts the others"),
        more => format!("recordings `{first}` and {more} more contradict the others"),
    })
}

// Maneuvers that are steered by the sensors that are logged: their inputs follow the noise of the log.

/// The setting of trajectories that lists them.
const LOGGED_HELM: &str = "steered_by_logged_sensors";

/// Their names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoggedHelm(Vec<String>);

impl LoggedHelm {
    /// Those of a dictionary.
    pub fn among(generator: &Generator) -> Self {
        let logged = generator.maneuvers().iter().filter(|maneuver| maneuver.is_steered_by_the_log());
        Self(logged.map(|maneuver| maneuver.name.clone()).collect())
    }

    /// Those of the trajectories of `provenance`.
    pub fn of(provenance: &Provenance) -> Self {
        let noted = provenance.settings.get(LOGGED_HELM).cloned();
        Self(noted.and_then(|noted| serde_json::from_value(noted).ok()).unwrap_or_default())
    }

    /// Notes them, if there are any, in `provenance`.
    pub fn note(&self, provenance: &mut Provenance) {
        if !self.0.is_empty() {
            provenance.settings.insert(LOGGED_HELM.to_owned(), json!(self.0));
        }
    }

    /// Refuses instruments that are simulated over recorded inputs, since these follow the noise of the regressors: estimates
    /// were wrong by 80 % where that was tried.
    ///
    /// # Errors
    /// Names the maneuver and the estimator.
    pub fn check(&self, file: &Path, estimators: &[Estimator]) -> Result<(), Error> {
        let by_instruments =
            |estimator: &&Estimator| estimator.by_instruments() || **estimator == Estimator::Auto;
        let (Some(name), Some(estimator)) = (self.0.first(), estimators.iter().find(by_instruments)) else {
            return Ok(());
        };
        Err(Error::refuse(
            file,
            format!("maneuver `{name}`"),
            format!(
                "inputs that follow the noise of the logged sensors, by which it is steered, and --estimator {estimator}"
            ),
            "an estimator that takes no recorded input as free of that noise",
            "use --estimator output-error, or steer by sensors of the helmsman's own (`sensors = \"own\"`)",
        ))
    }
}

/// The vessel at `path` at the rate that was requested \[Hz\], if one was; notes both.
///
/// # Errors
/// A rate that its terms per sample cannot have.
pub fn at_rate(
    path: &Path,
    vessel: Vessel,
    rate_hz: Option<f64>,
    provenance: &mut Provenance,
) -> Result<Vessel, Error> {
    let Some(rate_hz) = rate_hz else { return Ok(vessel) };
    let sample_rate_hz = vessel.sample_rate_hz;
    let vessel = vessel.at_rate(rate_hz).map_err(|e| crate::invalid(path, &e))?;
    provenance.settings.insert("rate_hz".into(), json!(rate_hz));
    provenance.settings.insert("vessel_rate_hz".into(), json!(sample_rate_hz));
    Ok(vessel)
}

/// Notes how well samples that are parts of the vessel's steps follow these, and says it; nothing for other samples.
///
/// # Errors
/// Samples that are off by more than 0.2 % of a standard deviation; maneuvers that cannot be simulated.
pub fn note_divided(maneuvers: &Maneuvers, provenance: &mut Provenance) -> Result<Option<String>, Refusal> {
    let Some(divided) = maneuvers.divided()? else { return Ok(None) };
    let statement = divided.statement().map_err(Refusal::Vessel)?;
    provenance.settings.insert("divided".into(), json!(statement));
    Ok(Some(statement))
}

/// Notes what the `maneuvers` of a dictionary reached, in words, and which of them react.
///
/// # Errors
/// The first that misses what it is called, with the number of others, unless that is allowed.
pub fn note_reached(
    maneuvers: &Maneuvers,
    reached: &[Reached],
    is_allowed: bool,
    provenance: &mut Provenance,
) -> Result<(), Invalid> {
    let missed: Vec<Invalid> = reached.iter().filter_map(Reached::missed).collect();
    if let Some(first) = missed.first().filter(|_| !is_allowed) {
        let others = match missed.len() - 1 {
            0 => String::new(),
            others => format!(" (and {others} more maneuvers miss theirs)"),
        };
        return Err(Invalid { expected: format!("{}{others}", first.expected), ..first.clone() });
    }
    let words = reached.iter().filter_map(|motion| Some((motion.maneuver.clone(), json!(motion.words()?))));
    let words: serde_json::Map<_, _> = words.collect();
    if !words.is_empty() {
        provenance.settings.insert(REACHED.into(), words.into());
    }
    Reacting::of(maneuvers).note(provenance);
    Ok(())
}
