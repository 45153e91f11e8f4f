use std::path::Path;

use files::{Digest, Error, Loaded, Provenance, exists, read_document};
use ship::engine::{Run, track};
use study::campaign_file::CampaignFile;
use study::documents::{
    CountedRuns, DesignDocument, DesignScores, EstimateDocument, IngestDocument, MeritDocument,
    MomentsDocument, PlanDocument, PromiseUpdate, Reference, ScoredEstimates, TrialsInRounds,
    ValidationDocument,
};
use study::files::{Variable, Vessel};
use study::scores;
use study::trajectories::{Layout, REACHED, TrajectoryReader};

use crate::loader::{Loader, Sources, document_at};
use crate::planned_trial::{PlannedTrial, map};

/// Everything that the page can show. Absent results are reported as missing.
#[derive(Clone, Debug, Default)]
pub struct Study {
    /// Name of the study: `paper`.
    pub name: String,
    /// Length of one experiment \[s\].
    pub experiment_s: Option<f64>,
    /// The model structure.
    pub vessel: Option<Vessel>,
    /// Every maneuver of the dictionary, in its order.
    pub dictionary: Option<Vec<ManeuverTrace>>,
    /// `moments.json`.
    pub moments: Option<MomentsDocument>,
    /// `design.json`.
    pub design: Option<DesignDocument>,
    /// Of `estimate.json`: what became of the promise; absent before the trial.
    pub update: Option<PromiseUpdate>,
    /// `estimate.json`, where it has estimates of single runs or of the vessel's terms.
    pub estimate: Option<EstimateDocument>,
    /// Of `validation.json`: estimates of simulated runs.
    pub validation: Option<ScoredEstimates>,
    /// Of `validation.json`: realizations in memory.
    pub counted: Option<CountedRuns>,
    /// The errors of every run by one estimator.
    pub scores: Option<Vec<scores::Row>>,
    /// The input that the estimated models were validated on.
    pub validation_trace: Option<ManeuverTrace>,
    /// Published results to compare with.
    pub reference: Option<Reference>,
    /// Figures of merit of standard maneuvers; absent in a study without.
    pub merit: Option<MeritDocument>,
    /// Models from picked sub-experiments; absent in a study without.
    pub selection: Option<super::SelectionStudy>,
    /// Results from measured logs; absent in a study of simulated trials.
    pub measured: Option<super::MeasuredStudy>,
    /// Trials designed in rounds against trials designed once.
    pub sequential: Option<TrialsInRounds>,
    /// Other studies' comparisons of estimators, to be shown side by side.
    pub scenarios: Vec<Scenario>,
    /// The planned trajectory; absent in a study that plans none.
    pub trajectory: Option<Trajectory>,
    /// The label of the data: `simulated logs`; absent for those of real ships and for simulation studies.
    pub data: Option<String>,
    /// The roles of files from different studies, if those were allowed.
    pub mixed: Vec<String>,
    /// Name of a file, what it is, its digest.
    pub files: Vec<(String, String, String)>,
}

/// Estimators compared under one kind of disturbance.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Name of its folder.
    pub name: String,
    /// Its `estimate.json`.
    pub estimate: EstimateDocument,
    /// The scores of its `validation.json`.
    pub validation: ScoredEstimates,
}

/// The results for a planned trajectory.
#[derive(Clone, Debug, Default)]
pub struct Trajectory {
    /// `plan.json`; absent if only `plan.toml` exists.
    pub main: Option<PlannedTrial>,
    /// `plan-*/plan.json`: variants of the plan.
    pub variants: Vec<PlannedTrial>,
    /// `planned/estimate.json`: estimates from simulated trials of the plan.
    pub estimate: Option<EstimateDocument>,
    /// `planned/validation.json`: errors of those estimates.
    pub validation: Option<ScoredEstimates>,
}

