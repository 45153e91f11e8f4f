//! Collects a study for the page from the folder that the stages wrote into.

use std::path::Path;
use study::files::Vessel;

use files::{Error, Provenance, read_document};
use ship::engine::{Run, track};
use study::campaign_file::CampaignFile;
use study::documents::{EstimateDocument, IngestDocument, ValidationDocument};
use study::scores;
use study::trajectories::{Layout, REACHED, TrajectoryReader};

use super::loader::{Loader, Sources, document_at};
use super::trajectory::files::trajectory;
use super::{ManeuverTrace, Scenario, Study};

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
    if let Some(Err(invalid)) = campaign.as_ref().map(CampaignFile::check) {
        return Err(Error::invalid(sources.study.join("campaign.toml"), invalid));
    }
    let maneuvers = loader.dictionary()?;
    let reference = loader.reference()?;
    let mut dictionary = loader.traces(&vessel, "dictionary.parquet", "maneuvers, undisturbed")?;
    let maneuvers = maneuvers.map(|file| file.expanded().unwrap_or_default()).unwrap_or_default();
    for trace in dictionary.iter_mut().flatten() {
        let own = maneuvers.iter().find(|maneuver| maneuver.name == trace.name);
        trace.description = own.map_or(String::new(), |maneuver| maneuver.description.clone());
    }
    let study = Study {
        name: title(sources, vessel.as_ref().map(|vessel| vessel.name.as_str())),
        experiment_s: campaign.map(|c| c.duration_s),
        dictionary,
        moments: loader.document("moments.json", "moments of every maneuver")?,
        design: loader.document("design.json", "optimal shares with their certificate")?,
        update: loader.document("design-update.json", "the promise of the design after its trial")?,
        validation_trace: loader
            .traces(&vessel, "validation.parquet", "validation maneuvers")?
            .and_then(|traces| traces.into_iter().next()),
        estimate: loader.document("estimate.json", "estimates of all runs together")?,
        validation: loader.document("validation.json", "errors of all runs together")?,
        tally: loader.document("tally.json", "realizations in memory, counted")?,
        scores: loader.scores()?,
        scenarios: sources
            .scenarios
            .iter()
            .map(|folder| scenario(folder, sources.allow_mixed))
            .collect::<Result<_, _>>()?,
        vessel,
        trajectory: trajectory(&mut loader)?,
        merit: loader.document("merit.json", "figures of merit of standard maneuvers")?,
        selection: super::selection::load(&mut loader)?,
        measured: super::measured::load(&mut loader)?,
        sequential: loader.document("sequential.json", "trials designed in rounds and at once")?,
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
            "none of crossval.json, design.json, dictionary.parquet, plan.json, search.json, selection.json, sequential.json, trust.json, validation.json",
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
    let found = match folder.is_dir() {
        false => "no such folder",
        true if WRITTEN.iter().all(|name| !folder.join(name).exists()) => "none of a study's files",
        true => return Ok(()),
    };
    let remedy = "name the folder of its hand-written files with --study";
    Err(study::refuse(folder, "study", found, "the folder of a study", remedy))
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
    let read = Scenario {
        name: folder.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned()),
        estimate: estimate.data,
        validation: validation.data,
    };
    if read.estimate.compared.is_some() && read.validation.compared.is_some() {
        return Ok(read);
    }
    let expected = "`compared`, several estimators on the same runs";
    let remedy = "run `estimate --compare` and `validate` again";
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
        let (Some(vessel), true) = (vessel, files::exists(&path)) else { return Ok(None) };
        let reader = TrajectoryReader::open(&path, &Layout::new(&vessel.model), vessel.sample_rate_hz)?;
        self.made(name, what, reader.digest(), reader.provenance())?;
        let reached = reader.provenance().settings.get(REACHED).cloned().unwrap_or_default();
        let mut traces = Vec::new();
        for block in 0..reader.blocks() {
            if traces.len() < MOST_TRACES {
                let (mut first, commands) = (0, reader.commands(block)?);
                for run in reader.runs(block)? {
                    let rows = first..first + run.samples();
                    let own =
                        |(name, values): &(String, Vec<f64>)| (name.clone(), values[rows.clone()].to_vec());
                    let commands = commands.iter().map(own).collect();
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
