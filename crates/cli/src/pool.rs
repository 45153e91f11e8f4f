//! Inputs of stages that pool sub-experiments.

use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Args, Parser};
use estimation::Estimator;
use estimation::pooled::Pool;
use files::{Digest, Provenance, STUDY_ROLES, read_document};
use regression::MeanRemoval;
use regression::pooled::{NominalModel, NominalSource, PooledRuns, Recorded};
use seatrial::{Promised, UpdateError, Updating};
use serde_json::{Value, json};
use ship::model::Vessel;
use study::Doubtful;
use study::documents::{
    DesignDocument, EstimateDocument, IngestDocument, LeftOutScores, ModelDocument, ModelStructure,
    PromiseUpdate,
};
use study::trajectories::label;

use crate::cli::{
    AdditionalFlags, Allowed, Common, Sharding, allowance, beside, choice, member, none_given, not_below,
    samples,
};
use crate::failure::Failure;
use crate::inputs;

/// The requested nominal model.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Nominal {
    /// The nominal values of `vessel.toml`.
    #[default]
    Given,
    /// The least-squares fit of the same data.
    LeastSquares,
    /// The mean estimate of a previous `estimate.json`.
    File(PathBuf),
}

/// What holds estimates back.
#[derive(Clone, Debug, PartialEq)]
pub enum Held {
    /// A pull to nominal values.
    Strength(f64),
    /// A former fit of forces.
    Former(PathBuf),
}

impl FromStr for Held {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(text.parse().map_or_else(|_| Self::Former(text.into()), Self::Strength))
    }
}

/// The selection of runs.
#[derive(Clone, Debug, Args)]
pub struct RunFlags {
    /// The runs
    #[arg(long, required = true, value_name = "trajectories.parquet")]
    pub trajectories: Option<PathBuf>,
    /// The ingest.json beside the trajectories, which names the recordings that runs were cut from.
    #[arg(skip)]
    recordings: Option<PathBuf>,
    /// Only these runs or recordings, whose own names may have commas, too; may stand more than once
    #[arg(long, value_name = "NAME,…")]
    pub runs: Vec<String>,
    /// All but these runs or recordings, as --runs has them
    #[arg(long, value_name = "NAME,…")]
    pub leave_out: Vec<String>,
    /// Accepts what is refused otherwise; the outputs say so
    #[arg(long, global = true, value_name = "LIST", value_delimiter = ',', value_parser = allowance(&[Allowed::Mixed, Allowed::Doubtful]))]
    pub allow: Vec<Allowed>,
}

impl RunFlags {
    /// Reads the runs with `recorded`, and finds their constant logged channels. Inputs of simulated runs are held during samples.
    /// Results from simulated logs are labelled so.
    pub fn read<R: Recorded>(
        &self,
        vessel: &Vessel,
        provenance: &mut Provenance,
        recorded: impl FnOnce(&Path, &Vessel, &mut Provenance) -> Result<R, Failure>,
    ) -> Result<(PooledRuns<R>, Vec<String>), Failure>
    where
        files::Error: From<R::Error>,
    {
        let kept = recorded(self.file(), vessel, provenance)?;
        let read = |path: &PathBuf| inputs::document::<IngestDocument>(path, "recordings", provenance);
        let recordings = self.recordings.as_ref().map(read).transpose()?;
        let named = recordings.as_ref().map(IngestDocument::recordings_by_run).unwrap_or_default();
        let is_held = inputs::are_simulated(self.file(), vessel)?;
        let mut runs = PooledRuns::of(kept, &named).map_err(files::Error::from)?.with_inputs_held(is_held);
        label(runs.designs(), provenance);
        let selected = runs.select(&self.runs, &self.leave_out);
        selected.map_err(|e| Failure::invalid(self.file(), &e.invalid()))?;
        if !self.allow.contains(&Allowed::Doubtful) {
            Doubtful::of(provenance).check(self.file(), |run| runs.has(run))?;
        }
        Ok((runs, recordings.as_ref().map(IngestDocument::constant_channels).unwrap_or_default()))
    }