/// One maneuver over time. All vectors are as long as `t`; a value that is not finite is left out of the figures.
#[derive(Clone, Debug, Default)]
pub struct ManeuverTrace {
    /// Name in the dictionary.
    pub name: String,
    /// Its description in the dictionary; may be empty.
    pub description: String,
    /// What it was to reach, and did; may be empty.
    pub reached: String,
    /// Times \[s\].
    pub t: Vec<f64>,
    /// Name, unit and values of every input.
    pub inputs: Vec<(String, String, Vec<f64>)>,
    /// What was commanded of inputs whose actuators follow it, by their names.
    pub commands: Vec<(String, Vec<f64>)>,
    /// Surge speed \[m/s\].
    pub u: Vec<f64>,
    /// Sway speed \[m/s\].
    pub v: Vec<f64>,
    /// Yaw rate \[rad/s\].
    pub r: Vec<f64>,
    /// Position along the initial heading \[m\].
    pub x: Vec<f64>,
    /// Position to starboard of it \[m\].
    pub y: Vec<f64>,
}

/// The design that is shown first wherever designs are compared.
const FIRST: &str = "optimized";

/// `designs` in their order, except that the optimized one comes first.
pub(super) fn optimized_first<T>(designs: &[T], name: impl Fn(&T) -> &str) -> Vec<&T> {
    let mut ordered: Vec<&T> = designs.iter().collect();
    ordered.sort_by_key(|design| name(design) != FIRST);
    ordered
}

impl Study {
    /// The inputs that the vessel declares.
    pub(super) fn inputs(&self) -> &[Variable] {
        self.vessel.as_ref().map_or(&[], |Vessel { model, .. }| model.input_variables())
    }

    /// The designs of the validation, the optimized one first.
    pub(super) fn scored(&self) -> Vec<&DesignScores> {
        self.validation.iter().flat_map(|v| optimized_first(&v.designs, |d| &d.design)).collect()
    }
}

/// Maneuvers beyond this many are not drawn.
const MOST_TRACES: usize = 400;

/// Reads the existing results of a study.
///
/// # Errors
/// An existing file is refused; a study without a folder, a folder without any result.
pub fn load(sources: &Sources) -> Result<Study, Error> {
    check_study(&sources.study)?;
    let mut loader = Loader::new(sources);
    let vessel = loader.vessel()?;
    let campaign = loader.toml::<CampaignFile>("campaign.toml", "runs, disturbances, seed, validation")?;
    let maneuvers = loader.dictionary()?;
    let reference = loader.reference()?;
    let mut dictionary = loader.traces(&vessel, "dictionary.parquet", "maneuvers, undisturbed")?;
    let maneuvers = maneuvers.map(|file| file.expanded().unwrap_or_default()).unwrap_or_default();
    for trace in dictionary.iter_mut().flatten() {
        let maneuver = maneuvers.iter().find(|maneuver| maneuver.name == trace.name);
        trace.description = maneuver.map_or(String::new(), |maneuver| maneuver.description.clone());
    }
    let validation: Option<ValidationDocument> =
        loader.document("validation.json", "how good the models are")?;
    let ValidationDocument { scored, counted, recordings, picks, rounds } = validation.unwrap_or_default();
    let mut estimate: Option<EstimateDocument> =
        loader.document("estimate.json", "estimates of all runs together")?;
    let measured = crate::measured::load(&mut loader, estimate.as_mut(), recordings)?;
    let study = Study {
        name: title(sources, vessel.as_ref().map(|vessel| vessel.name.as_str())),
        experiment_s: campaign.map(|c| c.duration_s),
        dictionary,
        moments: loader.document("moments.json", "moments of every maneuver")?,
        design: loader.document("design.json", "optimal shares with their certificate")?,
        update: estimate.as_mut().and_then(|estimate| estimate.promise.take()),
        validation_trace: loader
            .traces(&vessel, "validation.parquet", "validation maneuvers")?
            .and_then(|traces| traces.into_iter().next()),
        estimate: estimate.filter(|estimate| !estimate.designs.is_empty()),
        scores: if picks.is_some() || rounds.is_some() { None } else { loader.scores()? },
        validation: scored,
        counted,
        scenarios: sources
            .scenarios
            .iter()
            .map(|folder| scenario(folder, sources.allow_mixed))
            .collect::<Result<_, _>>()?,
        vessel,
        trajectory: trajectory(&mut loader)?,
        merit: loader.document("merit.json", "figures of merit of standard maneuvers")?,
        selection: crate::selection::load(&mut loader, picks)?,
        measured,
        sequential: rounds,
        data: loader.label()?,
        mixed: loader.mixed(),
        reference,
        files: Vec::new(),
    };
    let Study { design, dictionary, validation, trajectory, selection, measured, sequential, .. } = &study;
    let simulated = design.is_some() || dictionary.is_some() || validation.is_some() || sequential.is_some();
    let planned = trajectory.as_ref().is_some_and(|t| t.main.is_some());
    if !(simulated || planned || selection.is_some() || measured.is_some()) {
        return Err(study::refuse(
            &sources.results,
            "results",
            "none of design.json, dictionary.parquet, estimate.json, plan.json, validation.json",
            "files that the stages wrote",
            "run `make` first, or name their folder with --results",
        ));
    }
    Ok(Study { files: loader.files, ..study })
}

