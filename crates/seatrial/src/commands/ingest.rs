//! `ingest`: measured logs to trajectories.

use std::path::{Path, PathBuf};

use crate::cli::{Common, beside, provenance};
use crate::failure::Failure;
use crate::ingest::{
    IngestFile, Outcome, Plan, RowsBuilder, Source, Totals, check_segments, find, ingest, line, schema,
    simulated_label,
};
use crate::ordered::ordered;
use crate::progress::Progress;
use crate::stage::{Summary, Task};
use artifact::{EncodedBlock, Provenance, TableWriter, commit, encode_block, read_toml, stage_document};
use clap::Parser;
use serde_json::json;
use study::documents::IngestDocument;
use study::files::read_vessel;
use vessel::Vessel;

/// Turns log files into trajectories: one clock, SI units, body velocities, sub-experiments; says how good the data are
#[derive(Parser)]
#[command(
    name = "ingest",
    version,
    after_help = "Example:\n  ingest --config pipelines/esso-osaka/ingest.toml --logs LOGS \
    --vessel pipelines/esso-osaka/vessel.toml --out trajectories.parquet"
)]
pub struct Arguments {
    /// What is in the logs
    #[arg(long, value_name = "ingest.toml")]
    config: PathBuf,
    /// The folder that the patterns of files are relative to (default: that of ingest.toml)
    #[arg(long, value_name = "FOLDER")]
    logs: Option<PathBuf>,
    /// The vessel whose inputs and measured disturbances are needed (default: all channels are)
    #[arg(long, value_name = "vessel.toml")]
    vessel: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

impl Task for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn run(&self) -> Result<Summary, Failure> {
        stage(self)
    }
}

fn stage(a: &Arguments) -> Result<Summary, Failure> {
    let mut provenance = provenance("ingest");
    let (mut config, digest) = read_toml::<IngestFile>(&a.config)?;
    provenance.inputs.insert("config".into(), digest);
    config.check().map_err(|e| Failure::invalid(&a.config, &e))?;
    let vessel = a.vessel.as_deref().map(|path| read_vessel(path, &mut provenance)).transpose()?;
    let plan = Plan::new(&config, &a.config, vessel.as_ref().zip(a.vessel.as_deref()))?;
    let folder = a.logs.clone().unwrap_or_else(|| a.config.parent().unwrap_or(Path::new("")).to_owned());
    let sources = find(&config, &a.config, &folder)?;
    check_segments(&config, &a.config, &sources)?;
    let out = output(a, &folder, &sources)?;
    let label = simulated_label(&folder, &sources, &mut provenance)?;
    if let Some(label) = &label {
        config.design.clone_from(label);
        provenance.settings.insert("data".into(), json!(label));
    }
    let (blocks, totals) = all(a, &config, &plan, &folder, &sources, &mut provenance)?;
    write(a, &out, &config, &plan, vessel.as_ref(), &provenance, blocks, &totals, label.clone())?;
    let told = label.map_or(String::new(), |label| format!("; {label}"));
    Ok(Summary {
        line: line(&out, &totals) + &told,
        json: json!({
            "out": out,
            "runs": totals.runs,
            "samples": totals.samples,
            "recordings": totals.recordings.len(),
            "maneuvers": totals.maneuvers.len(),
            "dropped_rows": totals.dropped_rows(),
            "splits": totals.sum(|r| r.splits),
            "short_segments": totals.sum(|r| r.short_segments),
            "warnings": totals.sum(|r| r.warnings.iter().map(|w| w.count).sum()),
        }),
    })
}

/// Where the trajectories go; none of the files that are read.
fn output(a: &Arguments, folder: &Path, sources: &[Source]) -> Result<PathBuf, Failure> {
    let logs: Vec<PathBuf> = sources.iter().flat_map(|s| &s.files).map(|file| folder.join(file)).collect();
    let read = logs.iter().map(PathBuf::as_path).chain([a.config.as_path()]).chain(a.vessel.as_deref());
    a.common.main_output("trajectories.parquet", &read.collect::<Vec<_>>())
}

/// Reads all recordings in parallel and collects their runs in order.
fn all(
    a: &Arguments,
    config: &IngestFile,
    plan: &Plan,
    folder: &Path,
    sources: &[Source],
    provenance: &mut Provenance,
) -> Result<(Vec<EncodedBlock>, Totals), Failure> {
    let schema = schema(plan);
    let progress = Progress::new("recordings", sources.len(), a.common.quiet);
    let (mut totals, mut blocks) = (Totals::default(), Vec::new());
    let mut rows = RowsBuilder::new(plan, &config.design);
    let work = |i: usize| {
        let outcome = ingest(config, plan, folder, &sources[i]);
        progress.advance(1);
        outcome
    };
    ordered(0..sources.len(), work, |outcome: Outcome| {
        let Outcome { made, runs, mut summary, digests } = outcome;
        provenance.inputs.extend(digests);
        for run in &runs {
            rows.push(totals.number(run, &mut summary), &made, run);
            if rows.is_full() {
                let full = std::mem::replace(&mut rows, RowsBuilder::new(plan, &config.design));
                blocks.push(encode_block(&schema, &full.table())?);
            }
        }
        totals.recordings.push(summary);
        Ok::<(), Failure>(())
    })?;
    if !rows.is_empty() {
        blocks.push(encode_block(&schema, &rows.table())?);
    }
    if blocks.is_empty() {
        let found = format!("none of {} recordings", sources.len());
        let remedy = "lower `min_s` or `window_s`, or correct the segments";
        return Err(Failure::refuse(
            &a.config,
            "sub-experiments",
            &found,
            "at least one that is long enough",
            remedy,
        ));
    }
    Ok((blocks, totals))
}

#[allow(clippy::too_many_arguments)]
fn write(
    a: &Arguments,
    out: &Path,
    config: &IngestFile,
    plan: &Plan,
    vessel: Option<&Vessel>,
    provenance: &Provenance,
    blocks: Vec<EncodedBlock>,
    totals: &Totals,
    data: Option<String>,
) -> Result<(), Failure> {
    let document = IngestDocument {
        vessel: vessel.map(|vessel| vessel.name.clone()),
        design: config.design.clone(),
        data,
        reference_point: config.reference_point.clone(),
        sample_rate_hz: config.sample_rate_hz,
        runs: u64::from(totals.runs),
        samples: totals.samples,
        maneuvers: totals.maneuvers.clone(),
        recordings: totals.recordings.clone(),
    };
    let summary = beside(out, "ingest.json");
    if summary == a.config {
        return Err(Failure::Usage(
            "--out: found a folder whose ingest.json is the configuration; name another".into(),
        ));
    }
    let mut writer = TableWriter::create(out, &schema(plan), provenance)?;
    for block in blocks {
        writer.push(block)?;
    }
    commit(vec![writer.finish()?, stage_document(&summary, provenance, &document)?])?;
    Ok(())
}
