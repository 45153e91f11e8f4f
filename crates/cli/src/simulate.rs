//! `simulate`: trajectories of dictionaries, campaigns and validation maneuvers.

use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::Args;
use estimation::Estimator;
use files::{EncodedBlock, Provenance, Shard, TableWriter, Work, commit, encode_block};
use maneuver::Generator;
use numerics::LANES;
use seatrial::{MonteCarlo, Realized, StudyError};
use ship::model::Vessel;
use study::LoggedHelm;
use study::campaign_file::CampaignFile;
use study::documents::DesignDocument;
use study::files::{VesselReader, read_campaign, read_dictionary};
use study::parts::KeptTables;
use study::trajectories::{BlockBuilder, LEAST_ROW_BYTES, Layout, SIMULATED_PER_SECOND, rows_per_block};
use trial::campaign::{Campaign, Maneuvers, Refusal, Settings, SimulatedRun, Tally, Wanted};
use validation::tally::{Bounds, Tally as RunTally};

use crate::cli::{budget, folder_of, given};
use crate::failure::{Failure, WorkProgress};
use crate::inputs::{self, ordered};

/// The files of a simulation, for messages.
#[derive(Clone, Copy)]
pub struct Files<'a> {
    /// `vessel.toml`.
    pub vessel: &'a Path,
    /// `dictionary.toml`.
    pub dictionary: &'a Path,
    /// The file with the number and length of the runs.
    pub campaign: &'a Path,
    /// `campaign.toml`, for its disturbances.
    pub sea: &'a Path,
    /// `design.json`.
    pub design: &'a Path,
}

impl<'a> Files<'a> {
    /// All in one file.
    pub fn all(file: &'a Path) -> Self {
        Self { vessel: file, dictionary: file, campaign: file, sea: file, design: file }
    }

    /// A failure that names the file at fault.
    pub fn refused(&self, refusal: Refusal) -> Failure {
        let thing = |ordered| if ordered { "`data.sequence`" } else { "`data.shares`" };
        match refusal {
            Refusal::Vessel(e) => Failure::invalid(self.vessel, &e),
            Refusal::Dictionary(e) => Failure::invalid(self.dictionary, &e),
            Refusal::Campaign(e) => Failure::invalid(self.campaign, &e),
            Refusal::Sea(e) => Failure::invalid(self.sea, &e),
            Refusal::Design(e) => Failure::invalid(self.design, &e),
            Refusal::UnknownManeuver { name, ordered } => Failure::refuse(
                self.design,
                thing(ordered),
                &format!("maneuver `{name}`"),
                &format!("maneuvers of {}", self.dictionary.display()),
                if ordered { "arrange it again" } else { "make the design again from this dictionary" },
            ),
            Refusal::OtherLength { ordered, samples } => Failure::refuse(
                self.design,
                thing(true),
                &format!("{ordered} samples"),
                &format!("the {samples} samples of `duration_s` in {}", self.campaign.display()),
                "arrange the design for this duration, or change `duration_s`",
            ),
        }
    }
}

/// Refuses `work` that simulates `rows` rows, every thread at most `block` at a time, and writes at least `written`
/// of them, if they do not fit into memory or on disk.
fn check_room(
    work: Work,
    [rows, block, written]: [f64; 3],
    vessel: &Vessel,
    out: &Path,
) -> Result<(), Failure> {
    budget().disk(work, folder_of(out), written * LEAST_ROW_BYTES)?;
    let at_once = rows.min(block * rayon::current_num_threads() as f64);
    Ok(budget().memory(work, at_once * Layout::new(&vessel.model).working_bytes())?)
}

/// Refuses the campaign of `file` with `runs` runs of `samples` samples if it does not fit.
pub fn check_campaign(
    file: &Path,
    runs: f64,
    samples: usize,
    vessel: &Vessel,
    out: &Path,
) -> Result<(), Failure> {
    let rows = runs * (samples as f64 + 1.0);
    let size = format!("{runs} runs of {samples} samples");
    let remedy = "take fewer `realizations` or a shorter `duration_s`";
    let work = Work { file, thing: "`realizations`", found: &size, remedy };
    let block = rows_per_block(samples) as f64 * (samples as f64 + 1.0);
    check_room(work, [rows, block, rows], vessel, out)
}

