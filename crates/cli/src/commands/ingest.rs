//! `ingest`: measured logs to trajectories.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Parser;
use files::{Digest, Scratch, TableWriter, commit_with_document, free_bytes};
use logs::by_motion::{SampledRecording, judged};
use logs::{BLOCK, Plan, Recorded, RowSummary, Source, Totals};
use seatrial::Logs;
use serde_json::json;
use study::documents::{IngestDocument, RecordingSummary};
use study::files::{read_any_vessel, read_ingest};
use study::ingest_file::read::recorded;
use study::trajectories::{Layout, MeasuredBlock};
use study::{Doubtful, contradicting, note_contradicting};

use crate::cli::{Common, beside, budget, folder_of};
use crate::failure::{Failure, WorkProgress};
use crate::inputs::ordered;
use crate::stage::{Summary, Task};

/// Turns a ship's logs into trajectories, and says how good they are: one clock, SI units, body axes, sub-experiments
#[derive(Parser)]
#[command(
    name = "ingest",
    after_help = "Example:\n  ingest --config pipelines/esso-osaka/ingest.toml --logs LOGS \
    --vessel pipelines/esso-osaka/vessel.toml --out trajectories.parquet"
)]
pub struct IngestArguments {
    /// What is in the logs
    #[arg(long, value_name = "ingest.toml")]
    config: PathBuf,
    /// The folder that the patterns of files are relative to (default: that of ingest.toml)
    #[arg(long, value_name = "FOLDER")]
    logs: Option<PathBuf>,
    /// The vessel whose inputs and measured disturbances are needed (default: all channels are)
    #[arg(long, visible_alias = "model", value_name = "vessel.toml")]
    vessel: Option<PathBuf>,
}

impl Task for IngestArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("ingest");
        let config = read_ingest(&self.config, &mut provenance)?;
        let vessel = self.vessel.as_deref().map(|path| read_any_vessel(path, &mut provenance)).transpose()?;
        let vessel_file = self.vessel.as_deref().unwrap_or(Path::new("")).display().to_string();
        let named = vessel.as_ref().map(|vessel| (vessel, vessel_file.as_str()));
        let logs = Logs::of(&self.config, config, named, self.logs.as_deref(), &mut provenance)?;
        let files = logs.sources.iter().flat_map(|source| source.files.iter().flatten());
        let read = files.map(|file| logs.folder.join(file)).chain([self.config.clone()]);
        let out = common.main_output("trajectories.parquet", read.chain(self.vessel.clone()))?;
        // Logs do not depend on the model that is fitted to them: the vessel only names the required channels.
        if let Some(vessel) = provenance.inputs.remove("vessel") {
            provenance.inputs.insert("channels".to_owned(), vessel);
        }
        provenance.origins.clear();
        let summary_file = self.summary_file(&out)?;
        let schema = layout(&logs.plan).measured(&logs.plan.further);
        let mut writer = TableWriter::create(&out, &schema, &provenance)?.with_document(&summary_file);
        let (totals, recordings, digests) = all(&logs, &out, common.quiet, &mut writer)?;
        provenance.inputs.extend(digests);
        Doubtful::among(&recordings).note(&mut provenance);
        note_contradicting(&recordings, &mut provenance);
        writer.set_inputs(&provenance);
        let document = logs.document(totals, recordings)?;
        commit_with_document(writer.finish()?, &summary_file, &provenance, &document)?;
        Ok(summary(&out, &document))
    }
}

impl IngestArguments {
    /// The path of the summary of the table `out`.
    fn summary_file(&self, out: &Path) -> Result<PathBuf, Failure> {
        let summary = beside(out, "trajectories.parquet", "ingest.json");
        if summary == self.config {
            return Err(Failure::Usage(
                "--out: found a folder whose ingest.json is the configuration; name another".into(),
            ));
        }
        Ok(summary)
    }
}

fn layout(plan: &Plan) -> Layout {
    let exogenous = plan.exogenous.iter().map(|input| (input.name.clone(), input.unit.clone())).collect();
    Layout { exogenous, derived: plan.derived.clone(), ..Layout::default() }
}

/// The result for all recordings, and the logs' digests by their roles.
type Ingested = (Totals, Vec<RecordingSummary>, Vec<(String, Digest)>);

/// Bytes of channels that are held in memory; more is spilled to disk.
const HELD: f64 = 48e6;

/// Bytes of logs that are read in parallel.
const SIDE_BY_SIDE: u64 = 64 << 20;

/// Assumed compression ratio of a compressed log.
const COMPRESSED: u64 = 8;

/// Bytes of logs per second that a thread reads, puts on one clock and encodes, order of magnitude: an hour of 30
/// channels at 100 Hz on a server of 2024 (156 MB in 1.6 s).
const READ_PER_SECOND: f64 = 1e8;

/// Bytes of text in the logs of a recording, approximate if they are compressed.
fn size(folder: &Path, source: &Source) -> u64 {
    let of = |file: &String| {
        let length = std::fs::metadata(folder.join(file)).map_or(0, |about| about.len());
        length * if file.ends_with(".csv") { 1 } else { COMPRESSED }
    };
    source.files.iter().flatten().map(of).sum()
}

/// Groups of `sources` that are read in parallel: together no larger than [`SIDE_BY_SIDE`], or one alone.
fn groups(folder: &Path, sources: &[Source]) -> Vec<Range<usize>> {
    let (mut groups, mut bytes): (Vec<Range<usize>>, u64) = (Vec::new(), 0);
    for (i, source) in sources.iter().enumerate() {
        let more = size(folder, source);
        match groups.last_mut().filter(|_| bytes + more <= SIDE_BY_SIDE) {
            Some(group) => (group.end, bytes) = (i + 1, bytes + more),
            None => {
                groups.push(i..i + 1);
                bytes = more;
            }
        }
    }
    groups
}

