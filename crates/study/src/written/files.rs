//! The hand-written files of a study, read and checked, and their schemas.

use std::path::{Path, PathBuf};

use files::{Digest, Error, Provenance, read_document};
use maneuver::Generator;
use refusal::Invalid;
use schemars::{JsonSchema, schema_for};
use serde_json::Value;
use ship::engine::Run;
use ship::model::{Source, VesselFile};
use validation::comparison::{Counter, Outside, Validity};

use crate::documents::{ModelDocument, Reference};
use crate::plan::PlanFile;
use crate::tables::trajectories::{Layout, TrajectoryReader};
use crate::written::campaign_file::CampaignFile;
use crate::written::ingest_file::IngestFile;
use crate::written::logs_file::LogsFile;

// Types of the hand-written files.
pub use maneuver::DictionaryFile;
pub use ship::model::{Variable, Vessel};

/// A reader of vessels: which kinds of models a stage takes.
pub type VesselReader = fn(&Path, &mut Provenance) -> Result<Vessel, Error>;

/// As [`read_any_vessel`], where terms per sample are needed: a ship with forces is refused.
pub fn read_vessel(path: &Path, provenance: &mut Provenance) -> Result<Vessel, Error> {
    let vessel = read_any_vessel(path, provenance)?;
    let stage = provenance.producer.split(' ').next().unwrap_or_default();
    vessel.check_terms(stage).map_err(|e| crate::invalid(path, &e))?;
    Ok(vessel)
}

/// A stage that computes with terms per sample alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StageOfTerms {
    /// Trials in rounds.
    Sequential,
    /// `design --refine`.
    Refine,
    /// `validate --design`.
    Selection,
}

impl StageOfTerms {
    /// Its name, and what serves a ship with forces instead.
    fn named(self) -> [&'static str; 2] {
        match self {
            Self::Sequential => [
                "trials in rounds",
                "try trials that are designed once by `monte-carlo --estimator output-error`",
            ],
            Self::Refine => ["design --refine", "take the shares of `design --for output-error`"],
            Self::Selection => ["validate --design", "leave recordings out by `estimate --folds`"],
        }
    }

    /// As [`read_any_vessel`] for this stage.
    ///
    /// # Errors
    /// A file that is refused; a ship with forces, with what serves her.
    pub fn read(self, path: &Path, provenance: &mut Provenance) -> Result<Vessel, Error> {
        let vessel = read_any_vessel(path, provenance)?;
        let [name, instead] = self.named();
        let remedy = format!("{instead}, or give it a vessel with terms per sample");
        vessel.check_terms(name).map_err(|e| crate::invalid(path, &Invalid { remedy, ..e }))?;
        Ok(vessel)
    }

    /// As [`Self::read`], with the disturbances held of trials that are simulated: a model's runs follow the model.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_simulated(self, path: &Path, provenance: &mut Provenance) -> Result<Vessel, Error> {
        self.read(path, provenance).map(|vessel| followed(path, vessel).with_disturbances_held())
    }
}

/// Reads `vessel.toml`, or a `model.json` in its place, and notes its digest. A model starts a new study: its own
/// inputs are not part of that. The model may have terms per sample or forces.
pub fn read_any_vessel(path: &Path, provenance: &mut Provenance) -> Result<Vessel, Error> {
    if is_model(path) {
        let read = read_document::<ModelDocument>(path)?;
        provenance.written("vessel", path, read.digest)?;
        return read.data.vessel().map_err(|e| crate::invalid(path, &e));
    }
    let file: VesselFile = provenance.read_toml("vessel", "vessel", path)?;
    Vessel::from_file(file).map_err(|e| crate::invalid(path, &e))
}

/// As [`read_any_vessel`], noted as the input `role`: for stages that read several vessels.
pub fn read_any_vessel_as(role: &str, path: &Path, provenance: &mut Provenance) -> Result<Vessel, Error> {
    let mut noted = Provenance { changes: provenance.changes.clone(), ..Provenance::default() };
    let vessel = read_any_vessel(path, &mut noted)?;
    provenance.inputs.extend(noted.inputs.into_values().map(|digest| (role.to_owned(), digest)));
    provenance.read.extend(noted.read);
    provenance.settings.extend(noted.settings);
    Ok(vessel)
}

/// As [`read_any_vessel`], for stages whose runs may be simulated: those of a model follow the model.
pub fn read_any_followed(path: &Path, provenance: &mut Provenance) -> Result<Vessel, Error> {
    read_any_vessel(path, provenance).map(|vessel| followed(path, vessel))
}

/// As [`read_any_followed`], for stages that simulate trials or score simulated ones, which have no information about
/// disturbances that they hold constant.
///
/// # Errors
/// A file that is refused; a dead time, which simulations do not have.
pub fn read_any_simulated(path: &Path, provenance: &mut Provenance) -> Result<Vessel, Error> {
    let vessel = followed(path, read_any_vessel(path, provenance)?).with_disturbances_held();
    without_dead_time(path, vessel)
}