/// Maneuvers per block.
const BLOCK: usize = 64;

/// Simulates the maneuvers of `shard` (or all) into `out`, and reports what was left out.
pub fn write_maneuvers(
    maneuvers: &Maneuvers,
    files: &Files,
    out: &Path,
    provenance: &Provenance,
    quiet: bool,
) -> Result<Tally, Failure> {
    let count = maneuvers.count();
    let blocks = count.div_ceil(BLOCK);
    let mine = provenance.shard.map_or(0..blocks, |shard| shard.range(blocks));
    let layout = Layout::new(&maneuvers.vessel().model).reacting(&maneuvers.reacting());
    let mut writer = TableWriter::create(out, &layout.schema(), provenance)?;
    let progress = WorkProgress::new("maneuvers", count.min(mine.len() * BLOCK), quiet);
    let mut tally = Tally::default();
    let work = |block: usize| {
        let simulated = maneuvers.simulate(block * BLOCK..count.min((block + 1) * BLOCK));
        let (runs, tally) = simulated.map_err(|e| files.refused(e))?;
        progress.advance(BLOCK);
        let block = if runs.is_empty() { None } else { Some(encoded(&layout, maneuvers.vessel(), &runs)?) };
        Ok::<_, Failure>((block, tally))
    };
    ordered(mine, work, |(block, counts)| {
        tally.merge(&counts);
        Ok(block.map_or(Ok(()), |block| writer.push(block))?)
    })?;
    if provenance.shard.is_none() {
        tally.check().map_err(|e| Failure::invalid(files.dictionary, &e))?;
    }
    commit(vec![writer.finish()?])?;
    Ok(tally)
}

/// Refuses maneuvers whose runs do not fit into memory or on disk.
pub fn check_maneuvers(maneuvers: &Maneuvers, files: &Files, out: &Path) -> Result<(), Failure> {
    let (mut all, mut written, mut block) = (0, 0, 0);
    for start in (0..maneuvers.count()).step_by(BLOCK) {
        let counted = maneuvers.rows(start..maneuvers.count().min(start + BLOCK));
        let [rows, rows_written] = counted.map_err(|e| files.refused(e))?;
        (all, written, block) = (all + rows, written + rows_written, block.max(rows));
    }
    let size = format!("{} maneuvers of {all} rows", maneuvers.count());
    let remedy = "shorten maneuvers or take fewer";
    let work = Work { file: files.dictionary, thing: "`duration_s`", found: &size, remedy };
    check_room(work, [all as f64, block as f64, written as f64], maneuvers.vessel(), out)
}

/// Simulates the runs of `shard` (or all) into `out`; returns their number.
pub fn write_campaign(
    campaign: &Campaign,
    files: &Files,
    out: &Path,
    provenance: &Provenance,
    quiet: bool,
) -> Result<usize, Failure> {
    let layout = Layout::new(&campaign.vessel().model).reacting(campaign.reacting());
    let mut writer = TableWriter::create(out, &layout.schema(), provenance)?;
    let blocks = blocks(campaign);
    let mine = provenance.shard.as_ref().map_or(0..blocks.len(), |s: &Shard| s.range(blocks.len()));
    let runs = blocks[mine.clone()].iter().map(|(_, runs)| runs.len()).sum();
    let rows = runs as f64 * campaign.samples() as f64;
    let progress = WorkProgress::new("runs", runs, quiet).foretold(rows / SIMULATED_PER_SECOND);
    let work = |i: usize| {
        let (design, runs) = blocks[i].clone();
        progress.advance(runs.len());
        let runs = campaign.simulate(design, runs, Wanted::Commands).map_err(|e| files.refused(e))?;
        encoded(&layout, campaign.vessel(), &runs)
    };
    ordered(mine, work, |block| Ok(writer.push(block)?))?;
    Ok(commit(vec![writer.finish()?]).map(|()| runs)?)
}

