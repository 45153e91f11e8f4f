//! A plan on a chart: the task in `plan.toml`, and the files of the plan.

mod area;
mod cells;
mod chart_beside;
mod chart_file;
mod chart_grids;
mod chart_keys;
mod chart_text;
mod charts;
mod check;
mod document;
mod exchange_set;
mod file;
mod follow;
mod map;
mod programs;
mod resume;
mod routes;
mod slot;
mod task;
mod tide;
mod uncertain;
mod unplanned;
mod updates;

// Types of routes.
pub use chart::Plane;
pub use chart::route::{Feature, Geometry, Route};

pub use chart_text::chart_text;
pub use charts::{Charts, ChartsError, Means, read_charts};
pub use document::{of_problem, of_voyage};
pub use file::{
    ApproachSpec, AreaSpec, ChartKind, ChartSpec, KnownCurrent, PlanFile, SensorSpec, SlotSpec, TideSpec,
};
pub use follow::{Begun, FollowError, FollowFiles, FollowedPlan, SoFar};
pub use map::map_of;
pub use programs::programs;
pub use resume::{place, read_begun, resumed};
pub use routes::{NamedFile, Routes};
pub use task::second;
pub use tide::in_tide;
pub use uncertain::uncertain;
pub use unplanned::{Unplanned, no_plan, out_of_time, too_large, unplanned, unsafe_plan};
