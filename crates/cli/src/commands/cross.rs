//! `validate cross`: estimators compared over runs or recordings that are left out.

use clap::Parser;
use estimation::Estimator;
use serde_json::json;
use study::documents::CrossvalDocument;
use study::files::read_any_vessel;
use validation::crossval::{CrossOptions, Folds, cross_validate};

use crate::choice::choice;
use crate::cli::{Common, samples};
use crate::crossed::written;
use crate::failure::Failure;
use crate::inputs;
use crate::physical::{self, FittingFlags, Scored};
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
    /// The estimators to compare [default: ls, iv, auto, output-error; of a ship with forces output-error]
    #[arg(long, value_parser = choice(&Estimator::POOLED, Estimator::name, Estimator::description), value_delimiter = ',')]
    estimators: Vec<Estimator>,
    #[command(flatten)]
    fitting: FittingFlags,
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
        let vessel = self.flags.cored(read_any_vessel(&self.flags.vessel, &mut provenance)?)?;
        let window = self.window_s.map(|s| samples("--window-s", s, vessel.sample_rate_hz)).transpose()?;
        let out = common.main_output("crossval.json", self.flags.inputs())?;
        let count = || self.folds.map_or(usize::MAX, usize::from);
        let number =
            |sources: usize| if self.fold.is_empty() { count().min(sources) } else { self.fold.len() };
        if vessel.model.forces.is_some() {
            let settings = [("folds", json!(self.folds)), ("fold", json!(self.fold))];
            let inputs = (&self.flags, &self.fitting, self.estimators.as_slice());
            let scored = Scored { window, folds: &self.left_out(), number: &number, settings, out };
            return physical::cross(inputs, &vessel, scored, (common, provenance));
        }
        self.fitting.check_absent()?;
        let estimators = match self.estimators.as_slice() {
            [] => Estimator::COMPARED.to_vec(),
            asked => asked.to_vec(),
        };
        let (runs, pool) = self.flags.read(&vessel, &mut provenance, inputs::runs)?;
        let bytes = pool.bytes_of_many(&runs, rayon::current_num_threads());
        inputs::fits(self.flags.of.file(), &runs.amount(), bytes)?;
        let options = CrossOptions { estimators, window, folds: self.left_out() };
        let folds = number(runs.sources()) * options.estimators.len();
        let progress = Progress::new("folds", folds, common.quiet);
        let found = cross_validate(&pool, &runs, &options, &|count| progress.advance(count));
        let found = found.map_err(|e| Failure::invalid(self.flags.of.file(), &e.invalid()))?;
        let settings = [
            ("estimators", json!(options.estimators)),
            ("intercepts", json!(true)),
            ("window_samples", json!(window)),
            ("folds", json!(self.folds)),
            ("fold", json!(self.fold)),
        ];
        self.flags.note(settings, &mut provenance);
        let window_s = window.map(|samples| samples as f64 / vessel.sample_rate_hz);
        let document = CrossvalDocument::new(&pool, self.flags.nominal().source(), window_s, &found);
        written(&out, &provenance, &document)
    }
}

impl Arguments {
    fn left_out(&self) -> Folds {
        match (self.fold.is_empty(), self.folds) {
            (false, _) => Folds::Named(self.fold.iter().map(|fold| vec![fold.clone()]).collect()),
            (true, Some(count)) => Folds::Dealt(usize::from(count)),
            (true, None) => Folds::Each,
        }
    }
}
