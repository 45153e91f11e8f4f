//! Where a ship is in a plan: the positions so far against the planned track.
//!
//! Positions are aligned with the track in the order of time ([`aligned`]). A step is done if the ship came along all of it
//! within a stated distance, and is at a later one.

mod doubt;
mod refused;
mod track;

use std::collections::BTreeMap;

use numerics::statistics::sorted;
use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::VoyageError;
use super::task::Brief;
use refused::{Shift, check_alignment, check_positions, check_shift};
use track::{Along, median};

pub use track::{FollowLimits, PlannedStep, PlannedTrack, ShipPosition, TrackPoint, aligned};

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
        let kept = track::thinned_positions(&positions);
        let shift = Shift::of(&track, &kept);
        shift.iter().try_for_each(|shift| check_shift(&track, shift))?;
        let kept = shift.map_or_else(|| kept.clone(), |shift| shift.without(&kept));
        let along = Along::of(&track, &kept);
        check_alignment(&along)?;
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
                HowSailed::Otherwise(words) => (*state, why[step]) = (StepState::Spoiled, Some(words)),
                HowSailed::Unknown => unknown.push(step),
                HowSailed::Planned => {}
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
            usual_delay_s: median((0..along.positions.len()).map(|k| along.delay_s(k))),
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
        let elsewhere = if on_plan { planned } else { self.course().unwrap_or(planned) };
        [ship.heading_deg.unwrap_or(elsewhere[0]), ship.speed_m_s.unwrap_or(elsewhere[1])]
    }
}

/// A time that a maneuver was broken off for, or that is left out of it \[s\]; the plan goes on by less than a part of it.
const BROKEN_S: f64 = 30.0;
const GOES_ON: f64 = 0.3;
/// Waits this near the ends are not of the maneuver \[s\].
const ENDS_S: f64 = 5.0;
/// Least part of the planned motion, or input, and greatest error of it that tells.
const LEAST: f64 = 0.5;
const TELLS: f64 = 0.15;
/// Part of the samples at which an input may differ from the planned one, by a part of its amplitude.
const FEW: f64 = 0.1;
const DIFFERS: f64 = 0.5;

/// Series over time, by name: times and values.
pub type Inputs = BTreeMap<String, Vec<[f64; 2]>>;

/// What a log says of how a maneuver was sailed.
#[derive(Clone, Debug, PartialEq)]
enum HowSailed {
    /// As planned.
    Planned,
    /// Neither: the track is straight, and no input was logged.
    Unknown,
    /// Not as planned.
    Otherwise(String),
}

/// A position in a maneuver, and the point of the plan that it belongs to.
type Fix = (ShipPosition, TrackPoint);

impl Along<'_> {
    /// How the maneuver of `step` was sailed, by motion and by the inputs that were planned and logged.
    fn sailed(&self, step: usize, [planned, logged]: [&Inputs; 2]) -> HowSailed {
        let fix = |(ship, k): (&ShipPosition, &usize)| (*ship, self.track.points[*k]);
        let informative = |(_, plan): &Fix| plan.step == step && plan.informative;
        let fixes: Vec<Fix> = self.positions.iter().zip(&self.at).map(fix).filter(informative).collect();
        if fixes.is_empty() {
            return HowSailed::Planned;
        }
        let of = |(name, informative): (&String, &Vec<[f64; 2]>)| {
            input(&fixes, name, [informative, logged.get(name)?])
        };
        let inputs: Vec<Option<String>> = planned.iter().filter_map(of).collect();
        let known = !inputs.is_empty();
        match inputs.into_iter().flatten().next().or_else(|| broken_off(&fixes)) {
            Some(why) => HowSailed::Otherwise(why),
            None => shape(&fixes, known),
        }
    }
}

/// Where the ship waited in a maneuver, sailed part of it again, or left part of it out.
fn broken_off(fixes: &[Fix]) -> Option<String> {
    let [begins_s, ends_s] = [fixes.first()?, fixes.last()?].map(|(_, plan)| plan.at_s);
    let usual = fixes.iter().map(|(_, plan)| plan.speed_m_s).sum::<f64>() / fixes.len() as f64;
    let is_inner = |(_, plan): &&Fix| {
        (begins_s + ENDS_S..=ends_s - ENDS_S).contains(&plan.at_s) && plan.speed_m_s >= 0.5 * usual
    };
    let inner: Vec<&Fix> = fixes.iter().filter(is_inner).collect();
    let pairs = inner.iter().enumerate().flat_map(|(k, from)| inner[k..].iter().map(move |to| (*from, *to)));
    // By how much the log, or the plan, goes on while the other hardly does.
    let times = |(from, to): &(&Fix, &Fix)| [to.0.at_s - from.0.at_s, to.1.at_s - from.1.at_s];
    let stands = |pair: &(&Fix, &Fix)| {
        let [took_s, planned_s] = times(pair);
        let [least, most] = [took_s.min(planned_s), took_s.max(planned_s)];
        (most - least >= BROKEN_S).then_some(GOES_ON * most - least)
    };
    let pair = pairs.max_by(|a, b| stands(a).unwrap_or(-1.0).total_cmp(&stands(b).unwrap_or(-1.0)))?;
    stands(&pair).filter(|by| *by >= 0.0)?;
    let ([took_s, planned_s], after_s) = (times(&pair), pair.0.1.at_s - begins_s);
    Some(match took_s > planned_s {
        true => format!("broken off {after_s:.0} s after its beginning, and resumed {took_s:.0} s later"),
        false => format!("{planned_s:.0} s of it are left out, {after_s:.0} s after its beginning"),
    })
}

