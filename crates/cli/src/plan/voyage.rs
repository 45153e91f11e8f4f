//! `plan` on a chart: read, plan, write.

use std::path::Path;

use files::{Provenance, Staged, commit, stage_document, stage_set_document};
use plan::lattice::ProblemFile;
use plan::voyage::Search;
use report::plan_map;
use seatrial::{ChartedTrial, Planned};
use serde_json::json;
use study::documents::FollowStatus;
use study::plan::{Begun, SoFar};
use study::track::stage_track;

use super::Limits;
use super::files::{FOLLOWED, MAIN, VoyageFiles};
use crate::cli::{beside, budget};
use crate::failure::Failure;
use crate::said::on_stderr;
use crate::stage::Summary;

/// The outputs.
pub struct Wanted<'a> {
    /// `plan.json`.
    pub out: &'a Path,
    /// The lattice problem that was solved.
    pub problem: Option<&'a Path>,
    /// Whether to write plans that fail their check.
    pub unsafe_too: bool,
}

/// Plans a trial and writes `plan.json`, and next to it track, routes and map.
///
/// # Errors
/// Files that are refused; no plan, or none that passes its check unless unsafe ones are requested; output that
/// fails.
pub fn plan_voyage(
    files: &VoyageFiles,
    wanted: &Wanted,
    limits: &Limits,
    seed: u64,
    mut provenance: Provenance,
) -> Result<Summary, Failure> {
    let out = wanted.out;
    provenance.settings.insert("seed".into(), json!(seed));
    let refuse = |error| files.refused(error);
    let (brief, config, followed) = files.read(out, &mut provenance, seed)?;
    let means = (budget(), &(|| limits.keep_going()) as &(dyn Fn() -> bool + Sync));
    let trial = ChartedTrial::on_charts(brief, (files.config, &config), means, &mut provenance);
    let trial = trial.map_err(refuse)?;
    files.check_inputs(&config, out, wanted.problem)?;
    let mut said = String::new();
    let mut staged = Vec::new();
    if let (Some(own), Some(Begun { so_far: SoFar::Positions(own_files), .. })) = (&followed, &files.begun) {
        trial.check_afloat(own_files, own, &|| limits.keep_going()).map_err(refuse)?;
        staged.push(stage_document(beside(out, MAIN, FOLLOWED), &provenance, &own.document)?);
        let doubts = own.document.doubts.iter().filter(|_| !limits.quiet);
        doubts.for_each(|doubt| on_stderr(format_args!("plan follow: {doubt}")));
        if own.document.status != FollowStatus::UnderWay {
            commit(staged)?;
            let details = json!({"status": own.document.status, "step": own.document.step});
            return Ok(Summary::of(&beside(out, MAIN, FOLLOWED), own.document.statement.clone(), details));
        }
        said = format!("{}; ", own.document.summary());
    }
    let searched = limits.before_check();
    let search = Search {
        options: limits.options(),
        watch: &|| searched.watch(),
        keep_going: &|| limits.keep_going(),
    };
    let mut planned = trial.plan(&search, wanted.unsafe_too).map_err(refuse)?;
    planned.document.beyond = study::beyond(files.vessel, files.trajectories, None)?;
    if let Some(path) = wanted.problem {
        let cell_m = planned.prepared.brief.task.cell_m;
        let problem = ProblemFile::of(&planned.solved.problem, "trial on a chart", cell_m);
        let problem = problem.map_err(|e| Failure::invalid(files.config, &e))?;
        staged.push(Staged::bytes(path, &serde_json::to_vec(&problem).unwrap_or_default())?);
    }
    staged.extend(stage(&planned, out, &provenance)?);
    commit(staged)?;
    let document = &planned.document;
    document.messages().filter(|_| !limits.quiet).for_each(|chart| on_stderr(format_args!("plan: {chart}")));
    let (plan, details) = document.summary();
    Ok(Summary::of(out, said + &plan, details))
}

/// All outputs.
fn stage(planned: &Planned, out: &Path, provenance: &Provenance) -> Result<Vec<Staged>, Failure> {
    let (map, others) = rayon::join(
        || stage_map(planned, out, provenance),
        || stage_track_and_routes(planned, out, provenance),
    );
    let mut staged = others?;
    staged.extend(map?);
    staged.push(stage_set_document(out, provenance, &planned.document, &staged)?);
    Ok(staged)
}

fn stage_track_and_routes(
    planned: &Planned,
    out: &Path,
    provenance: &Provenance,
) -> Result<Vec<Staged>, Failure> {
    let Some(routes) = planned.routes() else { return Ok(Vec::new()) };
    let names: Vec<String> = routes.voyage.legs.iter().map(|leg| leg.name.clone()).collect();
    let (track, vessel) = (beside(out, MAIN, "track.parquet"), &planned.prepared.brief.vessel);
    let track = stage_track([&track, out], provenance, vessel, routes.plane, &names, routes.sailed)?;
    let refused = |(name, invalid)| {
        Failure::Failed(files::Error::invalid(beside(out, MAIN, name), invalid).to_string())
    };
    let route = beside(out, MAIN, "route.rtz");
    let files = routes.files(&route.file_stem().unwrap_or_default().to_string_lossy()).map_err(refused)?;
    let stage = |(name, bytes): (&str, Vec<u8>)| Ok(Staged::bytes(beside(out, MAIN, name), &bytes)?);
    std::iter::once(Ok(track)).chain(files.into_iter().map(stage)).collect()
}

/// The map document, and the map that is drawn from it.
fn stage_map(planned: &Planned, out: &Path, provenance: &Provenance) -> Result<Vec<Staged>, Failure> {
    let Some(map) = planned.map() else { return Ok(Vec::new()) };
    let svg = plan_map(&map).map_err(|e| Failure::Failed(format!("map: {e}")))?;
    let document = stage_document(beside(out, MAIN, "map.json"), provenance, &map)?;
    Ok(vec![document, Staged::bytes(beside(out, MAIN, "map.svg"), svg.as_bytes())?])
}
