//! Laws of whole plans, computed here by plain means.

use plan::lattice::Step;
use plan::voyage::{Check, Goal, Place, Prepared, Primary, Search, SettledLeg, VoyageError};
use plan::{Deviations, Sensors};
use ship::engine::{Changes, ChangingCurrent, Pose, Wind, simulate_one};

use crate::planned::{ISLAND_DEG, Planned, rich, small, small_brief};

/// East and north of the island: lowest, then highest \[m\].
pub fn island(planned: &Planned) -> [[f64; 2]; 2] {
    let [west, south, east, north] = ISLAND_DEG;
    let plane = planned.prepared.chart.plane();
    [plane.to_plane(west, south), plane.to_plane(east, north)]
}

/// Distance of a place from a box.
pub fn from_box([low, high]: [[f64; 2]; 2], place: [f64; 2]) -> f64 {
    let off = [0, 1].map(|k| (low[k] - place[k]).max(place[k] - high[k]).max(0.0));
    off[0].hypot(off[1])
}

/// Places along the sides of a hull at a pose, east and north.
pub fn hull(planned: &Planned, pose: Pose) -> Vec<[f64; 2]> {
    let corners = planned.prepared.brief.task.hull.outline();
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let along = |(a, b): (&[f64; 2], &[f64; 2])| {
        let (a, b) = (*a, *b);
        (0..20).map(move |k| [0, 1].map(|i| a[i] + (b[i] - a[i]) * f64::from(k) / 20.0))
    };
    let (sin, cos) = pose.psi.sin_cos();
    let place =
        |[ahead, aside]: [f64; 2]| [pose.y + ahead * sin + aside * cos, pose.x + ahead * cos - aside * sin];
    sides.flat_map(along).map(place).collect()
}

fn steps(planned: &Planned) -> impl Iterator<Item = (&Step, &SettledLeg)> {
    let legs = planned.sailing.legs.iter().map(|leg| &*planned.prepared.legs[*leg]);
    planned.solved.solution.steps.iter().zip(legs)
}

#[test]
fn law_the_hull_keeps_the_clearance_from_the_island_that_the_check_states() {
    let planned = small();
    let (samples, island) = (&planned.sailing.sailed.samples, island(planned));
    let places = samples.iter().flat_map(|sample| hull(planned, sample.pose));
    let least = places.map(|place| from_box(island, place)).fold(f64::INFINITY, f64::min);
    let stated = planned.sailing.check.clearance_m;
    // A cell of the finest raster, and half of the way between two samples.
    assert!(stated <= least + 0.1 && stated > least - 5.0, "{stated} {least}");
    let drawn = planned.sailing.runs.iter().map(|run| {
        let places = run.iter().flat_map(|fix| hull(planned, fix.pose));
        places.map(|place| from_box(island, place)).fold(f64::INFINITY, f64::min)
    });
    let nearest = drawn.fold(f64::INFINITY, f64::min);
    let [stated, ..] = planned.sailing.check.clearance_quantiles_m;
    assert!(stated <= nearest + 0.1 && stated > nearest - 5.0, "{stated} {nearest}");
}

#[test]
fn law_the_cost_of_a_walk_is_the_sum_of_its_legs() {
    let of = |planned: &Planned| {
        let seconds = |own: &SettledLeg| own.sailed.samples.len() as f64 / planned.rate_hz();
        let basic = steps(planned).filter(|(_, own)| !own.is_informative()).count() as f64;
        (basic, steps(planned).map(|(_, own)| seconds(own)).sum::<f64>())
    };
    let (basic, seconds) = of(small());
    assert_eq!(
        [small().solved.solution.cost.primary, small().solved.solution.cost.secondary],
        [basic, seconds]
    );
    assert_eq!(small().sailing.check.proved_s, seconds);
    let (_, seconds) = of(rich());
    assert_eq!(rich().solved.solution.cost.primary, seconds);
    for planned in [small(), rich()] {
        let sailed = planned.sailing.sailed.samples.len() as f64 / planned.rate_hz();
        assert_eq!(planned.sailing.check.sailed_s, sailed);
        assert!((sailed - of(planned).1).abs() < 0.02 * sailed, "{sailed}");
        for wanted in &planned.prepared.wanted {
            let uses = steps(planned).filter(|(_, own)| own.name == wanted.piece.maneuver).count();
            assert_eq!(uses, wanted.count as usize);
        }
    }
}