/// Files of which a study has one at least.
const WRITTEN: [&str; 5] = ["vessel.toml", "dictionary.toml", "campaign.toml", "ingest.toml", "plan.toml"];

/// Refuses what is no folder, and a folder without a study.
fn check_study(folder: &Path) -> Result<(), Error> {
    let fault = match folder.is_dir() {
        false => "no such folder",
        true if WRITTEN.iter().all(|name| !folder.join(name).exists()) => "none of a study's files",
        true => return Ok(()),
    };
    let remedy = "name the folder of its hand-written files with --study";
    Err(study::refuse(folder, "study", fault, "the folder of a study", remedy))
}

/// The title of the page: the study's folder, or that of all scenarios; the vessel's name where the folder's path has none.
fn title(sources: &Sources, vessel: Option<&str>) -> String {
    let above = sources.study.parent().filter(|_| !sources.scenarios.is_empty());
    let named = above.and_then(Path::file_name).or(sources.study.file_name());
    named.map_or(vessel.unwrap_or("Study").to_owned(), |name| name.to_string_lossy().into_owned())
}

/// The stages' documents on estimators in `folder`.
fn scenario(folder: &Path, allow_mixed: bool) -> Result<Scenario, Error> {
    let [first, second] = ["estimate.json", "validation.json"].map(|name| folder.join(name));
    let (estimate, validation) =
        (read_document::<EstimateDocument>(&first)?, read_document::<ValidationDocument>(&second)?);
    let mut known = Provenance { allow_mixed, ..Provenance::default() };
    known.made("estimate.json", &first, estimate.digest, &estimate.provenance)?;
    known.made("validation.json", &second, validation.digest, &validation.provenance)?;
    let name = folder.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
    let is_compared = estimate.data.compared.is_some();
    let scored = validation.data.scored.filter(|scored| scored.compared.is_some());
    if let (Some(validation), true) = (scored, is_compared) {
        return Ok(Scenario { name, estimate: estimate.data, validation });
    }
    let expected = "`compared`, several estimators on the same runs";
    let remedy = "run `estimate` with several estimators, as `--estimator ls,iv`, and `validate` again";
    Err(study::refuse(&folder.join("estimate.json"), "estimators", "one", expected, remedy))
}