/// Reads all recordings, many at a time, and writes their runs in order.
fn all(logs: &Logs, out: &Path, quiet: bool, writer: &mut TableWriter) -> Result<Ingested, Failure> {
    let Logs { config, plan, sources, folder, .. } = logs;
    let (layout, segmentation) = (layout(plan), config.segmentation());
    let schema = layout.measured(&plan.further);
    let rate_hz = plan.setup.conventions.rate_hz;
    let held = HELD.min(budget().bytes() / 8.0);
    let scratch = Arc::new(Scratch::new(out, BLOCK, held));
    let disk = free_bytes(folder_of(out)).unwrap_or(f64::INFINITY);
    let (mut totals, mut recordings, mut files) = (Totals::default(), Vec::new(), Vec::new());
    let mut block = MeasuredBlock::new(&config.design, rate_hz);
    let bytes: u64 = sources.iter().map(|source| size(folder, source)).sum();
    let progress = WorkProgress::new("recordings", sources.len(), quiet);
    // A long recording is read by one thread, many short ones by all.
    let alone = bytes / sources.len().max(1) as u64 > SIDE_BY_SIDE;
    let threads = if alone { rayon::current_num_threads() } else { 1 };
    let progress = progress.foretold(threads as f64 * bytes as f64 / READ_PER_SECOND);
    let work = |plan: &Plan, i: usize| {
        let recording = recorded(plan, &segmentation, folder, &sources[i], &scratch);
        progress.advance(1);
        recording.map_err(Failure::from)
    };
    let mut sampled = Vec::new();
    let mut fold = |(mut recorded, digests): (Recorded, Vec<Digest>)| {
        totals.number(&mut recorded);
        sampled.push(SampledRecording::of(&recorded.runs, plan.exogenous.len()));
        for run in &recorded.runs {
            block.push(run);
            if block.is_full() {
                block.write(&layout, &schema, writer)?;
            }
        }
        files.extend(recorded.summary.files.iter().map(|file| format!("log:{file}")).zip(digests));
        recordings.push(recorded.summary);
        Ok::<(), Failure>(())
    };
    for group in groups(folder, sources) {
        // Recordings that are read in parallel share the memory.
        let side_by_side = group.len().min(rayon::current_num_threads());
        let share = 1.0 / side_by_side as f64;
        let plan = plan.clone().within(share * (budget().bytes() - held), share * disk);
        ordered(group, |i| work(&plan, i), &mut fold)?;
    }
    block.write(&layout, &schema, writer)?;
    scratch.check()?;
    let each = recordings.iter_mut().zip(judged(&sampled, 1.0 / rate_hz));
    each.for_each(|(recording, judged): (&mut RecordingSummary, _)| judged.noted(recording));
    Ok((totals, recordings, files))
}

fn summary(out: &Path, document: &IngestDocument) -> Summary {
    let IngestDocument { runs, samples, maneuvers, recordings, .. } = document;
    let sum = |count: fn(&RecordingSummary) -> u64| recordings.iter().map(count).sum::<u64>();
    let mut rows = RowSummary::default();
    recordings.iter().for_each(|recording| rows += recording.rows);
    let (dropped, mended) =
        (rows.dropped(), rows.mended().map_or(String::new(), |words| format!("; {words}")));
    let left_out_s: f64 = recordings.iter().map(|r| r.left_out_s).sum();
    let unused = match rows.unused {
        0 => String::new(),
        count => format!("; {count} lines and sentences that no channel takes"),
    };
    let (splits, short) = (sum(|r| r.splits), sum(|r| r.short_segments));
    let warnings = sum(|r| r.warnings.iter().map(|w| w.count).sum());
    let first = recordings.iter().find_map(|recording| recording.warnings.first());
    let warned = first.map_or(String::new(), |first| {
        format!("; {warnings} warnings, see ingest.json; the first: {}", first.text)
    });
    let doubtful = Doubtful::among(recordings);
    let names: Vec<&str> = doubtful.names().collect();
    let doubted = match names.as_slice() {
        [] => String::new(),
        [one] => format!("; doubtful: `{one}`, see ingest.json"),
        [first, more @ ..] => format!("; doubtful: `{first}` and {} more, see ingest.json", more.len()),
    };
    let against: Vec<&str> =
        recordings.iter().filter(|one| one.contradicts.is_some()).map(|one| one.name.as_str()).collect();
    let contradicted =
        contradicting(&against).map_or(String::new(), |words| format!("; {words}, see ingest.json"));
    let unjudged = match recordings.iter().filter(|one| one.unjudged.is_some()).count() {
        0 => String::new(),
        count => format!("; {count} recordings cannot be judged by the others"),
    };
    let label = document.data.map_or(String::new(), |label| format!("; {label}"));
    let omitted = document.omitted();
    let left_out = omitted.in_words().map_or(String::new(), |words| format!("; {words}"));
    let line = format!(
        "{runs} runs, {samples} samples, {} maneuvers from {} recordings; {dropped} rows dropped, {splits} gaps \
         that split a recording, {short} segments too short, {left_out_s:.0} s in no \
         run{mended}{unused}{left_out}{warned}{doubted}{contradicted}{unjudged}{label}",
        maneuvers.len(),
        recordings.len(),
    );
    let details = json!({
        "runs": runs, "samples": samples, "recordings": recordings.len(), "maneuvers": maneuvers.len(),
        "dropped_rows": dropped, "unused_lines": rows.unused, "splits": splits, "short_segments": short, "left_out_s": left_out_s, "warnings": warnings,
        "omitted": omitted.as_slice(), "doubtful": names, "contradicting": against,
    });
    Summary::of(out, line, details)
}
