//! `plan` on a chart: read, plan, write.

use std::path::Path;

use artifact::{Provenance, Staged, commit, stage_set_document};
use lattice::ProblemFile;
use report::PlanMap;
use serde_json::{Value, json};
use study::documents::{PlanChart, PlanDocument, Voyage};
use study::plan::{ChartsError, Means, PlanFile, Routes, of_voyage, read_charts};
use study::track::stage_track;
use trial::voyage::{Brief, Prepared, Sailing, Search, Solved};

use super::Limits;
use super::files::{MAIN, VoyageFiles};
use super::problem::known;
use super::refusals;
use crate::cli::{beside, budget};
use crate::failure::Failure;
use crate::said::on_stderr;
use crate::stage::Summary;

/// What is to be written.
pub struct Wanted<'a> {
    /// `plan.json`.
    pub out: &'a Path,
    /// The lattice problem that was solved.
    pub problem: Option<&'a Path>,
    /// Plans, too, that fail their check.
    pub unsafe_too: bool,
}

/// Plans a trial and writes `plan.json`; beside it track, routes and map.
///
/// # Errors
/// Files that are refused; no plan, or none that passes its check unless those are wanted; output that fails.
pub fn plan_voyage(
    files: &VoyageFiles,
    wanted: &Wanted,
    limits: &Limits,
    seed: u64,
    mut provenance: Provenance,
) -> Result<Summary, Failure> {
    let out = wanted.out;
    provenance.settings.insert("seed".into(), json!(seed));
    let refuse = |error| refusals::voyage(files, error);
    let (mut brief, config) = files.read(out, &mut provenance, seed)?;
    let charts = charts(files, (&mut brief, &config), limits, &mut provenance)?;
    files.check_inputs(&config, out, wanted.problem)?;
    let searched = limits.before_check();
    let search = Search { options: limits.options(), watch: &|| searched.watch(), go_on: &|| limits.go_on() };
    let mut prepared = Prepared::new(brief, &search).map_err(refuse)?;
    let (solved, sailing) = prepared.plan(&search, wanted.unsafe_too).map_err(refuse)?;
    if !(wanted.unsafe_too || sailing.check.safe) {
        return Err(refusals::unsafe_plan(files.config, &sailing.check));
    }
    prepared.check_slot(&sailing.sailed).map_err(refuse)?;
    let beyond = study::beyond(files.vessel, files.trajectories)?;
    let document = PlanDocument { charts, beyond, ..of_voyage(&prepared, &solved, &sailing) };
    let planned = Planned { prepared: &prepared, solved: &solved, sailing: &sailing, document: &document };
    let mut staged = planned.stage(out, &provenance)?;
    if let Some(path) = wanted.problem {
        let cell_m = prepared.brief.task.cell_m;
        let problem = ProblemFile::of(&solved.problem, "trial on a chart", cell_m);
        let problem = problem.map_err(|e| Failure::invalid(files.config, &e))?;
        staged.push(Staged::bytes(path, &serde_json::to_vec(&problem).unwrap_or_default())?);
    }
    commit(staged)?;
    document.told().filter(|_| !limits.quiet).for_each(|chart| on_stderr(format_args!("plan: {chart}")));
    Ok(summary(out, &document))
}

/// Reads the charts into `brief`, and says what is to be told of them.
fn charts(
    files: &VoyageFiles,
    (brief, config): (&mut Brief, &PlanFile),
    limits: &Limits,
    provenance: &mut Provenance,
) -> Result<Vec<PlanChart>, Failure> {
    let (plane, bounds) = brief.sight().map_err(|error| refusals::voyage(files, error))?;
    let means = Means { area: (&plane, &bounds), budget: budget(), go_on: &|| limits.go_on() };
    let charts = read_charts(files.config, config, &means, provenance).map_err(|error| match error {
        ChartsError::Refused(error) => error.into(),
        ChartsError::OutOfTime => refusals::out_of_time(files.config, "the reading of its charts"),
    })?;
    (brief.layers, brief.chart_bytes) = (charts.layers, charts.bytes);
    Ok(charts.told)
}

