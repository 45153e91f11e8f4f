//! Inputs of stages that pool sub-experiments.

use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;
use estimation::pooled::Pool;
use files::{Digest, Provenance};
use regression::MeanRemoval;
use regression::pooled::{NominalModel, NominalSource, PooledRuns, Recorded};
use seatrial::core_of;
use serde_json::{Value, json};
use ship::model::Vessel;
use study::Doubtful;
use study::documents::{EstimateDocument, IngestDocument};
use study::trajectories::label;

use crate::cli::{Allowed, allowance, choice, none_given, not_below, samples};
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
    trajectories: Option<PathBuf>,
    /// What `ingest` wrote with the trajectories: names the recordings that runs were cut from [default: ingest.json beside them]
    #[arg(long, value_name = "ingest.json")]
    pub recordings: Option<PathBuf>,
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
    /// Reads the runs with `recorded`, and finds their constant logged channels. Results from simulated logs are
    /// labelled so.
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
        let recordings = self.recordings.clone().or_else(|| ingested_with(self.file()));
        let read = |path: PathBuf| inputs::document::<IngestDocument>(&path, "recordings", provenance);
        let recordings = recordings.map(read).transpose()?;
        let named = recordings.as_ref().map(IngestDocument::recordings_by_run).unwrap_or_default();
        let mut runs = PooledRuns::of(kept, &named).map_err(files::Error::from)?;
        label(runs.designs(), provenance);
        let selected = runs.select(&self.runs, &self.leave_out);
        selected.map_err(|e| Failure::invalid(self.file(), &e.invalid()))?;
        if !self.allow.contains(&Allowed::Doubtful) {
            Doubtful::of(provenance).check(self.file(), |run| runs.has(run))?;
        }
        Ok((runs, recordings.as_ref().map(IngestDocument::constant_channels).unwrap_or_default()))
    }

    /// As [`Self::read`], for forces: inputs of simulated runs are held during samples.
    pub fn read_of_forces(
        &self,
        vessel: &Vessel,
        provenance: &mut Provenance,
    ) -> Result<PooledRuns, Failure> {
        let (runs, _) = self.read(vessel, provenance, inputs::runs)?;
        Ok(runs.with_inputs_held(inputs::are_simulated(self.file(), vessel)?))
    }

    /// The files that are read.
    pub fn inputs(&self) -> impl Iterator<Item = &PathBuf> {
        self.trajectories.iter().chain(&self.recordings)
    }

    /// The file with the runs; the command line has one.
    pub fn file(&self) -> &Path {
        self.trajectories.as_deref().unwrap_or(Path::new(""))
    }
}

/// `ingest.json` beside `trajectories`, if it was written with them.
fn ingested_with(trajectories: &Path) -> Option<PathBuf> {
    let path = trajectories.with_file_name("ingest.json");
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
    /// Takes a core of some seven terms instead of the vessel's: resistance, drive and what steers
    #[arg(long)]
    core: bool,
    /// Which runs
    #[command(flatten)]
    pub of: RunFlags,
    /// How the instruments' mean is removed
    #[arg(long, value_parser = choice(&MeanRemoval::ALL, MeanRemoval::name, MeanRemoval::description), default_value_t = MeanRemoval::Complete)]
    pub mean_removal: MeanRemoval,
    /// Cuts longer sub-experiments, so that instruments start anew at least this often [s]
    #[arg(long, value_name = "S")]
    pub part_s: Option<f64>,
    /// The nominal model that instruments are simulated with: `given` in vessel.toml, `least-squares` (the fit of the same
    /// data), or a previous estimate.json
    #[arg(long, value_name = "given|least-squares|FILE")]
    pub nominal: Option<Nominal>,
    /// Pull towards the nominal model, on the scale of correlations; 0.03 is mild. Of a ship with forces: the weight of
    /// her priors, or the model of a former fit or of a sister's
    #[arg(long, value_name = "STRENGTH|model.json")]
    pub prior: Option<Held>,
}

impl PoolFlags {
    /// Notes a stage's `settings`, and the pooled runs and their parts; omits empty or absent ones.
    pub fn note<const N: usize>(&self, settings: [(&str, Value); N], provenance: &mut Provenance) {
        let pooled = [
            ("runs", json!(self.of.runs)),
            ("leave_out", json!(self.of.leave_out)),
            ("part_s", json!(self.part_s)),
            ("mean_removal", json!(self.mean_removal)),
            ("prior", json!(self.strength())),
            ("core", json!(Some(true).filter(|_| self.core))),
        ];
        let given = |(_, value): &(&str, Value)| *value != json!([]) && !value.is_null();
        let all = settings.into_iter().chain(pooled).filter(given);
        provenance.settings.extend(all.map(|(key, value)| (key.to_owned(), value)));
    }

    /// `vessel`, or her core of terms per sample where that is asked for.
    pub fn cored(&self, vessel: Vessel) -> Result<Vessel, Failure> {
        if !self.core {
            return Ok(vessel);
        }
        none_given([("--core", vessel.model.forces.is_some())], "a ship with forces", "terms per sample")?;
        core_of(&vessel).map_err(|e| Failure::invalid(&self.vessel, &e))
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
