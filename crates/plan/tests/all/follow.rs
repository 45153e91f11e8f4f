//! Ships followed along their plans.

use std::collections::BTreeMap;

use plan::voyage::{
    Brief, FollowLimits, Followed, Goal, Place, PlannedStep, PlannedTrack, Prepared, Search, ShipPosition,
    Slot, StepState, Task, TrackPoint, aligned,
};

use crate::planned::{ISLAND_DEG, Planned, rich, small, small_brief};

/// Uniform numbers from 0 to 1, by a linear congruence.
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A normal number, by Box and Muller.
    fn normal(&mut self) -> f64 {
        let (radius, angle) = ((-2.0 * (1.0 - self.next()).ln()).sqrt(), std::f64::consts::TAU * self.next());
        radius * angle.cos()
    }
}

/// The planned track, as from its files.
fn track(planned: &Planned) -> PlannedTrack {
    let (plan, prepared, sailed) = (planned.plan(), &planned.prepared, &planned.sailing.sailed);
    let point =
        |at: usize, step: usize, informative: bool, pose: ship::engine::Pose, state: [f64; 3]| TrackPoint {
            at_s: at as f64 / planned.rate_hz(),
            place: [pose.y, pose.x],
            heading_deg: prepared.true_deg(pose),
            speed_m_s: state[0].hypot(state[1]),
            step,
            informative,
        };
    let samples = sailed.samples.iter().enumerate();
    let mut points: Vec<TrackPoint> =
        samples.map(|(at, own)| point(at, own.leg, own.informative, own.pose, own.state)).collect();
    let ((pose, state), last) = (sailed.ends[sailed.ends.len() - 1], points[points.len() - 1].step);
    points.push(point(points.len(), last, false, pose, state));
    PlannedTrack::new(points, &plan.legs(), &plan.primitives(), &prepared.brief.task)
}

/// Every `apart` points of a track with noise of `noise_m`, `late_s` later than planned.
fn positions(track: &PlannedTrack, apart: usize, noise_m: f64, late_s: f64) -> Vec<ShipPosition> {
    let mut draws = Draws(apart as u64 + 1);
    let position = |point: &TrackPoint| ShipPosition {
        line: 0,
        at_s: point.at_s + late_s,
        place: point.place.map(|own| own + noise_m * draws.normal()),
        heading_deg: None,
        speed_m_s: None,
    };
    track.points.iter().step_by(apart).map(position).collect()
}

fn limits(planned: &Planned, track: &PlannedTrack) -> FollowLimits {
    FollowLimits::of(&planned.prepared.brief.task, track)
}

/// Where a ship is by her positions up to a time.
fn followed(planned: &Planned, track: &PlannedTrack, all: &[ShipPosition], until_s: f64) -> Followed {
    let so_far: Vec<ShipPosition> = all.iter().take_while(|own| own.at_s <= until_s).copied().collect();
    let none = BTreeMap::new();
    track.follow(&so_far, [&none, &none], &limits(planned, track)).unwrap()
}

/// Asserts that all steps before `step` are done, that the ship is at it, and that all others are ahead.
fn assert_at(found: &Followed, step: usize, context: &str) {
    let state = |own: usize| match own.cmp(&step) {
        std::cmp::Ordering::Less => StepState::Done,
        std::cmp::Ordering::Equal => StepState::UnderWay,
        std::cmp::Ordering::Greater => StepState::Ahead,
    };
    let expected: Vec<StepState> = (0..found.states.len()).map(state).collect();
    assert_eq!((found.step, &found.states), (step, &expected), "{context}: {:?}", found.deviations_m);
}

