//! Measured logs to runs, runs to one model, and models on recordings that they were not fitted to.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use estimation::Estimator;
use estimation::pooled::{Judgement, Pool, PoolError, Resampling, estimate, unstated};
use estimation::runs::AdditionalUnknowns;
use files::{Error, Provenance, Scratch};
use logs::{BLOCK, Plan, Source, Totals, check_intervals};
use rayon::prelude::*;
use refusal::{Invalid, listed};
use regression::pooled::{NominalModel, NominalSource, PooledRuns, Recorded};
use study::documents::{IngestDocument, RecordingSummary};
use study::files::read_ingest;
use study::ingest_file::read::recorded;
use study::ingest_file::recordings::find;
use study::ingest_file::{IngestFile, simulated_label};
use study::pooled_set::PooledSet;
use study::trajectories::DataLabel;
use study::{Doubtful, Tried};
use validation::comparison::{
    CompareOptions, Compared, Contestant, EstimatedErrors, Magnitudes, Ship, Standing, Traced, compare,
};
use validation::crossval::CrossError;

use ship::engine::Run;
use ship::model::Vessel;

/// Logs as `ingest.toml` describes them.
#[derive(Clone, Debug)]
pub struct Logs {
    /// Its keys; the design of simulated logs is their label.
    pub config: IngestFile,
    /// The use of their channels.
    pub plan: Plan,
    /// The recordings, each with its files.
    pub sources: Vec<Source>,
    /// The folder that the files' names are relative to.
    pub folder: PathBuf,
    /// The label of the logs, if they are not those of a real ship.
    pub label: Option<DataLabel>,
    /// `ingest.toml`.
    file: PathBuf,
    /// Name of the vessel.
    vessel: Option<String>,
}

impl Logs {
    /// The logs that `ingest.toml` at `file` describes, next to it, with the channels that `vessel` needs.
    ///
    /// # Errors
    /// Files that are refused; channels that nothing provides.
    pub fn read(file: &Path, vessel: &Vessel) -> Result<Self, Error> {
        let mut provenance = Provenance::default();
        let config = read_ingest(file, &mut provenance)?;
        Self::of(file, config, Some((vessel, "the vessel")), None, &mut provenance)
    }

    /// The logs that `config`, the contents of `file`, describes, in `folder` or next to `file`, with the channels
    /// that the named vessel needs, or all. The sources of simulated logs are noted in `provenance`.
    ///
    /// # Errors
    /// See [`Logs::read`].
    pub fn of(
        file: &Path,
        mut config: IngestFile,
        vessel: Option<(&Vessel, &str)>,
        folder: Option<&Path>,
        provenance: &mut Provenance,
    ) -> Result<Self, Error> {
        let refuse = |invalid| Error::invalid(file, invalid);
        let plan = Plan::new(config.setup().map_err(refuse)?, vessel).map_err(refuse)?;
        let folder = folder.or(file.parent()).unwrap_or(Path::new("")).to_owned();
        let naming = config.naming().map_err(refuse)?;
        let sources = find(&config, &naming, file, &folder)?;
        check_intervals(&config.segment, &sources).map_err(refuse)?;
        let label = simulated_label(&folder, &sources, provenance)?;
        if let Some(label) = label {
            config.design = label.to_string();
            label.label(provenance);
        }
        let vessel = vessel.map(|(vessel, _)| vessel.name.clone());
        Ok(Self { config, plan, sources, folder, label, file: file.to_owned(), vessel })
    }

