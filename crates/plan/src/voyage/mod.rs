//! A trial on a chart: one walk over the lattice that uses every maneuver as often as required, and its
//! simulation at sea.
//!
//! [`Prepared::new`] lays out chart and lattice and simulates every leg, [`Prepared::solve`] finds the
//! cheapest walk with its proof, [`Prepared::plan`] simulates it, in the known current and in unknown ones,
//! and repeats that until the proved plan passes the check.

mod afloat;
mod budget;
mod check;
mod check_run;
mod clearance;
mod closed;
mod counts;
mod daylight;
mod drafts;
mod draws;
mod error;
mod follow;
mod footing;
mod front;
mod gathered;
mod ground;
mod information;
mod legs;
mod map;
mod moment_sums;
mod moves;
mod off_nominal;
mod passage;
mod passage_lines;
mod places;
mod prepared;
mod sailed_plan;
mod sailing;
mod script;
mod search;
mod settled_legs;
mod solve;
mod steered;
mod task;
mod tide;
mod waters;
mod worst;

pub use check::Check;
pub use clearance::{Clearance, Cleared};
pub use counts::Wanted;
pub use daylight::Daylight;
pub use drafts::{Draft, Line, STRAIGHT, append_leg};
pub use error::VoyageError;
pub use follow::{
    FollowLimits, Followed, Inputs, PlannedStep, PlannedTrack, RestartPoint, ShipPosition, StepState,
    TrackPoint, aligned,
};
pub use footing::Footing;
pub use front::FrontPoint;
pub use gathered::{Gathered, GatheredManeuver};
pub use ground::AT_REST;
pub use information::Information;
pub use legs::{Primitive, VoyageLeg};
pub use map::{TrackPart, placed, round_minutes, widest};
pub use moves::Moves;
pub use passage::{NearestDanger, Passage, PassageLeg};
pub use places::compass_deg;
pub use prepared::Prepared;
pub use sailed_plan::SailedPlan;
pub use sailing::Sailing;
pub use search::{Search, Watch};
pub use settled_legs::{Dropped, SettledLeg};
pub use solve::Solved;
pub use task::{
    Area, Brief, CostRule, ErrorsFrom, Goal, Hull, ManeuverUse, Place, Primary, Safety, Secondary, Shares,
    Slot, SpeedLimit, Task,
};
pub use tide::{Tide, TideRow, current_m_s};
pub use waters::Waters;
pub use worst::{WorstVessel, WorstVessels};
