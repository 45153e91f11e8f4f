//! `moments`: the information of each maneuver about the parameters.

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

use clap::Parser;
use estimation::Estimator;
use files::{Provenance, TableWriter, commit, commit_with_document, stage_document};
use refusal::Invalid;
use regression::pooled::{PooledRuns, PooledSums, Regression};
use regression::{InstrumentKind, MeanRemoval, Noise, Sums};
use seatrial::sampled_ships;
use serde_json::json;
use ship::model::Vessel;
use study::campaign_file::CampaignFile;
use study::documents::MomentsDocument;
use study::files::{generator, read_any_vessel, read_campaign, read_model};
use study::moments_table::{self, table_of};
use study::parts;
use study::trajectories::{TrajectoryReader, label};
use trial::moments::{
    Estimated, Expected, FreeRunModel, HeldParameter, ManeuverMoments, Moments, Pool, Prediction,
    PriorInformation, Unpredictable, check_constants, structure,
};

use crate::cli::{Common, Sharding, choice, none_given};
use crate::failure::{Failure, WorkProgress};
use crate::inputs::{self, ordered};
use crate::pool::Nominal;
use crate::stage::{Summary, Task};

/// Computes how much each maneuver says about each parameter: its moments, the matrices M of docs/notation.md. Parameters that no
/// maneuver excites apart from the others are held at their values
#[derive(Parser)]
#[command(
    name = "moments",
    after_help = "Example:\n  moments --vessel pipelines/paper/vessel.toml \
    --trajectories dictionary.parquet --out moments.json\n  \
    moments --vessel vessel.toml --trajectories dictionary.parquet --campaign campaign.toml --out moments.json\n  \
    moments --vessel vessel.toml --trajectories dictionary.parquet --campaign campaign.toml --estimator output-error --out moments.json"
)]
pub struct MomentsArguments {
    /// The vessel
    #[arg(long, visible_alias = "model", value_name = "vessel.toml")]
    vessel: PathBuf,
    /// One run per maneuver; of measured runs the segments are pooled by maneuver, instruments start anew with each
    #[arg(long, value_name = "dictionary.parquet")]
    trajectories: PathBuf,
    /// The nominal model that instruments are simulated with: `given` in vessel.toml, `least-squares` (the fit of the same
    /// data), or a previous estimate.json
    #[arg(long, value_name = "given|least-squares|FILE")]
    nominal: Option<Nominal>,
    /// The disturbances to expect: adds the matrices B that the estimate's covariance is made of
    #[arg(long, required_if_eq("estimator", "output-error"), value_name = "campaign.toml")]
    campaign: Option<PathBuf>,
    /// The estimator to predict: of `ls` the regressors are the instruments; `output-error` adds the matrices F and P, and G of the
    /// campaign's validation maneuvers
    #[arg(long, value_parser = choice(&PREDICTED, Estimator::name, Estimator::description), default_value_t = Estimator::Iv)]
    estimator: Estimator,
    /// Writes the maneuvers into moments.parquet beside the document, as they come: for dictionaries of very many
    #[arg(long, value_parser = ["table"], conflicts_with_all = ["campaign", "shard", "gather"])]
    keep: Option<String>,
    #[command(flatten)]
    sharding: Sharding,
}

