//! Documents made in shards, and the tables that are kept beside counts.

use std::path::{Path, PathBuf};

use estimation::{RunEstimate, RunScore};
use files::{
    Document, Error, Loaded, Provenance, Staged, TableWriter, check_given, check_shards, read_part,
    stage_set_document,
};
use maneuver::Reacting;
use ship::model::Vessel;
use trial::campaign::SimulatedRun;
use validation::tally::Bounds;

use crate::documents::{CountedRuns, MomentsDocument, ScoredEstimates, ValidationDocument};
use crate::tables::trajectories::{BlockBuilder, Layout, rows_per_block};
use crate::tables::{estimates, scores};
use crate::{beside, validated};

/// The documents of all `shards`, in the order of their numbers.
pub(crate) fn all<D: Document>(shards: &[PathBuf]) -> Result<Vec<(&Path, Loaded<D>)>, Error> {
    let read = |path| Ok::<_, Error>((path, read_part::<D>(path)?));
    let mut all: Vec<(&Path, Loaded<D>)> =
        shards.iter().map(PathBuf::as_path).map(read).collect::<Result<_, _>>()?;
    check_shards(all.iter().map(|(path, loaded)| (*path, &loaded.provenance)))?;
    all.sort_by_key(|(_, loaded)| loaded.provenance.shard);
    Ok(all)
}

/// The moments of all `shards` together. `given`: their expected inputs.
///
/// # Errors
/// Files that are not all shards of one document; shards of other inputs.
pub fn moments(shards: &[PathBuf], mut given: Provenance) -> Result<(Provenance, MomentsDocument), Error> {
    let mut all = all::<MomentsDocument>(shards)?.into_iter();
    let Some((path, first)) = all.next() else { unreachable!("there is a shard to gather") };
    check_given(&mut given, path, &first.provenance)?;
    let Loaded { data: mut whole, mut provenance, .. } = first;
    provenance.accept_label(&given);
    all.for_each(|(_, loaded)| whole.0.maneuvers.extend(loaded.data.0.maneuvers));
    Ok((Provenance { shard: None, ..provenance }, whole))
}

/// The usual name of the document.
pub const MAIN: &str = "validation.json";

/// The merged counts of all `shards`, in any order.
///
/// # Errors
/// Files that are not all shards of the same counts.
pub fn merged(shards: &[PathBuf]) -> Result<(Provenance, CountedRuns), Error> {
    let mut all = self::all::<ValidationDocument>(shards)?.into_iter();
    let Some((path, first)) = all.next() else { unreachable!("there is a shard to gather") };
    let refuse = |path, found| {
        let (expected, remedy) = ("those of the other shards", "write the shards again");
        crate::refuse(path, "`counted`", found, expected, remedy)
    };
    let Loaded { data, provenance, .. } = first;
    let mut merged = data.counted.ok_or_else(|| refuse(path, "none"))?;
    for (path, loaded) in all {
        let counted = loaded.data.counted.ok_or_else(|| refuse(path, "none"))?;
        if !merged.tally.merge(counted.tally) {
            return Err(refuse(path, "other designs or estimators"));
        }
    }
    let CountedRuns { tally, bounds, realizations, samples, validation_samples, seed, .. } = merged;
    let samples = [samples, validation_samples];
    let provenance = Provenance { shard: None, ..provenance };
    Ok((provenance, CountedRuns::new(tally, bounds, realizations, samples, seed)))
}

refusal::choices! {
    /// What is kept beside counts.
    pub enum Keep {
        /// No table.
        None = "none",
        /// scores.parquet.
        Scores = "scores",
        /// And estimates.parquet and estimate.json.
        Estimates = "estimates",
        /// And campaign.parquet.
        Trajectories = "trajectories",
    }
}

impl Keep {
    /// Whether at least `least` is kept.
    pub fn keeps(self, least: Self) -> bool {
        self as u8 >= least as u8
    }
}

/// Tables that are kept, and their rows.
#[derive(Default)]
pub struct KeptTables {
    scores: Option<(TableWriter, Vec<RunScore>)>,
    estimates: Option<(TableWriter, Vec<RunEstimate>)>,
    runs: Option<(TableWriter, Layout)>,
    vessel: Option<Vessel>,
}

