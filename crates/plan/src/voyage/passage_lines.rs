//! The passage of a plan: the simulated tracks compared with the lines between waypoints.

use std::ops::Range;

use chart::Dangers;
use chart::route::Timestamp;

use super::orders::first_side;
use super::passage::{
    Departures, Draft, Line, NearestDanger, Passage, PassageLeg, STRAIGHT, append_leg, distance,
};
use super::sailing::SailedPlan;
use super::task::squat_m;
use crate::{Fix, Phase, Sample};

/// Waypoints that are nearer than this are one \[m\].
const ONE_PLACE_M: f64 = 1.0;
/// Distance of the places of a corridor at which depths are taken \[m\], and most of them along it and across.
const SOUNDED_M: f64 = 10.0;
const MOST_STEPS: f64 = 400.0;
/// How near things are that the crew has to know about \[m\].
const NEAR_M: f64 = 200.0;
/// Least cross-track distance \[m\]: positions by satellite are no better, and what shows charts alarms beyond it.
const LEAST_XTD_M: f64 = 10.0;
/// Least distance of the positions of a track from which dangers are searched \[m\].
const LOOKOUT_M: f64 = 5.0;

/// The places of a track, by number, between which it is straight `within` a distance: the ends among them.
fn corners(place: impl Fn(usize) -> [f64; 2], Range { start, end }: Range<usize>, within: f64) -> Vec<usize> {
    let (mut kept, mut rest) = (vec![start], vec![end]);
    while let (Some(from), Some(to)) = (kept.last().copied(), rest.last().copied()) {
        let line = Line::between(place(from), place(to));
        let away = (from + 1..to).map(|k| (k, line.away(place(k))));
        match away.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, away)| *away > within) {
            Some((farthest, _)) => rest.push(farthest),
            None => {
                rest.pop();
                kept.push(to);
            }
        }
    }
    kept
}

impl<'a> SailedPlan<'a> {
    /// Abort tracks that have moves: index of the step that each leads from the end of, with east and north of the nominal vessel,
    /// and those between which it is straight within half the beam.
    pub fn aborts(self) -> impl Iterator<Item = (usize, &'a [[f64; 2]], Vec<usize>)> {
        let within = 0.5 * self.prepared.brief.task.hull.beam_m;
        self.sailing.failures.iter().enumerate().filter_map(move |(step, one)| {
            let places = &one.abort.as_ref().ok().filter(|(track, _)| !track.moves.is_empty())?.1[..];
            Some((step, places, corners(|k| places[k], 0..places.len().checked_sub(1)?, within)))
        })
    }
}

