//! Areas that are polygons: the hull stays within them, and invalid ones are refused.

use crate::geometry::{Polygon, polygons_of};
use crate::planned::*;
use crate::support::*;
use crate::waters::hull;

const BOX: &str = "west_deg = 24.98\nsouth_deg = 59.99\neast_deg = 25.02\nnorth_deg = 60.01";
/// The box with a notch from the north, down to where the ship would go without it.
const NOTCHED: &str = "[24.98, 59.99], [25.02, 59.99], [25.02, 60.01], [24.99, 59.9995], [24.98, 60.01]";

fn notched() -> Polygon {
    let ring = format!("[{NOTCHED}, [24.98, 59.99]]");
    let text = format!(
        r#"{{"type": "FeatureCollection", "features": [{{"type": "Feature", "properties": {{}},
        "geometry": {{"type": "Polygon", "coordinates": [{ring}]}}}}]}}"#
    );
    polygons_of(&text).remove(0)
}

#[test]
fn law_the_hull_stays_in_the_polygon_and_that_costs_no_less() {
    let polygon = notched();
    let (planned, boxed) = (plan_small(&[(BOX, &format!("corners = [{NOTCHED}]"))]), small_planned());
    assert_eq!(planned.plan["status"], "optimal");
    assert!(hull(boxed).any(|(place, _)| !polygon.holds(place)), "the notch makes no difference");
    assert!(hull(&planned).all(|(place, _)| polygon.holds(place)));
    assert!(planned.number("/cost") >= boxed.number("/cost"));
    assert_eq!(planned.number("/voyage/check/left_area"), 0.0);
}

#[test]
fn law_neither_the_sense_of_the_corners_nor_their_longitude_matters() {
    let mut corners: Vec<&str> = NOTCHED.split_inclusive("], ").collect();
    corners.reverse();
    let turned = corners.iter().map(|c| c.trim_end_matches(", ")).collect::<Vec<_>>().join(", ");
    let own = plan_small(&[(BOX, &format!("corners = [{NOTCHED}]"))]);
    let other = plan_small(&[(BOX, &format!("corners = [{turned}]"))]);
    assert_eq!(own.steps(), other.steps());
    // The same across the antimeridian.
    let east = |text: &str| {
        let moved = text.replace("24.98,", "179.98,").replace("24.99,", "179.99,");
        moved.replace("25.02,", "-179.98,")
    };
    let folder = small_with(&[
        (BOX, &format!("corners = [{}]", east(NOTCHED))),
        ("longitude_deg = 24.985", "longitude_deg = 179.985"),
    ]);
    let land = ISLAND.replace("24.998", "179.998").replace("25.002", "-179.998");
    put(&folder, "land.geojson", &land);
    run(&folder, PLAN).succeeds();
    assert_eq!(Planned::of(&folder).plan["cost"], own.plan["cost"]);
}

#[test]
fn a_start_in_the_box_and_not_in_the_polygon_has_no_plan() {
    let slanted = "corners = [[24.995, 59.99], [25.02, 59.99], [25.02, 60.01], [24.98, 60.01]]";
    let folder = small_with(&[(BOX, slanted)]);
    refused(&folder, 4, PLAN, &["plan.toml", "`start`", "the hull reaches out of `area`", "m away"]);
}

#[test]
fn corners_of_no_polygon_are_refused() {
    let cases: [(&str, &[&str]); 8] = [
        ("corners = [[24.98, 59.99], [25.02, 59.99]]", &["area.corners", "2 corners", "at least three"]),
        (
            "corners = [[24.98, 59.99], [25.02, 60.01], [25.02, 59.99], [24.98, 60.01]]",
            &["area.corners", "the edges after corner 1 and corner 3 cross", "in their order"],
        ),
        ("corners = [[24.98, 59.99], [25.0, 59.99], [25.02, 59.99]]", &["area.corners", "on one line"]),
        ("corners = [[24.98, 59.99], [25.02, 59.99], [25.02, 96.0]]", &["area.corners", "[25.02, 96]"]),
        ("corners = [[24.98, 59.99], [25.02, 59.99], [nan, 60.0]]", &["area.corners", "NaN"]),
        ("corners = [[24.98, 59.99, 0.0], [25.02, 59.99], [25.0, 60.0]]", &["corners"]),
        (
            "corners = [[24.98, 59.99], [25.02, 59.99], [25.0, 60.0]]\nwest_deg = 24.98",
            &["`area`", "both `corners` and `west_deg`", "leave one"],
        ),
        ("west_deg = 24.98\nsouth_deg = 59.99\neast_deg = 25.02", &["`area`", "no `north_deg`", "corners"]),
    ];
    for (area, pieces) in cases {
        refused(&small_with(&[(BOX, area)]), 3, PLAN, &[&["plan.toml"], pieces].concat());
    }
}