    /// Reads all recordings into memory.
    ///
    /// # Errors
    /// Files that are refused; no sub-experiment long enough.
    pub fn ingested(&self) -> Result<Ingested, Error> {
        let scratch = Arc::new(Scratch::new(Path::new(""), BLOCK, f64::INFINITY));
        let segmentation = self.config.segmentation();
        let read = |source| recorded(&self.plan, &segmentation, &self.folder, source, &scratch);
        let all: Vec<_> = self.sources.par_iter().map(read).collect();
        let (mut totals, mut recordings, mut runs) = (Totals::default(), Vec::new(), Vec::new());
        for one in all {
            let (mut recorded, _) = one?;
            totals.number(&mut recorded);
            let width = self.plan.exogenous.len();
            runs.extend(recorded.runs.iter().map(|run| run.run(&self.config.design, width)));
            recordings.push(recorded.summary);
        }
        Ok(Ingested { runs, document: self.document(totals, recordings)? })
    }

    /// `ingest.json` of recordings with these `totals`.
    ///
    /// # Errors
    /// No run at all.
    pub fn document(
        &self,
        totals: Totals,
        recordings: Vec<RecordingSummary>,
    ) -> Result<IngestDocument, Error> {
        if totals.runs == 0 {
            let found = format!("none of {} recordings", self.sources.len());
            let expected = "at least one that is long enough";
            let remedy = "lower `min_s` or `window_s`, or correct the segments";
            return Err(Error::refuse(&self.file, "sub-experiments", found, expected, remedy));
        }
        Ok(IngestDocument {
            vessel: self.vessel.clone(),
            design: self.config.design.clone(),
            data: self.label,
            reference_point: self.config.reference_point.clone(),
            sample_rate_hz: self.config.sample_rate_hz,
            runs: u64::from(totals.runs),
            samples: totals.samples,
            maneuvers: totals.maneuvers,
            recordings,
        })
    }
}

/// Ingested logs.
#[derive(Clone, Debug)]
pub struct Ingested {
    /// The runs that recordings were cut into.
    pub runs: Vec<Run>,
    /// `ingest.json`: the recordings, and the quality of their data.
    pub document: IngestDocument,
}

impl Ingested {
    /// The runs, by their recordings.
    ///
    /// # Errors
    /// Inconsistent recordings: see `doubtful` in the document.
    pub fn pooled(self) -> Result<PooledRuns, Error> {
        Doubtful::among(&self.document.recordings).check(Path::new("logs"), |_| true)?;
        Ok(PooledRuns::new(self.runs, &self.document.recordings_by_run()))
    }
}

/// Options of a model from several runs.
#[derive(Clone)]
pub struct Pooling<'a> {
    /// The vessel, the removal of means, the model of the instruments, the additional unknowns.
    pub pool: Pool<'a>,
    /// The source of the nominal model of instruments.
    pub nominal: NominalSource,
    /// Number of resamples of sub-experiments, and their seed.
    pub judgement: Judgement,
}

/// A remark if no estimator was requested.
const NO_NOISE: &str = "estimated by `output-error`: no noise known here describes the errors, and filters for another one predict worse; \
     --estimator takes others";

impl<'a> Pooling<'a> {
    /// Defaults for `vessel`: instruments by its nominal values, no resamples.
    pub fn new(vessel: &'a Vessel) -> Self {
        let judgement = Judgement { replicates: 0, seed: 1 };
        Self { pool: Pool::new(vessel), nominal: NominalSource::Given, judgement }
    }

    /// The same with instruments by least squares of the same data.
    #[must_use]
    pub fn by_least_squares(mut self) -> Self {
        (self.pool.nominal, self.nominal) = (NominalModel::Fitted, NominalSource::LeastSquares);
        self
    }

    /// The model of `runs`, by the requested estimator `asked`, or the default for measured logs.
    ///
    /// # Errors
    /// Parameters that the runs do not determine; a failed search; runs that cannot be read again.
    pub fn model<R: Recorded>(
        &self,
        runs: &PooledRuns<R>,
        asked: Option<Estimator>,
    ) -> Result<PooledSet, PoolError<R::Error>> {
        if let Err(refused) = self.pool.vessel.check_terms("estimate --fit together") {
            return Err(PoolError::NotIdentifiable(vec![refused.to_string()]));
        }
        let estimator = match asked.or_else(|| self.pool.usual(false)) {
            Some(estimator) => estimator,
            None => unstated(&self.pool, runs)?,
        };
        self.judged(runs, (estimator, asked.is_none()), Resampling::Drawn(&|_| ()))
    }