impl Task for MomentsArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("moments");
        let mut vessel = read_any_vessel(&self.vessel, &mut provenance)?;
        let reader = inputs::trajectories(&self.trajectories, "trajectories", &vessel, &mut provenance)?;
        if reader.true_states() {
            vessel = vessel.with_disturbances_held();
        }
        check_constants(&vessel.model).map_err(|e| Failure::invalid(&self.vessel, &e))?;
        if let Some(nominal) = &self.nominal {
            vessel.nominal = nominal_of(self, nominal, &vessel, &mut provenance)?;
        }
        if reader.blocks() > 0 {
            label(reader.runs(0)?.iter().map(|run| run.design.as_str()), &mut provenance);
        }
        self.check(&vessel)?;
        let instruments = vessel.model.has_regressors().then(|| self.instruments());
        if let Some(kind) = instruments {
            provenance.settings.insert("instruments".into(), json!(kind));
        }
        let beyond = study::beyond(&self.vessel, &self.trajectories, None)?;
        let is_own = instruments.is_some()
            && self.keep.is_none()
            && matches!(self.nominal, None | Some(Nominal::Given));
        let sampled = is_own.then(|| sampled_ships(&self.vessel, &vessel, &reader)).transpose()?.flatten();
        let inputs = [&self.vessel, &self.trajectories].into_iter().chain(&self.campaign);
        let out = common.main_output("moments.json", inputs.chain(&self.sharding.gather))?;
        let known = read_model(&self.vessel)?.and_then(|model| model.known());
        let known = known.or_else(|| PriorInformation::of(&vessel.model));
        let mut held = Vec::new();
        let document = loop {
            let mut beyond = beyond.clone();
            let (disturbances, output_error) = predicted(self, &vessel, &mut beyond, &mut provenance)?;
            let (disturbed, free_runs) = (disturbances.as_ref(), output_error.as_ref());
            let prediction = Prediction::new(&vessel, self.instruments(), disturbed, free_runs);
            let (a, quiet) = (self, common.quiet);
            let reading = Reading { a, vessel: &vessel, prediction, reader: &reader, quiet };
            let head = |maneuvers: Vec<ManeuverMoments>| Moments {
                vessel: vessel.name.clone(),
                sample_rate_hz: vessel.sample_rate_hz,
                instruments,
                degrees: structure(&vessel.model),
                maneuvers,
                held: held.clone(),
                beyond: beyond.clone(),
                disturbances: disturbances.clone(),
                output_error: output_error.clone(),
                prior: known.clone(),
                sampled: sampled.clone(),
            };
            if self.keep.is_some() {
                return reading.table(&out, &provenance, &MomentsDocument(head(Vec::new())));
            }
            if self.sharding.gathers() {
                let (gathered, document) = parts::moments(&self.sharding.gather, provenance)?;
                provenance = gathered;
                break document;
            }
            provenance.shard = self.sharding.shard;
            let moments = head(reading.maneuvers()?);
            match self.unexcited(&moments)? {
                None => break MomentsDocument(moments),
                Some(parameter) => {
                    vessel = vessel.with_held(&parameter.parameter);
                    held.push(parameter);
                }
            }
        };
        published(&out, &provenance, &document)
    }
}

/// Publishes the moments, and summarises them.
fn published(out: &Path, provenance: &Provenance, document: &MomentsDocument) -> Result<Summary, Failure> {
    commit(vec![stage_document(out, provenance, document)?])?;
    let count = document.0.maneuvers.len();
    let part = provenance.shard.map_or(String::new(), |shard| format!(", shard {shard}"));
    let held = &document.0.held;
    let said = if held.is_empty() { String::new() } else { format!("; {}", HeldParameter::words(held)) };
    let is_left_out =
        document.0.disturbances.as_ref().is_some_and(|expected| expected.lasting_current_left_out);
    let current =
        if is_left_out { "; of measurement errors alone, not of the current that lasts" } else { "" };
    let details = json!({"maneuvers": count, "held": held});
    Ok(Summary::of(out, format!("moments of {count} maneuvers{part}{said}{current}"), details))
}

/// The estimators that moments are of.
const PREDICTED: [Estimator; 3] = [Estimator::Ls, Estimator::Iv, Estimator::OutputError];

impl MomentsArguments {
    /// What the instruments are made of.
    fn instruments(&self) -> InstrumentKind {
        if self.estimator == Estimator::Ls { InstrumentKind::Regressors } else { InstrumentKind::Nominal }
    }

    /// Refuses what needs regressors, of a `vessel` without them.
    fn check(&self, vessel: &Vessel) -> Result<(), Failure> {
        if vessel.model.has_regressors() {
            return Ok(());
        }
        if self.estimator != Estimator::OutputError {
            vessel.check_terms("iv").map_err(|e| {
                let remedy = "add --estimator output-error and --campaign campaign.toml";
                Failure::invalid(&self.vessel, &Invalid { remedy: remedy.into(), ..e })
            })?;
        }
        let flags = [("--nominal", self.nominal.is_some()), ("--keep", self.keep.is_some())];
        none_given(flags, "a vessel with forces, which has no instruments", "one with terms per sample")
    }

