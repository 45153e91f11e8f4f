//! `validate cross`: estimators compared over runs or recordings that are left out.

use artifact::{commit, stage_document};
use clap::Parser;
use identification::Estimator;
use serde_json::json;
use study::documents::CrossvalDocument;
use study::files::read_vessel;
use validation::crossval::{CrossOptions, Folds, cross_validate};

use crate::choice::choice;
use crate::cli::{Common, samples};
use crate::failure::Failure;
use crate::inputs;
use crate::pool::PoolFlags;
use crate::progress::Progress;
use crate::stage::{Summary, Task};

/// Finds how well a model predicts runs or recordings that were left out of it; writes crossval.json
#[derive(Parser)]
#[command(
    name = "cross",
    after_help = "Example:\n  validate cross --vessel pipelines/kvlcc2/vessel.toml \
    --trajectories trajectories.parquet --out crossval.json"
)]
pub struct Arguments {
    #[command(flatten)]
    flags: PoolFlags,
    /// The estimators to compare
    #[arg(long, value_parser = choice(&Estimator::POOLED, Estimator::name, Estimator::description), value_delimiter = ',', default_values_t = Estimator::COMPARED)]
    estimators: Vec<Estimator>,
    /// Simulates over windows of this length, side by side [s]; whole runs without it
    #[arg(long, value_name = "S")]
    window_s: Option<f64>,
    /// Deals runs or recordings in turns into N folds; without it each is left out on its own
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..))]
    folds: Option<u16>,
    /// Leaves these runs or recordings out together; again for the next fold
    #[arg(long, value_name = "NAME,…", conflicts_with = "folds")]
    fold: Vec<String>,
}

impl Task for Arguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("validate");
        let vessel = read_vessel(&self.flags.vessel, &mut provenance)?;
        let window = self.window_s.map(|s| samples("--window-s", s, vessel.sample_rate_hz)).transpose()?;
        let out = common.main_output("crossval.json", self.flags.inputs())?;
        let (runs, pool) = self.flags.read(&vessel, &mut provenance, inputs::runs)?;
        let bytes = pool.bytes_of_many(&runs, rayon::current_num_threads());
        inputs::fits(self.flags.of.file(), &runs.amount(), bytes)?;
        let names = |fold: &String| fold.split(',').map(|name| name.trim().to_owned()).collect();
        let folds = match (self.fold.is_empty(), self.folds) {
            (false, _) => Folds::Named(self.fold.iter().map(names).collect()),
            (true, Some(count)) => Folds::Dealt(usize::from(count)),
            (true, None) => Folds::Each,
        };
        let options = CrossOptions { estimators: self.estimators.clone(), window, folds };
        let folds = match self.fold.len() {
            0 => self.folds.map_or(usize::MAX, usize::from).min(runs.sources()),
            named => named,
        };
        let progress = Progress::new("folds", folds * self.estimators.len(), common.quiet);
        let found = cross_validate(&pool, &runs, &options, &|count| progress.advance(count));
        let found = found.map_err(|e| Failure::invalid(self.flags.of.file(), &e.invalid()))?;
        let settings = [
            ("estimators", json!(self.estimators)),
            ("intercepts", json!(true)),
            ("window_samples", json!(window)),
            ("folds", json!(self.folds)),
            ("fold", json!(self.fold)),
        ];
        self.flags.note(settings, &mut provenance);
        let window_s = window.map(|samples| samples as f64 / vessel.sample_rate_hz);
        let document = CrossvalDocument::new(&pool, self.flags.nominal().source(), window_s, &found);
        commit(vec![stage_document(&out, &provenance, &document)?])?;
        let (windows, folds, said) = (found.windows, found.folds, found.statements.join("; "));
        Ok(Summary::of(
            &out,
            format!("{windows} windows, {folds} folds; {said}"),
            json!({"windows": windows, "folds": folds,
                "recommended": document.recommended, "statements": found.statements}),
        ))
    }
}
