//! A chart to a plan.

use std::collections::BTreeMap;
use std::path::Path;

use files::{Budget, Error, Provenance, budget};
use plan::voyage::{Brief, Check, Prepared, SailedPlan, Sailing, Search, Shares, Solved, VoyageError};
use ship::engine::Run;
use ship::model::Vessel;
use study::documents::{MapDocument, PlanChart, PlanDocument};
use study::files::read_plan;
use study::plan::{
    ChartsError, FollowError, FollowFiles, FollowedPlan, Means, PlanFile, Routes, in_tide, map_of, of_voyage,
    read_charts, uncertain,
};
use thiserror::Error;

/// Why there is no plan.
#[derive(Debug, Error)]
pub enum PlanError {
    /// A file is refused, or cannot be read.
    #[error(transparent)]
    File(#[from] Error),
    /// The trial cannot be planned.
    #[error(transparent)]
    Voyage(#[from] VoyageError),
    /// The plan does not pass its check.
    #[error("plan at sea: {}", .0.faults.join(", "))]
    Unsafe(Box<Check>),
}

/// A trial to be planned on charts.
#[derive(Clone, Debug)]
pub struct ChartedTrial {
    /// Its name: as stated, or that of the folder of `plan.toml`, with the file's own where it is another one.
    pub name: String,
    /// The task and the vessel, with the charts and a run of every maneuver.
    pub brief: Brief,
    /// The treatment of the charts' objects and depths.
    pub charts: Vec<PlanChart>,
}

impl From<FollowError> for PlanError {
    fn from(error: FollowError) -> Self {
        match error {
            FollowError::File(error) => Self::File(error),
            FollowError::Voyage(error) => Self::Voyage(error),
        }
    }
}

impl ChartedTrial {
    /// The trial of `vessel` in `plan.toml` at `file`, on the charts and in the tide that it names. `dictionary` has
    /// a run of every maneuver; `design` its shares, for counts that `plan.toml` does not state. Maneuvers that react to
    /// the ship need their commands in `brief.programs`.
    ///
    /// # Errors
    /// Files that are refused; a trial that does not fit its charts.
    pub fn read(
        file: &Path,
        vessel: Vessel,
        dictionary: Vec<Run>,
        design: Option<Shares>,
    ) -> Result<Self, PlanError> {
        let mut provenance = Provenance::default();
        let config = read_plan(file, &mut provenance)?;
        let vessel = vessel.with_disturbances_held();
        let task = config.task(&vessel).map_err(|e| Error::invalid(file, e))?;
        // The vessel has no covariance.
        let task = uncertain([file; 2], &config, &vessel, task)?;
        let task = in_tide(file, &config, task, &mut provenance)?;
        let (layers, chart_bytes) = (Vec::new(), 0);
        let programs = BTreeMap::new();
        let brief = Brief { vessel, task, layers, chart_bytes, dictionary, programs, design, seed: 1 };
        Self::on_charts(brief, (file, &config), (budget(), &|| true), &mut provenance)
    }

    /// The trial of `brief` on the charts in `config`, the contents of `file`: read within the memory of `budget`,
    /// while `keep_going` returns true. Their digests are noted in `provenance`.
    ///
    /// # Errors
    /// See [`ChartedTrial::read`]; a lattice beyond the memory; the end of the time.
    pub fn on_charts(
        mut brief: Brief,
        (file, config): (&Path, &PlanFile),
        (budget, keep_going): (&Budget, &(dyn Fn() -> bool + Sync)),
        provenance: &mut Provenance,
    ) -> Result<Self, PlanError> {
        brief.check_size(budget.bytes() as u64)?;
        let (plane, bounds) = brief.sight()?;
        let means = Means { area: (&plane, &bounds), budget, keep_going };
        let charts = read_charts(file, config, &means, provenance).map_err(|error| match error {
            ChartsError::Refused(error) => PlanError::File(error),
            ChartsError::OutOfTime => VoyageError::OutOfTime("the reading of its charts").into(),
        })?;
        (brief.layers, brief.chart_bytes) = (charts.layers, charts.bytes);
        let name = config.name.clone().unwrap_or_else(|| name_of(file));
        Ok(Self { name, brief, charts: charts.summaries })
    }

    /// Refuses positions of a plan that is `followed` on land, or in what a ship in transit keeps clear of.
    ///
    /// # Errors
    /// The first of them, with the charted object; those of the area and its charts; the end of the time.
    pub fn check_afloat(
        &self,
        files: &FollowFiles,
        followed: &FollowedPlan,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<(), PlanError> {
        match self.brief.aground(&followed.positions, keep_going)? {
            Some(invalid) => Err(Error::invalid(files.positions, invalid).into()),
            None => Ok(()),
        }
    }

    /// The cheapest plan that passes its check; with `unsafe_too`, if none does, one that does not.
    ///
    /// # Errors
    /// No plan, or none in time; a plan longer than its slot.
    pub fn plan(self, search: &Search, unsafe_too: bool) -> Result<Planned, PlanError> {
        let mut prepared = Prepared::new(self.brief, search)?;
        let (solved, sailing) = prepared.plan(search, unsafe_too)?;
        if !(unsafe_too || sailing.check.safe) {
            return Err(PlanError::Unsafe(Box::new(sailing.check)));
        }
        prepared.check_slot(&sailing.sailed)?;
        let sailed = SailedPlan { prepared: &prepared, solved: &solved, sailing: &sailing };
        let document = PlanDocument { charts: self.charts, ..of_voyage(&sailed) };
        Ok(Planned { name: self.name, prepared, solved, sailing, document })
    }
}

/// The name of the trial in `file` where it states none.
fn name_of(file: &Path) -> String {
    let folder = std::path::absolute(file).ok();
    let folder = folder.as_deref().and_then(Path::parent).and_then(Path::file_name);
    let stem = file.file_stem().filter(|file_stem| *file_stem != "plan");
    let names = folder.into_iter().chain(stem).map(|name| name.to_string_lossy());
    let name = names.collect::<Vec<_>>().join(" ");
    if refusal::check_name("name", &name).is_ok() { name } else { "route".to_owned() }
}

/// A plan on a chart.
#[derive(Clone, Debug)]
pub struct Planned {
    /// Name of the trial.
    pub name: String,
    /// Chart, lattice and settled legs.
    pub prepared: Prepared,
    /// The problem and its solution.
    pub solved: Solved,
    /// The simulated plan, and its check.
    pub sailing: Sailing,
    /// `plan.json`.
    pub document: PlanDocument,
}

impl Planned {
    /// The map of the plan; `None` without a part at sea.
    pub fn map(&self) -> Option<MapDocument> {
        let Self { prepared, solved, sailing, document, .. } = self;
        Some(map_of(&SailedPlan { prepared, solved, sailing }, document, document.voyage.as_ref()?))
    }

    /// The plan as routes and tracks in other formats; `None` without a part at sea.
    pub fn routes(&self) -> Option<Routes<'_>> {
        let Self { prepared, solved, sailing, .. } = self;
        let planned = SailedPlan { prepared, solved, sailing };
        Some(Routes {
            name: &self.name,
            plane: self.prepared.chart.plane(),
            document: &self.document,
            voyage: self.document.voyage.as_ref()?,
            sailed: &self.sailing.sailed,
            aborts: planned.aborts().collect(),
            sample_s: 1.0 / self.prepared.brief.vessel.sample_rate_hz,
        })
    }
}