    /// Why nothing is predicted of the maneuvers of `file`.
    fn unpredictable(&self, file: &Path, error: Unpredictable) -> Failure {
        match error {
            Unpredictable::Maneuver(e) => Failure::invalid(file, &e),
            Unpredictable::Vessel(e) => Failure::invalid(&self.vessel, &e),
        }
    }

    /// The parameter to be held next, since no maneuver excites it apart from the others; none of a part of the maneuvers.
    fn unexcited(&self, moments: &Moments) -> Result<Option<HeldParameter>, Failure> {
        if self.sharding.shard.is_some() || moments.instruments.is_none() {
            return Ok(None);
        }
        let estimated = match self.estimator {
            Estimator::OutputError => Estimated::OutputError,
            _ => Estimated::Iv(MeanRemoval::Complete),
        };
        moments.unexcited(estimated).map_err(|e| Failure::invalid(&self.trajectories, &e))
    }
}

/// Rows per second whose moments a thread computes, order of magnitude: the paper's campaign on a server of 2024, a
/// million rows in 1.6 s, with the disturbances' matrices in 1.9, with those of `output-error` in 2.7.
const ROWS_PER_SECOND: f64 = 5e5;

/// The file at fault: noise is the campaign's.
fn fault<'a>(invalid: &Invalid, vessel: &'a Path, campaign: &'a Path) -> &'a Path {
    if invalid.thing.starts_with("`measurement") { campaign } else { vessel }
}

/// The inputs, and how they are read.
struct Reading<'a> {
    a: &'a MomentsArguments,
    vessel: &'a Vessel,
    prediction: Prediction<'a>,
    reader: &'a TrajectoryReader,
    quiet: bool,
}

impl Reading<'_> {
    /// The moments of all maneuvers.
    fn maneuvers(&self) -> Result<Vec<ManeuverMoments>, Failure> {
        let mut pool = Pool::default();
        let refused = |e: Invalid| Failure::invalid(&self.a.trajectories, &e);
        self.each(|pooled, more| {
            if pooled && self.a.sharding.shard.is_some() {
                return Err(self.pooled(&more.name, "--shard"));
            }
            pool.add(pooled, more).map_err(refused)
        })?;
        pool.finish(&self.vessel.model).map_err(refused)
    }

    /// Writes the moments of all maneuvers into the table next to `out`, as they are computed.
    fn table(&self, out: &Path, provenance: &Provenance, head: &MomentsDocument) -> Result<Summary, Failure> {
        let columns = moments_table::columns(&head.0.degrees);
        let writer = TableWriter::create(table_of(out), columns.schema(), provenance)?;
        let (mut writer, mut rows, mut count) = (writer.with_document(out), Vec::new(), 0);
        let mut names = HashSet::new();
        self.each(|pooled, more| {
            if pooled || !names.insert(more.name.clone()) {
                return Err(self.pooled(&more.name, "--keep table"));
            }
            let long_enough = more.check_length(&self.vessel.model);
            long_enough.map_err(|e| Failure::invalid(&self.a.trajectories, &e))?;
            rows.push(more);
            count += 1;
            if rows.len() == moments_table::BLOCK {
                writer.push(columns.encode(&rows)?)?;
                rows.clear();
            }
            Ok(())
        })?;
        if !rows.is_empty() {
            writer.push(columns.encode(&rows)?)?;
        }
        commit_with_document(writer.finish()?, out, provenance, head)?;
        let said = format!("moments of {count} maneuvers in {}", table_of(out).display());
        Ok(Summary::of(out, said, json!({"maneuvers": count})))
    }

    /// Calls `take` with the moments of every run, in their order, and whether they are pooled with others of its maneuver.
    fn each(
        &self,
        mut take: impl FnMut(bool, ManeuverMoments) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let Self { a, prediction, reader, quiet, .. } = self;
        let blocks = a.sharding.shard.map_or(0..reader.blocks(), |shard| shard.range(reader.blocks()));
        let share = blocks.len() as f64 / reader.blocks().max(1) as f64;
        let seconds = share * reader.rows().0 as f64 / ROWS_PER_SECOND;
        let progress = WorkProgress::new("blocks", blocks.len(), *quiet).foretold(seconds);
        let work = |block: usize| {
            let moments = prediction.moments(&reader.runs(block)?);
            progress.advance(1);
            moments.map_err(|e| a.unpredictable(&a.trajectories, e))
        };
        ordered(blocks, work, |runs| runs.into_iter().try_for_each(|(pooled, more)| take(pooled, more)))
    }

    /// Refuses runs that would be pooled if each must be separate.
    fn pooled(&self, maneuver: &str, flag: &str) -> Failure {
        let (found, expected) = ("more than one run, which make one sum", "one simulated run per maneuver");
        let thing = format!("maneuver `{maneuver}`");
        Failure::refuse(&self.a.trajectories, &thing, found, expected, &format!("leave out {flag}"))
    }
}