/// Runs of one design that are written together.
fn blocks(campaign: &Campaign) -> Vec<(usize, Range<usize>)> {
    let (size, runs) = (rows_per_block(campaign.samples()), campaign.realizations());
    let of =
        |design: usize| (0..runs.div_ceil(size)).map(move |b| (design, b * size..runs.min((b + 1) * size)));
    (0..campaign.designs()).flat_map(of).collect()
}

fn encoded(layout: &Layout, vessel: &Vessel, runs: &[SimulatedRun]) -> Result<EncodedBlock, Failure> {
    let mut builder = BlockBuilder::new(layout, vessel.sample_rate_hz);
    runs.iter().for_each(|run| builder.push(run));
    Ok(encode_block(&layout.schema(), &builder.table())?)
}

/// The input files of a campaign.
#[derive(Clone, Debug, Args)]
pub struct CampaignFlags {
    /// The vessel
    #[arg(long, visible_alias = "model", required_unless_present = "gather", value_name = "vessel.toml")]
    pub vessel: Option<PathBuf>,
    /// The maneuvers
    #[arg(long, required_unless_present = "gather", value_name = "dictionary.toml")]
    pub dictionary: Option<PathBuf>,
    /// Runs, disturbances, validation, bounds, seed
    #[arg(long, required_unless_present = "gather", value_name = "campaign.toml")]
    pub campaign: Option<PathBuf>,
    /// The optimized shares
    #[arg(long, value_name = "design.json")]
    pub design: Option<PathBuf>,
}

/// The contents of these files.
pub struct CampaignInputs<'a> {
    /// Their names, for messages.
    pub files: Files<'a>,
    /// The vessel.
    pub vessel: Vessel,
    dictionary: Generator,
    /// Runs, disturbances, validation, bounds, seed.
    pub config: CampaignFile,
    design: DesignDocument,
}

impl CampaignFlags {
    /// All given files.
    pub fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.vessel, &self.dictionary, &self.campaign, &self.design].into_iter().flatten()
    }

    /// The files, for messages.
    fn files(&self) -> Result<Files<'_>, Failure> {
        let campaign = given(&self.campaign, "campaign")?;
        Ok(Files {
            vessel: given(&self.vessel, "vessel")?,
            dictionary: given(&self.dictionary, "dictionary")?,
            campaign,
            sea: campaign,
            design: given(&self.design, "design")?,
        })
    }

    /// Reads them, the vessel by that reader.
    pub fn read(&self, vessel: VesselReader, noted: &mut Provenance) -> Result<CampaignInputs<'_>, Failure> {
        let files = self.files()?;
        let vessel = vessel(files.vessel, noted)?;
        let dictionary = read_dictionary(files.dictionary, &vessel, noted)?;
        let config = read_campaign(files.campaign, noted)?;
        let design: DesignDocument = inputs::document(files.design, "design", noted)?;
        // Estimates of its trials tell nothing of these.
        let vessel = design.held.iter().fold(vessel, |vessel, held| vessel.with_held(&held.parameter));
        Ok(CampaignInputs { files, vessel, dictionary, config, design })
    }
}

impl CampaignInputs<'_> {
    /// Maneuvers whose inputs follow the noise of the log.
    pub fn logged_helm(&self) -> LoggedHelm {
        LoggedHelm::among(&self.dictionary)
    }

    /// The runs of `settings`.
    pub fn campaign(&self, settings: &Settings) -> Result<Campaign<'_>, Failure> {
        let sea = self.config.sea(&self.vessel).map_err(|e| Failure::invalid(self.files.vessel, &e))?;
        let campaign = Campaign::new(sea, &self.dictionary, &self.design.designed(), settings);
        campaign.map_err(|e| self.files.refused(e))
    }
}

/// Notes how maneuvers with inputs from tables were played, if there are any.
pub fn note_plays(campaign: &Campaign, provenance: &mut Provenance) {
    if !campaign.statements().is_empty() {
        provenance.settings.insert("plays".into(), campaign.statements().into());
    }
}

/// Groups of runs per block of the tables.
pub const BLOCK_OF_GROUPS: usize = 64;

/// Upper bound on the square root of the runs that a share needs for an interval of this half-width.
pub fn needed_for(width: f64) -> f64 {
    0.98 / width
}