    /// The files that are read.
    pub fn inputs(&self) -> impl Iterator<Item = &PathBuf> {
        self.trajectories.iter().chain(&self.recordings)
    }

    /// The same with the ingest.json beside the trajectories, where it was written with these.
    #[must_use]
    pub fn with_recordings_beside(&self) -> Self {
        Self { recordings: ingested_with(self.file()), ..self.clone() }
    }

    /// The file with the runs; the command line has one.
    pub fn file(&self) -> &Path {
        self.trajectories.as_deref().unwrap_or(Path::new(""))
    }
}

/// `ingest.json` beside `trajectories`, if it was written with them.
fn ingested_with(trajectories: &Path) -> Option<PathBuf> {
    let path = beside(trajectories, "trajectories.parquet", "ingest.json");
    let known = files::exists(&path).then(|| files::inspect(&path)).and_then(Result::ok).flatten()?;
    let member = known.members.get(&*trajectories.file_name()?.to_string_lossy());
    (member == Some(&Digest::of_file(trajectories).ok()?)).then_some(path)
}

/// Flags of stages that pool sub-experiments.
#[derive(Clone, Debug, Args)]
pub struct PoolFlags {
    /// The vessel
    #[arg(long, visible_alias = "model", value_name = "vessel.toml")]
    pub vessel: PathBuf,
    #[command(flatten)]
    pub of: RunFlags,
    /// How the instruments' mean is removed
    #[arg(long, help_heading = "How it is fitted", value_parser = choice(&MeanRemoval::ALL, MeanRemoval::name, MeanRemoval::description), default_value_t = MeanRemoval::Complete)]
    pub mean_removal: MeanRemoval,
    /// Cuts longer sub-experiments, so that instruments start anew at least this often [s]
    #[arg(long, help_heading = "How it is fitted", value_name = "S")]
    pub part_s: Option<f64>,
    /// The nominal model that instruments are simulated with: `given` in vessel.toml, `least-squares` (the fit of the same
    /// data), or a previous estimate.json
    #[arg(long, help_heading = "How it is fitted", value_name = "given|least-squares|FILE")]
    pub nominal: Option<Nominal>,
    /// Pull towards the nominal model, on the scale of correlations; 0.03 is mild. Of a ship with forces: the weight of
    /// her priors, or the model of a former fit or of a sister's
    #[arg(long, help_heading = "How it is fitted", value_name = "STRENGTH|model.json")]
    pub prior: Option<Held>,
}