impl KeptTables {
    /// Empty tables; trajectories with the columns of what reacts.
    ///
    /// # Errors
    /// Output that fails.
    pub fn new(
        keep: Keep,
        vessel: &Vessel,
        reacting: &Reacting,
        out: &Path,
        provenance: &Provenance,
    ) -> Result<Self, Error> {
        let layout = Layout::new(&vessel.model).reacting(reacting);
        let table = |least: Keep, name: &str, schema: &files::TableSchema, document: Option<&str>| {
            if !keep.keeps(least) {
                return Ok::<_, Error>(None);
            }
            let writer = TableWriter::create(beside(out, MAIN, name), schema, provenance)?;
            let document = document.map(|document| beside(out, MAIN, document));
            Ok(Some(document.iter().fold(writer, |writer, document| writer.with_document(document))))
        };
        let columns = estimates::columns(vessel);
        let scored = table(Keep::Scores, "scores.parquet", scores::columns().schema(), Some(MAIN))?;
        let estimated = table(Keep::Estimates, "estimates.parquet", columns.schema(), Some("estimate.json"))?;
        let runs = table(Keep::Trajectories, "campaign.parquet", &layout.schema(), None)?;
        Ok(Self {
            scores: scored.map(|writer| (writer, Vec::new())),
            estimates: estimated.map(|writer| (writer, Vec::new())),
            runs: runs.map(|writer| (writer, layout)),
            vessel: Some(vessel.clone()),
        })
    }

    /// The number of runs of each design that need trajectories.
    pub fn first(&self) -> usize {
        if self.runs.is_some() { usize::MAX } else { 0 }
    }

    /// Whether neither estimates nor trajectories are kept.
    pub fn of_scores_alone(&self) -> bool {
        self.estimates.is_none() && self.runs.is_none()
    }

    /// Adds the next rows, and the runs that need trajectories.
    ///
    /// # Errors
    /// Output that fails.
    pub fn push(
        &mut self,
        scored: Vec<RunScore>,
        estimated: Vec<RunEstimate>,
        runs: &[SimulatedRun],
    ) -> Result<(), Error> {
        let Some(vessel) = &self.vessel else { return Ok(()) };
        if let Some((writer, rows)) = &mut self.scores {
            writer.push(scores::columns().encode(&scored)?)?;
            rows.extend(scored);
        }
        if let Some((writer, rows)) = &mut self.estimates {
            writer.push(estimates::columns(vessel).encode(&estimated)?)?;
            rows.extend(estimated);
        }
        let (Some((writer, layout)), Some(first)) = (&mut self.runs, runs.first()) else { return Ok(()) };
        for runs in runs.chunks(rows_per_block(first.run.samples())) {
            let mut builder = BlockBuilder::new(layout, vessel.sample_rate_hz);
            runs.iter().for_each(|run| builder.push(run));
            writer.push(files::encode_block(&layout.schema(), &builder.table())?)?;
        }
        Ok(())
    }

    /// The files in addition to the document, and its section of scores; `samples`: of the validation runs.
    ///
    /// # Errors
    /// Output that fails.
    pub fn finish(
        self,
        out: &Path,
        bounds: Bounds,
        samples: u64,
        provenance: &Provenance,
    ) -> Result<(Vec<Staged>, Option<ScoredEstimates>), Error> {
        let (mut files, mut scored) = (Vec::new(), None);
        if let Some((vessel, (writer, rows))) = self.vessel.zip(self.estimates) {
            let table = [writer.finish()?];
            let document = estimates::summarize(table[0].path(), provenance, &vessel, &rows)?;
            let path = beside(out, MAIN, "estimate.json");
            let document = stage_set_document(path, provenance, &document, &table)?;
            files.extend(table.into_iter().chain([document]));
        }
        if let Some((writer, rows)) = self.scores {
            files.push(writer.finish()?);
            scored = Some(validated(&rows, bounds, samples, provenance));
        }
        if let Some((writer, _)) = self.runs {
            files.push(writer.finish()?);
        }
        Ok((files, scored))
    }
}