#[test]
fn law_nearness_costs_by_the_distance_of_the_nodes_from_the_island_and_the_shoal() {
    let planned = rich();
    let (grid, plane) = (&planned.prepared.grid, planned.prepared.chart.plane());
    // What is shallower than 4 m less the tide's half metre, and the rock.
    let shoal = [plane.to_plane(25.008, 60.003), plane.to_plane(25.012, 60.006)];
    let rock = [plane.to_plane(25.006, 59.9945), plane.to_plane(25.0062, 59.9946)];
    let obstacles = [island(planned), shoal, rock];
    // The raster has them up to a cell and a half nearer.
    let [least, most] = [0.0, 45.0].map(|nearer_m| {
        let class = |step: &Step| {
            let node = grid.pose(step.from.i, step.from.j, 0);
            let away = obstacles.map(|own| from_box(own, [node.y, node.x])).into_iter();
            (3 - ((away.fold(f64::INFINITY, f64::min) - nearer_m) / 120.0) as i32).max(0)
        };
        f64::from(steps(planned).map(|(step, _)| class(step)).sum::<i32>())
    });
    let found = planned.solved.solution.cost.secondary;
    assert!(0.0 < least && least <= found && found <= most && most < 6.0, "{least} {found} {most}");
}

#[test]
fn law_moves_lead_from_node_to_node_and_the_ship_along_them() {
    for planned in [small(), rich()] {
        let grid = &planned.prepared.grid;
        let mut at = planned.solved.problem.start();
        for ((step, own), (end, [u, v, r])) in steps(planned).zip(&planned.sailing.sailed.ends) {
            assert_eq!((step.from, step.from.layer), (at, own.leg.from));
            at = step.to;
            let moved = [at.i as i32 - step.from.i as i32, at.j as i32 - step.from.j as i32];
            assert_eq!((moved, at.layer), ([own.leg.di, own.leg.dj], own.leg.to));
            let (level, mode) = grid.level_and_mode(at.layer);
            let node = grid.pose(at.i, at.j, level);
            let turned =
                (end.psi - node.psi + 9.0 * std::f64::consts::PI).rem_euclid(2.0 * std::f64::consts::PI);
            assert!((end.x - node.x).hypot(end.y - node.y) <= 12.0, "{end:?} {node:?}");
            assert!((turned - std::f64::consts::PI).abs() <= 6.0_f64.to_radians(), "{end:?}");
            assert!((u - grid.modes[mode].speed_m_s).abs() <= 0.1 && v.abs() <= 0.25 && r.abs() <= 0.0075);
        }
        // North and east move on by the speeds over the ground.
        let samples = &planned.sailing.sailed.samples;
        for (now, next) in samples.iter().zip(&samples[1..]) {
            let ([u, v, r], (sin, cos)) = (now.state, now.pose.psi.sin_cos());
            let dt = 1.0 / planned.rate_hz();
            assert!((now.pose.x + (u * cos - v * sin) * dt - next.pose.x).abs() < 1e-9);
            assert!((now.pose.y + (u * sin + v * cos) * dt - next.pose.y).abs() < 1e-9);
            assert!((now.pose.psi + r * dt - next.pose.psi).abs() < 1e-9);
        }
    }
}

#[test]
fn law_home_is_the_start_and_legs_follow_each_other_in_time() {
    let steps = &small().solved.solution.steps;
    assert_eq!(steps[0].from, steps[steps.len() - 1].to);
    for planned in [small(), rich()] {
        let mut time_s = 0.0;
        for own in planned.plan().legs() {
            assert_eq!(own.start_s, time_s);
            time_s += own.duration_s;
            let Some((begin, lasts)) = own.maneuver_start_s.zip(own.maneuver_s) else { continue };
            assert!(begin >= own.start_s && begin + lasts <= time_s);
            let wanted = planned.prepared.wanted.iter().find(|wanted| wanted.piece.maneuver == own.name);
            assert_eq!(wanted.unwrap().piece.samples as f64 / planned.rate_hz(), lasts);
        }
        assert_eq!(time_s, planned.sailing.check.sailed_s);
    }
}

