//! Footprints against brute-force sampling of the moving hull.

use std::f64::consts::FRAC_PI_2;

use chart::Footprint;
use proptest::prelude::*;

use crate::support::from_polygon;

const TIMES: usize = 400;

fn hull_at(hull: &[[f64; 2]], (x, y, heading): (f64, f64, f64)) -> Vec<[f64; 2]> {
    let (north, east) = (heading.cos(), heading.sin());
    let mut ring: Vec<[f64; 2]> =
        hull.iter().map(|p| [x + p[0] * east + p[1] * north, y + p[0] * north - p[1] * east]).collect();
    ring.push(ring[0]);
    ring
}

fn ways(poses: &[(f64, f64, f64)], hull: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
    let at = |w: &[(f64, f64, f64)], t: f64| {
        let turn = (w[1].2 - w[0].2).sin().atan2((w[1].2 - w[0].2).cos());
        hull_at(hull, (w[0].0 + t * (w[1].0 - w[0].0), w[0].1 + t * (w[1].1 - w[0].1), w[0].2 + t * turn))
    };
    let mut rings: Vec<_> = poses
        .windows(2)
        .flat_map(|w| (0..=TIMES).map(|i| at(w, i as f64 / TIMES as f64)).collect::<Vec<_>>())
        .collect();
    rings.push(hull_at(hull, poses[0]));
    rings
}

fn covers(footprint: &Footprint, p: [f64; 2]) -> bool {
    let cell = p.map(|v| (v / footprint.cell_m()).floor() as i32);
    footprint.runs().iter().any(|r| r.row == cell[1] && (r.first..=r.last).contains(&cell[0]))
}

/// Convex and not: a ship, a box, an L.
fn hull() -> impl Strategy<Value = Vec<[f64; 2]>> {
    let ship = |l: f64, b: f64| vec![[l, 0.0], [l * 0.7, b], [-l, b], [-l, -b], [l * 0.7, -b]];
    let l = |l: f64, b: f64| vec![[l, -b], [l, 0.0], [0.0, 0.0], [0.0, b], [-l, b], [-l, -b]];
    (any::<bool>(), 2.0..90.0_f64, 1.0..30.0_f64)
        .prop_map(move |(convex, length, beam)| if convex { ship(length, beam) } else { l(length, beam) })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn oracle_footprints_are_what_the_sampled_hull_covers(
        hull in hull(),
        poses in prop::collection::vec((-150.0..150.0_f64, -150.0..150.0_f64, -4.0..8.0_f64), 1..4),
        cell_m in 8.0..40.0_f64,
    ) {
        let footprint = Footprint::swept(&hull, &poses, cell_m).unwrap();
        let rings = ways(&poses, &hull);
        for ring in &rings {
            // Along the edges, and the hull's inside as far as it is wider than a cell.
            for w in ring.windows(2) {
                for t in (0..=20).map(|i| f64::from(i) / 20.0) {
                    let p = [w[0][0] + t * (w[1][0] - w[0][0]), w[0][1] + t * (w[1][1] - w[0][1])];
                    prop_assert!(covers(&footprint, p), "missed {p:?}");
                }
            }
            let inner = (-6..=6).flat_map(|i| (-6..=6).map(move |j| [f64::from(i), f64::from(j)]));
            for p in inner.map(|p| [ring[0][0] + p[0] * cell_m / 2.0, ring[0][1] + p[1] * cell_m / 2.0]) {
                prop_assert!(from_polygon(std::slice::from_ref(ring), p) > 0.0 || covers(&footprint, p), "missed inside {p:?}");
            }
        }
        for run in footprint.runs() {
            for col in run.first..=run.last {
                let samples = (0..81).map(|i| {
                    [(f64::from(col) + f64::from(i % 9) / 8.0) * cell_m, (f64::from(run.row) + f64::from(i / 9) / 8.0) * cell_m]
                });
                let near = samples
                    .flat_map(|p| rings.iter().step_by(4).map(move |r| from_polygon(std::slice::from_ref(r), p)))
                    .fold(f64::MAX, f64::min);
                prop_assert!(near < 0.2 * cell_m + 2.0, "covered {col} {} for nothing: {near}", run.row);
            }
        }
    }

    #[test]
    fn law_runs_are_sorted_and_merged(
        hull in hull(), poses in prop::collection::vec((-300.0..300.0_f64, -300.0..300.0_f64, -4.0..8.0_f64), 1..5),
    ) {
        let footprint = Footprint::swept(&hull, &poses, 12.5).unwrap();
        for w in footprint.runs().windows(2) {
            prop_assert!(w[0].row < w[1].row || (w[0].row == w[1].row && w[0].last + 1 < w[1].first));
        }
        prop_assert!(footprint.runs().iter().all(|r| r.first <= r.last));
    }

    #[test]
    fn law_what_is_swept_turns_with_the_poses(
        hull in hull(), poses in prop::collection::vec((-300.0..300.0_f64, -300.0..300.0_f64, -4.0..8.0_f64), 1..5),
    ) {
        let to_port: Vec<_> = poses.iter().map(|(x, y, heading)| (-y, *x, heading - FRAC_PI_2)).collect();
        let [own, turned] = [&poses, &to_port].map(|poses| Footprint::swept(&hull, poses, 12.5).unwrap());
        prop_assert_eq!(own.turned(1), turned.clone());
        prop_assert_eq!(own.turned(4), own);
        prop_assert_eq!(turned.turned(4), turned);
    }
}

