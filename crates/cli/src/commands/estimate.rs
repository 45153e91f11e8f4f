//! `estimate`: parameters of every run, or a model of all.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use estimation::predictor::{InitialState, NoiseModel};
use estimation::runs::{RunEstimators, Unsuited};
use estimation::{EstimateStatus, Estimator, against_nominal};
use files::{Provenance, Staged, stage_document};
use regression::pooled::{PooledRuns, Recorded};
use serde_json::json;
use ship::engine::Run;
use ship::model::Vessel;
use study::documents::{ChosenStructure, EstimateDocument, ModelDocument, ModelStructure, PromiseUpdate};
use study::estimates::covariances::{self, Covariances};
use study::estimates::{self, Row, distinct};
use study::files::{read_any_followed, read_any_vessel, read_campaign};
use study::trajectories::{KeptRuns, Layout, TrajectoryReader};
use study::{Doubtful, LoggedHelm};

use crate::cli::{Allowed, Common, beside, given, member, none_given};
use crate::failure::{Failure, WorkProgress};
use crate::inputs::{self, Made, joined, joined_blocks};
use crate::pool::{EstimateArguments, FitKind, Nominal, besides};
use crate::stage::{Summary, Task};

use super::{estimate_pool, search};

/// The usual name of the table.
pub const MAIN: &str = "estimates.parquet";

/// Fewest recordings for a search, as many as it has folds.
pub const SEARCHED: usize = 6;

/// The structure of a model of so many recordings.
pub fn usual_structure(recordings: usize, has_regressors: bool) -> ModelStructure {
    match (recordings >= SEARCHED, has_regressors) {
        (true, true) => ModelStructure::Library,
        (true, false) => ModelStructure::Average,
        (false, true) => ModelStructure::Core,
        (false, false) => ModelStructure::Own,
    }
}

impl Task for EstimateArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let is_measured = self.is_measured(common);
        let usual = if is_measured || self.structure.is_some() { FitKind::Together } else { FitKind::Each };
        if self.fit.unwrap_or(usual) == FitKind::Each {
            self.check_each()?;
            return self.each(common);
        }
        let flags = [("--campaign", self.campaign.is_some()), ("--keep", self.keep.is_some())];
        none_given(flags, "an estimate of all runs together", "--fit each")?;
        let (asked, chosen) = self.resolved(is_measured, common)?;
        let said = self.structure.is_none().then(|| chosen.statement.clone());
        let summary = match chosen.chosen {
            ModelStructure::Own | ModelStructure::Core => estimate_pool::pooled(&asked, chosen, common),
            _ => search::searched(&asked, chosen, common),
        };
        Ok(summary?.also(said))
    }
}

impl EstimateArguments {
    /// Whether the runs are measured; one that cannot be read is refused later.
    fn is_measured(&self, common: &Common) -> bool {
        let Some(file) = &self.flags.of.trajectories else { return false };
        let vessel = read_any_vessel(&self.flags.vessel, &mut common.provenance("estimate"));
        vessel.is_ok_and(|vessel| inputs::are_simulated(file, &vessel).is_ok_and(|simulated| !simulated))
    }

    /// The flags with the defaults of a model of all runs, and which structure it has.
    fn resolved(&self, is_measured: bool, common: &Common) -> Result<(Self, ChosenStructure), Failure> {
        let mut asked = self.clone();
        asked.flags.of = asked.flags.of.with_recordings_beside();
        let vessel = read_any_vessel(&self.flags.vessel, &mut common.provenance("estimate"))?;
        let has_regressors = vessel.model.has_regressors();
        let (chosen, why) = if let Some(chosen) = self.structure {
            (chosen, "as asked for".to_owned())
        } else if !is_measured {
            (ModelStructure::Own, "the runs are simulated".to_owned())
        } else if !self.estimator.is_empty() {
            (ModelStructure::Own, "an estimator is given".to_owned())
        } else {
            let (runs, _) =
                asked.flags.of.read(&vessel, &mut common.provenance("estimate"), inputs::kept_runs)?;
            let count = runs.sources();
            let enough = if count >= SEARCHED { "are enough" } else { "are too few" };
            (usual_structure(count, has_regressors), format!("{count} recordings {enough} for a search"))
        };
        if self.structure.is_none() && chosen == ModelStructure::Core {
            // Few recordings distinguish seven terms best by their steps.
            asked.estimator = vec![Estimator::PredictionError];
        }
        // A prior holds estimates near given values.
        let is_of_terms = has_regressors || chosen == ModelStructure::Core;
        if is_measured && is_of_terms && asked.flags.nominal.is_none() && asked.flags.prior.is_none() {
            asked.flags.nominal = Some(Nominal::LeastSquares);
        }
        Ok((asked, ChosenStructure { chosen, statement: format!("structure `{chosen}`: {why}") }))
    }