impl PoolFlags {
    /// Notes a stage's `settings`, and the pooled runs and their parts; omits empty or absent ones.
    pub fn note<const N: usize>(&self, settings: [(&'static str, Value); N], provenance: &mut Provenance) {
        let pooled = [
            ("runs", json!(self.of.runs)),
            ("leave_out", json!(self.of.leave_out)),
            ("part_s", json!(self.part_s)),
            ("mean_removal", json!(self.mean_removal)),
            ("prior", json!(self.strength())),
        ];
        note(settings.into_iter().chain(pooled), provenance);
    }

    /// The files that are read.
    pub fn inputs(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.vessel].into_iter().chain(self.of.inputs()).chain(self.former())
    }

    /// The model of a former fit.
    pub fn former(&self) -> Option<&PathBuf> {
        match &self.prior {
            Some(Held::Former(path)) => Some(path),
            _ => None,
        }
    }

    /// Reads the runs with `recorded`, and the model for instruments. Results from simulated logs are labelled so.
    pub fn read<'a, R: Recorded>(
        &self,
        vessel: &'a Vessel,
        provenance: &mut Provenance,
        recorded: impl FnOnce(&Path, &Vessel, &mut Provenance) -> Result<R, Failure>,
    ) -> Result<(PooledRuns<R>, Pool<'a>), Failure>
    where
        files::Error: From<R::Error>,
    {
        if let Some(Held::Former(path)) = &self.prior {
            return Err(Failure::Usage(format!(
                "--prior: found {} for a vessel with terms per sample, expected a number from 0.0 on; correct it",
                path.display()
            )));
        }
        let strength = not_below("--prior", self.strength(), 0.0)?;
        let nominal = self.nominal().read(vessel, provenance)?;
        let (runs, constant) = self.of.read(vessel, provenance, recorded)?;
        let rate_hz = vessel.sample_rate_hz;
        let part_samples = self.part_s.map(|s| samples("--part-s", s, rate_hz)).transpose()?;
        let removal = self.mean_removal;
        let pool = Pool { removal, strength, nominal, part_samples, constant, ..Pool::new(vessel) };
        pool.check().map_err(|e| Failure::invalid(&self.vessel, &e))?;
        Ok((runs, pool))
    }

    /// The pull to nominal values.
    fn strength(&self) -> f64 {
        if let Some(Held::Strength(strength)) = self.prior { strength } else { 0.0 }
    }

    /// Refuses flags of regressions for a ship with forces.
    pub fn check_forces(&self) -> Result<(), Failure> {
        let flags = [
            ("--nominal", self.nominal.is_some()),
            ("--part-s", self.part_s.is_some()),
            ("--mean-removal", self.mean_removal != MeanRemoval::Complete),
        ];
        none_given(flags, "a ship with forces, which has no instruments", "terms per sample")
    }

    /// The source of instruments.
    pub fn nominal(&self) -> Nominal {
        self.nominal.clone().unwrap_or_default()
    }
}

impl Nominal {
    /// Its name in files.
    pub fn source(&self) -> NominalSource {
        match self {
            Self::Given => NominalSource::Given,
            Self::LeastSquares => NominalSource::LeastSquares,
            Self::File(_) => NominalSource::Estimate,
        }
    }

    /// The model that it names.
    pub fn read(&self, vessel: &Vessel, provenance: &mut Provenance) -> Result<NominalModel, Failure> {
        provenance.settings.insert("nominal".into(), json!(self.source()));
        match self {
            Self::Given => Ok(NominalModel::Known(vessel.nominal.clone())),
            Self::LeastSquares => Ok(NominalModel::Fitted),
            Self::File(path) => {
                let estimate: EstimateDocument = inputs::document(path, "nominal", provenance)?;
                let mean = estimate.mean(vessel).map_err(|e| Failure::invalid(path, &e))?;
                Ok(NominalModel::Known(mean))
            }
        }
    }
}

impl FromStr for Nominal {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(match text {
            "given" => Self::Given,
            "least-squares" => Self::LeastSquares,
            file => Self::File(file.into()),
        })
    }
}

refusal::choices! {
    /// What an estimate is of.
    pub enum FitKind {
        /// Each run by itself.
        Each = "each",
        /// All runs or recordings together.
        Together = "together",
    }
}

/// How runs or recordings are left out: each on its own, or dealt into so many folds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Folds(pub Option<u16>);

impl FromStr for Folds {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.parse() {
            Ok(count @ 2..) => Ok(Self(Some(count))),
            _ if text == "each" => Ok(Self(None)),
            _ => Err("expected `each` or a whole number from 2 on"),
        }
    }
}

