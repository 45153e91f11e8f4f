//! Where a ship is in a plan: the positions so far against the planned track.
//!
//! Positions are aligned with the track in the order of time ([`aligned`]). A step is done if the ship came along all of it
//! within a stated distance, and is at a later one.

mod alignment;
mod along;
mod doubt;
mod limits;
mod refused;
mod shift;
mod spoiled;
mod track;

use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use alignment::aligned;
use along::Along;
pub use limits::FollowLimits;
use refused::{check_alignment, check_positions, check_shift};
use shift::Shift;
pub use spoiled::Inputs;
use spoiled::Sailed;
pub use track::{PlannedStep, PlannedTrack, ShipPosition, TrackPoint};

refusal::choices! {
    /// What became of a step.
    pub enum StepState {
        /// The ship came along all of it.
        Done = "done",
        /// She is at a later step, and did not come along all of this one.
        Missed = "missed",
        /// She came along all of it, and sailed its maneuver otherwise than planned.
        Spoiled = "spoiled",
        /// She is at it.
        UnderWay = "under-way",
        /// It is still to come.
        Ahead = "ahead",
    }
}

/// Where the ship goes on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RestartPoint {
    /// Longitude of the last position.
    pub longitude_deg: f64,
    /// Its latitude.
    pub latitude_deg: f64,
    /// True heading there: as logged, else as planned where the ship is on the plan, else her course.
    pub heading_deg: f64,
    /// Speed over the ground there, by the same rule \[m/s\].
    pub speed_m_s: f64,
    /// The speed mode that is nearest to it.
    pub mode: String,
}

/// Where a ship is in a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Followed {
    /// The state of every step.
    pub states: Vec<StepState>,
    /// The greatest distance of the ship from the track of each step that she came along \[m\].
    pub deviations_m: Vec<Option<f64>>,
    /// The step that she is at.
    pub step: usize,
    /// Whether she is in its maneuver.
    pub in_maneuver: bool,
    /// Whether the plan is done: she came to its end.
    pub finished: bool,
    /// When the last position was, after the departure \[s\].
    pub at_s: f64,
    /// How far it is from where the plan has the ship then, delay apart \[m\].
    pub deviation_m: f64,
    /// How much later she is there than planned \[s\]; negative where she is earlier.
    pub delay_s: f64,
    /// True heading and speed there \[deg, m/s\]; see [`RestartPoint`].
    pub motion: [f64; 2],
    /// The positions without spikes.
    pub positions: Vec<ShipPosition>,
    /// How many spikes there were, which the ship cannot have come to and back from.
    pub spikes: usize,
    /// What is odd about the log, in words.
    pub odd: Vec<String>,
    /// By how much she is usually later than planned \[s\].
    pub usual_delay_s: f64,
    /// What each step's maneuver was sailed like, where that is not as planned.
    pub why: Vec<Option<String>>,
    /// Steps of which positions do not say how their maneuvers were sailed.
    pub unknown: Vec<usize>,
}

impl PlannedTrack {
    /// Where the ship is, by her `positions`, the first of which is the oldest, and by planned and logged inputs.
    ///
    /// # Errors
    /// Positions that cannot be the ship's on this plan, with their lines: of another day or plan, with jumps, with gaps in
    /// maneuvers, after its end, displaced, or that contradict themselves.
    pub fn follow(
        &self,
        positions: &[ShipPosition],
        inputs: [&Inputs; 2],
        limits: &FollowLimits,
    ) -> Result<Followed, Invalid> {
        let (positions, spikes) = check_positions(self, positions, limits)?;
        let track = self.thinned();
        let kept = track::thinned_positions(&positions, limits.max_gap_s);
        let shift = Shift::of(&track, &kept);
        shift.iter().try_for_each(|own| check_shift(&track, own))?;
        let kept = shift.map_or_else(|| kept.clone(), |own| own.without(&kept));
        let along = Along::of(&track, &kept);
        check_alignment(&along, limits)?;
        let shifted = shift.map(|shift| format!("{}: their datum, or the antenna's place", shift.words()));
        let odd = shifted.into_iter().chain(doubt::check(&along, limits)?).collect();
        let (last, ship) = (along.last(), &along.ship);
        let (point, end) = (&track.points[last], along.reached_end());
        let finished = end.is_some();
        let steps = 0..track.steps.len();
        let mut states: Vec<StepState> = steps.clone().map(|step| along.state(step, finished)).collect();
        let (mut why, mut unknown) = (vec![None; track.steps.len()], Vec::new());
        for (step, state) in states.iter_mut().enumerate().filter(|(_, state)| **state == StepState::Done) {
            match along.sailed(step, inputs) {
                Sailed::Otherwise(words) => (*state, why[step]) = (StepState::Spoiled, Some(words)),
                Sailed::Unknown => unknown.push(step),
                Sailed::Planned => {}
            }
        }
        Ok(Followed {
            states,
            deviations_m: steps.map(|step| along.deviation_m(step)).collect(),
            step: point.step,
            in_maneuver: point.informative && !finished,
            finished,
            at_s: ship.at_s,
            deviation_m: point.away_m(ship.place),
            delay_s: along.delay_s(end.unwrap_or(along.positions.len() - 1)),
            motion: along.motion(),
            positions,
            spikes,
            odd,
            usual_delay_s: track::median((0..along.positions.len()).map(|k| along.delay_s(k))),
            why,
            unknown,
        })
    }
}

impl Along<'_> {
    fn state(&self, step: usize, finished: bool) -> StepState {
        let now = self.track.points[self.last()].step;
        match step.cmp(&now) {
            _ if (finished || step < now) && self.is_covered(step) => StepState::Done,
            _ if finished || step < now => StepState::Missed,
            std::cmp::Ordering::Equal => StepState::UnderWay,
            _ => StepState::Ahead,
        }
    }

    /// True heading and speed at the last position \[deg, m/s\].
    fn motion(&self) -> [f64; 2] {
        let (point, ship) = (&self.track.points[self.last()], &self.ship);
        let on_plan = point.away_m(ship.place) <= self.track.steps[point.step].within_m;
        let planned = [point.heading_deg, point.speed_m_s];
        let own = if on_plan { planned } else { self.course().unwrap_or(planned) };
        [ship.heading_deg.unwrap_or(own[0]), ship.speed_m_s.unwrap_or(own[1])]
    }
}