/// The regressors of surge, sway and yaw of the vessel of Helsinki, with the constant.
fn regressors([u, v, r]: [f64; 3], inputs: &[f64]) -> [Vec<f64>; 3] {
    [
        vec![u, u * u.abs(), v * r, inputs[0], 1.0],
        vec![v, u * r, inputs[1], 1.0],
        vec![r, u * v, inputs[2], 1.0],
    ]
}

/// log|det| of a matrix, by elimination with pivots.
fn log_det(mut rows: Vec<Vec<f64>>) -> f64 {
    let mut sum = 0.0;
    while let Some(pivot) = (0..rows.len()).max_by(|a, b| rows[*a][0].abs().total_cmp(&rows[*b][0].abs())) {
        let own = rows.swap_remove(pivot);
        sum += own[0].abs().ln();
        for row in &mut rows {
            let factor = row[0] / own[0];
            *row = row.iter().zip(&own).skip(1).map(|(a, b)| a - factor * b).collect();
        }
    }
    sum
}

/// The sum over surge, sway and yaw of log|det| of Σ φ ζᵀ of `parts`: inputs and states of each, and how often it counts.
/// ζ is of the nominal model with the same inputs from the same state.
fn information(planned: &Planned, parts: &[(Vec<f64>, Vec<f64>, f64)]) -> f64 {
    let vessel = &planned.prepared.brief.vessel;
    let mut sums = [5, 4, 4].map(|n| vec![vec![0.0; n]; n]);
    for (inputs, states, times) in parts {
        let initial = [states[0], states[1], states[2]];
        let nominal = simulate_one(&vessel.model, &vessel.nominal, initial, inputs);
        for (k, own) in inputs.chunks_exact(3).enumerate() {
            let state = |of: &[f64]| [of[3 * k], of[3 * k + 1], of[3 * k + 2]];
            let both = regressors(state(states), own).into_iter().zip(regressors(state(&nominal), own));
            for (sum, (phi, zeta)) in sums.iter_mut().zip(both) {
                let each = sum.iter_mut().zip(&phi);
                each.for_each(|(row, x)| row.iter_mut().zip(&zeta).for_each(|(to, z)| *to += times * x * z));
            }
        }
    }
    sums.into_iter().map(log_det).sum()
}

/// At constant speeds u and u |u| are nearly one: this is left of the digits of their determinant.
const ROUNDED: f64 = 1e-3;

#[test]
fn oracle_the_information_of_a_plan_is_the_sum_over_its_maneuvers() {
    for planned in [small(), rich()] {
        let vessel = &planned.prepared.brief.vessel;
        let pieces = planned.prepared.wanted.iter().map(|wanted| {
            let initial = [wanted.piece.speed_m_s, 0.0, 0.0];
            let states = simulate_one(&vessel.model, &vessel.nominal, initial, &wanted.piece.inputs);
            (wanted.piece.inputs.clone(), states, f64::from(wanted.count))
        });
        let found = &planned.sailing.information;
        let promised = information(planned, &pieces.collect::<Vec<_>>());
        assert!((found.predicted_log_det.unwrap() - promised).abs() < ROUNDED, "{promised} {found:?}");
        let samples = &planned.sailing.sailed.samples;
        let last = planned.sailing.sailed.ends.last().unwrap().1;
        let part = |from: usize, to: usize| {
            let after = samples.get(to).map_or(last, |sample| sample.state);
            let states = samples[from..to].iter().map(|sample| sample.state).chain([after]);
            let inputs = samples[from..to].iter().flat_map(|sample| sample.inputs.clone()).collect();
            (inputs, states.flatten().collect::<Vec<f64>>(), 1.0)
        };
        let bounds = (0..samples.len()).filter(|k| {
            let before = k.checked_sub(1).map(|k| &samples[k]);
            before.is_none_or(|before| {
                before.leg != samples[*k].leg || before.informative != samples[*k].informative
            })
        });
        let bounds: Vec<usize> = bounds.chain([samples.len()]).collect();
        let parts = bounds.windows(2).filter(|pair| samples[pair[0]].informative);
        let realised = information(planned, &parts.map(|pair| part(pair[0], pair[1])).collect::<Vec<_>>());
        assert!((found.realised_log_det.unwrap() - realised).abs() < ROUNDED, "{realised} {found:?}");
        let whole = information(planned, &[part(0, samples.len())]);
        assert!((found.whole_log_det.unwrap() - whole).abs() < ROUNDED, "{whole} {found:?}");
        assert!((found.efficiency.unwrap().ln() * 13.0 - (realised - promised)).abs() < ROUNDED);
    }
}