impl SailedPlan<'_> {
    /// The passage from waypoint to waypoint, as wide as the tracks of the check.
    pub fn passage(&self) -> Passage {
        let (drafts, before, leaves) = self.drafts();
        let rate_hz = self.prepared.brief.vessel.sample_rate_hz;
        let start = self.solved.solution.steps.first().map_or([0.0; 2], |step| self.prepared.node(step.from));
        let (longitude_deg, latitude_deg) = self.geographic(start);
        let dangers = self.prepared.chart.dangers(self.prepared.brief.task.safety.transit_depth_m);
        let mut legs: Vec<PassageLeg> = drafts.iter().map(|one| self.passage_leg(one, &dangers)).collect();
        let widths = self.widths(&drafts, &dangers);
        for ((draft, [port, starboard]), leg) in drafts.iter().zip(widths).zip(&mut legs) {
            (leg.xtd_port_m, leg.xtd_starboard_m) = (port, starboard);
            self.sound(&draft.line(), leg);
        }
        let task = &self.prepared.brief.task;
        let departures = task.departure.and_then(|at| {
            let check = &self.sailing.check;
            let lasts_s = check.sailed_quantiles_s[2].max(check.sailed_s);
            Departures::around(&task.times, task.tide.as_ref(), at as f64, lasts_s)
        });
        let departure = task.departure.and_then(|at| Timestamp::from_second(at).ok());
        let departure = departure.map(|at| at.to_string());
        let tide = task.tide;
        let leave_s = leaves as f64 / rate_hz;
        Passage { departure, tide, departures, longitude_deg, latitude_deg, before, leave_s, legs }
    }

    fn geographic(&self, [north, east]: [f64; 2]) -> (f64, f64) {
        self.prepared.chart.plane().to_geographic([east, north])
    }

    /// The legs of the steps. Steps that end where they begin are listed at their waypoint: those at the first one beside the
    /// legs, with the sample at which the ship leaves it.
    fn drafts(&self) -> (Vec<Draft>, Vec<String>, usize) {
        let (mut all, mut before, mut leaves, mut sample) = (Vec::<Draft>::new(), Vec::new(), 0, 0);
        for (k, step) in self.solved.solution.steps.iter().enumerate() {
            let samples = sample..sample + self.sailing.sailed.samples.iter().filter(|s| s.leg == k).count();
            sample = samples.end;
            let (from, to) = (self.prepared.node(step.from), self.prepared.node(step.to));
            let leg = &self.prepared.legs[self.sailing.legs[k]];
            let of_step = &self.sailing.sailed.samples[samples.clone()];
            let side = first_side(of_step).map_or_else(String::new, |side| format!(", {side}"));
            let what = leg.name.clone() + &side;
            if distance(from, to) < ONE_PLACE_M {
                // Deviations at a waypoint count for the leg that leads there.
                match all.last_mut() {
                    Some(last) => {
                        last.then.push(what);
                        (last.steps.end, last.leaves) = (k + 1, samples.end);
                    }
                    None => (leaves, ()) = (samples.end, before.push(what)),
                }
                continue;
            }
            let informative = leg.is_informative();
            let straight = |what: &str, from, to, samples: Range<usize>| Draft {
                what: what.to_owned(),
                informative,
                straight: !informative && what == STRAIGHT,
                steps: k..k + 1,
                from,
                to,
                turn_radius_m: None,
                leaves: samples.end,
                samples,
                then: Vec::new(),
            };
            if informative {
                let mut begin = (from, samples.start);
                for (place, sample) in self.bends(&samples).into_iter().chain([(to, samples.end)]) {
                    all.push(straight(&what, begin.0, place, begin.1..sample));
                    begin = (place, sample);
                }
                continue;
            }
            match self.corner(k) {
                Some((corner, radius_m)) => {
                    let turn = samples.start + self.nearest(&samples, corner);
                    let mut first = straight(STRAIGHT, from, corner, samples.start..turn);
                    first.turn_radius_m = Some(radius_m);
                    append_leg(&mut all, first);
                    append_leg(&mut all, straight(STRAIGHT, corner, to, turn..samples.end));
                }
                None => append_leg(&mut all, straight(&what, from, to, samples)),
            }
        }
        (all, before, leaves)
    }

    /// The intersection of the courses at both ends of a step, if it turns under way, and the turn's radius.
    fn corner(&self, k: usize) -> Option<([f64; 2], f64)> {
        let (grid, step) = (&self.prepared.grid, &self.solved.solution.steps[k]);
        let leg = &self.prepared.legs[self.sailing.legs[k]].leg;
        let of = |phase: &Phase| if let Phase::Arc { radius_m, .. } = phase { Some(*radius_m) } else { None };
        let radius_m = leg.phases.iter().find_map(of)?;
        let [a, b] = [leg.from, leg.to].map(|layer| grid.heading_rad(grid.level_and_mode(layer).0));
        let (from, to) = (self.prepared.node(step.from), self.prepared.node(step.to));
        let [north, east] = [to[0] - from[0], to[1] - from[1]];
        let ahead = (north * libm::sin(b) - east * libm::cos(b)) / libm::sin(b - a);
        let corner = [from[0] + ahead * libm::cos(a), from[1] + ahead * libm::sin(a)];
        let apart = distance(from, corner).min(distance(corner, to));
        (ahead > 0.0 && apart.is_finite() && apart > ONE_PLACE_M).then_some((corner, radius_m))
    }

    /// The places on the nominal track, with their samples, between which it is straight within the floor of cross-track
    /// distances or a ship's length.
    fn bends(&self, samples: &Range<usize>) -> Vec<([f64; 2], usize)> {
        let all = &self.sailing.sailed.samples;
        let place = |k: usize| [all[k].pose.x, all[k].pose.y];
        let within = self.unsure_m().max(self.prepared.brief.task.hull.length_m);
        let last = samples.end.min(all.len() - 1);
        let kept = corners(place, samples.start..last, within);
        kept.iter().filter(|k| **k > samples.start && **k < last).map(|k| (place(*k), *k)).collect()
    }

    /// Half the beam, and twice the standard deviation of positions \[m\].
    fn unsure_m(&self) -> f64 {
        let task = &self.prepared.brief.task;
        0.5 * task.hull.beam_m + 2.0 * task.sensors.position_m
    }

    /// The sample of the nominal track that is nearest to `place`.
    fn nearest(&self, samples: &Range<usize>, place: [f64; 2]) -> usize {
        let away = self.sailing.sailed.samples[samples.clone()].iter();
        let away = away.map(|s| distance([s.pose.x, s.pose.y], place)).enumerate();
        away.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index)
    }

    fn passage_leg(&self, draft: &Draft, dangers: &Dangers) -> PassageLeg {
        let (longitude_deg, latitude_deg) = self.geographic(draft.to);
        let line = self.prepared.route([draft.from, draft.to]);
        let rate_hz = self.prepared.brief.vessel.sample_rate_hz;
        let places = self.places(&draft.samples);
        let bearing_deg = |between: [[f64; 2]; 2]| {
            self.prepared.route(between.map(|[east, north]| [north, east])).course_deg(0).unwrap_or(0.0)
        };
        let nearest = dangers.nearest(&places).map(|nearest| NearestDanger {
            what: nearest.called.to_string(),
            distance_m: nearest.distance_m,
            bearing_deg: bearing_deg(nearest.between),
        });
        let (speed_m_s, hull) = (self.speed_m_s(&draft.samples), &self.prepared.brief.task.hull);
        PassageLeg {
            what: draft.what.clone(),
            informative: draft.informative,
            longitude_deg,
            latitude_deg,
            course_deg: line.course_deg(0).unwrap_or(0.0),
            distance_m: line.leg_m(0).unwrap_or(0.0),
            speed_m_s,
            end_s: draft.samples.end as f64 / rate_hz,
            leave_s: draft.leaves as f64 / rate_hz,
            turn_radius_m: draft.turn_radius_m,
            xtd_port_m: 0.0,
            xtd_starboard_m: 0.0,
            least_depth_m: None,
            squat_m: hull.block_coefficient.map(|block| squat_m(block, speed_m_s)),
            under_keel_m: None,
            nearest,
            passes: self.prepared.chart.noted_near(&places, NEAR_M).into_iter().collect(),
            then: draft.then.clone(),
        }
    }

    /// The least depth in a leg's corridor along `line`, and what remains under the keel.
    fn sound(&self, line: &Line, leg: &mut PassageLeg) {
        let task = &self.prepared.brief.task;
        let across_m = leg.xtd_port_m + leg.xtd_starboard_m;
        let steps = |length_m: f64| (length_m / SOUNDED_M).ceil().clamp(1.0, MOST_STEPS) as usize;
        let (long, wide) = (steps(line.length_m), steps(across_m));
        let part = |k: usize, of: usize| k as f64 / of as f64;
        let place = |(i, j): (usize, usize)| {
            let [north, east] =
                line.place([line.length_m * part(i, long), across_m * part(j, wide) - leg.xtd_port_m]);
            [east, north]
        };
        let places: Vec<[f64; 2]> =
            (0..=long).flat_map(|i| (0..=wide).map(move |j| (i, j))).map(place).collect();
        leg.least_depth_m = self.prepared.chart.least_depth_m(&places);
        let level_m = task.tide.map_or(0.0, |tide| tide.level_m) - leg.squat_m.unwrap_or(0.0);
        let under_keel = |(depth_m, draught_m): (f64, f64)| depth_m + level_m - draught_m;
        leg.under_keel_m = leg.least_depth_m.zip(task.hull.draught_m).map(under_keel);
    }

    /// Legs with less water under the keel than the task asks for, in words.
    pub(super) fn too_shallow(&self) -> Vec<String> {
        let Some(least_m) = self.prepared.brief.task.safety.under_keel_m else { return Vec::new() };
        let legs = self.passage().legs.into_iter().zip(1..);
        let told = legs.filter_map(|(leg, number): (PassageLeg, usize)| {
            let (under_m, depth_m) = leg.under_keel_m.zip(leg.least_depth_m)?;
            let squat = leg.squat_m.map_or_else(String::new, |squat_m| format!(", squat {squat_m:.1} m"));
            (under_m < least_m).then(|| {
                format!(
                    "{under_m:.1} m under the keel on leg {number} of the passage, `{}` (charted {depth_m:.1} m{squat}), less \
                     than `safety.under_keel_m`, {least_m} m: raise `safety.transit_depth_m`",
                    leg.what
                )
            })
        });
        told.collect()
    }

    /// East and north of the nominal track, thinned for the search for dangers.
    fn places(&self, samples: &Range<usize>) -> Vec<[f64; 2]> {
        let all = &self.sailing.sailed.samples;
        let mut kept: Vec<[f64; 2]> = Vec::new();
        let last = (samples.end + 1).min(all.len());
        for (index, sample) in all[..last].iter().enumerate().skip(samples.start) {
            let place = [sample.pose.y, sample.pose.x];
            if index + 1 == last || kept.last().is_none_or(|last| distance(*last, place) >= LOOKOUT_M) {
                kept.push(place);
            }
        }
        kept
    }

    /// Mean speed along the nominal track.
    fn speed_m_s(&self, samples: &Range<usize>) -> f64 {
        let all = &self.sailing.sailed.samples;
        let of_step = &all[samples.start..(samples.end + 1).min(all.len())];
        let place = |s: &Sample| [s.pose.x, s.pose.y];
        let way: f64 = of_step.windows(2).map(|pair| distance(place(&pair[0]), place(&pair[1]))).sum();
        let seconds = of_step.len().saturating_sub(1) as f64 / self.prepared.brief.vessel.sample_rate_hz;
        if seconds > 0.0 { way / seconds } else { 0.0 }
    }

    /// Cross-track distances to port and starboard of each leg \[m\].
    fn widths(&self, drafts: &[Draft], dangers: &Dangers) -> Vec<[f64; 2]> {
        // The nominal track counts beyond the ends of legs, too, as in a circle at a waypoint.
        let strayed = self.strayed(drafts, self.sailing.sailed.fixes(), Line::away);
        let across = |line: &Line, place: [f64; 2]| line.along(place)[1].abs();
        let all = self.strayed(drafts, self.sailing.runs.iter().flatten().copied(), across);
        let each = drafts.iter().zip(strayed.iter().zip(&all));
        each.map(|(draft, (strayed, all))| {
            [0, 1].map(|side| {
                let wanted = all[side].max(strayed[side]).max(self.unsure_m()).max(LEAST_XTD_M);
                strayed[side].max(self.clear_m(&draft.line(), side, wanted, dangers))
            })
        })
        .collect()
    }

    /// How far the water beside a line is clear of dangers for the hull, to port (0) or to starboard, up to `wanted` \[m\].
    fn clear_m(&self, line: &Line, side: usize, wanted: f64, dangers: &Dangers) -> f64 {
        let half_m = 0.5 * self.prepared.brief.task.hull.beam_m;
        let mut clear_m = 0.0;
        while clear_m < wanted {
            let aside = if side == 1 { clear_m } else { -clear_m };
            let steps = (line.length_m / LOOKOUT_M).ceil().max(1.0) as usize;
            let places: Vec<[f64; 2]> = (0..=steps)
                .map(|k| line.place([line.length_m * k as f64 / steps as f64, aside]))
                .map(|[north, east]| [east, north])
                .collect();
            let left_m = dangers.nearest(&places).map_or(f64::INFINITY, |danger| danger.distance_m) - half_m;
            // Places between those that are tried are no farther from them than half a step.
            if left_m <= 0.5 * LOOKOUT_M {
                break;
            }
            clear_m += left_m;
        }
        clear_m.min(wanted)
    }

    /// The greatest deviations of tracks to port and starboard of each leg, as `off` measures them \[m\].
    fn strayed(
        &self,
        drafts: &[Draft],
        fixes: impl Iterator<Item = Fix>,
        off: impl Fn(&Line, [f64; 2]) -> f64,
    ) -> Vec<[f64; 2]> {
        let mut strayed = vec![[0.0_f64; 2]; drafts.len()];
        let lines: Vec<Line> = drafts.iter().map(Draft::line).collect();
        for fix in fixes {
            let place = [fix.pose.x, fix.pose.y];
            let near = drafts.iter().enumerate().filter(|(_, draft)| draft.steps.contains(&fix.leg));
            let indices = near.map(|(index, _)| index);
            let nearest = indices.min_by(|a, b| lines[*a].away(place).total_cmp(&lines[*b].away(place)));
            let index = nearest.unwrap_or(0);
            if let Some(line) = lines.get(index) {
                let side = usize::from(line.along(place)[1] > 0.0);
                strayed[index][side] = strayed[index][side].max(off(line, place));
            }
        }
        strayed
    }
}
