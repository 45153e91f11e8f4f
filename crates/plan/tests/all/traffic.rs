//! Plans with the traffic: along lanes, across them near a right angle, never against them.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use chart::{Area, Called, Chart, Class, Layer, Noted, PolygonLayer, Traffic};
use plan::voyage::{Prepared, Search, VoyageError};
use ship::engine::Streams;

use crate::planned::{small, small_brief};

/// A rectangle about `centre`, `long` towards a bearing and `wide` across it, east and north \[m\].
fn rectangle(centre: [f64; 2], [long, wide]: [f64; 2], bearing: f64) -> [[f64; 2]; 4] {
    let (sin, cos) = bearing.sin_cos();
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[a, b]| {
        let (ahead, aside) = (a * long / 2.0, b * wide / 2.0);
        [centre[0] + ahead * sin + aside * cos, centre[1] + ahead * cos - aside * sin]
    })
}

/// The small trial on its chart with a lane as well, or another part of the traffic.
fn with_traffic(traffic: Traffic, corners: [[f64; 2]; 4]) -> Prepared {
    let mut prepared = small().prepared.clone();
    let plane = *prepared.chart.plane();
    let ring = corners.iter().chain(&corners[..1]).map(|[east, north]| {
        let (lon, lat) = plane.to_geographic([*east, *north]);
        [lon, lat]
    });
    let called = Called { what: "TSSLPT", name: None, depth_m: None };
    let area = Area { class: Class::TransitOnly, called, rings: vec![ring.collect()], feature: 0 };
    let noted = vec![Noted { traffic: Some(traffic), areas: vec![area], marks: Vec::new() }];
    let lane = Layer::Polygons(PolygonLayer { noted, ..PolygonLayer::default() });
    let layers: Vec<Layer> = small_brief().layers.into_iter().chain([lane]).collect();
    prepared.chart =
        Chart::new(plane, prepared.chart.area(), &layers, prepared.brief.task.uncharted).unwrap();
    prepared
}

/// Courses of the nominal vessel, leg by leg, each where both ends of a stretch of 20 m are within `inside`.
fn courses(
    prepared: &Prepared,
    solved: &plan::voyage::Solved,
    inside: impl Fn([f64; 2]) -> bool,
) -> Vec<f64> {
    let mut courses = Vec::new();
    for step in &solved.solution.steps {
        let from = prepared.node(step.from);
        let name = &solved.moves.actions[step.action].name;
        let alike = solved.moves.actions[step.action].moves.iter().filter(|m| m.from == step.from.layer);
        let of_step = alike.clone().nth(step.variant).unwrap();
        let leg = prepared.legs.iter().find(|leg| {
            let leg_ends = (leg.leg.from, leg.leg.to, leg.leg.di, leg.leg.dj);
            leg.name == *name && leg_ends == (of_step.from, of_step.to, of_step.di, of_step.dj)
        });
        let places: Vec<[f64; 2]> =
            leg.unwrap().sailed.samples.iter().map(|s| [from[1] + s.pose.y, from[0] + s.pose.x]).collect();
        let mut last = places[0];
        for place in places {
            let [east, north] = [place[0] - last[0], place[1] - last[1]];
            if east.hypot(north) >= 20.0 {
                if inside(place) && inside(last) {
                    courses.push(east.atan2(north));
                }
                last = place;
            }
        }
    }
    courses
}

#[test]
fn law_no_plan_sails_against_a_random_lane() {
    let streams = Streams::new(7, "lanes");
    let crossing = small().prepared.brief.task.crossing_rad;
    let (mut sailed, mut courses_in, mut without) = (0, 0, 0);
    for lane in 0..100 {
        let drawn = streams.choices(lane, 0, 1 << 20, 3);
        let part = |i: usize| f64::from(drawn[i]) / f64::from(1 << 20);
        let towards = 2.0 * PI * part(0);
        let (centre, size) = ([1200.0 * (part(1) - 0.5), 1200.0 * (part(2) - 0.5)], [1600.0, 500.0]);
        let prepared = with_traffic(Traffic::Lane(towards), rectangle(centre, size, towards));
        let (sin, cos) = towards.sin_cos();
        let inside = |[east, north]: [f64; 2]| {
            let [east, north] = [east - centre[0], north - centre[1]];
            // The raster may be a little wider than the lane.
            (east * sin + north * cos).abs() < size[0] / 2.0
                && (east * cos - north * sin).abs() < size[1] / 2.0
        };
        match prepared.solve(&Search::unlimited()) {
            Ok(solved) => {
                sailed += 1;
                for course in courses(&prepared, &solved, inside) {
                    let turned = (course - towards).rem_euclid(2.0 * PI);
                    let off = turned.min(2.0 * PI - turned);
                    courses_in += 1;
                    // Over 20 m a turn is not quite straight.
                    let slack = 0.1;
                    let is_along = off <= FRAC_PI_4 + slack;
                    let is_across = (off - FRAC_PI_2).abs() <= crossing + slack;
                    assert!(is_along || is_across, "lane {lane}: {course} in {towards}");
                }
            }
            Err(VoyageError::Infeasible(why)) => {
                without += 1;
                assert!(why.contains("`traffic.crossing_deg`"), "{why}");
            }
            Err(other) => panic!("{other}"),
        }
    }
    assert!(sailed > 20 && courses_in > 0, "{sailed} sailed, {courses_in} courses, {without} without a plan");
}

#[test]
fn law_directions_admit_courses_by_their_angle_alone() {
    let crossing = 20.0_f64.to_radians();
    for towards in (0..360).step_by(7).map(|deg| f64::from(deg).to_radians()) {
        for off in -180..180 {
            let course = towards + f64::from(off).to_radians() + 4.0 * PI;
            let (off, exact) = (f64::from(off).abs(), |limit: f64, off: f64| (off - limit).abs() < 1e-6);
            if [45.0, 70.0, 110.0, 135.0].iter().any(|limit| exact(*limit, off)) {
                continue;
            }
            let across = (70.0..110.0).contains(&off);
            let admits = |traffic: Traffic| traffic.admits(course, crossing);
            assert_eq!(admits(Traffic::Lane(towards)), off < 45.0 || across, "{off}");
            assert_eq!(admits(Traffic::OneWay(towards)), off < 135.0, "{off}");
            assert_eq!(admits(Traffic::Zone(Some(towards))), across, "{off}");
            assert!(!admits(Traffic::Zone(None)));
        }
    }
}
