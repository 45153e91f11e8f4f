//! Speed limits in parts of the area.

use crate::geometry::{moved, polygons_of};
use crate::planned::*;
use crate::support::*;

/// All of the area but its western rim, where the ship starts.
const EAST: &str = "[24.988, 59.98], [25.03, 59.98], [25.03, 60.02], [24.988, 60.02]";
/// All of it.
const ALL: &str = "[24.97, 59.98], [25.03, 59.98], [25.03, 60.02], [24.97, 60.02]";

fn limit(corners: &str, max_speed_m_s: &str) -> String {
    format!("[[speed_limit]]\ncorners = [{corners}]\nmax_speed_m_s = {max_speed_m_s}\n[start]")
}

/// The greatest speed over the ground of the nominal track while any of the hull is in [`EAST`] \[m/s\].
fn fastest_in_the_east_m_s(planned: &Planned) -> f64 {
    let text = format!(
        r#"{{"type": "FeatureCollection", "features": [{{"type": "Feature", "properties": {{}},
        "geometry": {{"type": "Polygon", "coordinates": [[{EAST}, [24.988, 59.98]]]}}}}]}}"#
    );
    let (east, track) = (polygons_of(&text).remove(0), &planned.track);
    let corners = [[15.0, 0.0], [9.0, 4.0], [-15.0, 4.0], [-15.0, -4.0], [9.0, -4.0]];
    let is_in = |row: &usize| {
        corners.iter().any(|corner| east.holds(moved(track.place[*row], track.pose[*row][2], *corner)))
    };
    let rows = (0..track.place.len()).filter(is_in);
    rows.map(|row| track.state[row][0].hypot(track.state[row][1])).fold(0.0, f64::max)
}

#[test]
fn law_no_leg_in_the_polygon_is_faster_than_its_limit() {
    let free = small_planned();
    assert!(fastest_in_the_east_m_s(free) > 1.4, "the limit makes no difference");
    let slow = plan_small(&[("[start]", &limit(EAST, "1.0"))]);
    assert_eq!(slow.plan["status"], "optimal");
    assert!(fastest_in_the_east_m_s(&slow) <= 1.1);
    assert!(slow.number("/cost") >= free.number("/cost"));
    let fits = |planned: &Planned| -> u64 {
        let primitives = planned.voyage()["primitives"].as_array().unwrap().iter();
        primitives.filter(|p| p["maneuver"] == "zig-zag-steep").map(|p| p["fits"].as_u64().unwrap()).sum()
    };
    assert!(fits(&slow) < fits(free));
}

#[test]
fn law_a_limit_that_no_leg_exceeds_changes_nothing() {
    let planned = plan_small(&[("[start]", &limit(ALL, "5.0"))]);
    assert_eq!(planned.steps(), small_planned().steps());
}

#[test]
fn a_limit_below_all_speeds_closes_its_polygon() {
    let folder = small_with(&[("[start]", &limit(ALL, "0.2"))]);
    refused(&folder, 4, PLAN, &["plan.toml", "found none (proved)", "[[speed_limit]]"]);
}

#[test]
fn limits_without_meaning_are_refused() {
    for number in ["0.0", "-1.0", "nan", "inf"] {
        let folder = small_with(&[("[start]", &limit(EAST, number))]);
        refused(&folder, 3, PLAN, &["plan.toml", "`max_speed_m_s` of speed limit 1", "above 0 m/s"]);
    }
    let named = limit("[24.98, 60.0], [25.0, 60.0]", "1.0\nname = \"harbour\"");
    let pieces = ["plan.toml", "`corners` of speed limit `harbour`", "2 corners", "at least three"];
    refused(&small_with(&[("[start]", &named)]), 3, PLAN, &pieces);
    let without = "[[speed_limit]]\nmax_speed_m_s = 1.0\n[start]";
    refused(&small_with(&[("[start]", without)]), 3, PLAN, &["plan.toml", "corners"]);
}
