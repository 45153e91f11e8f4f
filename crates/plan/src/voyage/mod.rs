//! A trial on a chart: one walk over the lattice that uses every maneuver as often as required, and its simulation at sea.
//!
//! [`Prepared::new`] lays out chart and lattice and simulates every leg, [`Prepared::solve`] finds the
//! cheapest walk with its proof, [`Prepared::plan`] simulates it, in the known current and in unknown ones,
//! and repeats that until the proved plan passes the check.

mod aborts;
mod check;
mod check_run;
mod clearance;
mod error;
mod follow;
mod legs;
mod moment_sums;
mod orders;
mod passage;
mod passage_lines;
mod prepared;
mod room;
mod sailing;
mod settled_legs;
mod solve;
mod task;
mod waters;
mod worst;

pub use aborts::{AbortMove, AbortTrack, LegDrift, LegFailure};
pub use check::Check;
pub use clearance::{Clearance, Cleared, compass_deg};
pub use error::{Footing, Search, VoyageError, Watch};
pub use follow::{
    FollowLimits, Followed, Inputs, PlannedStep, PlannedTrack, RestartPoint, ShipPosition, StepState,
    TrackPoint, aligned,
};
pub use legs::{Primitive, TrackPart, VoyageLeg, placed, round_minutes, widest};
pub use moment_sums::{Gathered, GatheredManeuver};
pub use orders::WheelOver;
pub use passage::{
    Daylight, Departures, Draft, Line, NearestDanger, Passage, PassageLeg, STRAIGHT, Tide, TideRow, Times,
    append_leg, current_m_s, utc,
};
pub use prepared::{AT_REST, Prepared};
pub use sailing::{Information, SailedPlan, Sailing};
pub use settled_legs::{Dropped, SettledLeg, Wanted};
pub use solve::{FrontPoint, Moves, Solved};
pub use task::{
    AbortRule, Area, Brief, CostRule, ErrorsFrom, Failing, Goal, Hull, ManeuverUse, Place, Primary, Safety,
    Secondary, Shares, Slot, SpeedLimit, Task,
};
pub use waters::{WaitingPlace, Waters};
pub use worst::{WorstVessel, WorstVessels};