    /// Refuses flags of a model of all runs.
    fn check_each(&self) -> Result<(), Failure> {
        let flags = &self.flags;
        let given = [
            ("--structure", self.structure.is_some()),
            ("--leave-out", !flags.of.leave_out.is_empty()),
            ("--part-s", flags.part_s.is_some()),
            ("--nominal", flags.nominal.is_some()),
            ("--prior", flags.prior.is_some()),
            ("--bootstrap", self.bootstrap.is_some()),
            ("--folds", self.folds.is_some()),
            ("--window-s", self.window_s.is_some()),
            ("--fitted-window-s", self.fitted_window_s.is_some()),
            ("--reference", self.reference.is_some()),
            ("--estimator auto", self.estimator.contains(&Estimator::Auto)),
        ];
        none_given(given, "an estimate of each run", "--fit together")?;
        let is_divided = self.sharding.shard.is_some() || self.sharding.gathers();
        none_given([("--runs", is_divided && !flags.of.runs.is_empty())], "--shard or --gather", "all runs")
    }

    /// Estimates each run.
    fn each(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("estimate");
        let vessel = self.determined(read_any_followed(&self.flags.vessel, &mut provenance)?)?;
        self.flags.mean_removal.check(&vessel.model).map_err(|e| Failure::invalid(&self.flags.vessel, &e))?;
        let inputs =
            [&self.flags.vessel].into_iter().chain(&self.flags.of.trajectories).chain(&self.sharding.gather);
        let out = common.main_output(MAIN, inputs)?;
        let levels = levels(self, &vessel, &mut provenance)?;
        let document = beside(&out, MAIN, "estimate.json");
        let path = member(
            &out,
            MAIN,
            "model.json",
            [&self.flags.vessel].into_iter().chain(&self.flags.of.trajectories),
        )?;
        let inputs = [&self.flags.vessel].into_iter().chain(&self.flags.of.trajectories);
        let table = member(&out, MAIN, covariances::FILE, inputs)?;
        let kept = self.keep.is_some().then(|| Covariances::new(&table));
        let promised = self.promised(common)?;
        let (mut made, model) = match self.sharding.gathers() {
            true => (gathered(&self.sharding.gather, &vessel, [&out, &document], provenance)?, None),
            false => {
                self.computed(&vessel, levels, provenance, [&out, &document], (kept.as_ref(), common.quiet))?
            }
        };
        if promised.is_some() && model.is_none() {
            let remedy = "name it by --runs, or estimate all by --fit together";
            return Err(Failure::Usage(format!(
                "--promised: found no single run with an estimate, expected one; {remedy}"
            )));
        }
        let promise = self.promise(promised, model.as_ref(), &mut made.provenance)?;
        let also = kept.map(|kept| kept.staged(&vessel, &document, &made.provenance)).transpose()?;
        publish((&vessel, promise), &document, made, (&path, model), also)
    }