/// The expected disturbances, and the model of free simulations, if requested.
fn predicted(
    a: &MomentsArguments,
    vessel: &Vessel,
    beyond: &mut Vec<String>,
    provenance: &mut Provenance,
) -> Result<(Option<Expected>, Option<FreeRunModel>), Failure> {
    let Some(campaign) = &a.campaign else { return Ok((None, None)) };
    let config = read_campaign(campaign, provenance)?;
    let noise = if a.estimator == Estimator::OutputError {
        config.output_noise()
    } else {
        config.noise_for(a.instruments()).map_err(|e| Failure::invalid(campaign, &e))?
    };
    Prediction::check(&vessel.model, &noise)
        .map_err(|e| Failure::invalid(fault(&e, &a.vessel, campaign), &e))?;
    let expected = expected(a, vessel, &config, noise)?;
    if a.estimator != Estimator::OutputError {
        return Ok((Some(expected), None));
    }
    let validation = generator(campaign, vessel, &config.validation_dictionary(), provenance)?;
    let model = match FreeRunModel::new(vessel, Some(&validation)) {
        // A model of logs may not hold what its ship does.
        Err(Unpredictable::Maneuver(why)) if read_model(&a.vessel)?.is_some() => {
            beyond.push(format!(
                "no simulation errors are predicted, as the model cannot hold a validation maneuver: {why}"
            ));
            FreeRunModel::new(vessel, None)
        }
        found => found,
    };
    Ok((Some(expected), Some(model.map_err(|e| a.unpredictable(campaign, e))?)))
}

/// The disturbances to expect of trials of `campaign`, of which `noise` is predicted.
fn expected(
    a: &MomentsArguments,
    vessel: &Vessel,
    campaign: &CampaignFile,
    noise: Noise,
) -> Result<Expected, Failure> {
    let expected =
        Expected::new(vessel, noise, campaign.duration_s).map_err(|e| Failure::invalid(&a.vessel, &e))?;
    Ok(Expected { lasting_current_left_out: campaign.noise().is_none(), ..expected })
}

/// The nominal parameters of `--nominal`, without intercepts.
fn nominal_of(
    a: &MomentsArguments,
    nominal: &Nominal,
    vessel: &Vessel,
    provenance: &mut Provenance,
) -> Result<Vec<f64>, Failure> {
    let model = nominal.read(vessel, provenance)?;
    let runs = PooledRuns::new(inputs::runs(&a.trajectories, vessel, provenance)?, &BTreeMap::new());
    label(runs.designs(), provenance);
    let parts = runs.parts(None);
    let sums: Vec<Sums> = parts.iter().map(|p| Regression::of(&vessel.model, &p.whole()).sums()).collect();
    let parameters = model.parameters(&PooledSums::of(&sums, MeanRemoval::None));
    parameters.map(|(theta, _)| theta).ok_or_else(|| {
        Failure::NoAnswer(format!(
            "{}: nominal model: found data that identify no least-squares model, expected all terms to vary; name another \
             --nominal",
            a.trajectories.display()
        ))
    })
}