/// Estimates a model's parameters with standard errors: of each simulated run, or one model of all recordings; writes estimate.json,
/// estimates.parquet, and of one model model.json, which stands for a vessel.toml
#[derive(Clone, Debug, Parser)]
#[command(
    name = "estimate",
    after_help = "Example:\n  estimate --vessel pipelines/paper/vessel.toml --trajectories campaign.parquet --out results/\n  \
    estimate --vessel vessel.toml --trajectories out/measured/trajectories.parquet --out model/",
    mut_arg("trajectories", |runs| runs.required(false).required_unless_present("gather"))
)]
pub struct EstimateArguments {
    #[command(flatten)]
    pub flags: PoolFlags,
    /// What is estimated [default: each simulated run, recordings together]
    #[arg(long, value_parser = choice(&FitKind::ALL, FitKind::name, FitKind::description))]
    pub fit: Option<FitKind>,
    /// The model of all runs together [default: of six recordings or more `library`, of a ship with forces `average`; of fewer `core`,
    /// of a ship with forces `own`; of simulated runs and with --estimator `own`]
    #[arg(long, help_heading = "One model of all", value_parser = choice(&ModelStructure::ALL, ModelStructure::name, ModelStructure::description))]
    pub structure: Option<ModelStructure>,
    /// The estimators, with commas between them; the first makes the model of all together, of each run the default one leads
    /// [default: `prediction-error` for measured logs, or `output-error` where no noise known here describes their errors, and of
    /// forces; of simulated trials and with --prior `iv`]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = choice(&Estimator::POOLED, Estimator::name, Estimator::description))]
    pub estimator: Vec<Estimator>,
    /// Of each run: what disturbs it, for `prediction-error` and standard errors of `output-error`, which else find the noise of
    /// each run by itself, and to ask the runs what the model lacks
    #[arg(long, help_heading = "An estimate of each run", value_name = "campaign.toml")]
    pub campaign: Option<PathBuf>,
    #[command(flatten, next_help_heading = "How it is fitted")]
    pub additional: AdditionalFlags,
    /// Of each run: `covariance` writes covariances.parquet, the covariances of its parameters
    #[arg(long, help_heading = "An estimate of each run", value_name = "LIST", value_parser = ["covariance"], conflicts_with_all = ["shard", "gather"])]
    pub keep: Option<String>,
    /// Resamples of the bootstrap over sub-experiments; of `few` terms over recordings, 50 without it
    #[arg(long, help_heading = "One model of all", value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1_000_000))]
    pub bootstrap: Option<u32>,
    /// Leaves recordings out, each or in N folds, and scores the estimators on them; a search has 6 folds without it
    #[arg(long, help_heading = "One model of all", value_name = "each|N")]
    pub folds: Option<Folds>,
    /// Scores models over windows of this length, side by side [s]; whole runs without it
    #[arg(long, help_heading = "One model of all", value_name = "S")]
    pub window_s: Option<f64>,
    /// Length of the windows that are fitted, of a search and of forces [s] [default: 60; of forces 100, at most]
    #[arg(long, help_heading = "How it is fitted", value_name = "S")]
    pub fitted_window_s: Option<f64>,
    /// Of a ship with forces: values of captive tests under `derivatives`, to set beside the estimates
    #[arg(long, help_heading = "One model of all", value_name = "reference.toml")]
    pub reference: Option<PathBuf>,
    /// The design of this trial, with its moments.json beside it: says what became of its promise
    #[arg(long, help_heading = "One model of all", value_name = "design.json")]
    pub promised: Option<PathBuf>,
    #[command(flatten, next_help_heading = "In parts")]
    pub sharding: Sharding,
}

impl EstimateArguments {
    /// The files that are read.
    pub fn inputs(&self) -> impl Iterator<Item = &PathBuf> {
        let given = [&self.reference, &self.promised].into_iter().flatten();
        self.flags.inputs().chain(given).chain(&self.sharding.gather)
    }

    /// The length in samples of windows that models are scored over.
    pub fn scored(&self, vessel: &Vessel) -> Result<Option<usize>, Failure> {
        self.window_s.map(|s| samples("--window-s", s, vessel.sample_rate_hz)).transpose()
    }

    /// The design of the trial, with what it was made from beside it.
    pub fn promised(&self, common: &Common) -> Result<Option<(Promised, Provenance)>, Failure> {
        let Some(design) = &self.promised else { return Ok(None) };
        let mut noted = common.provenance("estimate");
        let [moments, figures] =
            ["moments.json", "merit.json"].map(|name| beside(design, "design.json", name));
        let known: DesignDocument = read_document(design)?.data;
        let figures = Some(figures.as_path()).filter(|file| known.figures.is_some() && files::exists(file));
        Ok(Some((Promised::read(design, &moments, figures, &mut noted)?, noted)))
    }

