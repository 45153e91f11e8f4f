//! `plan` on a chart: the algorithm box.

use std::path::{Path, PathBuf};

use artifact::{Provenance, Staged, commit, stage_document};
use serde_json::json;

use super::map::{Drawing, stage_map};
use super::outputs::{Geographic, stage_routes};
use super::sailing::Sailing;
use super::search::{Limits, status, steps, uses};
use super::solve::Solved;
use super::track::stage_track;
use super::trial::{Trial, VoyageFiles};
use crate::cli::{beside, provenance};
use crate::failure::Failure;
use crate::stage::Summary;
use study::documents::{PlanDocument, PlanPose, Secondary};

/// Plans a trial and writes `plan.json` to `out`; beside it `track.parquet`, `track.geojson`, `route.rtz`, `route.gpx` and
/// `map.svg`.
///
/// # Errors
/// Files that are refused; no feasible plan; output that fails.
pub fn plan_voyage(files: &VoyageFiles, out: &Path, limits: &Limits, seed: u64) -> Result<Summary, Failure> {
    let mut provenance = provenance("plan");
    provenance.settings.insert("seed".into(), json!(seed));
    check_names(out)?;
    let trial = Trial::read(files, &mut provenance, seed)?;
    check_charts(files, &trial, out)?;
    let solved = trial.solve(files, limits)?;
    let sailing = trial.sail(files, &solved, limits, seed)?;
    trial.write(out, &provenance, &solved, sailing)
}

/// What is written beside `plan.json`.
const BESIDE: [&str; 5] = ["track.parquet", "track.geojson", "route.rtz", "route.gpx", "map.svg"];

/// Refuses a main output under the name of one beside it.
fn check_names(out: &Path) -> Result<(), Failure> {
    let name = BESIDE.iter().find(|name| out.file_name().is_some_and(|own| own == **name));
    name.map_or(Ok(()), |name| {
        let message =
            format!("--out: found {name}, which is written beside it, expected another name; take plan.json");
        Err(Failure::Usage(message))
    })
}

/// Refuses to write over an input: any of them beside `out`, and charts under its own name.
fn check_charts(files: &VoyageFiles, trial: &Trial, out: &Path) -> Result<(), Failure> {
    let folder = files.config.parent().unwrap_or(Path::new(""));
    let charts = trial.config.chart.iter().map(|spec| folder.join(&spec.file));
    let others = [Some(files.vessel), Some(files.config), Some(files.trajectories), files.design];
    let inputs: Vec<PathBuf> = charts.chain(others.into_iter().flatten().map(Path::to_path_buf)).collect();
    let outputs = BESIDE.iter().map(|name| beside(out, name)).chain([out.to_path_buf()]);
    for output in outputs.filter_map(|path| path.canonicalize().ok()) {
        let same = |input: &&PathBuf| input.canonicalize().is_ok_and(|path| path == output);
        if let Some(input) = inputs.iter().find(same) {
            return Err(Failure::Usage(format!(
                "--out: found {}, an input that what is written beside it would replace, expected another folder; name one",
                input.display()
            )));
        }
    }
    Ok(())
}

impl Trial {
    fn write(
        &self,
        out: &Path,
        provenance: &Provenance,
        solved: &Solved,
        sailing: Sailing,
    ) -> Result<Summary, Failure> {
        let Solved { waters, problem, solution, .. } = solved;
        let (status, statement) = status(problem, solution);
        let pose = |p: lattice::Pose| {
            let (level, mode) = self.grid.level_and_mode(p.layer);
            let mode = Some(self.grid.modes[mode].name.clone());
            PlanPose { i: p.i as u64, j: p.j as u64, h: level as u64, mode }
        };
        let names: Vec<String> = sailing.voyage.legs.iter().map(|leg| leg.name.clone()).collect();
        let document = PlanDocument {
            status,
            statement,
            cost_unit: self.config.cost.primary.name().into(),
            cost: solution.cost.primary,
            lower_bound: solution.lower_bound.primary,
            secondary: Some(Secondary {
                name: self.config.cost.secondary.name().into(),
                value: solution.cost.secondary,
            }),
            counts: uses(problem, solution),
            steps: steps(problem, solution, pose),
            voyage: Some(sailing.voyage),
        };
        let mut staged: Vec<Staged> = vec![stage_document(out, provenance, &document)?];
        let track = beside(out, "track.parquet");
        let plane = self.chart.plane();
        staged.push(stage_track(&track, provenance, &self.vessel, plane, &names, &sailing.sailed)?);
        if let Some(voyage) = &document.voyage {
            let rate_hz = self.vessel.sample_rate_hz;
            let sailed = &sailing.sailed;
            let own = Geographic { plane, document: &document, voyage, sailed, rate_hz };
            staged.extend(stage_routes(out, &own)?);
        }
        let drawing = Drawing {
            chart: &self.chart,
            grid: &self.grid,
            document: &document,
            sailed: &sailing.sailed,
            runs: &sailing.runs,
            transit: &waters.obstacles[waters.layer_of_leg[0]],
            trial: waters.deepest(&self.rehearsed),
            outline: &self.config.hull.outline(),
        };
        staged.push(stage_map(out, &drawing)?);
        commit(staged)?;
        let PlanDocument { status, cost, cost_unit, lower_bound, .. } = &document;
        let seconds = document.voyage.as_ref().map_or(0.0, |v| v.duration_s);
        let clearance = document.voyage.as_ref().map_or(0.0, |v| v.check.clearance_m);
        let (aground, runs) = document.voyage.as_ref().map_or((0, 0), |v| (v.check.aground, v.check.runs));
        let astray = match aground {
            0 => String::new(),
            _ => format!(", but {aground} of {runs} runs in unknown current aground"),
        };
        Ok(Summary {
            line: format!(
                "{}: {status}, {cost} {cost_unit}, {} steps, {seconds} s at sea, {clearance:.0} m clear{astray}",
                out.display(),
                document.steps.len()
            ),
            json: json!({"out": out, "status": status, "cost": cost, "lower_bound": lower_bound,
                "steps": document.steps.len(), "duration_s": seconds, "clearance_m": clearance, "aground": aground, "runs": runs}),
        })
    }
}