    /// The vessel with the parameters that the runs can determine: simulated runs, which have their true states, have
    /// no information about disturbances that they hold constant.
    fn determined(&self, vessel: Vessel) -> Result<Vessel, Failure> {
        if vessel.model.simulated.is_empty() {
            return Ok(vessel);
        }
        let simulated = match (&self.flags.of.trajectories, self.sharding.gather.first()) {
            (Some(file), _) => {
                let layout = Layout::new(&vessel.model);
                TrajectoryReader::open(file, &layout, vessel.sample_rate_hz)?.true_states()
            }
            (None, Some(shard)) => !estimates::of_all(shard, &vessel)?,
            (None, None) => false,
        };
        Ok(if simulated { vessel.with_disturbances_held() } else { vessel })
    }

    /// Estimates from the runs of this shard, or of all.
    fn computed(
        &self,
        vessel: &Vessel,
        levels: Option<NoiseModel>,
        mut provenance: Provenance,
        out: [&Path; 2],
        (kept, quiet): (Option<&Covariances>, bool),
    ) -> Result<(Made<Row>, Option<ModelDocument>), Failure> {
        let file = given(&self.flags.of.trajectories, "trajectories")?;
        let reader = inputs::trajectories(file, "trajectories", vessel, &mut provenance)?;
        study::note_seed(reader.provenance(), &mut provenance);
        let (doubtful, helm) = (Doubtful::of(reader.provenance()), LoggedHelm::of(reader.provenance()));
        let initial = if reader.true_states() { InitialState::Known } else { InitialState::Estimated };
        // Noise that is not stated is found with the parameters.
        let unstated = !reader.true_states() && levels.is_none();
        let kept_runs = self.named(reader, file)?;
        let (expected, samples) = match &kept_runs {
            KeptRuns::Held(runs) => (runs.len() as f64, runs.iter().map(Run::samples).sum()),
            KeptRuns::InFile(reader) => (reader.expected_runs()?, reader.rows().0),
        };
        if !self.flags.of.allow.contains(&Allowed::Doubtful) {
            let is_used = |number| match &kept_runs {
                KeptRuns::Held(runs) => runs.iter().any(|run| run.run == number),
                KeptRuns::InFile(_) => true,
            };
            doubtful.check(file, is_used)?;
        }
        let usual = if !vessel.model.has_regressors() {
            Estimator::OutputError
        } else if unstated {
            Estimator::PredictionError
        } else {
            Estimator::Iv
        };
        let asked = if self.estimator.is_empty() { vec![usual] } else { self.estimator.clone() };
        let leading = if asked.contains(&usual) { usual } else { asked[0] };
        let estimators = RunEstimators {
            vessel,
            estimators: distinct(asked.into_iter()),
            removal: self.flags.mean_removal,
            initial,
            additional: self.additional.unknown(),
            levels,
        };
        estimators.check().map_err(|e| match e {
            Unsuited::Vessel(e) => Failure::invalid(&self.flags.vessel, &e),
            Unsuited::Runs(e) => Failure::invalid(file, &e),
        })?;
        helm.check(file, &estimators.estimators)?;
        self.additional.check(&estimators.estimators)?;
        let asks = estimators.asks();
        self.settings(leading, &estimators, &mut provenance);
        let share = self.sharding.shard.map_or(1.0, |shard| 1.0 / f64::from(shard.count));
        let rows = expected * share * estimators.estimators.len() as f64;
        let bytes = estimates::row_bytes(vessel) + kept.map_or(0.0, |_| covariances::row_bytes(vessel));
        inputs::fits(file, &format!("about {rows:.0} estimates"), rows * bytes)?;
        let each: f64 = estimators.estimators.iter().map(|estimator| estimator.seconds_per_row()).sum();
        let each = each + if asks { RunEstimators::SECONDS_PER_ROW_ASKED } else { 0.0 };
        let each = each + estimators.seconds_per_row_calibrated();
        let seconds = samples as f64 * share * each;
        let progress = WorkProgress::new("blocks of runs", kept_runs.blocks(), quiet).foretold(seconds);
        let block = |i: usize| {
            let runs = kept_runs.block(i)?;
            let estimates = match kept {
                None => estimators.estimates(&runs),
                Some(kept) => {
                    estimators.estimates_with_covariances(&runs).map(|estimates| kept.keep(i, estimates))
                }
            };
            let mut rows = estimates.map_err(|e| Failure::of_run(&e, &self.flags.vessel, file))?;
            if asks {
                estimators.criticise(&runs, &mut rows);
            }
            progress.advance(1);
            Ok(rows)
        };
        let (columns, blocks) = (estimates::columns(vessel), kept_runs.blocks());
        let made =
            Made::computed(out, &columns, provenance, joined_blocks(blocks), |i| joined(i, blocks, block))?;
        if self.sharding.shard.is_none()
            && let Some(why) = estimates::unidentified(&estimators, &kept_runs, &made.rows)?
        {
            return Err(Failure::NoAnswer(format!("{}: {why}", file.display())));
        }
        let model = self.model(&estimators, file, &kept_runs, &made.rows)?;
        Ok((made, model))
    }