#[test]
fn oracle_the_efficiency_of_counts_is_against_the_shares_over_the_same_time() {
    let planned = rich();
    let (brief, wanted) = (&planned.prepared.brief, &planned.prepared.wanted);
    let samples: f64 = wanted.iter().map(|own| f64::from(own.count) * own.piece.samples as f64).sum();
    let shares = &brief.design.as_ref().unwrap().share;
    let parts: Vec<_> = brief
        .dictionary
        .iter()
        .filter_map(|run| {
            let share = shares.get(&run.segments[0].maneuver)?;
            let times = share * samples / run.samples() as f64;
            Some((run.exogenous.clone(), run.measured.clone(), times))
        })
        .collect();
    let found = &planned.sailing.information;
    let expected = ((found.predicted_log_det.unwrap() - information(planned, &parts)) / 13.0).exp();
    assert!((found.design_efficiency.unwrap() - expected).abs() < ROUNDED, "{expected} {found:?}");
}

#[test]
fn law_each_track_is_in_the_corridor_of_some_leg() {
    for planned in [small(), rich()] {
        let plane = planned.prepared.chart.plane();
        let passage = planned.plan().passage();
        let mut corner = plane.to_plane(passage.longitude_deg, passage.latitude_deg);
        let mut lines = Vec::new();
        for leg in &passage.legs {
            let to = plane.to_plane(leg.longitude_deg, leg.latitude_deg);
            let along = [to[0] - corner[0], to[1] - corner[1]];
            let length = along[0].hypot(along[1]);
            assert!((leg.distance_m / length - 1.0).abs() < 1e-5, "{leg:?} {length}");
            let course = along[0].atan2(along[1]).to_degrees().rem_euclid(360.0);
            // North of the plane is that of its centre.
            let turned = (course - leg.course_deg + 180.0).rem_euclid(360.0) - 180.0;
            assert!(turned.abs() < 0.02, "{leg:?} {course}");
            lines.push((corner, along.map(|k| k / length), length, [leg.xtd_port_m, leg.xtd_starboard_m]));
            corner = to;
        }
        let is_in = |place: [f64; 2]| {
            lines.iter().any(|(from, [east, north], length, [port, starboard])| {
                let off = [place[0] - from[0], place[1] - from[1]];
                let (along, across) = (off[0] * east + off[1] * north, off[0] * north - off[1] * east);
                // At its ends she turns or sways: the nominal vessel by her length, which is a bend beyond it, others by
                // as much more as they stray across.
                let beyond = planned.prepared.brief.task.hull.length_m + port.max(*starboard);
                (-beyond..=length + beyond).contains(&along)
                    && -port - 0.01 <= across
                    && across <= starboard + 0.01
            })
        };
        let nominal = planned.sailing.sailed.fixes();
        for fix in nominal.chain(planned.sailing.runs.iter().flatten().copied()) {
            assert!(is_in([fix.pose.y, fix.pose.x]), "{fix:?} {lines:?}");
        }
        // As narrow as that: half the beam and twice the noise of positions at least, and some track at every width.
        let floor = 4.0 + 2.0 * planned.prepared.brief.task.sensors.position_m;
        assert!(lines.iter().all(|line| line.3.iter().all(|wide| (floor..50.0).contains(wide))));
        let corridors = passage.corridors(plane);
        for ((from, [east, north], length, [port, starboard]), corners) in lines.iter().zip(corridors) {
            let at = |along: f64, across: f64| {
                [from[0] + along * east + across * north, from[1] + along * north - across * east]
            };
            let expected = [at(0.0, -port), at(*length, -port), at(*length, *starboard), at(0.0, *starboard)];
            for (corner, expected) in corners.unwrap().iter().zip(expected) {
                assert!((corner[0] - expected[0]).hypot(corner[1] - expected[1]) < 1e-6);
            }
        }
    }
}