    /// What became of the promise of the design, by the `model` of its trial. The estimate may be by another vessel.toml, with other
    /// nominal values.
    pub fn promise(
        &self,
        promised: Option<(Promised, Provenance)>,
        model: Option<&ModelDocument>,
        provenance: &mut Provenance,
    ) -> Result<Option<PromiseUpdate>, Failure> {
        let (Some((of, mut noted)), Some(design), Some(model)) = (promised, &self.promised, model) else {
            return Ok(None);
        };
        let (file, mut from) = (self.flags.of.file(), provenance.clone());
        let others: Vec<&str> = STUDY_ROLES.into_iter().filter(|role| *role != "design").collect();
        from.forget(&others);
        if let Some(digest) = provenance.inputs.get("trajectories") {
            noted.made("trajectories", file, *digest, &from)?;
        }
        let roles =
            [("design", "promised"), ("moments", "promised:moments"), ("figures", "promised:figures")];
        let known =
            roles.iter().filter_map(|(role, name)| Some(((*name).to_owned(), *noted.inputs.get(*role)?)));
        provenance.inputs.extend(known);
        provenance.read.extend(noted.read);
        let updated = Updating::new(&of).after(model);
        updated.map(Some).map_err(|e| match e {
            UpdateError::Design(e) => Failure::invalid(design, &e),
            UpdateError::Model(e) => Failure::invalid(file, &e),
        })
    }

    /// Refuses the first of `flags` that is given, which `structure` does not have.
    pub fn check_none<const N: usize>(
        &self,
        structure: ModelStructure,
        flags: [(&str, bool); N],
    ) -> Result<(), Failure> {
        none_given(flags, &format!("structure `{structure}`"), "another --structure")
    }
}

/// Where the files of one model are written.
#[derive(Default)]
pub struct SetPaths {
    /// What --out names.
    pub main: PathBuf,
    /// estimates.parquet.
    pub table: PathBuf,
    /// estimate.json.
    pub document: PathBuf,
    /// model.json.
    pub model: PathBuf,
}

impl SetPaths {
    /// Those of `asked`: --out names the document, or the table where there is one.
    pub fn of(common: &Common, asked: &EstimateArguments, has_table: bool) -> Result<Self, Failure> {
        let is_table =
            has_table && common.out.extension().is_some_and(|end| end.eq_ignore_ascii_case("parquet"));
        let usual = if is_table { "estimates.parquet" } else { "estimate.json" };
        let main = common.main_output(usual, asked.inputs())?;
        let of = |name: &str| match name == usual {
            true => Ok(main.clone()),
            false => member(&main, usual, name, asked.inputs()),
        };
        let [table, document, model] = ["estimates.parquet", "estimate.json", "model.json"].map(of);
        Ok(Self { table: table?, document: document?, model: model?, main })
    }
}

/// Notes settings that are not empty.
pub fn note(settings: impl IntoIterator<Item = (&'static str, Value)>, provenance: &mut Provenance) {
    let given = settings.into_iter().filter(|(_, value)| *value != json!([]) && !value.is_null());
    provenance.settings.extend(given.map(|(key, value)| (key.to_owned(), value)));
}

/// What is said of a model besides, in a line.
pub fn besides(left_out: Option<&LeftOutScores>, promise: Option<&PromiseUpdate>) -> Option<String> {
    let scored = |found: &LeftOutScores| {
        let said = found.statements.join("; ");
        format!("left out: {} windows, {} folds; {said}", found.windows, found.folds)
    };
    let all: Vec<String> =
        left_out.map(scored).into_iter().chain(promise.map(PromiseUpdate::summary)).collect();
    (!all.is_empty()).then(|| all.join("; "))
}
