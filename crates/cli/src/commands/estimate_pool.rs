//! `estimate pool`: one estimate from all runs.

use std::path::{Path, PathBuf};

use clap::Parser;
use estimation::Estimator;
use estimation::pooled::{Judgement, Pool, Resample, Resampling, grown, resampled, unstated};
use estimation::runs::AdditionalUnknowns;
use files::{Provenance, Shard, TableReader};
use regression::pooled::{PooledRuns, Recorded};
use seatrial::Pooling;
use serde_json::json;
use ship::model::Vessel;
use study::files::read_any_vessel;
use study::pooled_set::MAIN;
use study::trajectories::{Layout, TrajectoryReader};
use study::{LoggedHelm, resamples};

use crate::cli::{AdditionalFlags, Common, Sharding, choice, member, none_given};
use crate::failure::{Failure, WorkProgress};
use crate::inputs::{self, Made, rows_of_shards};
use crate::physical::{self, absent};
use crate::pool::PoolFlags;
use crate::stage::{Summary, Task};

/// Makes one model from all runs or recordings, and says how far it can be trusted; writes estimates.parquet, estimate.json,
/// trust.json, and model.json, which stands for a vessel.toml
#[derive(Parser)]
#[command(
    name = "pool",
    after_help = "Example:\n  estimate pool --vessel pipelines/kvlcc2/vessel.toml \
    --trajectories trajectories.parquet --nominal least-squares --estimator auto --bootstrap 500 --out results/",
    mut_arg("shard", |shard| shard.requires("bootstrap").help("Draw only the resamples of part K of N, into a table; gather the \
    parts with --gather")),
    mut_arg("gather", |gather| gather.requires("bootstrap").help("Take the resamples from the files of all shards instead of \
    drawing them"))
)]
pub struct PoolArguments {
    #[command(flatten)]
    flags: PoolFlags,
    /// The estimator [default: of a ship with forces `output-error`; of measured logs `prediction-error`, or `output-error` where no noise known here describes their
    /// errors; of simulated trials and with --prior `iv`]
    #[arg(long, value_parser = choice(&Estimator::POOLED, Estimator::name, Estimator::description))]
    estimator: Option<Estimator>,
    #[command(flatten)]
    additional: AdditionalFlags,
    /// Resamples of the bootstrap over sub-experiments
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    bootstrap: Option<u32>,
    /// Terms that are added at most, one after the other, where the model is found to lack them; forces, where recordings
    /// left out confirm them
    #[arg(long, value_name = "K", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=50))]
    add_terms: u16,
    /// Of a ship with forces: the runs are simulated in windows of at most this length [s] [default: 100]
    #[arg(long, value_name = "S")]
    window_s: Option<f64>,
    /// Of a ship with forces: values of captive tests under `derivatives`, to set beside the estimates
    #[arg(long, value_name = "reference.toml")]
    reference: Option<PathBuf>,
    #[command(flatten)]
    sharding: Sharding,
}

impl Task for PoolArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("estimate");
        let vessel = self.flags.cored(read_any_vessel(&self.flags.vessel, &mut provenance)?)?;
        if vessel.model.forces.is_some() {
            self.check_forces()?;
            let flags = (&self.flags, self.window_s, self.reference.as_ref());
            let asked = (self.estimator, usize::from(self.add_terms));
            return physical::fit(flags, asked, &vessel, (common, provenance));
        }
        absent([("--window-s", self.window_s.is_some()), ("--reference", self.reference.is_some())])?;
        let main = if self.sharding.shard.is_some() { resamples::MAIN } else { MAIN };
        let out = common.main_output(main, self.flags.inputs().chain(&self.sharding.gather))?;
        let model = member(&out, MAIN, "model.json", self.flags.inputs())?;
        let (runs, pool) = self.flags.read(&vessel, &mut provenance, inputs::kept_runs)?;
        let pool = Pool { additional: self.additional.unknown(), ..pool };
        let estimator = self.estimator(&pool, &runs)?;
        self.additional.check(&[estimator])?;
        LoggedHelm::of(&provenance).check(self.flags.of.file(), &[estimator])?;
        let judgement = Judgement { replicates: self.bootstrap.unwrap_or(0), seed: common.seed.unwrap_or(1) };
        let (replicates, threads) = (judgement.replicates, rayon::current_num_threads());
        let bytes = pool.bytes(&runs, estimator, replicates, threads);
        inputs::fits(self.flags.of.file(), &runs.amount(), bytes)?;
        self.note(estimator, &judgement, &mut provenance);
        let most = usize::from(self.add_terms);
        let grown = grown(&pool, &runs, estimator, &judgement, most)
            .map_err(|e| Failure::of_pool(e, self.flags.of.file()))?;
        let pool_of_grown = pool.of(&grown.vessel, grown.nominal.clone());
        if let Some(shard) = self.sharding.shard {
            provenance.shard = Some(shard);
            let (pooled, how) = ((&pool_of_grown, &runs), (estimator, &judgement));
            return self.shard(shard, &out, pooled, how, (provenance, common.quiet));
        }
        let drawn = self.gathered(&grown.vessel, replicates, &mut provenance)?;
        let progress = WorkProgress::new("resamples", replicates as usize, common.quiet);
        let resampled = |count: usize| progress.advance(count);
        let resampling = drawn.as_deref().map_or(Resampling::Drawn(&resampled), Resampling::Given);
        let nominal = self.flags.nominal().source();
        let pooling = Pooling { pool, nominal, judgement, most_added: most };
        let set = pooling.judged(grown, &runs, (estimator, self.estimator.is_none()), resampling);
        let set = set.map_err(|e| Failure::of_pool(e, self.flags.of.file()))?;
        set.write([&out, &model], &provenance)?;
        let (said, details) = set.summary();
        Ok(Summary::of(&out, said, details))
    }
}

