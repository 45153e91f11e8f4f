//! The files of a plan on a chart: read, and guarded from being overwritten.

use std::path::{Path, PathBuf};

use artifact::Provenance;
use study::documents::{DesignDocument, PlanChart, PlanDocument};
use study::files::read_vessel;
use study::plan::{ChartsError, Means, PlanFile, in_tide, read_charts, resumed};
use trial::voyage::{Brief, Place, Shares};

use super::Limits;
use super::refusals::{out_of_time, voyage};
use crate::cli::{beside, budget};
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
    /// `design.json`, for counts that follow from its shares.
    pub design: Option<&'a Path>,
    /// The plan whose rest is wanted.
    pub resumed: Option<Resumed<'a>>,
}

/// A plan that was begun.
pub struct Resumed<'a> {
    /// `plan.json`.
    pub plan: &'a Path,
    /// Steps that are done.
    pub done: usize,
    /// Where the ship is.
    pub from: &'a Place,
}

/// What a plan is usually called.
pub const MAIN: &str = "plan.json";

/// What is written beside `plan.json`.
const BESIDE: [&str; 8] = [
    "track.parquet",
    "track.geojson",
    "route.rtz",
    "route.gpx",
    "route.kml",
    "route.plan",
    "route.gpkg",
    "map.svg",
];

impl VoyageFiles<'_> {
    /// Reads everything for a plan that is to be written to `out`, and what is to be told of its charts.
    pub(super) fn read(
        &self,
        out: &Path,
        provenance: &mut Provenance,
        seed: u64,
        limits: &Limits,
    ) -> Result<(Brief, Vec<PlanChart>), Failure> {
        check_names(out)?;
        let vessel = read_vessel(self.vessel, provenance)?.with_disturbances_held();
        let config: PlanFile = inputs::toml(self.config, "plan", provenance)?;
        let task = config.task(&vessel).map_err(|e| Failure::invalid(self.config, &e))?;
        let task = in_tide(self.config, &config, task, provenance)?;
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
        let mut brief = Brief { vessel, task, layers: Vec::new(), chart_bytes: 0, dictionary, design, seed };
        let (plane, bounds) = brief.sight().map_err(|error| voyage(self, error))?;
        let means = Means { area: (&plane, &bounds), budget: budget(), go_on: &|| limits.go_on() };
        let charts = read_charts(self.config, &config, &means, provenance).map_err(|error| match error {
            ChartsError::Refused(error) => error.into(),
            ChartsError::OutOfTime => out_of_time(self.config, "the reading of its charts"),
        })?;
        self.check_inputs(&config, out)?;
        (brief.layers, brief.chart_bytes) = (charts.layers, charts.bytes);
        Ok((brief, charts.told))
    }

    /// Refuses to write over an input: any of them beside `out`, and charts under its own name.
    fn check_inputs(&self, config: &PlanFile, out: &Path) -> Result<(), Failure> {
        let folder = self.config.parent().unwrap_or(Path::new(""));
        let charts = config.chart.iter().map(|spec| folder.join(&spec.file));
        let others = [Some(self.vessel), Some(self.config), Some(self.trajectories), self.design];
        let inputs: Vec<PathBuf> =
            charts.chain(others.into_iter().flatten().map(Path::to_path_buf)).collect();
        let outputs = BESIDE.iter().map(|name| beside(out, MAIN, name)).chain([out.to_path_buf()]);
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
}

/// Refuses a main output under the name of one beside it.
fn check_names(out: &Path) -> Result<(), Failure> {
    let name = BESIDE.iter().find(|name| out.file_name().is_some_and(|own| own == **name));
    name.map_or(Ok(()), |name| {
        let message =
            format!("--out: found {name}, which is written beside it, expected another name; take plan.json");
        Err(Failure::Usage(message))
    })
}
