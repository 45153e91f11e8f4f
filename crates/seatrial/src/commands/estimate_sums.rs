//! `estimate pool --sums-only` and `--sums`: pooled estimates from sums of runs.

use std::path::PathBuf;

use artifact::{commit, stage_document};
use identification::pooled::{NoEstimate, NominalModel, Pool, estimate_merged};
use identification::runs::Beside;
use identification::{Estimator, MeanRemoval};
use serde_json::json;
use study::documents::SumsDocument;
use study::files::read_vessel;
use study::pooled_set::{self, PooledSet};
use study::sums::{self, MergedSums};

use crate::cli::{Common, member, not_below};
use crate::failure::Failure;
use crate::inputs;
use crate::pool::{Nominal, PoolFlags};
use crate::stage::Summary;

/// Writes the sums of runs.
pub fn added_up(flags: &PoolFlags, estimator: Estimator, common: &Common) -> Result<Summary, Failure> {
    check(flags, estimator)?;
    let mut provenance = common.provenance("estimate");
    let vessel = read_vessel(&flags.vessel, &mut provenance)?;
    let out = common.main_output(sums::MAIN, flags.inputs())?;
    let (runs, pool) = flags.read(&vessel, &mut provenance, inputs::kept_part)?;
    let file = flags.of.file();
    inputs::fits(file, &runs.amount(), pool.bytes(&runs, estimator, 0, rayon::current_num_threads()))?;
    flags.note([("estimator", json!(estimator)), ("pool", json!(true))], &mut provenance);
    let found = pool.run_sums(&runs.cut(pool.part_samples), estimator).map_err(|e| match e {
        NoEstimate::Lost(lost) => Failure::lost(file, &lost),
        NoEstimate::Unread(e) => e.into(),
    })?;
    let nominal = flags.nominal().source();
    let document = SumsDocument::new(&pool, (estimator, nominal), flags.part_s, &runs, &found);
    let document = document.ok_or_else(|| {
        let (expected, remedy) = ("sums that are numbers", "leave out the runs that are no motion");
        Failure::refuse(file, "runs", "sums that are too large", expected, remedy)
    })?;
    commit(vec![stage_document(&out, &provenance, &document)?])?;
    let (parts, samples) = (found.parts, found.samples);
    let said = format!("sums of {parts} parts of {} runs, {samples} samples", runs.count());
    Ok(Summary::of(&out, said, json!({"parts": parts, "runs": runs.count(), "samples": samples})))
}

/// Refuses what sums cannot be made for.
fn check(flags: &PoolFlags, estimator: Estimator) -> Result<(), Failure> {
    let refused = |found: &str| Err(Failure::Usage(format!("{found} without --sums-only")));
    if !matches!(estimator, Estimator::Ls | Estimator::Iv) {
        let why = "others go through the runs again; choose one, or estimate";
        return refused(&format!("--estimator: found {estimator}, expected ls or iv; {why}"));
    }
    if flags.mean_removal == MeanRemoval::Batch {
        let why = "means of each sub-experiment are not kept; choose one, or estimate";
        return refused(&format!("--mean-removal: found batch, expected complete or none; {why}"));
    }
    if flags.nominal() == Nominal::LeastSquares {
        let why = "it needs a pass over all runs first; name a model, or estimate";
        return refused(&format!(
            "--nominal: found least-squares, expected given or an estimate.json; {why}"
        ));
    }
    Ok(())
}

/// Estimates from the sums in `files`.
pub fn merged(
    flags: &PoolFlags,
    estimator: Estimator,
    files: &[PathBuf],
    common: &Common,
) -> Result<Summary, Failure> {
    let mut provenance = common.provenance("estimate");
    let strength = not_below("--prior", flags.prior.unwrap_or(0.0), 0.0)?;
    let vessel = read_vessel(&flags.vessel, &mut provenance)?;
    let inputs = || [&flags.vessel].into_iter().chain(files);
    let out = common.main_output(pooled_set::MAIN, inputs())?;
    let model = member(&out, pooled_set::MAIN, "model.json", inputs())?;
    let MergedSums { about, sums, runs } = sums::merged(files, &vessel, &mut provenance)?;
    let asked =
        [(estimator.name(), about.estimator.name()), (flags.mean_removal.name(), about.mean_removal.name())];
    if let Some((asked, found)) = asked.into_iter().find(|(asked, found)| asked != found) {
        let remedy = "ask for what the sums were made for, or make them again";
        return Err(Failure::refuse(
            &files[0],
            "settings",
            found,
            &format!("{asked}, as is asked for now"),
            remedy,
        ));
    }
    flags.note(
        [("estimator", json!(estimator)), ("pool", json!(true)), ("nominal", json!(about.nominal))],
        &mut provenance,
    );
    let pool = Pool {
        vessel: &vessel,
        model: vessel.model.with_intercepts(),
        removal: about.mean_removal,
        strength,
        nominal: NominalModel::Known(about.nominal_values.clone()),
        part_samples: None,
        beside: Beside::default(),
        constant: Vec::new(),
    };
    pool.check().map_err(|e| Failure::invalid(&flags.vessel, &e))?;
    let design = about.designs.first().map_or("", String::as_str);
    let found =
        estimate_merged(&pool, estimator, &sums, design).map_err(|e| Failure::of_pool(e, &files[0]))?;
    let mut set = PooledSet::new(&pool, about.nominal, (estimator, 0), (&found, &[]));
    set.trust.sources = runs;
    set.write(&vessel, [&out, &model], &provenance)?;
    let (said, told) = set.told();
    Ok(Summary::of(&out, said, told))
}
