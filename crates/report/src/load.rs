//! Collects a study for the page from the folder that the stages wrote into.

use std::collections::BTreeMap;
use std::path::Path;

use artifact::{TableReader, read_document};
use vessel::{DegreeOfFreedom, Vessel, track};

use super::loader::{Loader, Sources};
use super::trajectory_files::trajectory;
use super::{ManeuverTrace, ParameterRow, Scenario, Study, VesselSummary};
use artifact::Error;
use study::campaign_file::CampaignFile;
use study::documents::{EstimateDocument, IngestDocument, Reference, ValidationDocument};
use study::scores;
use study::trajectories::{Layout, TrajectoryReader};
use vessel::Run;

/// Maneuvers beyond this many are not drawn.
const MOST_TRACES: usize = 400;

/// Reads whatever of a study exists.
///
/// # Errors
/// A file that exists and is refused; a folder without any result.
pub fn load(sources: &Sources) -> Result<Study, Error> {
    let mut loader = Loader { sources, files: Vec::new() };
    let vessel = loader.vessel()?;
    let campaign = loader.toml::<CampaignFile>("campaign.toml", "runs, disturbances, seed, validation")?;
    let descriptions = loader.dictionary()?;
    let reference = loader.toml::<Reference>("reference.toml", "published results, to compare with")?;
    let descriptions: BTreeMap<String, String> = descriptions
        .iter()
        .flat_map(|d| d.expanded().unwrap_or_default())
        .map(|m| (m.name, m.description))
        .collect();
    let described = |name: &str| descriptions.get(name).cloned().unwrap_or_default();
    let study = Study {
        name: sources.study.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned()),
        experiment_s: campaign.map(|c| c.duration_s),
        dictionary: loader.traces(&vessel, "dictionary.parquet", "maneuvers, undisturbed", &described)?,
        moments: loader.document("moments.json", "moments of every maneuver")?,
        design: loader.document("design.json", "optimal shares with their certificate")?,
        validation_trace: loader
            .traces(&vessel, "validation.parquet", "validation maneuvers", &|_| String::new())?
            .and_then(|traces| traces.into_iter().next()),
        estimate: loader.document("estimate.json", "estimates of all runs together")?,
        validation: loader.document("validation.json", "errors of all runs together")?,
        scores: loader.scores()?,
        scenarios: sources.scenarios.iter().map(|folder| scenario(folder)).collect::<Result<_, _>>()?,
        vessel: vessel.as_ref().map(summary),
        trajectory: trajectory(&mut loader)?,
        selection: super::selection::load(&mut loader)?,
        measured: super::measured::load(&mut loader)?,
        sequential: loader.document("sequential.json", "trials designed in rounds and at once")?,
        data: loader.label()?,
        reference,
        files: Vec::new(),
    };
    let planned = study.trajectory.as_ref().is_some_and(|t| t.main.is_some());
    let planned = planned || study.selection.is_some() || study.measured.is_some();
    let planned = planned || study.sequential.is_some();
    if study.design.is_none() && study.dictionary.is_none() && study.validation.is_none() && !planned {
        return Err(study::refuse(
            &sources.results,
            "results",
            "none of crossval.json, design.json, dictionary.parquet, plan.json, selection.json, sequential.json, trust.json, validation.json",
            "files that the stages wrote",
            "run `make` first, or name their folder with --results",
        ));
    }
    Ok(Study { files: loader.files, ..study })
}

/// What the stages wrote into `folder` about its estimators.
fn scenario(folder: &Path) -> Result<Scenario, Error> {
    let read = Scenario {
        name: folder.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned()),
        estimate: read_document::<EstimateDocument>(folder.join("estimate.json"))?.data,
        validation: read_document::<ValidationDocument>(folder.join("validation.json"))?.data,
    };
    if read.estimate.compared.is_some() && read.validation.compared.is_some() {
        return Ok(read);
    }
    let expected = "`compared`, several estimators on the same runs";
    let remedy = "run `estimate --compare` and `validate` again";
    Err(study::refuse(&folder.join("estimate.json"), "estimators", "one", expected, remedy))
}

impl Loader<'_> {
    /// What `ingest` says that the logs are.
    fn label(&mut self) -> Result<Option<String>, Error> {
        let path = self.sources.results.join("ingest.json");
        if !path.exists() {
            return Ok(None);
        }
        Ok(read_document::<IngestDocument>(&path)?.data.data.map(|label| label.to_string()))
    }

    fn scores(&mut self) -> Result<Option<Vec<scores::Row>>, Error> {
        let path = self.sources.results.join("scores.parquet");
        if !path.exists() {
            return Ok(None);
        }
        let reader = TableReader::open(&path, scores::ID, scores::VERSION)?;
        self.note("scores.parquet", "errors of every run", reader.digest());
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
        described: &dyn Fn(&str) -> String,
    ) -> Result<Option<Vec<ManeuverTrace>>, Error> {
        let path = self.sources.results.join(name);
        let (Some(vessel), true) = (vessel, path.exists()) else { return Ok(None) };
        let reader = TrajectoryReader::open(&path, &Layout::new(&vessel.model), vessel.sample_rate_hz)?;
        self.note(name, what, reader.digest());
        let mut traces = Vec::new();
        for block in 0..reader.blocks() {
            if traces.len() < MOST_TRACES {
                traces.extend(reader.runs(block)?.iter().map(|run| trace(vessel, run, described)));
            }
        }
        Ok(Some(traces))
    }
}

fn trace(vessel: &Vessel, run: &Run, described: &dyn Fn(&str) -> String) -> ManeuverTrace {
    let samples = run.samples();
    let width = vessel.model.exogenous();
    let state = |i: usize| run.measured.iter().skip(i).step_by(3).take(samples).copied().collect::<Vec<_>>();
    let input = |i: usize| {
        let variable = &vessel.model.variables[3 + i];
        let values = run.exogenous.iter().skip(i).step_by(width).copied().collect();
        (variable.name.clone(), variable.unit.clone(), values)
    };
    let poses = track(&run.measured, vessel.sample_rate_hz);
    let name = run.segments[0].maneuver.clone();
    ManeuverTrace {
        description: described(&name),
        name,
        t: (0..samples).map(|k| k as f64 / vessel.sample_rate_hz).collect(),
        inputs: (0..vessel.model.inputs).map(input).collect(),
        u: state(0),
        v: state(1),
        r: state(2),
        x: poses.iter().take(samples).map(|p| p.x).collect(),
        y: poses.iter().take(samples).map(|p| p.y).collect(),
    }
}

fn summary(vessel: &Vessel) -> VesselSummary {
    let units = vessel.model.parameter_units();
    let terms = DegreeOfFreedom::ALL.into_iter().zip(&vessel.model.degrees);
    let named = terms
        .flat_map(|(d, degree)| degree.parameters.iter().zip(&degree.terms).map(move |(p, t)| (d, p, t)));
    let parameter = |(i, (d, name, term)): (usize, (DegreeOfFreedom, &String, &vessel::Term))| ParameterRow {
        name: name.clone(),
        unit: units[i].clone(),
        term: term.text.clone(),
        degree: d.name().to_owned(),
        truth: vessel.value[i],
        nominal: vessel.nominal[i],
    };
    let inputs = &vessel.model.variables[3..3 + vessel.model.inputs];
    VesselSummary {
        name: vessel.name.clone(),
        sample_rate_hz: vessel.sample_rate_hz,
        inputs: inputs.iter().map(|v| (v.name.clone(), v.unit.clone())).collect(),
        parameters: named.enumerate().map(parameter).collect(),
    }
}