#[test]
fn law_a_ship_on_the_plan_is_at_the_step_at_which_her_positions_end() {
    for planned in [small(), rich()] {
        let (track, legs) = (track(planned), planned.plan().legs());
        for (apart_s, late_s) in [(1.0, 0.0), (5.0, 0.0), (1.0, 400.0), (5.0, -20.0)] {
            let apart = (apart_s * planned.rate_hz()) as usize;
            let all = positions(&track, apart, 3.0, late_s);
            for (step, leg) in legs.iter().enumerate() {
                for part in [0.2, 0.5, 0.8] {
                    let cut_s = leg.start_s + part * leg.duration_s;
                    let found = followed(planned, &track, &all, cut_s + late_s);
                    assert_at(&found, step, &format!("{} at {cut_s} s, every {apart_s} s", leg.name));
                    assert!((found.delay_s - late_s).abs() < 12.0, "{} {late_s}", found.delay_s);
                    assert!(found.deviation_m < 16.0, "{}", found.deviation_m);
                    assert!(!found.finished);
                }
            }
            let found = followed(planned, &track, &all, f64::INFINITY);
            assert!(found.finished && found.states.iter().all(|own| *own == StepState::Done), "{found:?}");
        }
    }
}

#[test]
fn law_ships_within_the_stated_error_are_followed_through_unknown_currents() {
    let planned = rich();
    let (track, legs) = (track(planned), planned.plan().legs());
    assert!(planned.sailing.runs.len() >= 3);
    for run in &planned.sailing.runs {
        let mut draws = Draws(7);
        let position = |(at, fix): (usize, &plan::Fix)| ShipPosition {
            line: at,
            at_s: at as f64 / planned.rate_hz(),
            place: [fix.pose.y, fix.pose.x].map(|own| own + 3.0 * draws.normal()),
            heading_deg: None,
            speed_m_s: None,
        };
        let all: Vec<ShipPosition> = run.iter().enumerate().map(position).collect();
        for (step, leg) in legs.iter().enumerate() {
            let own: Vec<usize> = (0..run.len()).filter(|at| run[*at].leg == step).collect();
            let middle = all[own[own.len() / 2]].at_s;
            assert_at(&followed(planned, &track, &all, middle), step, &leg.name);
        }
    }
}

#[test]
fn law_a_wait_delays_and_what_is_left_out_is_missed() {
    let planned = small();
    let (track, legs) = (track(planned), planned.plan().legs());
    let wait_s = legs[2].start_s + 40.0;
    let mut all = positions(&track, 1, 3.0, 0.0);
    all.iter_mut().filter(|own| own.at_s > wait_s).for_each(|own| own.at_s += 120.0);
    let waiting: Vec<ShipPosition> =
        (1..120).map(|k| ShipPosition { at_s: wait_s + f64::from(k), ..all[wait_s as usize] }).collect();
    let later = all.split_off(wait_s as usize + 1);
    all.extend(waiting);
    all.extend(later);
    // In its maneuver she is late, and it is spoiled.
    let found = followed(planned, &track, &all, f64::INFINITY);
    let others = found.states.iter().enumerate().filter(|(step, _)| *step != 2);
    assert!(
        found.finished && others.into_iter().all(|(_, own)| *own == StepState::Done),
        "{:?}",
        found.states
    );
    assert_eq!(found.states[2], StepState::Spoiled);
    assert!(found.why[2].as_ref().unwrap().starts_with("broken off"), "{:?}", found.why);
    assert!((found.delay_s - 120.0).abs() < 12.0, "{}", found.delay_s);
    // 80 m aside for a part of a step: that one alone is missed.
    let mut aside = positions(&track, 1, 3.0, 0.0);
    let [begin, end] = [0.3, 0.7].map(|part| legs[3].start_s + part * legs[3].duration_s);
    let ramp = |at_s: f64| 80.0 * ((at_s - begin).min(end - at_s) / 10.0).clamp(0.0, 1.0);
    aside.iter_mut().for_each(|own| own.place[0] += ramp(own.at_s));
    aside.iter_mut().for_each(|own| own.place[1] += ramp(own.at_s));
    let found = followed(planned, &track, &aside, legs[5].start_s + 20.0);
    let missed: Vec<usize> = (0..legs.len()).filter(|k| found.states[*k] == StepState::Missed).collect();
    assert_eq!((found.step, missed), (5, vec![3]), "{:?}", found.deviations_m);
    assert!(found.deviations_m[3].unwrap() > 60.0);
}

