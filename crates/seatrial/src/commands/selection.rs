//! `validate selection`: models from sub-experiments that a design picked against random picks.

use std::path::{Path, PathBuf};

use artifact::{Provenance, TableWriter, commit_with_document};
use clap::Parser;
use identification::Estimator;
use serde_json::json;
use study::documents::SelectionDocument;
use study::files::{read_reference, read_vessel};
use study::selection::{Row, columns, document};
use validation::selection::{PublishedLimits, SelectionOptions, available, select};

use super::counts::counts;
use crate::choice::choice;
use crate::cli::{Common, beside};
use crate::failure::Failure;
use crate::inputs;
use crate::pool::{PoolFlags, lost};
use crate::progress::Progress;
use crate::stage::{Summary, Task};

/// The estimators that sums per sub-experiment are enough for.
const ESTIMATORS: [Estimator; 3] = [Estimator::Ls, Estimator::Iv, Estimator::Auto];

/// Models from sub-experiments that a design picked against random picks; writes selection.parquet, selection.json
#[derive(Parser)]
#[command(
    name = "selection",
    after_help = "Example:\n  validate selection --vessel pipelines/esso-osaka/vessel.toml \
    --trajectories trajectories.parquet --design design.json --out selection.parquet"
)]
pub struct Arguments {
    #[command(flatten)]
    flags: PoolFlags,
    /// The design whose counts, or shares of --picks, are picked
    #[arg(long, required_unless_present = "counts", conflicts_with = "counts", value_name = "design.json")]
    design: Option<PathBuf>,
    /// How many of each maneuver are picked, instead
    #[arg(long, value_name = "NAME=N,…", value_delimiter = ',')]
    counts: Vec<String>,
    /// Sub-experiments per realization, where the design has no counts
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    picks: Option<u16>,
    /// Realizations per design
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    realizations: u32,
    /// The estimator: `ls`, `iv` or `auto`
    #[arg(long, value_parser = choice(&Estimator::POOLED, Estimator::name, Estimator::description), default_value_t = Estimator::Iv)]
    estimator: Estimator,
    /// Published results to compare with: counts realizations beyond the errors at which their figures end
    #[arg(long, value_name = "reference.toml")]
    reference: Option<PathBuf>,
}

impl Task for Arguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("validate");
        let vessel = read_vessel(&self.flags.vessel, &mut provenance)?;
        if !ESTIMATORS.contains(&self.estimator) {
            let found = format!("--estimator: found {}, expected ls, iv or auto", self.estimator);
            return Err(Failure::Usage(format!(
                "{found}; a selection study adds up sums per sub-experiment"
            )));
        }
        let inputs = self.flags.inputs().chain(&self.design).chain(&self.reference);
        let out = common.main_output("selection.parquet", inputs)?;
        let (runs, pool) = self.flags.read(&vessel, &mut provenance, inputs::runs)?;
        let bytes = pool.bytes_of_many(&runs, rayon::current_num_threads());
        inputs::fits(&self.flags.of.trajectories, &runs.amount(), bytes)?;
        let there = available(&runs.parts(None));
        let picks = self.picks.map(u64::from);
        let options = SelectionOptions {
            estimator: self.estimator,
            counts: counts(self.design.as_deref(), &self.counts, picks, &there, &mut provenance)?,
            realizations: self.realizations,
            seed: common.seed.unwrap_or(1),
            published_limits: self.published(&mut provenance)?,
        };
        let progress = Progress::new("realizations", 2 * self.realizations as usize, common.quiet);
        let found = select(&pool, &runs, &options, &|count| progress.advance(count));
        let found = found.map_err(|e| lost(&self.flags.of.trajectories, &e))?;
        self.note(&options, &mut provenance);
        let document = document(&pool, self.flags.nominal().source(), &options, &found);
        publish(&out, &provenance, &found.realizations, &document)
    }
}

impl Arguments {
    /// Where the figures of a published selection study end.
    fn published(&self, provenance: &mut Provenance) -> Result<Option<PublishedLimits>, Failure> {
        let Some(file) = &self.reference else { return Ok(None) };
        let reference = read_reference(file, "reference", provenance)?;
        Ok(reference.selection.as_ref().map(PublishedLimits::from))
    }

    fn note(&self, options: &SelectionOptions, provenance: &mut Provenance) {
        let settings = [
            ("estimator", json!(options.estimator)),
            ("intercepts", json!(true)),
            ("realizations", json!(options.realizations)),
            ("seed", json!(options.seed)),
        ];
        self.flags.note(settings, provenance);
    }
}

fn publish(
    out: &Path,
    provenance: &Provenance,
    rows: &[Row],
    document: &SelectionDocument,
) -> Result<Summary, Failure> {
    let summary = beside(out, "selection.parquet", "selection.json");
    let columns = columns();
    let mut writer = TableWriter::create(out, columns.schema(), provenance)?.with_document(&summary);
    writer.push(columns.encode(rows)?)?;
    commit_with_document(writer.finish()?, &summary, provenance, document)?;
    let told = json!({"ratio_q90": document.ratio_q90, "statements": document.statements});
    Ok(Summary::of(out, document.statements.join("; "), told))
}