/// A failure that names the file at fault.
pub fn refused(files: &Files, error: StudyError) -> Failure {
    match error {
        StudyError::Trial(refusal) => files.refused(refusal),
        StudyError::Estimate(error) => Failure::of_run(&error, files.vessel, files.campaign),
        StudyError::Invalid(invalid) => Failure::invalid(files.campaign, &invalid),
        StudyError::Design(error) => Failure::NoAnswer(error.to_string()),
    }
}

/// The work and its progress reports.
pub struct Counting<'a> {
    pub study: &'a MonteCarlo<'a>,
    /// Its files, for messages.
    pub files: &'a Files<'a>,
    /// Bounds of good estimates.
    pub bounds: Bounds,
    pub quiet: bool,
}

impl Counting<'_> {
    fn blank(&self) -> RunTally {
        RunTally::new(&self.study.campaign.names(), &self.study.estimators.estimators)
    }

    /// Realizes and counts `parts`; the kept rows of each are added to `kept` in order.
    pub fn tallied(
        &self,
        parts: Vec<(usize, Range<usize>)>,
        kept: &mut KeptTables,
    ) -> Result<RunTally, Failure> {
        let runs: usize = parts.iter().map(|(_, runs)| runs.len()).sum();
        let progress = WorkProgress::new("runs", runs, self.quiet).foretold(self.seconds(runs));
        let mut tally = self.blank();
        self.count(parts, kept, &mut tally, &progress)?;
        Ok(tally)
    }

    fn count(
        &self,
        parts: Vec<(usize, Range<usize>)>,
        kept: &mut KeptTables,
        tally: &mut RunTally,
        progress: &WorkProgress,
    ) -> Result<(), Failure> {
        let (first, scores_alone) = (kept.first(), kept.of_scores_alone());
        let work = |i: usize| {
            let (design, runs) = parts[i].clone();
            let count = runs.len();
            let realized = match scores_alone {
                true => self.study.scores(design, runs).map(Realized::scored),
                false => self.study.realize(design, runs, first),
            };
            let realized = realized.map_err(|e| refused(self.files, e))?;
            let mut tally = self.blank();
            tally.add(&realized.scores, self.bounds);
            progress.advance(count);
            Ok::<_, Failure>((tally, realized))
        };
        ordered(0..parts.len(), work, |(part, realized)| {
            tally.merge(part);
            Ok(kept.push(realized.scores, realized.estimates, &realized.runs)?)
        })
    }

    /// Continues until no share's interval is wider than twice `width`; checks at fixed numbers of runs, each a tenth
    /// larger.
    pub fn until(&self, width: f64) -> Result<RunTally, Failure> {
        let (mut tally, mut done, block) = (self.blank(), 0, LANES * BLOCK_OF_GROUPS);
        let designs = self.study.campaign.designs();
        let most = needed_for(width).powi(2) * designs as f64;
        let progress =
            WorkProgress::new("runs", most as usize, self.quiet).foretold(self.seconds(most as usize));
        while tally.half_width() > width && done < self.study.campaign.realizations() {
            let next = (done + (done / 10).max(block)).next_multiple_of(block);
            let next = next.min(self.study.campaign.realizations());
            let parts = |d| (done..next).step_by(block).map(move |start| (d, start..next.min(start + block)));
            let parts = (0..designs).flat_map(parts).collect();
            self.count(parts, &mut KeptTables::default(), &mut tally, &progress)?;
            done = next;
        }
        Ok(tally)
    }

    /// Seconds of one thread for `runs` runs, order of magnitude.
    fn seconds(&self, runs: usize) -> f64 {
        let searched =
            self.study.estimators.estimators.iter().filter(|e| !matches!(e, Estimator::Ls | Estimator::Iv));
        let each = SECONDS_PER_ROW + searched.map(|e| e.seconds_per_row()).sum::<f64>();
        runs as f64 * self.study.campaign.samples() as f64 * each
    }
}

/// Seconds per row and thread for simulation, estimation by regression and scoring, order of magnitude.
const SECONDS_PER_ROW: f64 = 3e-8;