/// All that is written.
struct Planned<'a> {
    prepared: &'a Prepared,
    solved: &'a Solved,
    sailing: &'a Sailing,
    document: &'a PlanDocument,
}

impl Planned<'_> {
    fn stage(&self, out: &Path, provenance: &Provenance) -> Result<Vec<Staged>, Failure> {
        let (map, others) =
            rayon::join(|| self.stage_map(out), || self.stage_track_and_routes(out, provenance));
        let mut staged = others?;
        staged.push(map?);
        staged.insert(0, stage_set_document(out, provenance, self.document, &staged)?);
        Ok(staged)
    }

    fn stage_track_and_routes(&self, out: &Path, provenance: &Provenance) -> Result<Vec<Staged>, Failure> {
        let Self { prepared, sailing, document, .. } = self;
        let (plane, vessel) = (prepared.chart.plane(), &prepared.brief.vessel);
        let mut staged = Vec::new();
        if let Some(voyage) = &document.voyage {
            let names: Vec<String> = voyage.legs.iter().map(|leg| leg.name.clone()).collect();
            let track = beside(out, MAIN, "track.parquet");
            staged.push(stage_track([&track, out], provenance, vessel, plane, &names, &sailing.sailed)?);
            staged.extend(self.stage_routes(out, voyage)?);
        }
        Ok(staged)
    }

    fn stage_routes(&self, out: &Path, voyage: &Voyage) -> Result<Vec<Staged>, Failure> {
        let routes = Routes {
            plane: self.prepared.chart.plane(),
            document: self.document,
            voyage,
            sailed: &self.sailing.sailed,
            sample_s: 1.0 / self.prepared.brief.vessel.sample_rate_hz,
        };
        let files = routes.files().map_err(|(name, invalid)| {
            Failure::Failed(artifact::Error::invalid(beside(out, MAIN, name), invalid).to_string())
        })?;
        let stage = |(name, bytes): (&str, Vec<u8>)| Ok(Staged::bytes(beside(out, MAIN, name), &bytes)?);
        files.into_iter().map(stage).collect()
    }

    fn stage_map(&self, out: &Path) -> Result<Staged, Failure> {
        let Self { prepared, solved, sailing, document } = *self;
        let map = PlanMap { prepared, solved, sailing, document };
        let svg = map.svg().map_err(|e| Failure::Failed(format!("map: {e}")))?;
        Ok(Staged::bytes(beside(out, MAIN, "map.svg"), svg.as_bytes())?)
    }
}

fn summary(out: &Path, document: &PlanDocument) -> Summary {
    let PlanDocument { status, cost, cost_unit, lower_bound, gap, .. } = document;
    let steps = document.steps.len();
    let mut said = format!("{}, {cost} {}, {steps} steps", known(document), cost_unit.name());
    let mut told =
        json!({"status": status, "cost": cost, "lower_bound": lower_bound, "gap": gap, "steps": steps});
    if let Some(Voyage { duration_s, check, .. }) = &document.voyage {
        let more = if check.clearance_m >= check.sight_m { "more than " } else { "" };
        said += &format!(", {duration_s} s at sea, {more}{:.0} m clear", check.clearance_m);
        if check.left_area > 0 {
            said += &format!(", {} of {} runs outside of the area", check.left_area, check.runs);
        }
        for told in document.charts.iter().filter_map(|chart| Some((&chart.file, chart.depths.as_ref()?))) {
            said += &format!("; {}: {}", told.0, told.1.told());
        }
        if !check.safe {
            said += &format!("; UNSAFE: {}", check.faults.join(", "));
        }
        let own = json!({"duration_s": duration_s, "clearance_m": check.clearance_m, "safe": check.safe,
            "faults": check.faults, "aground": check.aground, "runs": check.runs, "left_area": check.left_area,
            "rounds": check.rounds});
        if let (Value::Object(all), Value::Object(own)) = (&mut told, own) {
            all.extend(own);
        }
    }
    Summary::of(out, said, told)
}