/// As [`read_any_vessel`], for plans and designs whose vessel is simulated with its nominal numbers: the ship may have forces.
///
/// # Errors
/// As [`read_any_simulated`].
pub fn read_planned(path: &Path, provenance: &mut Provenance) -> Result<Vessel, Error> {
    without_dead_time(path, read_any_vessel(path, provenance)?.with_disturbances_held())
}

fn without_dead_time(path: &Path, vessel: Vessel) -> Result<Vessel, Error> {
    if vessel.model.has_dead_time(&vessel.nominal) {
        let (found, expected) = ("a dead time above 0 s", "none: simulations give inputs as they act");
        return Err(Error::refuse(path, "`dead_time_s`", found, expected, "remove it for this stage"));
    }
    Ok(vessel)
}

/// The vessel of `path`, whose truth is the model where the file is one.
fn followed(path: &Path, vessel: Vessel) -> Vessel {
    let truth = vessel.nominal.iter().copied().map(Some).collect();
    if is_model(path) { Vessel { value: truth, ..vessel } } else { vessel }
}

/// The vessel at `path`; if it is a model, limited to the ranges of its data, unless it may go `beyond` them.
///
/// # Errors
/// A file that cannot be read.
pub fn kept_to_data(path: &Path, vessel: Vessel, beyond: bool) -> Result<Vessel, Error> {
    let model = if beyond { None } else { read_model(path)? };
    Ok(match model {
        Some(model) => model.kept_to_data(vessel),
        None => vessel,
    })
}

/// The `model.json` in a vessel's place; `None` for a `vessel.toml`.
pub fn read_model(path: &Path) -> Result<Option<ModelDocument>, Error> {
    is_model(path).then(|| read_document(path).map(|read| read.data)).transpose()
}

/// Whether the best known parameters of `vessel`, read from `path`, are a guess: nominal ones, no true ones and no estimates.
pub fn is_guess(path: &Path, vessel: &Vessel) -> bool {
    vessel.best_known() == Source::Nominal && !is_model(path)
}

fn is_model(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "json")
}

/// Reads `dictionary.toml` and notes its digest.
pub fn read_dictionary(
    path: &Path,
    vessel: &Vessel,
    provenance: &mut Provenance,
) -> Result<Generator, Error> {
    let file: DictionaryFile = provenance.read_toml("dictionary", "dictionary", path)?;
    generator(path, vessel, &file, provenance)
}

/// Reads `campaign.toml` and notes its digest.
pub fn read_campaign(path: &Path, provenance: &mut Provenance) -> Result<CampaignFile, Error> {
    let file: CampaignFile = provenance.read_toml("campaign", "campaign", path)?;
    Ok(file)
}

/// Reads `ingest.toml` and notes its digest.
pub fn read_ingest(path: &Path, provenance: &mut Provenance) -> Result<IngestFile, Error> {
    let file: IngestFile = provenance.read_toml("config", "ingest", path)?;
    file.check().map_err(|e| crate::invalid(path, &e))?;
    Ok(file)
}

/// Reads `reference.toml` and notes its digest as the input `role`.
pub fn read_reference(path: &Path, role: &str, provenance: &mut Provenance) -> Result<Reference, Error> {
    let file: Reference = provenance.read_toml(role, "reference", path)?;
    Ok(file)
}

/// Reads `plan.toml` and notes its digest; it is checked against a vessel by [`PlanFile::task`].
pub fn read_plan(path: &Path, provenance: &mut Provenance) -> Result<PlanFile, Error> {
    provenance.read_toml("plan", "plan", path)
}

/// Turns the maneuvers of `file`, read from `path`, into a generator; notes the digests of its input files.
pub fn generator(
    path: &Path,
    vessel: &Vessel,
    file: &DictionaryFile,
    provenance: &mut Provenance,
) -> Result<Generator, Error> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let digests = std::cell::RefCell::new(Vec::new());
    let read = |name: &str| {
        let text = files::read_to_string(folder.join(name)).map_err(|e| {
            let found = match e {
                Error::Io { source, .. } => source.to_string(),
                Error::Refused { invalid, .. } => invalid.found,
            };
            Invalid::new(format!("`file` {name}"), found, "a readable CSV file", "check the path")
        })?;
        digests.borrow_mut().push((format!("inputs:{name}"), Digest::of_bytes(text.as_bytes())));
        Ok(text)
    };
    let generator = Generator::new(vessel, file, read).map_err(|e| crate::invalid(path, &e))?;
    provenance.inputs.extend(digests.into_inner());
    if !generator.tables().is_empty() {
        let tables: Vec<String> = generator.tables().values().map(ToString::to_string).collect();
        provenance.settings.insert("tables".into(), tables.into());
    }
    Ok(generator)
}

/// The role of a file of this name for files made from it: one of [`files::STUDY_ROLES`]; the name itself if its
/// role is not unique.
pub fn role_of(name: &str) -> &str {
    match name {
        "vessel.toml" => "vessel",
        "dictionary.toml" => "dictionary",
        "campaign.toml" => "campaign",
        "moments.json" => "moments",
        "design.json" => "design",
        "validation.parquet" => "validation",
        "estimates.parquet" => "estimates",
        name => name,
    }
}