impl Loader<'_> {
    /// The label of the logs by `ingest`.
    fn label(&mut self) -> Result<Option<String>, Error> {
        let ingest = document_at::<IngestDocument>(self.sources.results.join("ingest.json"))?;
        Ok(ingest.and_then(|ingest| ingest.data.data).map(|label| label.to_string()))
    }

    fn scores(&mut self) -> Result<Option<Vec<scores::Row>>, Error> {
        let schema = (scores::ID, scores::VERSION);
        let Some(reader) = self.table("scores.parquet", "errors of every run", schema)? else {
            return Ok(None);
        };
        let mut rows = scores::rows(&reader)?;
        let leading = scores::leading(&rows);
        rows.retain(|row| Some(row.estimator) == leading);
        Ok(Some(rows))
    }

    fn traces(
        &mut self,
        vessel: &Option<Vessel>,
        name: &str,
        what: &str,
    ) -> Result<Option<Vec<ManeuverTrace>>, Error> {
        let path = self.sources.results.join(name);
        let (Some(vessel), true) = (vessel, exists(&path)) else { return Ok(None) };
        let reader = TrajectoryReader::open(&path, &Layout::new(&vessel.model), vessel.sample_rate_hz)?;
        self.made(name, what, reader.digest(), reader.provenance())?;
        let reached = reader.provenance().settings.get(REACHED).cloned().unwrap_or_default();
        let mut traces = Vec::new();
        for block in 0..reader.blocks() {
            if traces.len() < MOST_TRACES {
                let (mut first, commands) = (0, reader.commands(block)?);
                for run in reader.runs(block)? {
                    let rows = first..first + run.samples();
                    let cut =
                        |(name, values): &(String, Vec<f64>)| (name.clone(), values[rows.clone()].to_vec());
                    let commands = commands.iter().map(cut).collect();
                    traces.push(ManeuverTrace { commands, ..trace(vessel, &run) });
                    first += run.samples() + 1;
                }
            }
        }
        for trace in &mut traces {
            trace.reached = reached[&trace.name].as_str().unwrap_or_default().to_owned();
        }
        Ok(Some(traces))
    }
}

fn trace(vessel: &Vessel, run: &Run) -> ManeuverTrace {
    let samples = run.samples();
    let width = vessel.model.exogenous();
    let state = |i: usize| run.measured.iter().skip(i).step_by(3).take(samples).copied().collect::<Vec<_>>();
    let input = |i: usize| {
        let variable = &vessel.model.variables[3 + i];
        let values = run.exogenous.iter().skip(i).step_by(width).copied().collect();
        (variable.name.clone(), variable.unit.clone(), values)
    };
    let poses = track(&run.measured, vessel.sample_rate_hz);
    ManeuverTrace {
        name: run.segments[0].maneuver.clone(),
        description: String::new(),
        reached: String::new(),
        t: (0..samples).map(|k| k as f64 / vessel.sample_rate_hz).collect(),
        inputs: (0..vessel.model.inputs).map(input).collect(),
        commands: Vec::new(),
        u: state(0),
        v: state(1),
        r: state(2),
        x: poses.iter().take(samples).map(|p| p.x).collect(),
        y: poses.iter().take(samples).map(|p| p.y).collect(),
    }
}

/// The files that `plan` writes next to `plan.json`.
const ADDITIONAL: [(&str, &str); 6] = [
    ("track.parquet", "planned trajectory, every sample"),
    ("track.geojson", "planned track, for charts"),
    ("route.rtz", "route for the bridge"),
    ("route.gpx", "route and track for receivers"),
    ("aborts.gpx", "abort tracks for receivers"),
    ("route.plan", "route for ground stations of autopilots"),
];