    /// The runs that are named, or all.
    fn named(&self, reader: TrajectoryReader, file: &Path) -> Result<KeptRuns, Failure> {
        let all = KeptRuns::InFile(Box::new(reader));
        if self.flags.of.runs.is_empty() {
            return Ok(all);
        }
        let mut runs = PooledRuns::of(all, &BTreeMap::new())?;
        runs.select(&self.flags.of.runs, &[]).map_err(|e| Failure::invalid(file, &e.invalid()))?;
        Ok(KeptRuns::Held(runs.kept()?))
    }

    /// The model of the only run.
    fn model(
        &self,
        estimators: &RunEstimators,
        file: &Path,
        runs: &KeptRuns,
        rows: &[Row],
    ) -> Result<Option<ModelDocument>, Failure> {
        let ([row], None) = (rows, self.sharding.shard) else { return Ok(None) };
        let block = runs.block(0)?;
        let name = format!("{}/{}", row.design, row.run);
        let delivered = block.first().map(|run| estimators.delivered(run, &name)).transpose();
        let delivered = delivered.map_err(|e| Failure::of_run(&e, &self.flags.vessel, file))?.flatten();
        Ok(delivered.map(|(estimate, model)| {
            ModelDocument::of_run(estimators.vessel, self.flags.mean_removal, &estimate, &model)
        }))
    }

    /// The settings that the estimates depend on besides the inputs.
    fn settings(&self, leading: Estimator, estimators: &RunEstimators, provenance: &mut Provenance) {
        let (settings, all) = (&mut provenance.settings, &estimators.estimators);
        if estimators.asks() {
            settings.insert(estimates::CRITICISED.into(), json!("stated"));
        }
        settings.insert("estimator".into(), json!(leading));
        if all.len() > 1 {
            settings.insert("compared".into(), json!(all));
        }
        if all.iter().any(|estimator| estimator.searches()) {
            settings.insert("initial_state".into(), json!(estimators.initial.name()));
        }
        if !self.flags.of.runs.is_empty() {
            settings.insert("runs".into(), json!(self.flags.of.runs));
        }
        settings.insert("mean_removal".into(), json!(self.flags.mean_removal));
        self.additional.note(settings);
        provenance.shard = self.sharding.shard;
    }
}

/// The estimates of all shards.
fn gathered(
    shards: &[PathBuf],
    vessel: &Vessel,
    out: [&Path; 2],
    given: Provenance,
) -> Result<Made<Row>, Failure> {
    Made::gathered(shards, out, &estimates::columns(vessel), given, |reader| {
        let blocks = (0..reader.blocks()).map(|i| estimates::rows(reader, vessel, reader.path(), i));
        Ok(blocks.collect::<Result<Vec<_>, _>>()?.concat())
    })
}

