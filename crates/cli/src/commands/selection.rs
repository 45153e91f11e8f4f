//! `validate selection`: models from sub-experiments that a design picked against random picks.

use std::path::{Path, PathBuf};

use clap::Parser;
use estimation::Estimator;
use files::Provenance;
use serde_json::json;
use study::documents::SelectionDocument;
use study::files::{StageOfTerms, read_reference};
use study::selection::{Row, columns, document, rows};
use validation::selection::{PublishedLimits, Selection, SelectionOptions, Selector, available};

use super::counts::counts;
use crate::cli::{Common, Sharding, beside, choice};
use crate::failure::{Failure, Progress};
use crate::inputs::{self, Made, joined, joined_blocks};
use crate::pool::PoolFlags;
use crate::stage::{Summary, Task};

/// The estimators that only need sums per sub-experiment.
const ESTIMATORS: [Estimator; 3] = [Estimator::Ls, Estimator::Iv, Estimator::Auto];

/// Compares models from sub-experiments that a design picks with random picks; writes selection.parquet, selection.json
#[derive(Parser)]
#[command(
    name = "selection",
    after_help = "Example:\n  validate selection --vessel pipelines/esso-osaka/vessel.toml \
    --trajectories trajectories.parquet --design design.json --out selection.parquet"
)]
pub struct SelectionArguments {
    #[command(flatten)]
    flags: PoolFlags,
    /// The design whose counts are picked
    #[arg(long, required_unless_present = "counts", conflicts_with = "counts", value_name = "design.json")]
    design: Option<PathBuf>,
    /// How many of each maneuver are picked, instead
    #[arg(long, value_name = "NAME=N,…")]
    counts: Vec<String>,
    /// Realizations per design
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    realizations: u32,
    /// The estimator: `ls`, `iv` or `auto`
    #[arg(long, value_parser = choice(&Estimator::POOLED, Estimator::name, Estimator::description), default_value_t = Estimator::Iv)]
    estimator: Estimator,
    /// Published results to compare with: counts realizations beyond the errors at which their figures end
    #[arg(long, value_name = "reference.toml")]
    reference: Option<PathBuf>,
    #[command(flatten)]
    sharding: Sharding,
}

/// The usual name of the table.
const MAIN: &str = "selection.parquet";

impl Task for SelectionArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("validate");
        let vessel = self.flags.cored(StageOfTerms::Selection.read(&self.flags.vessel, &mut provenance)?)?;
        if !ESTIMATORS.contains(&self.estimator) {
            let found = format!("--estimator: found {}, expected ls, iv or auto", self.estimator);
            return Err(Failure::Usage(format!(
                "{found}; a selection study adds up sums per sub-experiment"
            )));
        }
        let inputs = self.flags.inputs().chain(&self.design).chain(&self.reference);
        let out = common.main_output(MAIN, inputs.chain(&self.sharding.gather))?;
        let (runs, pool) = self.flags.read(&vessel, &mut provenance, inputs::runs)?;
        let bytes = pool.bytes_of_many(&runs, rayon::current_num_threads());
        inputs::fits(self.flags.of.file(), &runs.amount(), bytes)?;
        let there = available(&runs.parts(None));
        let options = SelectionOptions {
            estimator: self.estimator,
            counts: counts(self.design.as_deref(), &self.counts, &there, &mut provenance)?,
            realizations: self.realizations,
            seed: common.seed.unwrap_or(1),
            published_limits: self.published(&mut provenance)?,
        };
        self.note(&options, &mut provenance);
        let selector = Selector::new(&pool, &runs, &options);
        let selector = selector.map_err(|e| Failure::lost(self.flags.of.file(), &e))?;
        let document_file = beside(&out, MAIN, "selection.json");
        let outputs = [out.as_path(), document_file.as_path()];
        let made = if self.sharding.gathers() {
            Made::gathered(&self.sharding.gather, outputs, &columns(), provenance, rows)?
        } else {
            provenance.shard = self.sharding.shard;
            realized(&selector, outputs, provenance, common.quiet)?
        };
        let of = |found: &Selection| document(&pool, self.flags.nominal().source(), &options, found);
        publish(made, &document_file, |rows| of(&selector.found(rows)))
    }
}

impl SelectionArguments {
    /// The limits of the figures of a published selection study.
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

/// The rows of this shard, or all.
fn realized(
    selector: &Selector,
    out: [&Path; 2],
    provenance: Provenance,
    quiet: bool,
) -> Result<Made<Row>, Failure> {
    let (groups, blocks) = (selector.groups(), joined_blocks(selector.groups()));
    let share = provenance.shard.map_or(1.0, |shard| shard.range(blocks).len() as f64 / blocks as f64);
    let all = (0..groups).map(|i| selector.realizations_of(i)).sum::<usize>();
    let progress = Progress::new("realizations", (share * all as f64) as usize, quiet);
    let group = |i: usize| {
        progress.advance(selector.realizations_of(i));
        Ok(selector.group(i))
    };
    Made::computed(out, &columns(), provenance, blocks, |i| joined(i, groups, group))
}

fn publish(
    made: Made<Row>,
    file: &Path,
    document: impl FnOnce(&[Row]) -> SelectionDocument,
) -> Result<Summary, Failure> {
    if let Some(shard) = made.provenance.shard {
        return made.publish_shard(shard, "realizations");
    }
    let Made { table, provenance, rows } = made;
    let out = table.path().to_owned();
    let document = document(&rows);
    let details = json!({"ratio_q90": document.ratio_q90, "statements": document.statements});
    let said = document.statements.join("; ");
    inputs::publish(table, file, &provenance, || Ok(document))?;
    Ok(Summary::of(&out, said, details))
}
