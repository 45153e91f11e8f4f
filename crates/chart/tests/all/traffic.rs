//! Traffic lanes, separation zones and one-way tracks of electronic charts.

use std::collections::BTreeMap;

use chart::enc::{Feature, Geometry, class};
use chart::{Chart, Layer, Plane, PolygonLayer, Rules, Traffic, Treatment};

use crate::support::square;

fn rectangle([west, south, east, north]: [f64; 4]) -> Geometry {
    let ring = vec![[west, south], [east, south], [east, north], [west, north], [west, south]];
    Geometry::Area(vec![vec![ring]])
}

fn object(acronym: &str, attributes: &[(u16, &str)], geometry: Geometry) -> Feature {
    Feature {
        class: class(acronym).unwrap(),
        id: format!("GB-{acronym}-1"),
        attributes: attributes.iter().map(|(code, text)| (*code, (*text).to_owned())).collect(),
        geometry,
        position_quality: Vec::new(),
    }
}

const ORIENT: u16 = 117;
const TRAFIC: u16 = 172;

/// A scheme off 25° E, 60° N: a lane to the west in the north, one to the east in the south, a zone between them, and a track.
fn scheme(north_lane: &[(u16, &str)]) -> Vec<Feature> {
    let track = Geometry::Lines(vec![vec![[24.99, 60.02], [24.99, 60.03]]]);
    vec![
        object("DEPARE", &[(87, "20")], rectangle([24.9, 59.95, 25.1, 60.05])),
        object("TSSLPT", north_lane, rectangle([24.95, 60.004, 25.05, 60.01])),
        object("TSEZNE", &[], rectangle([24.95, 60.002, 25.05, 60.004])),
        object("TSSLPT", &[(ORIENT, "90")], rectangle([24.95, 59.99, 25.05, 60.0])),
        object("RECTRC", &[(ORIENT, "0"), (TRAFIC, "3")], track.clone()),
        object("RECTRC", &[(ORIENT, "45"), (TRAFIC, "4")], track),
        object("PILBOP", &[(116, "Harmaja")], Geometry::Points(vec![[25.0, 59.98]])),
    ]
}

fn chart(objects: &[Feature], rules: &Rules) -> Chart {
    let (layer, _) = PolygonLayer::from_objects(objects, Some(20_000), rules).unwrap();
    Chart::new(Plane::new(25.0, 60.0).unwrap(), square(4900.0), &[Layer::Polygons(layer)], None).unwrap()
}

fn directions(chart: &Chart) -> Vec<(&'static str, Traffic)> {
    chart.traffic().map(|(traffic, polygon)| (polygon.called.what, traffic)).collect()
}

#[test]
fn lanes_have_their_direction_and_zones_that_of_the_nearest_lane() {
    let degrees = |deg: f64| deg.to_radians();
    let all = chart(&scheme(&[(ORIENT, "270")]), &Rules::default());
    let expected = [
        ("TSSLPT", Traffic::Lane(degrees(270.0))),
        ("TSEZNE", Traffic::Zone(Some(degrees(270.0)))),
        ("TSSLPT", Traffic::Lane(degrees(90.0))),
        ("RECTRC", Traffic::OneWay(0.0)),
    ];
    assert_eq!(directions(&all), expected);
    assert!(all.has_transit_only());
    // A bridge is told of what lies within the distance, and of nothing else.
    let near = |place: [f64; 2], within_m: f64| {
        let place = all.plane().to_plane(place[0], place[1]);
        all.noted_near(&[place], within_m).into_iter().collect::<Vec<_>>()
    };
    assert_eq!(near([25.0, 59.981], 300.0), ["PILBOP Harmaja"]);
    assert_eq!(near([25.0, 59.995], 300.0), ["TSSLPT"]);
    assert!(near([25.0, 59.985], 200.0).is_empty());
}

#[test]
fn rules_take_the_direction_away_or_close_the_lane() {
    for (treatment, left, closed) in [(Treatment::Ignore, 2, 0), (Treatment::Avoid, 2, 2)] {
        let changed = BTreeMap::from([("TSSLPT".to_owned(), treatment)]);
        let all = chart(&scheme(&[(ORIENT, "270")]), &Rules { changed, ..Rules::default() });
        let traffic = directions(&all);
        assert_eq!(traffic.len(), left, "{traffic:?}");
        // Without a lane nothing may be crossed.
        assert_eq!(traffic[0], ("TSEZNE", Traffic::Zone(None)));
        let lanes = all.polygons().iter().filter(|p| p.called.what == "TSSLPT").count();
        assert_eq!(lanes, closed);
    }
    // A part of a lane without a direction, where others join it, is kept out of.
    let (_, tallies) = PolygonLayer::from_objects(&scheme(&[]), None, &Rules::default()).unwrap();
    assert_eq!((tallies["TSSLPT"].avoided, tallies["TSSLPT"].maneuvers_avoid), (1, 1));
}

#[test]
fn a_direction_that_is_no_bearing_is_refused_with_the_rule_that_helps() {
    for wrong in ["400", "-1", "west"] {
        let why =
            PolygonLayer::from_objects(&scheme(&[(ORIENT, wrong)]), None, &Rules::default()).unwrap_err();
        assert!(why.to_string().contains("TSSLPT GB-TSSLPT-1, `ORIENT`"), "{why}");
    }
    let changed = BTreeMap::from([("TSSLPT".to_owned(), Treatment::Avoid)]);
    let rules = Rules { changed, ..Rules::default() };
    PolygonLayer::from_objects(&scheme(&[(ORIENT, "400")]), None, &rules).unwrap();
}
