//! Measured logs to runs.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use files::{Error, Provenance, Scratch};
use logs::{BLOCK, Plan, Source, Totals, check_intervals};
use rayon::prelude::*;
use regression::pooled::PooledRuns;
use ship::engine::Run;
use ship::model::Vessel;
use study::Doubtful;
use study::documents::{IngestDocument, RecordingSummary};
use study::files::read_ingest;
use study::ingest_file::read::recorded;
use study::ingest_file::recordings::find;
use study::ingest_file::{IngestFile, simulated_label};
use study::trajectories::DataLabel;

/// Logs as `ingest.toml` describes them.
#[derive(Clone, Debug)]
pub struct Logs {
    /// Its keys; the design of simulated logs is their label.
    pub config: IngestFile,
    /// The use of their channels.
    pub plan: Plan,
    /// The recordings, each with its files.
    pub sources: Vec<Source>,
    /// The folder that the files' names are relative to.
    pub folder: PathBuf,
    /// The label of the logs, if they are not those of a real ship.
    pub label: Option<DataLabel>,
    /// `ingest.toml`.
    file: PathBuf,
    /// Name of the vessel.
    vessel: Option<String>,
}

impl Logs {
    /// The logs that `ingest.toml` at `file` describes, next to it, with the channels that `vessel` needs.
    ///
    /// # Errors
    /// Files that are refused; channels that nothing provides.
    pub fn read(file: &Path, vessel: &Vessel) -> Result<Self, Error> {
        let mut provenance = Provenance::default();
        let config = read_ingest(file, &mut provenance)?;
        Self::of(file, config, Some((vessel, "the vessel")), None, &mut provenance)
    }

    /// The logs that `config`, the contents of `file`, describes, in `folder` or next to `file`, with the channels
    /// that the named vessel needs, or all. The sources of simulated logs are noted in `provenance`.
    ///
    /// # Errors
    /// See [`Logs::read`].
    pub fn of(
        file: &Path,
        mut config: IngestFile,
        vessel: Option<(&Vessel, &str)>,
        folder: Option<&Path>,
        provenance: &mut Provenance,
    ) -> Result<Self, Error> {
        let refuse = |invalid| Error::invalid(file, invalid);
        let plan = Plan::new(config.setup().map_err(refuse)?, vessel).map_err(refuse)?;
        let folder = folder.or(file.parent()).unwrap_or(Path::new("")).to_owned();
        let naming = config.naming().map_err(refuse)?;
        let sources = find(&config, &naming, file, &folder)?;
        check_intervals(&config.segment, &sources).map_err(refuse)?;
        let label = simulated_label(&folder, &sources, provenance)?;
        if let Some(label) = label {
            config.design = label.to_string();
            label.label(provenance);
        }
        let vessel = vessel.map(|(vessel, _)| vessel.name.clone());
        Ok(Self { config, plan, sources, folder, label, file: file.to_owned(), vessel })
    }

    /// Reads all recordings into memory.
    ///
    /// # Errors
    /// Files that are refused; no sub-experiment long enough.
    pub fn ingested(&self) -> Result<Ingested, Error> {
        let scratch = Arc::new(Scratch::new(Path::new(""), BLOCK, f64::INFINITY));
        let segmentation = self.config.segmentation();
        let read = |source| recorded(&self.plan, &segmentation, &self.folder, source, &scratch);
        let all: Vec<_> = self.sources.par_iter().map(read).collect();
        let (mut totals, mut recordings, mut runs) = (Totals::default(), Vec::new(), Vec::new());
        for one in all {
            let (mut recorded, _) = one?;
            totals.number(&mut recorded);
            let width = self.plan.exogenous.len();
            runs.extend(recorded.runs.iter().map(|run| run.run(&self.config.design, width)));
            recordings.push(recorded.summary);
        }
        Ok(Ingested { runs, document: self.document(totals, recordings)? })
    }

    /// `ingest.json` of recordings with these `totals`.
    ///
    /// # Errors
    /// No run at all.
    pub fn document(
        &self,
        totals: Totals,
        recordings: Vec<RecordingSummary>,
    ) -> Result<IngestDocument, Error> {
        if totals.runs == 0 {
            let found = format!("none of {} recordings", self.sources.len());
            let expected = "at least one that is long enough";
            let remedy = "lower `min_s` or `window_s`, or correct the segments";
            return Err(Error::refuse(&self.file, "sub-experiments", found, expected, remedy));
        }
        Ok(IngestDocument {
            vessel: self.vessel.clone(),
            design: self.config.design.clone(),
            data: self.label,
            reference_point: self.config.reference_point.clone(),
            sample_rate_hz: self.config.sample_rate_hz,
            runs: u64::from(totals.runs),
            samples: totals.samples,
            maneuvers: totals.maneuvers,
            recordings,
        })
    }
}

/// Ingested logs.
#[derive(Clone, Debug)]
pub struct Ingested {
    /// The runs that recordings were cut into.
    pub runs: Vec<Run>,
    /// `ingest.json`: the recordings, and the quality of their data.
    pub document: IngestDocument,
}

impl Ingested {
    /// The runs, by their recordings.
    ///
    /// # Errors
    /// Inconsistent recordings: see `doubtful` in the document.
    pub fn pooled(self) -> Result<PooledRuns, Error> {
        Doubtful::among(&self.document.recordings).check(Path::new("logs"), |_| true)?;
        Ok(PooledRuns::new(self.runs, &self.document.recordings_by_run()))
    }
}