#[test]
fn law_a_passage_takes_the_time_and_the_way_of_the_track() {
    for planned in [small(), rich()] {
        let passage = planned.plan().passage();
        let mut time_s = passage.leave_s;
        let samples = &planned.sailing.sailed.samples;
        for leg in &passage.legs {
            let own = &samples[time_s as usize..samples.len().min(leg.end_s as usize + 1)];
            let way: f64 = own
                .windows(2)
                .map(|pair| (pair[1].pose.x - pair[0].pose.x).hypot(pair[1].pose.y - pair[0].pose.y))
                .sum();
            assert!((leg.speed_m_s * (own.len() - 1) as f64 - way).abs() < 1e-6, "{leg:?} {way}");
            assert!(leg.end_s > time_s && leg.leave_s >= leg.end_s, "{leg:?}");
            time_s = leg.leave_s;
        }
        assert_eq!(time_s, planned.sailing.check.sailed_s);
    }
    let keel = |leg: &plan::voyage::PassageLeg| leg.under_keel_m.unwrap() - leg.least_depth_m.unwrap();
    // Half a metre of tide above a draught of 3 m.
    assert!(rich().plan().passage().legs.iter().all(|leg| (keel(leg) + 2.5).abs() < 1e-9));
}

#[test]
fn law_the_worst_vessels_are_within_the_stated_errors_and_no_better_than_drawn_ones() {
    for (planned, error, bound) in [(small(), 0.0, 0.05), (rich(), 5.0, 0.07)] {
        let check = &planned.sailing.check;
        let worst = check.worst.as_ref().unwrap();
        for who in [&worst.nearest, &worst.farthest] {
            assert!(who.current_m_s <= bound + 1e-12 && (0.0..360.0).contains(&who.towards_deg), "{who:?}");
            assert_eq!(who.parameters_percent.len(), 10);
            assert!(who.parameters_percent.values().all(|off| off.abs() <= error + 0.005), "{who:?}");
            let own = &planned.prepared.legs[planned.sailing.legs[who.step as usize - 1]];
            assert_eq!((&who.leg, who.informative), (&own.name, own.is_informative()));
        }
        assert!(worst.clearance_m <= check.clearance_m && worst.tolerance_used >= check.tolerance_used);
        assert!(worst.clearance_m <= check.clearance_quantiles_m[0], "{worst:?}");
        assert_eq!(worst.ends, worst.searched * planned.sailing.legs.len() as u64);
        assert_eq!(check.ends, check.runs * planned.sailing.legs.len() as u64);
    }
}

/// The cost of the plan of a trial, and with the first recovery of each maneuver, heading and side alone.
fn costs(mut prepared: Prepared) -> [[f64; 2]; 2] {
    let cost = |prepared: &Prepared| {
        let found = prepared.solve(&Search::unlimited()).unwrap().solution.cost;
        [found.primary, found.secondary]
    };
    let all = cost(&prepared);
    let mut known = Vec::new();
    prepared.legs.retain(|own| {
        let key = (own.name.clone(), own.leg.purpose.side(), own.leg.from);
        let is_first = !own.is_informative() || !known.contains(&key);
        known.push(key);
        is_first
    });
    [all, cost(&prepared)]
}

#[test]
fn law_further_recoveries_never_make_a_plan_dearer() {
    let wide = |error: f64, primary: Primary| {
        let mut brief = small_brief();
        brief.task.deviations = Deviations::Box(error);
        brief.task.cost.primary = primary;
        Prepared::new(brief, &Search::unlimited()).unwrap()
    };
    let trials = [0.1, 0.2, 0.3]
        .into_iter()
        .flat_map(|error| [wide(error, Primary::BasicMoves), wide(error, Primary::Seconds)]);
    let mut gained = 0;
    for prepared in trials.chain([small(), rich()].map(|planned| planned.prepared.clone())) {
        let [all, first] = costs(prepared);
        assert!(all <= first, "{all:?} {first:?}");
        gained += usize::from(all < first);
    }
    assert!(gained > 0);
}