impl PoolArguments {
    /// Refuses flags that a fit of forces does not have.
    fn check_forces(&self) -> Result<(), Failure> {
        let flags = [
            ("--bootstrap", self.bootstrap.is_some()),
            ("--add-terms beside a former fit", self.add_terms > 0 && self.flags.former().is_some()),
            ("--unknown-current or --intercepts", self.additional.unknown() != AdditionalUnknowns::default()),
        ];
        none_given(flags, "a ship with forces", "terms per sample")
    }

    /// The requested estimator, or the default.
    fn estimator<R: Recorded<Error = files::Error>>(
        &self,
        pool: &Pool,
        runs: &PooledRuns<R>,
    ) -> Result<Estimator, Failure> {
        if let Some(asked) = self.estimator {
            return Ok(asked);
        }
        let (layout, file) = (Layout::new(&pool.vessel.model), self.flags.of.file());
        let reader = TrajectoryReader::open(file, &layout, pool.vessel.sample_rate_hz)?;
        if let Some(usual) = pool.usual(reader.true_states() || self.flags.prior.is_some()) {
            return Ok(usual);
        }
        let bytes = pool.bytes(runs, Estimator::PredictionError, 0, rayon::current_num_threads());
        inputs::fits(file, &runs.amount(), bytes)?;
        unstated(pool, runs).map_err(|e| Failure::of_pool(e, file))
    }

    fn note(&self, estimator: Estimator, judgement: &Judgement, provenance: &mut Provenance) {
        let settings = [
            ("estimator", json!(estimator)),
            ("pool", json!(true)),
            ("bootstrap", json!(judgement.replicates)),
            ("seed", json!(judgement.seed)),
            ("add_terms", json!(Some(self.add_terms).filter(|most| *most > 0))),
        ];
        self.flags.note(settings, provenance);
        self.additional.note(&mut provenance.settings);
    }

    /// Draws the resamples of `shard`.
    fn shard<R: Recorded<Error = files::Error>>(
        &self,
        shard: Shard,
        out: &Path,
        (pool, runs): (&Pool, &PooledRuns<R>),
        (estimator, judgement): (Estimator, &Judgement),
        (provenance, quiet): (Provenance, bool),
    ) -> Result<Summary, Failure> {
        let (blocks, each) = resamples::blocks(judgement.replicates);
        let progress = WorkProgress::new("blocks of resamples", shard.range(blocks).len(), quiet);
        let (columns, last) = (resamples::columns(pool.vessel), judgement.replicates);
        let made = resampled(pool, runs, (estimator, judgement.seed), |draw| {
            Made::computed([out, out], &columns, provenance, blocks, |i| {
                let first = i as u32 * each;
                let rows = (first..last.min(first + each)).map(draw).collect::<Result<_, _>>()?;
                progress.advance(1);
                Ok(rows)
            })
        });
        made.map_err(|e| Failure::of_pool(e, self.flags.of.file()))??.publish_shard(shard, "resamples")
    }

    /// The resamples of all shards; `None` if they are to be drawn.
    fn gathered(
        &self,
        vessel: &Vessel,
        replicates: u32,
        provenance: &mut Provenance,
    ) -> Result<Option<Vec<Resample>>, Failure> {
        let Some(first) = self.sharding.gather.first() else { return Ok(None) };
        let rows = |reader: &TableReader| resamples::rows(reader, vessel);
        let all = rows_of_shards(&self.sharding.gather, &resamples::columns(vessel), provenance, rows)?;
        resamples::check(&all, replicates, first)?;
        Ok(Some(all))
    }
}
