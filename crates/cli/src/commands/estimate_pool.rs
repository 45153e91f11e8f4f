//! `estimate --fit together` with the terms of the vessel or a core: one estimate from all runs.

use std::path::Path;

use estimation::Estimator;
use estimation::pooled::{Judgement, Pool, Resample, Resampling, resampled, unstated};
use estimation::runs::AdditionalUnknowns;
use files::{Provenance, Shard, TableReader};
use regression::pooled::{PooledRuns, Recorded};
use seatrial::{Pooling, core_of};
use serde_json::json;
use ship::model::Vessel;
use study::documents::{ChosenStructure, EstimateDocument, LeftOutScores, ModelStructure};
use study::files::read_any_vessel;
use study::{LoggedHelm, noted_contradicting, resamples};
use validation::crossval::{CrossOptions, cross_validate, dealt};

use crate::cli::{Common, none_given};
use crate::failure::{Failure, WorkProgress};
use crate::inputs::{self, Made, rows_of_shards};
use crate::pool::{EstimateArguments, Folds, SetPaths, besides};
use crate::stage::Summary;

use super::estimate_forces::{self, absent};

/// Makes one model of all runs or recordings, with the terms or forces of the vessel or a core of terms.
pub(super) fn pooled(
    asked: &EstimateArguments,
    structure: ChosenStructure,
    common: &Common,
) -> Result<Summary, Failure> {
    let mut provenance = common.provenance("estimate");
    let (flags, file) = (&asked.flags, asked.flags.of.file());
    let given = read_any_vessel(&flags.vessel, &mut provenance)?;
    let is_core = structure.chosen == ModelStructure::Core;
    if !given.model.has_regressors() && !is_core {
        check_fit(asked)?;
        return estimate_forces::fit(asked, structure, &given, (common, provenance));
    }
    let vessel = match is_core {
        true => core_of(&given).map_err(|e| Failure::invalid(&flags.vessel, &e))?,
        false => given,
    };
    let windows = asked.window_s.is_some() && asked.folds.is_none();
    none_given([("--window-s", windows)], "no --folds", "recordings that are left out")?;
    absent([
        ("--fitted-window-s", asked.fitted_window_s.is_some()),
        ("--reference", asked.reference.is_some()),
    ])?;
    let (replicates, is_divided) =
        (asked.bootstrap.unwrap_or(0), asked.sharding.shard.is_some() || asked.sharding.gathers());
    none_given([("--bootstrap 1", asked.bootstrap == Some(1))], "a single resample", "two or more")?;
    let flag = if asked.sharding.gathers() { "--gather" } else { "--shard" };
    none_given([(flag, is_divided && replicates == 0)], "no resamples to divide", "--bootstrap")?;
    let written = match asked.sharding.shard {
        Some(_) => {
            SetPaths { main: common.main_output(resamples::MAIN, asked.inputs())?, ..SetPaths::default() }
        }
        None => SetPaths::of(common, asked, true)?,
    };
    let promised = asked.promised(common)?;
    let (runs, pool) = flags.read(&vessel, &mut provenance, inputs::kept_runs)?;
    let pool = Pool { additional: asked.additional.unknown(), ..pool };
    let estimator = leading(asked, &pool, &runs)?;
    asked.additional.check(&[estimator])?;
    LoggedHelm::of(&provenance).check(file, &[estimator])?;
    let judgement = Judgement { replicates, seed: common.seed.unwrap_or(1) };
    let threads = rayon::current_num_threads();
    inputs::fits(file, &runs.amount(), pool.bytes(&runs, estimator, replicates, threads))?;
    let dealt_runs = asked.folds.map(|folds| {
        let (runs, pool) = flags.read(&vessel, &mut common.provenance("estimate"), inputs::runs)?;
        inputs::fits(file, &runs.amount(), pool.bytes_of_many(&runs, threads))?;
        Ok::<_, Failure>((folds, runs, pool))
    });
    let dealt_runs = dealt_runs.transpose()?;
    note(asked, (estimator, is_core), &judgement, &mut provenance);
    if let Some(shard) = asked.sharding.shard {
        provenance.shard = Some(shard);
        let (pooled, how) = ((&pool, &runs), (estimator, &judgement));
        return drawn(asked, (shard, &written.main), pooled, how, (provenance, common.quiet));
    }
    let drawn = gathered(asked, &vessel, replicates, &mut provenance)?;
    let progress = WorkProgress::new("resamples", replicates as usize, common.quiet);
    let resampled = |count: usize| progress.advance(count);
    let resampling = drawn.as_deref().map_or(Resampling::Drawn(&resampled), Resampling::Given);
    let nominal = flags.nominal().source();
    let pooling = Pooling { pool, nominal, judgement };
    let set = pooling.judged(&runs, (estimator, asked.estimator.is_empty()), resampling);
    let mut set = set.map_err(|e| Failure::of_pool(e, file))?;
    set.trust.statements.extend(noted_contradicting(&provenance));
    let scores =
        |(Folds(folds), runs, pool)| left_out(asked, folds, (&pool, &runs), (common, &mut provenance));
    let left_out = dealt_runs.map(scores).transpose()?;
    let promise = asked.promise(promised, set.model.as_ref(), &mut provenance)?;
    let (said, details) = set.summary();
    let besides = besides(left_out.as_ref(), promise.as_ref());
    let document = EstimateDocument { structure: Some(structure), left_out, promise, ..set.document() };
    set.write([&written.table, &written.document, &written.model], &provenance, document)?;
    Ok(Summary::of(&written.main, said, details).also(besides))
}

