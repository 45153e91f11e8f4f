//! The files of a plan on a chart: read, and guarded from being overwritten.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use artifact::Provenance;
use study::documents::{DesignDocument, PlanDocument};
use study::files::{kept_to_data, read_plan, read_vessel};
use study::plan::{PlanFile, in_tide, resumed, uncertain};
use trial::voyage::{Brief, Place, Shares};

use crate::cli::beside;
use crate::failure::Failure;
use crate::inputs;

/// The files of a plan on a chart.
pub struct VoyageFiles<'a> {
    /// `vessel.toml`.
    pub vessel: &'a Path,
    /// `plan.toml`.
    pub config: &'a Path,
    /// The dictionary's trajectories.
    pub trajectories: &'a Path,
    /// `dictionary.toml`, for maneuvers that react to the ship.
    pub dictionary: Option<&'a Path>,
    /// `design.json`, for counts that follow from its shares.
    pub design: Option<&'a Path>,
    /// Whether inputs may leave the range of the model's logs.
    pub beyond_range: bool,
    /// The plan to be resumed.
    pub resumed: Option<Resumed<'a>>,
}

/// A plan that was started.
pub struct Resumed<'a> {
    /// `plan.json`.
    pub plan: &'a Path,
    /// Steps that are done.
    pub done: usize,
    /// The ship's position.
    pub from: &'a Place,
}

/// The usual name of a plan.
pub const MAIN: &str = "plan.json";

/// The files written next to `plan.json`.
const ADDITIONAL: [&str; 9] = [
    "track.parquet",
    "track.geojson",
    "route.rtz",
    "route.gpx",
    "route.kml",
    "route.plan",
    "route.gpkg",
    "map.json",
    "map.svg",
];

impl<'a> VoyageFiles<'a> {
    /// The files that are read, but for the charts and the plan to be resumed.
    pub fn inputs(&self) -> impl Iterator<Item = &'a Path> {
        let others = self.dictionary.into_iter().chain(self.design);
        [self.vessel, self.config, self.trajectories].into_iter().chain(others)
    }

    /// Reads everything for a plan to be written to `out`, except its charts, and `plan.toml`, which names them.
    pub(super) fn read(
        &self,
        out: &Path,
        provenance: &mut Provenance,
        seed: u64,
    ) -> Result<(Brief, PlanFile), Failure> {
        check_names(out)?;
        let vessel = read_vessel(self.vessel, provenance)?.with_disturbances_held();
        let vessel = kept_to_data(self.vessel, vessel, self.beyond_range)?;
        let config = read_plan(self.config, provenance)?;
        let task = config.task(&vessel).map_err(|e| Failure::invalid(self.config, &e))?;
        let task = uncertain([self.config, self.vessel], &config, &vessel, task)
            .and_then(|task| in_tide(self.config, &config, task, provenance))?;
        let task = match &self.resumed {
            Some(Resumed { plan, done, from }) => {
                let begun = inputs::document::<PlanDocument>(plan, "plan", provenance)?;
                resumed(task, &begun, *done, (*from).clone()).map_err(|e| Failure::invalid(plan, &e))?
            }
            None => task,
        };
        let dictionary = inputs::runs(self.trajectories, &vessel, provenance)?;
        let design = self.design.map(|path| inputs::document::<DesignDocument>(path, "design", provenance));
        let design = design.transpose()?.map(|d| Shares { order: d.order, share: d.shares });
        let (layers, programs) = (Vec::new(), BTreeMap::new());
        let mut brief = Brief { vessel, task, layers, chart_bytes: 0, dictionary, programs, design, seed };
        brief.programs = study::plan::programs(self.dictionary, &brief, provenance)?;
        Ok((brief, config))
    }

    /// Refuses to overwrite an input: those next to `out`, and charts by the name of an output.
    pub(super) fn check_inputs(
        &self,
        config: &PlanFile,
        out: &Path,
        problem: Option<&Path>,
    ) -> Result<(), Failure> {
        let folder = self.config.parent().unwrap_or(Path::new(""));
        let charts = config.chart.iter().map(|spec| folder.join(&spec.file));
        let inputs: Vec<PathBuf> = charts.chain(self.inputs().map(Path::to_path_buf)).collect();
        let outputs: Vec<PathBuf> =
            ADDITIONAL.iter().map(|name| beside(out, MAIN, name)).chain([out.to_path_buf()]).collect();
        if let Some(problem) = problem {
            let existing = problem.canonicalize().ok();
            let is = |path: &&PathBuf| {
                **path == problem || existing.is_some() && path.canonicalize().ok() == existing
            };
            if let Some(other) = inputs.iter().chain(&outputs).find(is) {
                return Err(Failure::Usage(format!(
                    "--export-problem: found {}, which is also an input or another output, expected another file; name one",
                    other.display()
                )));
            }
        }
        for output in outputs.into_iter().filter_map(|path| path.canonicalize().ok()) {
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
}

/// Refuses a main output with the name of an additional one.
fn check_names(out: &Path) -> Result<(), Failure> {
    let name = ADDITIONAL.iter().find(|name| out.file_name().is_some_and(|own| own == **name));
    name.map_or(Ok(()), |name| {
        let message =
            format!("--out: found {name}, which is written beside it, expected another name; take plan.json");
        Err(Failure::Usage(message))
    })
}