/// The trajectory that the study plans; `None` if there is neither `plan.toml` nor `plan.json`.
fn trajectory(loader: &mut Loader) -> Result<Option<Trajectory>, Error> {
    let config = loader.sources.study.join("plan.toml");
    if exists(&config) {
        loader.note("plan.toml", "chart, lattice, safety, counts, start and goal", Digest::of_file(&config)?);
    } else if !exists(loader.sources.results.join("plan.json")) {
        return Ok(None);
    }
    let main = planned(loader, "")?;
    let mut variants = Vec::new();
    for name in folders(&loader.sources.results)? {
        variants.extend(planned(loader, &name)?);
    }
    Ok(Some(Trajectory {
        main,
        variants,
        estimate: loader.document("planned/estimate.json", "estimates of the simulated planned trials")?,
        validation: loader
            .document::<ValidationDocument>(
                "planned/validation.json",
                "errors of the simulated planned trials",
            )?
            .and_then(|validation| validation.scored),
    }))
}

/// Names of the folders `plan-*`, by the first number in them and by name.
fn folders(results: &Path) -> Result<Vec<String>, Error> {
    let fails = |e| Error::io(results, "list", e);
    let mut names = Vec::new();
    files::observe_names(results, "plan-*");
    for entry in std::fs::read_dir(results).map_err(fails)? {
        let entry = entry.map_err(fails)?;
        let name = entry.file_name().into_string().unwrap_or_default();
        if name.starts_with("plan-") && entry.path().is_dir() {
            names.push(name);
        }
    }
    names.sort_by_key(|name| (number(name), name.clone()));
    Ok(names)
}

/// The first number in a name: 4 of `plan-4-headings`.
fn number(name: &str) -> Option<u64> {
    name.split(|c: char| !c.is_ascii_digit()).find_map(|digits| digits.parse().ok())
}

/// The plan in folder `name` of the results; the study's own if it is empty.
fn planned(loader: &mut Loader, name: &str) -> Result<Option<PlannedTrial>, Error> {
    let within = |file: &str| if name.is_empty() { file.to_owned() } else { format!("{name}/{file}") };
    let what = if name.is_empty() { "planned trajectory" } else { "the same trial planned otherwise" };
    let Some(loaded) = loader.loaded::<PlanDocument>(&within("plan.json"), what)? else { return Ok(None) };
    let stale = stale(loader, name, &loaded);
    let (map, document) = map(loader, &within("map"))?;
    if name.is_empty() {
        for (file, what) in ADDITIONAL {
            let path = loader.sources.results.join(file);
            if exists(&path) {
                loader.note(file, what, Digest::of_file(&path)?);
            }
        }
    }
    charts(loader, &loaded);
    Ok(Some(PlannedTrial { name: name.to_owned(), plan: loaded.data, map, document, stale }))
}

/// The charts of the plan, by their names in it; each once.
fn charts(loader: &mut Loader, loaded: &Loaded<PlanDocument>) {
    for (role, digest) in &loaded.provenance.inputs {
        let Some(name) = role.strip_prefix("chart:") else { continue };
        let digest = digest.to_string();
        if loader.files.iter().all(|(known, _, other)| (known.as_str(), other) != (name, &digest)) {
            loader.files.push((name.to_owned(), "chart that was planned on".to_owned(), digest));
        }
    }
}

/// Files of the study that differ from those that the plan was made from.
fn stale(loader: &Loader, name: &str, loaded: &Loaded<PlanDocument>) -> Vec<String> {
    let config = if name.is_empty() { "plan.toml".to_owned() } else { format!("{name}.toml") };
    let roles = [
        ("vessel", "vessel.toml"),
        ("plan", config.as_str()),
        ("trajectories", "dictionary.parquet"),
        ("design", "design.json"),
    ];
    let differs = |(role, file): &(&str, &str)| {
        let Some(used) = loaded.provenance.inputs.get(*role) else { return false };
        let noted = loader.files.iter().find(|(known, ..)| known == file).map(|(.., digest)| digest.clone());
        let join = loader.sources.study.join(file);
        let digest = noted.or_else(|| Digest::of_file(join).ok().map(|digest| digest.to_string()));
        digest.is_some_and(|digest| digest != used.to_string())
    };
    roles.iter().filter(|role| differs(role)).map(|(_, file)| (*file).to_owned()).collect()
}
