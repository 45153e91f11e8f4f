//! `plan` on a chart: read, plan, write.

use std::path::Path;

use artifact::{Provenance, Staged, commit, stage_set_document};
use report::PlanMap;
use serde_json::json;
use study::documents::{PlanDocument, Voyage};
use study::plan::{Routes, of_voyage};
use study::track::stage_track;
use trial::voyage::{Prepared, Sailing, Search, Solved};

use super::files::{MAIN, VoyageFiles};
use super::limits::Limits;
use super::refusals;
use crate::cli::beside;
use crate::failure::Failure;
use crate::stage::Summary;

/// Plans a trial and writes `plan.json` to `out`; beside it `track.parquet`, `track.geojson`, `route.rtz`, `route.gpx` and
/// `map.svg`.
///
/// # Errors
/// Files that are refused; no feasible plan; output that fails.
pub fn plan_voyage(
    files: &VoyageFiles,
    out: &Path,
    limits: &Limits,
    seed: u64,
    mut provenance: Provenance,
) -> Result<Summary, Failure> {
    provenance.settings.insert("seed".into(), json!(seed));
    let brief = files.read(out, &mut provenance, seed)?;
    let refuse = |error| refusals::voyage(files, error);
    let search = Search { options: limits.options(), watch: &|| limits.watch() };
    let prepared = Prepared::new(brief).map_err(refuse)?;
    let solved = prepared.solve(&search).map_err(refuse)?;
    let sailing = prepared.sail(&solved).map_err(refuse)?;
    let document = of_voyage(&prepared, &solved, &sailing);
    let planned = Planned { prepared: &prepared, solved: &solved, sailing: &sailing, document: &document };
    commit(planned.stage(out, &provenance)?)?;
    Ok(summary(out, &document))
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
        let Self { prepared, sailing, document, .. } = self;
        let (plane, vessel) = (prepared.chart.plane(), &prepared.brief.vessel);
        let mut staged = Vec::new();
        if let Some(voyage) = &document.voyage {
            let names: Vec<String> = voyage.legs.iter().map(|leg| leg.name.clone()).collect();
            let track = beside(out, MAIN, "track.parquet");
            staged.push(stage_track([&track, out], provenance, vessel, plane, &names, &sailing.sailed)?);
            staged.extend(self.stage_routes(out, voyage)?);
        }
        staged.push(self.stage_map(out)?);
        staged.insert(0, stage_set_document(out, provenance, *document, &staged)?);
        Ok(staged)
    }

    fn stage_routes(&self, out: &Path, voyage: &Voyage) -> Result<Vec<Staged>, Failure> {
        let routes = Routes {
            plane: self.prepared.chart.plane(),
            document: self.document,
            voyage,
            sailed: &self.sailing.sailed,
            rate_hz: self.prepared.brief.vessel.sample_rate_hz,
        };
        let files = routes.files().map_err(|(name, invalid)| {
            Failure::Failed(artifact::Error::invalid(beside(out, MAIN, name), invalid).to_string())
        })?;
        let stage =
            |(name, text): (&str, String)| Ok(Staged::bytes(beside(out, MAIN, name), text.as_bytes())?);
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
    let PlanDocument { status, cost, cost_unit, lower_bound, .. } = document;
    let steps = document.steps.len();
    let voyage = document.voyage.as_ref();
    let (seconds, clearance) = voyage.map_or((0.0, 0.0), |v| (v.duration_s, v.check.clearance_m));
    let (aground, runs) = voyage.map_or((0, 0), |v| (v.check.aground, v.check.runs));
    let astray = match aground {
        0 => String::new(),
        _ => format!(", but {aground} of {runs} runs in unknown current aground"),
    };
    Summary::of(
        out,
        format!(
            "{}, {cost} {}, {steps} steps, {seconds} s at sea, {clearance:.0} m clear{astray}",
            status.name(),
            cost_unit.name()
        ),
        json!({"status": status, "cost": cost, "lower_bound": lower_bound, "steps": steps,
            "duration_s": seconds, "clearance_m": clearance, "aground": aground, "runs": runs}),
    )
}