#[test]
fn law_noise_alone_tells_no_vessels_apart_that_a_search_compares() {
    let mut brief = small_brief();
    // Too little to change a parameter: every vessel within the errors is the nominal one.
    brief.task.deviations = Deviations::Box(1e-300);
    brief.task.safety.unknown_current_m_s = 0.0;
    brief.task.maneuvers.remove(0);
    let place = Place { latitude_deg: 60.006, heading_deg: 90.0, ..brief.task.start.clone() };
    brief.task.goal = Goal::Places { places: vec![place] };
    let mut prepared = Prepared::new(brief, &Search::unlimited()).unwrap();
    // With such noise too many legs end off, and after the first search of vessels no plan is left.
    prepared.brief.task.sensors = Sensors { position_m: 15.0, ..Sensors::default() };
    let refused = prepared.plan(&Search::unlimited(), false).map(|_| ()).unwrap_err().to_string();
    // Either bound of ten parameters and of two components of the current, and one corner for all legs.
    assert!(refused.contains("of 25 vessels searched"), "{refused}");
}

#[test]
fn law_changing_water_moves_the_vessels_of_a_check_and_leaves_the_nominal_one() {
    let with = |changes: Changes| {
        let mut brief = small_brief();
        brief.task.changes = changes;
        let mut prepared = Prepared::new(brief, &Search::unlimited()).unwrap();
        let (_, sailing) = prepared.plan(&Search::unlimited(), false).unwrap();
        (sailing.check, sailing.legs, sailing.runs)
    };
    let current = ChangingCurrent { std_m_s: 0.01, time_constant_s: 60.0 };
    let wind = Wind {
        std_surge_m_s2: 0.001,
        std_sway_m_s2: 0.002,
        std_yaw_rad_s2: 1e-5,
        time_constant_s: Some(20.0),
    };
    let (steady, legs, runs) = with(Changes::default());
    for changes in
        [Changes { current: Some(current), wind: None }, Changes { current: None, wind: Some(wind) }]
    {
        let (check, own_legs, own_runs) = with(changes);
        assert_eq!(own_legs, legs);
        assert_eq!((check.clearance_m, check.sailed_s), (steady.clearance_m, steady.sailed_s));
        let worst = |of: &Check| of.worst.as_ref().map(|own| own.tolerance_used);
        assert!(own_runs.len() == runs.len() && own_runs.iter().zip(&runs).all(|(own, other)| own != other));
        assert_ne!(worst(&check), worst(&steady));
        assert_eq!(with(changes).0, check, "drawn anew");
    }
}

#[test]
fn law_what_runs_leave_possible_is_by_the_binomial_distribution() {
    for (planned, runs) in [(small(), 4.0), (rich(), 12.0)] {
        let check = &planned.sailing.check;
        assert_eq!((check.runs as f64, check.aground, check.rounds), (runs, 0, 1));
        // So many runs without one aground are as probable as the doubt of the first round: half of 5 %.
        let bound = check.aground_bound.unwrap();
        assert!(((1.0 - bound).powf(runs) - 0.025).abs() < 1e-9, "{bound}");
        let z2 = 1.959_963_984_540_054_f64.powi(2);
        assert!((check.aground_interval[1] - z2 / (runs + z2)).abs() < 1e-9, "{check:?}");
    }
}

#[test]
fn law_a_leg_fits_where_its_hull_keeps_the_margin() {
    let planned = small();
    let (waters, grid) = (&planned.solved.waters, &planned.prepared.grid);
    let (frame, island) = (planned.plan().frame(), island(planned));
    let mut counts = [0, 0];
    for (index, own) in planned.prepared.legs.iter().enumerate() {
        let outlines: Vec<[f64; 2]> = own
            .sailed
            .samples
            .iter()
            .step_by(5)
            .flat_map(|sample| hull(planned, sample.pose))
            .step_by(10)
            .collect();
        let spread = own.spread_m() + 12.0;
        for (i, j) in (0..grid.nx).flat_map(|i| (0..grid.ny).map(move |j| (i, j))) {
            let node = grid.pose(i, j, 0);
            let places = outlines.iter().map(|place| [place[0] + node.y, place[1] + node.x]);
            let clear = places.map(|place| {
                let inside = [0, 1].map(|k| (place[k] - frame.min[k]).min(frame.max[k] - place[k]));
                (from_box(island, place) - 20.0).min(inside[0]).min(inside[1])
            });
            let clear = clear.fold(f64::INFINITY, f64::min);
            let fits = waters.fits(index, i, j);
            // By as much as vessels spread, and by two cells of 30 m, it may be more than the nominal hull needs.
            assert!(!fits || clear >= -1.0, "{} at {i}, {j}: {clear}", own.name);
            assert!(fits || clear <= spread + 85.0, "{} at {i}, {j}: {clear}", own.name);
            counts[usize::from(fits)] += 1;
        }
        let all = (0..grid.nx).flat_map(|i| (0..grid.ny).map(move |j| (i, j)));
        assert_eq!(waters.fits_at(index), all.filter(|(i, j)| waters.fits(index, *i, *j)).count());
    }
    assert!(counts[0] > 1000 && counts[1] > 1000, "{counts:?}");
}