/// The path of `name` in the set of the main file `main`, usually called `usual`: if `main` has another name, so has
/// the file, so that two sets in one folder share none.
///
/// `estimate.json` belongs to `estimates.parquet`, `estimate-2.json` to `estimates-2.parquet`, and
/// `tank-estimate.json` to `tank.parquet`.
pub fn beside(main: &Path, usual: &str, name: &str) -> PathBuf {
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let (stem, usual) = (stem(main), stem(Path::new(usual)));
    let (start, end) = name.split_once('.').unwrap_or((name, ""));
    let name = match stem.strip_prefix(&usual) {
        Some(rest) => format!("{start}{rest}.{end}"),
        None => format!("{stem}-{name}"),
    };
    main.with_file_name(name)
}

/// Endings of files of other kinds: those that stages write, and that users may expect of them.
const KINDS: [&str; 33] = [
    "arrow", "bag", "c", "cpp", "csv", "dat", "feather", "gpkg", "gpx", "h5", "html", "ipynb", "json", "kml",
    "mat", "mcap", "md", "mo", "nc", "nmea", "npy", "npz", "parquet", "pdf", "png", "py", "rtz", "svg",
    "toml", "tsv", "txt", "xlsx", "yaml",
];

/// Refuses to write what is usually called `usual` to `out`, if that is named as another kind of file: readers would take it for
/// such a one.
///
/// # Errors
/// Names `out` and the ending that it needs.
pub fn check_kind(out: &Path, usual: &str) -> Result<(), Invalid> {
    let end = |path: &Path| path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match (end(out), end(Path::new(usual))) {
        (Some(found), Some(wanted)) if found != wanted && KINDS.contains(&found.as_str()) => {
            let expected = format!("a name that ends in .{wanted}, as {usual} does");
            let is_map = usual == "plan.json" && ["gpkg", "kml"].contains(&found.as_str());
            let maps = if is_map { ", and give maps the track.geojson or route.gpx beside it" } else { "" };
            let remedy = format!("write --out {}{maps}", out.with_extension(wanted).display());
            Err(Invalid::new("--out", out.display().to_string(), expected, remedy))
        }
        _ => Ok(()),
    }
}

/// Warnings about the runs in `out` that the model in the file `model` simulated, at its own rate or at `rate_hz`; empty for a
/// vessel.toml.
///
/// # Errors
/// Files that cannot be read.
pub fn beyond(model: &Path, out: &Path, rate_hz: Option<f64>) -> Result<Vec<String>, Error> {
    let Some(model) = read_model(model)? else { return Ok(Vec::new()) };
    let vessel = model.vessel().map_err(|e| crate::invalid(out, &e))?;
    let (layout, rate_hz) = (Layout::new(&vessel.model), rate_hz.unwrap_or(vessel.sample_rate_hz));
    let reader = TrajectoryReader::open(out, &layout, rate_hz)?;
    let (mut counter, mut validity) = (Counter::new(&model.covered), None);
    let mut magnitudes = model.magnitudes;
    // A disturbance with a stated value in simulations is not too small.
    for channel in magnitudes.iter_mut().flat_map(|known| &mut known.channels) {
        let place = vessel.model.variables.iter().position(|variable| variable.name == channel.name);
        if place.is_some_and(|place| vessel.model.simulated.contains_key(&place)) {
            channel.low = 0.0;
        }
    }
    for block in 0..reader.blocks() {
        let runs = reader.runs(block)?;
        runs.iter().for_each(|run| counter.add(&run.exogenous, &run.measured));
        let views = runs.iter().map(Run::view);
        let reached = magnitudes.as_ref().and_then(|known| Validity::of(known, views, rate_hz));
        validity = Validity::together(validity, reached);
    }
    let stretches = validity.as_ref().and_then(Validity::statement);
    Ok(stretches.into_iter().chain(counter.outside().iter().map(Outside::statement)).collect())
}

/// A kind of file, and what writes its schema.
type HandWrittenKind = (&'static str, fn() -> Value);

/// All of them.
const HAND_WRITTEN: [HandWrittenKind; 7] = [
    ("vessel", schema::<VesselFile>),
    ("dictionary", schema::<DictionaryFile>),
    ("campaign", schema::<CampaignFile>),
    ("plan", schema::<PlanFile>),
    ("logs", schema::<LogsFile>),
    ("reference", schema::<Reference>),
    ("ingest", schema::<IngestFile>),
];

/// The kinds of files with their schemas.
pub fn schemas() -> [(&'static str, Value); 7] {
    HAND_WRITTEN.map(|(kind, schema)| (kind, schema()))
}

fn schema<T: JsonSchema>() -> Value {
    schema_for!(T).to_value()
}

/// Name of the file with the schema of `kind`.
pub fn file_name(kind: &str) -> String {
    format!("{kind}-toml.schema.json")
}

/// The kind of a hand-written file by its name, which may go on after the kind: `plan-4-headings.toml` is a plan.
pub fn kind_of(name: &str) -> Option<&'static str> {
    let stem = name.strip_suffix(".toml")?;
    HAND_WRITTEN.into_iter().map(|(kind, _)| kind).find(|kind| stem.split('-').next() == Some(kind))
}
