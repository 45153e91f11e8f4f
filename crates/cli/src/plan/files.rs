//! The files of a plan on a chart: read, and guarded from being overwritten.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use files::Provenance;
use plan::voyage::{Brief, Shares};
use seatrial::PlanError;
use study::documents::DesignDocument;
use study::files::{kept_to_data, read_model, read_plan, read_planned};
use study::plan::{Begun, FollowedPlan, PlanFile, in_tide, read_begun, uncertain};

use crate::cli::beside;
use crate::failure::Failure;
use crate::inputs;

use super::refusals;

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
    /// The plan of which this is the rest.
    pub begun: Option<Begun<'a>>,
}

/// The usual name of a plan.
pub const MAIN: &str = "plan.json";

/// Where the ship is in a plan that is followed.
pub(super) const FOLLOWED: &str = "follow.json";

/// The files written next to `plan.json`.
const ADDITIONAL: [&str; 8] = [
    FOLLOWED,
    "track.parquet",
    "track.geojson",
    "route.rtz",
    "route.gpx",
    "route.plan",
    "map.json",
    "map.svg",
];

impl<'a> VoyageFiles<'a> {
    /// The files that are read, but for the charts and the plan to be resumed.
    pub fn inputs(&self) -> impl Iterator<Item = &'a Path> {
        let others = self.dictionary.into_iter().chain(self.design);
        [self.vessel, self.config, self.trajectories].into_iter().chain(others)
    }

    /// Why there is no plan of these files.
    pub(super) fn refused(&self, error: PlanError) -> Failure {
        refusals::plan([self.config, self.trajectories], self.design, error)
    }

    /// Reads everything for a plan to be written to `out`, except its charts, and `plan.toml`, which names them.
    pub(super) fn read(
        &self,
        out: &Path,
        provenance: &mut Provenance,
        seed: u64,
    ) -> Result<(Brief, PlanFile, Option<FollowedPlan>), Failure> {
        check_names(out)?;
        let vessel = read_planned(self.vessel, provenance)?;
        let vessel = kept_to_data(self.vessel, vessel, self.beyond_range)?;
        // What was made before the trial is of the vessel before it was identified.
        let of_model = self.begun.is_some() && read_model(self.vessel)?.is_some();
        let model = if of_model { provenance.inputs.remove("vessel") } else { None };
        let config = read_plan(self.config, provenance)?;
        let task = config.task(&vessel).map_err(|e| Failure::invalid(self.config, &e))?;
        let task = uncertain([self.config, self.vessel], &config, &vessel, task)
            .and_then(|task| in_tide(self.config, &config, task, provenance))?;
        let plan = self.begun.map(|begun| read_begun(begun.plan, of_model, provenance)).transpose()?;
        let begun = self.begun.as_ref().zip(plan.as_ref());
        let task = begun.map_or_else(|| Ok(task.clone()), |(begun, plan)| begun.task(plan, task.clone()))?;
        let dictionary = inputs::runs(self.trajectories, &vessel, provenance)?;
        let design = self.design.map(|path| inputs::document::<DesignDocument>(path, "design", provenance));
        let design = design.transpose()?.map(|d| Shares { order: d.order, share: d.shares });
        let (layers, programs) = (Vec::new(), BTreeMap::new());
        let mut brief = Brief { vessel, task, layers, chart_bytes: 0, dictionary, programs, design, seed };
        brief.programs = study::plan::programs(self.dictionary, &brief, provenance)?;
        let followed = match begun {
            Some((begun, plan)) => {
                begun.followed(plan, &mut brief, provenance).map_err(|error| self.refused(error.into()))?
            }
            None => None,
        };
        if let Some(model) = model {
            provenance.origins.remove("vessel");
            provenance.inputs.insert("vessel".to_owned(), model);
        }
        Ok((brief, config, followed))
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
        let own = self.inputs().chain(self.begun.iter().flat_map(Begun::files));
        let inputs: Vec<PathBuf> = charts.chain(own.map(Path::to_path_buf)).collect();
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