/// The disturbances of the runs, if stated.
fn levels(
    a: &EstimateArguments,
    vessel: &Vessel,
    provenance: &mut Provenance,
) -> Result<Option<NoiseModel>, Failure> {
    let Some(file) = a.campaign.as_deref() else { return Ok(None) };
    let levels = read_campaign(file, provenance)?.levels(vessel.sample_rate_hz);
    let silent = levels.measurement.iter().position(|std| *std == 0.0);
    match silent.filter(|_| a.estimator.contains(&Estimator::PredictionError)) {
        None => Ok(Some(levels)),
        Some(d) => Err(Failure::refuse(
            file,
            &format!("`measurement.{}`", ["std_u_m_s", "std_v_m_s", "std_r_rad_s"][d]),
            "0",
            "measurement noise in every state, which the filter of `prediction-error` weighs predictions with",
            "state what the sensor has, however little",
        )),
    }
}

fn publish(
    (vessel, promise): (&Vessel, Option<PromiseUpdate>),
    document: &Path,
    made: Made<Row>,
    (path, model): (&Path, Option<ModelDocument>),
    covariances: Option<Staged>,
) -> Result<Summary, Failure> {
    let Made { table, provenance, rows } = made;
    let out = table.path().to_owned();
    let (runs, identified) = (rows.len(), rows.iter().filter(|r| r.estimate.is_some()).count());
    let asked = estimates::criticised(&provenance);
    let count = |status: EstimateStatus| rows.iter().filter(|r| r.status == status).count();
    let (unexcited, unconverged, rejected, approximate, waves) = (
        count(EstimateStatus::NotIdentifiable),
        count(EstimateStatus::NotConverged),
        count(EstimateStatus::Rejected),
        count(EstimateStatus::Approximate),
        count(EstimateStatus::Waves),
    );
    let own_instruments = count(EstimateStatus::OwnInstruments);
    let also = |count: usize, what: &str| if count > 0 { format!(", {count} {what}") } else { String::new() };
    let searched = also(unconverged, EstimateStatus::NotConverged.name())
        + &also(own_instruments, "with instruments by output error: the nominal model diverges")
        + &also(approximate, "with approximate standard errors: these errors follow no noise known here")
        + &also(waves, "without standard errors: waves move the ship");
    let verdict =
        if asked { format!(", {rejected} reject the model") } else { ", model not criticised".to_owned() };
    let turned = turned(vessel, &rows).map_or(String::new(), |turned| format!("; {turned}"));
    let said = besides(None, promise.as_ref());
    let summary = || {
        let summary = estimates::summarize(&out, &provenance, vessel, &rows)?;
        Ok(EstimateDocument { promise, ..summary })
    };
    let also_model = if model.is_some() { ", a model" } else { "" };
    let model = model.map(|model| stage_document(path, &provenance, &model)).transpose()?;
    estimates::publish(table, [covariances, model], document, &provenance, summary)?;
    let single = estimates::estimators(&rows).len() < 2;
    let things = if single { "runs" } else { "estimates" };
    let part = provenance.shard.map_or(String::new(), |s| format!(", shard {s}"));
    Ok(Summary::of(
        &out,
        format!("{runs} {things}, {unexcited} not identifiable{searched}{verdict}{also_model}{part}{turned}"),
        if single && unconverged == 0 {
            json!({"runs": runs, "identified": identified, "rejected": asked.then_some(rejected)})
        } else {
            json!({"estimates": runs, "identified": identified, "not_identifiable": unexcited,
                "not_converged": unconverged, "rejected": asked.then_some(rejected)})
        },
    )
    .also(said))
}

/// The means of all runs with another sign than the nominal value, in words; standard errors are those of a run.
fn turned(vessel: &Vessel, rows: &[Row]) -> Option<String> {
    let with_errors = || rows.iter().filter(|row| row.status != EstimateStatus::Waves);
    let known = || with_errors().filter_map(|row| row.estimate.as_ref());
    let count = known().count() as f64;
    let parameter = |i: usize| {
        let [estimate, error] =
            known().fold([0.0, 0.0], |sum, pair| [sum[0] + pair.0[i], sum[1] + pair.1[i]]);
        Some([estimate / count, error / count])
    };
    let means: Vec<_> = (0..vessel.model.parameters()).map(parameter).collect();
    against_nominal(&vessel.model, &vessel.nominal, &means)
}