    /// The model of `runs` by this estimator; and whether that was the default.
    ///
    /// # Errors
    /// See [`Pooling::model`].
    pub fn judged<R: Recorded>(
        &self,
        runs: &PooledRuns<R>,
        (estimator, is_usual): (Estimator, bool),
        resampling: Resampling,
    ) -> Result<PooledSet, PoolError<R::Error>> {
        let Self { pool, judgement, .. } = self;
        let mut judged = estimate(pool, runs, estimator, judgement, resampling)?;
        if is_usual && estimator == Estimator::OutputError && pool.additional == AdditionalUnknowns::default()
        {
            judged.statements.insert(0, NO_NOISE.to_owned());
        }
        let made = (estimator, judgement.replicates);
        let mut set = PooledSet::new(pool, self.nominal, made, &judged);
        if let Some(model) = &mut set.model {
            let Vessel { model: of, sample_rate_hz, .. } = pool.vessel;
            model.magnitudes = Magnitudes::of(of, runs, *sample_rate_hz).map_err(PoolError::Unread)?;
        }
        Ok(set)
    }
}

/// Compares a model with least squares of the same data, the mean of the recordings, and other models.
pub struct Comparison<'a> {
    /// The model, or several whose trajectories are averaged.
    pub model: &'a Tried,
    /// Other models.
    pub others: &'a [Vessel],
    /// Length of the simulated windows in samples; whole runs without it.
    pub window: Option<usize>,
}

/// The vessel whose channels runs are read with: the first one with the most.
pub fn widest<'a>(vessels: &[&'a Vessel]) -> Option<&'a Vessel> {
    vessels.iter().rev().copied().max_by_key(|vessel| vessel.model.exogenous())
}

/// Where the inputs and measured disturbances of `vessel` stand in the rows of `widest`.
///
/// # Errors
/// Another sampling rate; a channel that `widest` does not have, or computes otherwise.
pub fn channels_within(vessel: &Vessel, widest: &Vessel) -> Result<Vec<usize>, Invalid> {
    let rates = [vessel, widest].map(|vessel| vessel.sample_rate_hz);
    if rates[0] != rates[1] {
        let [found, expected] = rates.map(|rate| format!("{rate} Hz"));
        return Err(Invalid::new("sampling rate", found, expected, "compare models of the same logs"));
    }
    let formula = |of: &Vessel, place: usize| {
        of.model.derived.iter().find(|derived| derived.variable == place).map(|derived| derived.text.clone())
    };
    let all = &widest.model.variables;
    let column = |place: usize| {
        let channel = &vessel.model.variables[place];
        let same = |i: &usize| {
            let texts = (formula(vessel, place), formula(widest, *i));
            let otherwise = matches!(texts, (Some(text), Some(other)) if text != other);
            all[*i].name == channel.name && all[*i].unit == channel.unit && !otherwise
        };
        (3..all.len()).find(same).map(|i| i - 3).ok_or_else(|| {
            let names: Vec<&str> = all[3..].iter().map(|variable| variable.name.as_str()).collect();
            Invalid::new(
                format!("channel `{}` in {}", channel.name, channel.unit),
                "a channel of this model alone",
                format!("those of the model with the most: {}", names.join(", ")),
                "compare models of the same logs",
            )
        })
    };
    (3..vessel.model.variables.len()).map(column).collect()
}

impl<'a> Comparison<'a> {
    /// Of `model` over whole runs, with no other.
    pub fn of(model: &'a Tried) -> Self {
        Self { model, others: &[], window: None }
    }