#[test]
fn starboard_is_to_the_right_of_the_bow() {
    // A hull that lies ahead and to starboard of the reference point, at rest.
    let hull = [[10.0, 10.0], [40.0, 10.0], [40.0, 20.0], [10.0, 20.0]];
    let at = |heading: f64| {
        let f = Footprint::swept(&hull, &[(0.0, 0.0, heading)], 5.0).unwrap();
        let x: Vec<i32> = f.runs().iter().flat_map(|r| [r.first, r.last]).collect();
        let y: Vec<i32> = f.runs().iter().map(|r| r.row).collect();
        [x.iter().min(), x.iter().max(), y.iter().min(), y.iter().max()].map(|v| *v.unwrap())
    };
    // Touching counts: one more cell on each side.
    assert_eq!(at(0.0), [1, 4, 1, 8], "north: ahead is y, starboard is x");
    assert_eq!(at(std::f64::consts::FRAC_PI_2), [1, 8, -5, -2], "east: ahead is x, starboard is −y");
}

#[test]
fn a_turn_takes_the_shorter_way() {
    let hull = [[100.0, 0.0], [-1.0, 1.0], [-1.0, -1.0]];
    let f = Footprint::swept(&hull, &[(0.0, 0.0, 6.0), (0.0, 0.0, 0.3)], 5.0).unwrap();
    assert!(f.runs().iter().all(|r| r.row >= -1), "never points south");
}

#[test]
fn hulls_and_motions_that_make_no_sense_are_refused() {
    let hull = [[10.0, 0.0], [-10.0, 5.0], [-10.0, -5.0]];
    let pose = [(0.0, 0.0, 0.0)];
    assert!(Footprint::swept(&hull[..2], &pose, 5.0).is_err());
    assert!(Footprint::swept(&hull, &[], 5.0).is_err());
    assert!(Footprint::swept(&hull, &pose, 0.0).is_err());
    assert!(Footprint::swept(&hull, &pose, f64::NAN).is_err());
    assert!(Footprint::swept(&hull, &[(f64::NAN, 0.0, 0.0)], 5.0).is_err());
    assert!(Footprint::swept(&[[f64::INFINITY, 0.0], [0.0, 1.0], [1.0, 0.0]], &pose, 5.0).is_err());
    let far = Footprint::swept(&hull, &[(0.0, 0.0, 0.0), (1e8, 1e8, 0.0)], 5.0).unwrap_err();
    assert!(far.to_string().contains("cells"), "{far}");
    assert!(Footprint::swept(&hull, &[(0.0, 0.0, 1e300), (10.0, 0.0, -1e300)], 5.0).is_ok());
}