/// The scores of estimators on recordings that are left out of them, a fold at a time.
fn left_out(
    asked: &EstimateArguments,
    folds: Option<u16>,
    (pool, runs): (&Pool, &PooledRuns),
    (common, provenance): (&Common, &mut Provenance),
) -> Result<LeftOutScores, Failure> {
    let window = asked.scored(pool.vessel)?;
    let of = |estimators: &[Estimator]| {
        Estimator::POOLED.into_iter().filter(|one| estimators.contains(one)).collect::<Vec<_>>()
    };
    let estimators =
        if asked.estimator.is_empty() { Estimator::COMPARED.to_vec() } else { of(&asked.estimator) };
    let options = CrossOptions { estimators, window, folds: folds.map(usize::from) };
    let all = dealt(runs.sources(), options.folds).len() * options.estimators.len();
    let progress = WorkProgress::new("folds", all, common.quiet);
    let scores = cross_validate(pool, runs, &options, &|count| progress.advance(count));
    let scores = scores.map_err(|e| Failure::invalid(asked.flags.of.file(), &e.invalid()))?;
    let settings = [
        ("estimators", json!(options.estimators)),
        ("window_samples", json!(window)),
        ("folds", json!(folds)),
    ];
    crate::pool::note(settings, provenance);
    let window_s = window.map(|samples| samples as f64 / pool.vessel.sample_rate_hz);
    Ok(LeftOutScores::new(pool, asked.flags.nominal().source(), window_s, &scores))
}

/// Refuses flags that a fit of forces does not have.
fn check_fit(asked: &EstimateArguments) -> Result<(), Failure> {
    let flags = [
        ("--bootstrap", asked.bootstrap.is_some()),
        ("--unknown-current or --intercepts", asked.additional.unknown() != AdditionalUnknowns::default()),
        ("--shard or --gather", asked.sharding.shard.is_some() || asked.sharding.gathers()),
    ];
    none_given(flags, "a ship with forces", "terms per sample")
}

/// The first estimator that is requested, or the default.
fn leading<R: Recorded<Error = files::Error>>(
    asked: &EstimateArguments,
    pool: &Pool,
    runs: &PooledRuns<R>,
) -> Result<Estimator, Failure> {
    if let Some(first) = asked.estimator.first() {
        return Ok(*first);
    }
    let file = asked.flags.of.file();
    let is_simulated = inputs::are_simulated(file, pool.vessel)?;
    if let Some(usual) = pool.usual(is_simulated || asked.flags.prior.is_some()) {
        return Ok(usual);
    }
    let bytes = pool.bytes(runs, Estimator::PredictionError, 0, rayon::current_num_threads());
    inputs::fits(file, &runs.amount(), bytes)?;
    unstated(pool, runs).map_err(|e| Failure::of_pool(e, file))
}

fn note(
    asked: &EstimateArguments,
    (estimator, is_core): (Estimator, bool),
    judgement: &Judgement,
    provenance: &mut Provenance,
) {
    let settings = [
        ("estimator", json!(estimator)),
        ("pool", json!(true)),
        ("bootstrap", json!(judgement.replicates)),
        ("seed", json!(judgement.seed)),
        ("core", json!(Some(true).filter(|_| is_core))),
    ];
    asked.flags.note(settings, provenance);
    asked.additional.note(&mut provenance.settings);
}

/// Draws the resamples of `shard`.
fn drawn<R: Recorded<Error = files::Error>>(
    asked: &EstimateArguments,
    (shard, out): (Shard, &Path),
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
    made.map_err(|e| Failure::of_pool(e, asked.flags.of.file()))??.publish_shard(shard, "resamples")
}

/// The resamples of all shards; `None` if they are to be drawn.
fn gathered(
    asked: &EstimateArguments,
    vessel: &Vessel,
    replicates: u32,
    provenance: &mut Provenance,
) -> Result<Option<Vec<Resample>>, Failure> {
    let Some(first) = asked.sharding.gather.first() else { return Ok(None) };
    let rows = |reader: &TableReader| resamples::rows(reader, vessel);
    let all = rows_of_shards(&asked.sharding.gather, &resamples::columns(vessel), provenance, rows)?;
    resamples::check(&all, replicates, first)?;
    Ok(Some(all))
}