/// How much of the planned motion aside of a straight line there is, over the maneuver and each third of it.
fn shape(fixes: &[Fix], known: bool) -> HowSailed {
    let third = fixes.len() / 3;
    let parts = [0..fixes.len(), 0..third, third..2 * third, 2 * third..fixes.len()];
    let gains: Vec<[f64; 2]> = parts.into_iter().filter_map(|part| gain(&fixes[part])).collect();
    let tells = || gains.iter().filter(|[_, error]| *error <= TELLS);
    match tells().find(|[gain, error]| gain + 2.0 * error < LEAST) {
        Some([gain, _]) if *gain < -LEAST => HowSailed::Otherwise("to the other side".to_owned()),
        Some([gain, _]) => {
            let percent = 100.0 * gain.max(0.0);
            let words = format!("its motion has {percent:.0} % of the planned one, or a part of it has");
            HowSailed::Otherwise(words)
        }
        None if known || tells().next().is_some() => HowSailed::Planned,
        None => HowSailed::Unknown,
    }
}

/// The part of the planned way aside of a straight line that was sailed, and its standard error.
fn gain(fixes: &[Fix]) -> Option<[f64; 2]> {
    let mean = |of: &dyn Fn(&Fix) -> f64| fixes.iter().map(of).sum::<f64>() / fixes.len() as f64;
    let at_s = mean(&|(_, plan)| plan.at_s);
    let later_s = |(_, plan): &Fix| plan.at_s - at_s;
    let squares = mean(&|fix| later_s(fix) * later_s(fix));
    let aside = |place: fn(&Fix) -> [f64; 2]| -> Vec<[f64; 2]> {
        let line = [0, 1].map(|c: usize| {
            [mean(&|fix| place(fix)[c]), mean(&|fix| later_s(fix) * place(fix)[c]) / squares]
        });
        let off = |fix: &Fix| [0, 1].map(|c: usize| place(fix)[c] - line[c][0] - line[c][1] * later_s(fix));
        fixes.iter().map(off).collect()
    };
    let (planned, sailed) = (aside(|(_, plan)| plan.place), aside(|(ship, _)| ship.place));
    let dot =
        |a: &[[f64; 2]], b: &[[f64; 2]]| a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1]).sum::<f64>();
    let squares = dot(&planned, &planned);
    let gain = dot(&planned, &sailed) / squares;
    let misses = dot(&sailed, &sailed) - gain * gain * squares;
    let error = (misses.max(0.0) / (2.0 * fixes.len() as f64) / squares).sqrt();
    (gain.is_finite() && error.is_finite()).then_some([gain, error])
}

/// Whether a logged input is the planned one; `None` where it was not logged, or is constant in the plan.
fn input(fixes: &[Fix], name: &str, series: [&[[f64; 2]]; 2]) -> Option<Option<String>> {
    let value = |series: &[[f64; 2]], at_s: f64| {
        let next = series.partition_point(|sample| sample[0] <= at_s + 1e-6);
        series.get(next.checked_sub(1)?).filter(|sample| at_s - sample[0] <= BROKEN_S).map(|sample| sample[1])
    };
    let pair = |(ship, plan): &Fix| Some([value(series[0], plan.at_s)?, value(series[1], ship.at_s)?]);
    let pairs: Vec<[f64; 2]> = fixes.iter().filter_map(pair).collect();
    let middle = median(pairs.iter().map(|pair| pair[0]));
    let amplitudes = sorted(pairs.iter().map(|pair| Some((pair[0] - middle).abs())));
    let amplitude = *amplitudes.get(amplitudes.len() * 9 / 10).filter(|most| **most > 1e-6 * middle.abs())?;
    let sum = |of: fn(&[f64; 2]) -> f64| pairs.iter().map(of).sum::<f64>();
    let gain = (sum(|pair| pair[0] * pair[1]) / sum(|pair| pair[0] * pair[0])).clamp(LEAST, 1.0 / LEAST);
    let differs = pairs.iter().filter(|pair| (pair[1] / gain - pair[0]).abs() > DIFFERS * amplitude).count();
    let part = differs as f64 / pairs.len() as f64;
    let words = || format!("`{name}` differs from the planned one for {:.0} % of it", 100.0 * part);
    Some((part > FEW).then(words))
}

impl Brief {
    /// Why positions cannot be of the ship: the first that is on land, or in what a ship in transit keeps clear of, with the
    /// charted object; `None` where all are in water.
    ///
    /// # Errors
    /// Those of the area and its charts, as [`super::Prepared::new`] has them; the end of the time.
    pub fn aground(
        &self,
        positions: &[ShipPosition],
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Option<Invalid>, VoyageError> {
        let drift_m = self.drift_m(&self.wanted()?);
        let (chart, _) = self.task.ground(&self.vessel, &self.layers, drift_m, keep_going)?;
        let places: Vec<[f64; 2]> = positions.iter().map(|position| position.place).collect();
        let dangers = chart.dangers(self.task.safety.transit_depth_m);
        let Some((first, called)) = dangers.first_inside(&places) else { return Ok(None) };
        let (longitude, latitude) = chart.plane().to_geographic(places[first]);
        let thing = format!("line {}", positions[first].line);
        let position = format!("longitude {longitude:.5}, latitude {latitude:.5} in `{called}`");
        let expected = "a position in water that the ship may pass";
        let remedy = "correct positions and chart: one of them is displaced";
        Ok(Some(Invalid::new(thing, position, expected, remedy)))
    }
}