#[test]
fn law_faster_legs_are_not_offered_where_a_speed_limit_holds() {
    let planned = rich();
    let (waters, grid, plane) =
        (&planned.solved.waters, &planned.prepared.grid, planned.prepared.chart.plane());
    let limited = [plane.to_plane(24.98, 60.004), plane.to_plane(24.992, 60.01)];
    let inside = |i: usize, j: usize| {
        let node = grid.pose(i, j, 0);
        from_box(limited, [node.y, node.x]) == 0.0
    };
    let nodes = || (0..grid.nx).flat_map(|i| (0..grid.ny).map(move |j| (i, j)));
    assert!(nodes().filter(|(i, j)| inside(*i, *j)).count() > 15);
    let mut slow_ones = 0;
    for (index, own) in planned.prepared.legs.iter().enumerate() {
        let ends = [own.leg.from, own.leg.to].map(|layer| grid.modes[grid.level_and_mode(layer).1].speed_m_s);
        let fastest = own.sailed.samples.iter().map(|sample| sample.state[0].hypot(sample.state[1]));
        let is_fast = ends[0].max(ends[1]) > 1.0 || fastest.fold(0.0, f64::max) > 1.1;
        let there = nodes().filter(|(i, j)| inside(*i, *j) && waters.fits(index, *i, *j)).count();
        assert!(!is_fast || there == 0, "{}: {there}", own.name);
        slow_ones += there;
    }
    assert!(slow_ones > 100, "{slow_ones}");
}

#[test]
fn law_a_plan_in_its_slot_is_taken_and_one_second_less_is_too_short() {
    let planned = small();
    let mut prepared = planned.prepared.clone();
    let sailed = &planned.sailing.sailed;
    let lasts_s = planned.sailing.check.sailed_s;
    let mut of = |lasts_s: f64| {
        prepared.brief.task.slot = Some(plan::voyage::Slot { key: "slot", lasts_s });
        prepared.check_slot(sailed)
    };
    assert_eq!(of(lasts_s), Ok(()));
    let Err(VoyageError::NoAnswer(refused)) = of(lasts_s - 1.0) else { panic!() };
    assert_eq!((refused.thing.as_str(), refused.found.as_str()), ("`slot`", "a slot of 1538 s"));
    assert!(refused.expected.starts_with("1539 s"), "{refused}");
}

#[test]
fn law_the_map_shows_what_the_hull_sweeps_and_where_maneuvers_begin() {
    for planned in [small(), rich()] {
        let (grid, swept) = planned.plan().swept().unwrap();
        let is_swept = |place: [f64; 2]| {
            let at = [0, 1].map(|k| ((place[k] - grid.origin[k]) / grid.cell_m).floor() as i64);
            let near = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [at[0] + i, at[1] + j]));
            near.into_iter().any(|[i, j]| swept[j as usize * grid.nx + i as usize])
        };
        let samples = &planned.sailing.sailed.samples;
        assert!(samples.iter().flat_map(|sample| hull(planned, sample.pose)).all(is_swept));
        let begin = |k: &usize| samples[*k].informative && !samples[*k - 1].informative;
        let begins: Vec<usize> = (1..samples.len()).filter(begin).collect();
        let hulls = planned.plan().hulls();
        assert_eq!(hulls.len(), begins.len());
        for (found, k) in hulls.iter().zip(begins) {
            let bow = hull(planned, samples[k].pose)[0];
            assert!((found[0][0] - bow[0]).hypot(found[0][1] - bow[1]) < 1e-9);
        }
        let points: usize = planned.plan().track().iter().map(|part| part.points.len()).sum();
        assert_eq!(points, samples.len() + planned.plan().track().len());
    }
}