#[test]
fn law_gathered_information_grows_with_every_maneuver_to_all_of_it() {
    for planned in [small(), rich()] {
        let brief = &planned.prepared.brief;
        let names: Vec<String> =
            planned.plan().legs().into_iter().filter(|leg| leg.informative).map(|leg| leg.name).collect();
        let count = |names: &[String]| {
            let mut all: BTreeMap<String, u64> = BTreeMap::new();
            names.iter().for_each(|name| *all.entry(name.clone()).or_default() += 1);
            all
        };
        let plan = count(&names);
        let so_far: Vec<_> =
            (0..=names.len()).map(|done| brief.gathered(&plan, &count(&names[..done])).unwrap()).collect();
        // Whole plans are nearly singular, about 1e10: their shares have that many digits fewer.
        let shares: Vec<f64> = so_far.iter().map(|own| own.share.unwrap()).collect();
        assert!(shares.windows(2).all(|pair| pair[0] < pair[1]), "{shares:?}");
        assert!(shares[0] == 0.0 && (shares[names.len()] - 1.0).abs() < 1e-5, "{shares:?}");
        let efficiencies: Vec<f64> = so_far.iter().map(|own| own.efficiency.unwrap_or(0.0)).collect();
        assert!(efficiencies.windows(2).all(|pair| pair[0] <= pair[1]), "{efficiencies:?}");
        assert!((efficiencies[names.len()] - 1.0).abs() < 1e-9, "{efficiencies:?}");
        // One use of a thousand times as many is a small part: to first order, ln(efficiency) falls by its share.
        let many: BTreeMap<String, u64> =
            plan.iter().map(|(name, count)| (name.clone(), 1000 * count)).collect();
        for (name, count) in &many {
            let mut less = many.clone();
            less.insert(name.clone(), count - 1);
            let found = brief.gathered(&many, &less).unwrap();
            let own = found.maneuvers.iter().find(|own| own.name == *name).unwrap();
            let share = own.share.unwrap() / *count as f64;
            let fallen = -found.efficiency.unwrap().ln();
            let left = 1.0 - found.share.unwrap() - share;
            assert!((fallen / share - 1.0).abs() < 0.01 && left.abs() < 1e-5, "{fallen} {share} {left}");
        }
    }
}

/// The least cost of an alignment, by trying every point before every point.
fn least_cost(track: &PlannedTrack, all: &[ShipPosition]) -> f64 {
    let points = &track.points;
    let mut costs: Vec<f64> = (0..points.len()).map(|k| cost_of(track, all, &[k])).collect();
    for i in 1..all.len() {
        let to = |k: usize| {
            let from = (0..=k).map(|before| costs[before] + added(track, all, i, [before, k]));
            from.fold(f64::INFINITY, f64::min)
        };
        costs = (0..points.len()).map(to).collect();
    }
    costs.into_iter().fold(f64::INFINITY, f64::min)
}

/// The cost of position `i` after the one before it, for points `from` and `to`.
fn added(track: &PlannedTrack, all: &[ShipPosition], i: usize, [from, to]: [usize; 2]) -> f64 {
    let elapsed = all[i].at_s - all[i - 1].at_s;
    let ahead = track.points[to].at_s - track.points[from].at_s - elapsed;
    let pace = if ahead > 0.0 { 0.25 * ahead } else { -0.1 * ahead };
    pace + elapsed.min(10.0) * off(track, to, &all[i])
}

fn off(track: &PlannedTrack, k: usize, own: &ShipPosition) -> f64 {
    let point = &track.points[k];
    let [x, y] = [0, 1].map(|c: usize| (own.place[c] - point.place[c]) / track.steps[point.step].within_m);
    let turned = own.heading_deg.map_or(0.0, |psi| {
        let turned = (psi - point.heading_deg).rem_euclid(360.0);
        turned.min(360.0 - turned) / 45.0
    });
    (x * x + y * y + turned * turned).min(1.0)
}

