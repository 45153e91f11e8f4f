//! How much of every maneuver exists.

use std::collections::BTreeMap;
use std::path::Path;

use artifact::{Digest, Provenance, read_document, read_toml};
use serde::Deserialize;
use vessel::nearest;

use crate::failure::Failure;
use study::documents::{IngestDocument, MomentsDocument};

/// `available.toml` or `available.json` as written; or from `ingest.json` the segments it counts. Maneuvers in neither table are not limited.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct AvailableFile {
    /// Maneuver → at most so long \[s\].
    #[serde(default)]
    seconds: BTreeMap<String, f64>,
    /// Maneuver → at most so many whole segments.
    #[serde(default)]
    segments: BTreeMap<String, u64>,
}

/// The experiment that shares are of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Experiment {
    /// Its samples, where that is known.
    pub samples: Option<f64>,
    /// Whole segments and the samples of each, where there are to be any.
    pub segments: Option<(u64, u64)>,
}

/// Upper bounds, one per maneuver in the dictionary's order.
#[derive(Clone, Debug, PartialEq)]
pub struct Available {
    /// On the share; 1 where there is no limit.
    pub shares: Vec<f64>,
    /// On the count of whole segments; the number of segments where there is no limit.
    pub counts: Option<Vec<u64>>,
}

impl Available {
    /// Reads what is available and notes its digest.
    ///
    /// # Errors
    /// A file that is refused, a maneuver that the moments do not know or that is limited twice, a negative time; usage where
    /// the length of the experiment or of its segments is needed and not given.
    pub fn read(
        path: &Path,
        moments: &MomentsDocument,
        experiment: &Experiment,
        provenance: &mut Provenance,
    ) -> Result<Self, Failure> {
        let (file, digest) = read(path)?;
        provenance.inputs.insert("available".into(), digest);
        file.check(path, moments)?;
        let usage = |table: &str, flags: &str| {
            Failure::Usage(format!(
                "--available: found `{table}` in {}, expected {flags} to relate them to; add it",
                path.display()
            ))
        };
        if !file.segments.is_empty() && experiment.segments.is_none() {
            return Err(usage("segments", "--segments and --segment-samples"));
        }
        let samples = match experiment.samples {
            Some(samples) => samples,
            None if file.seconds.is_empty() => 1.0,
            None => return Err(usage("seconds", "--duration-s, or --segments and --segment-samples,")),
        };
        let rate = moments.sample_rate_hz;
        let share = |name: &String| match (file.seconds.get(name), file.segments.get(name)) {
            (Some(seconds), _) => seconds * rate / samples,
            (_, Some(segments)) => *segments as f64 / experiment.segments.map_or(1.0, |(n, _)| n as f64),
            _ => 1.0,
        };
        let count = |name: &String, (total, each): (u64, u64)| match (
            file.seconds.get(name),
            file.segments.get(name),
        ) {
            // Rounding must not cost a segment that just fits.
            (Some(seconds), _) => (seconds * rate / each as f64 + 1e-9).floor() as u64,
            (_, Some(segments)) => *segments,
            _ => total,
        };
        let names = || moments.maneuvers.iter().map(|m| &m.name);
        let found = Self {
            shares: names().map(|name| share(name).min(1.0)).collect(),
            counts: experiment
                .segments
                .map(|about| names().map(|name| count(name, about).min(about.0)).collect()),
        };
        found.check_enough(path, experiment)?;
        Ok(found)
    }

    fn check_enough(&self, path: &Path, experiment: &Experiment) -> Result<(), Failure> {
        let total: f64 = self.shares.iter().sum();
        let refuse = |found: String, expected: String| {
            Err(Failure::NoAnswer(format!(
                "{}: what is available: found {found}, expected at least {expected}; shorten the experiment or make more \
                 available",
                path.display()
            )))
        };
        if total < 1.0 - 1e-12 {
            let percent =
                format!("{:.1} % of the experiment's time in all maneuvers together", 100.0 * total);
            return refuse(percent, "100 %".into());
        }
        if let (Some(counts), Some((segments, _))) = (&self.counts, experiment.segments) {
            let room: u128 = counts.iter().map(|a| u128::from(*a)).sum();
            if room < u128::from(segments) {
                return refuse(format!("{room} whole segments"), format!("{segments}"));
            }
        }
        Ok(())
    }
}

fn read(path: &Path) -> Result<(AvailableFile, Digest), Failure> {
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
        return Ok(read_toml(path)?);
    }
    let bytes = std::fs::read(path).map_err(|e| Failure::Failed(format!("{}: read: {e}", path.display())))?;
    let refuse = |e: serde_json::Error| {
        Failure::refuse(
            path,
            &format!("line {}", e.line()),
            e.to_string().lines().next().unwrap_or_default(),
            "{\"seconds\": {maneuver: number}, \"segments\": {maneuver: whole number}}",
            "correct it",
        )
    };
    let value: serde_json::Value = serde_json::from_slice(&bytes).map_err(refuse)?;
    if value.get("schema").is_some() {
        return ingested(path);
    }
    let file = serde_json::from_slice(&bytes).map_err(refuse)?;
    Ok((file, Digest::of_bytes(&bytes)))
}

/// What `ingest` cut of each maneuver.
fn ingested(path: &Path) -> Result<(AvailableFile, Digest), Failure> {
    let loaded = read_document::<IngestDocument>(path)?;
    let segments = loaded.data.maneuvers.into_iter().map(|m| (m.name, m.segments)).collect();
    Ok((AvailableFile { seconds: BTreeMap::new(), segments }, loaded.digest))
}

impl AvailableFile {
    fn check(&self, path: &Path, moments: &MomentsDocument) -> Result<(), Failure> {
        let names = || moments.maneuvers.iter().map(|m| m.name.as_str());
        if let Some(unknown) =
            self.seconds.keys().chain(self.segments.keys()).find(|key| names().all(|name| name != *key))
        {
            let remedy = match nearest(unknown, names()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => "name one of them".into(),
            };
            let expected = "a maneuver of the moments";
            return Err(Failure::refuse(path, "maneuver", &format!("`{unknown}`"), expected, &remedy));
        }
        if let Some(twice) = self.seconds.keys().find(|key| self.segments.contains_key(*key)) {
            let (thing, found) =
                (format!("maneuver `{twice}`"), "a limit in `seconds` and one in `segments`");
            return Err(Failure::refuse(path, &thing, found, "one limit", "remove one"));
        }
        match self.seconds.iter().find(|(_, s)| !(s.is_finite() && **s >= 0.0)) {
            None => Ok(()),
            Some((name, seconds)) => Err(Failure::refuse(
                path,
                &format!("`seconds` of `{name}`"),
                &seconds.to_string(),
                "a time of 0 s or more",
                "correct it",
            )),
        }
    }
}