    /// All vessels that are simulated.
    pub fn vessels(&self) -> Vec<&'a Vessel> {
        self.model.vessels().iter().chain(self.others).collect()
    }

    /// The verdict of `runs`, which have the channels of [`widest`], and the model's simulation of them sample by sample.
    ///
    /// # Errors
    /// Channels that are not those of the runs; no run as long as a window.
    pub fn over(&self, runs: &PooledRuns) -> Result<(Compared, Vec<Traced>), ComparisonError> {
        let vessels = self.vessels();
        let lead = widest(&vessels).unwrap_or_else(|| self.model.vessel());
        let columns =
            vessels.iter().map(|vessel| channels_within(vessel, lead)).collect::<Result<Vec<_>, _>>()?;
        let contestants = self.contestants(lead, &columns);
        let known: Vec<EstimatedErrors> = self.model.known().into_iter().collect();
        let (covered, magnitudes) = (self.model.covered(), self.model.magnitudes());
        let (window, rate_hz) = (self.window, lead.sample_rate_hz);
        let vessel = &self.model.vessel().name;
        let options = CompareOptions { vessel, window, known: &known, covered, magnitudes, rate_hz };
        let (mut compared, trace) = compare(&contestants, runs, &options)?;
        let short = runs.windows(window).into_iter().filter(|(_, windows)| windows.is_empty());
        let short: Vec<String> = short.map(|(name, _)| name).collect();
        if !short.is_empty() {
            compared.statements.push(format!("shorter than a window and not compared: {}", listed(&short)));
        }
        Ok((compared, trace))
    }

    /// The model or the average, its models alone, and what it is compared with. `columns` are those of all vessels.
    fn contestants<'b>(&self, lead: &Vessel, columns: &'b [Vec<usize>]) -> Vec<Contestant<'b>>
    where
        'a: 'b,
    {
        let model = self.model;
        let whole = |columns: &[usize]| columns.iter().copied().eq(0..lead.model.exogenous());
        let of = |columns: &'b Vec<usize>| Some(columns.as_slice()).filter(|columns| !whole(columns));
        let all: Vec<Ship<'b>> =
            self.vessels().into_iter().zip(columns).map(|(vessel, from)| ship(vessel, of(from))).collect();
        let (several, others) = all.split_at(model.vessels().len());
        let one = |standing, ships: &[Ship<'b>]| Contestant { standing, place: None, ships: ships.to_vec() };
        let mut contestants = vec![one(model.standing(), several)];
        // Models of several kinds, not of one search
        let kinds = several.len() > 1 && several.iter().any(|ship| !ship.model.has_regressors());
        let alone = several.iter().enumerate().filter(|_| kinds);
        contestants.extend(alone.map(|(i, ship)| Contestant {
            place: Some(i as u64 + 1),
            ..one(Standing::Averaged, std::slice::from_ref(ship))
        }));
        let place = |i: usize| Some(i as u64 + 2).filter(|_| others.len() > 1);
        contestants.extend(others.iter().enumerate().map(|(i, ship)| Contestant {
            place: place(i),
            ..one(Standing::Other, std::slice::from_ref(ship))
        }));
        let same = model.by_least_squares().map(|vessel| ship(vessel, columns.first().and_then(of)));
        contestants.extend(same.map(|ship| one(Standing::LeastSquares, &[ship])));
        contestants
    }
}

fn ship<'b>(vessel: &'b Vessel, columns: Option<&'b [usize]>) -> Ship<'b> {
    Ship { model: &vessel.model, theta: &vessel.nominal, columns }
}

/// Why models were not compared.
#[derive(Debug, thiserror::Error)]
pub enum ComparisonError {
    /// Channels that do not belong together.
    #[error("{0}")]
    Channels(#[from] Invalid),
    /// Nothing can be simulated.
    #[error("{0}")]
    Windows(#[from] CrossError),
}

impl ComparisonError {
    /// What is invalid.
    pub fn invalid(&self) -> Invalid {
        match self {
            Self::Channels(invalid) => invalid.clone(),
            Self::Windows(error) => error.invalid(),
        }
    }
}