/// The cost of an alignment of the first positions.
fn cost_of(track: &PlannedTrack, all: &[ShipPosition], at: &[usize]) -> f64 {
    let first = 0.25 * track.points[at[0]].at_s + off(track, at[0], &all[0]);
    let others = (1..at.len()).map(|i| added(track, all, i, [at[i - 1], at[i]]));
    first + others.sum::<f64>()
}

#[test]
fn oracle_alignments_cost_no_more_than_the_best_of_all() {
    let mut draws = Draws(3);
    for _ in 0..40 {
        let (mut place, mut at_s) = ([0.0; 2], 0.0);
        let points: Vec<TrackPoint> = (0..40)
            .map(|k| {
                place = place.map(|own| own + 20.0 * draws.next() - 8.0);
                at_s += 0.5 + 3.0 * draws.next();
                let (heading_deg, speed_m_s) = (360.0 * draws.next(), 1.0);
                TrackPoint { at_s, place, heading_deg, speed_m_s, step: k / 8, informative: false }
            })
            .collect();
        let steps = (0..5)
            .map(|_| PlannedStep { name: String::new(), within_m: 10.0 + 20.0 * draws.next() })
            .collect();
        let track = PlannedTrack { points, steps };
        let mut at_s = 5.0 * draws.next();
        let all: Vec<ShipPosition> = (0..30)
            .map(|line| {
                at_s += 0.2 + 4.0 * draws.next();
                let near = &track.points[(line * 4 / 3).min(39)];
                let place = near.place.map(|own| own + 12.0 * draws.normal());
                let heading_deg = (draws.next() < 0.5).then(|| near.heading_deg + 20.0 * draws.normal());
                ShipPosition { line, at_s, place, heading_deg, speed_m_s: None }
            })
            .collect();
        let at = aligned(&track, &all);
        assert!(at.is_sorted() && at.len() == all.len());
        let (found, least) = (cost_of(&track, &all, &at), least_cost(&track, &all));
        assert!((found - least).abs() < 1e-9, "{found} {least}");
    }
}

#[test]
fn law_a_later_departure_leaves_the_end_of_the_slot_where_it_is() {
    let slot = Slot { key: "slot.until", lasts_s: 3600.0 };
    let task = Task { slot: Some(slot), ..rich().prepared.brief.task.clone() };
    let (departure, tide) = (task.departure.unwrap(), task.tide.unwrap());
    let later = task.departing(departure + 600);
    assert_eq!(later.departure, Some(departure + 600));
    assert_eq!((later.slot.unwrap().lasts_s, later.tide.unwrap().slot_s), (3000.0, tide.slot_s - 600.0));
}

#[test]
fn law_a_goal_near_the_shore_stays_within_a_cell_of_its_place_on_a_moved_lattice() {
    // Fifty metres west of the island.
    let place = |longitude_deg| Place { longitude_deg, latitude_deg: 60.0, heading_deg: 0.0, mode: None };
    let search = Search::unlimited();
    let mut moved = 0;
    for start in [24.9850, 24.9855, 24.9860, 24.9865] {
        let brief = small_brief();
        let goal = Goal::Places { places: vec![place(24.9971)] };
        let task = Task { start: place(start), goal, on_node: true, ..brief.task };
        let prepared = Prepared::new(Brief { task, ..brief }, &search).unwrap();
        let end = prepared.solve(&search).unwrap().solution.steps.last().unwrap().to;
        let [north, east] = prepared.node(end);
        let [x, y] = prepared.chart.plane().to_plane(24.9971, 60.0);
        let off = [east - x, north - y];
        assert!(off.iter().all(|own| own.abs() <= 180.0), "{off:?}");
        // 20 m of margin and half of the beam.
        let shore = prepared.chart.plane().to_plane(ISLAND_DEG[0], 60.0)[0];
        assert!(shore - east >= 24.0 || off[1].abs() > 100.0, "{off:?}");
        moved += u32::from(off.iter().any(|own| own.abs() > 60.0));
    }
    assert!(moved > 0);
}
