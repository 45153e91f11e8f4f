//! Time slots of trials: by times, and by daylight.

use crate::planned::*;
use crate::support::*;

/// The small study that departs at `departure` within `slot`; at sea it takes 27 minutes.
fn study(departure: &str, slot: &str) -> tempfile::TempDir {
    let departure = format!("departure = \"{departure}\"\nheadings = 4");
    small_with(&[("headings = 4", &departure), ("[start]", &format!("[slot]\n{slot}\n[start]"))])
}

const DEPARTURE: &str = "2026-06-01T08:00:00Z";

#[test]
fn a_plan_within_its_slot_is_the_plan_without_one() {
    for slot in [
        "from = \"2026-06-01T11:00:00+03:00\"\nuntil = \"2026-06-01T09:00:00Z\"\ndaylight = true",
        "from = \"2026-06-01T07:00:00Z\"",
        "until = \"2026-06-01T09:00:00Z\"",
        "daylight = true",
    ] {
        let folder = study(DEPARTURE, slot);
        run(&folder, PLAN).succeeds();
        assert_eq!(json(&folder, "plan.json")["data"]["steps"], small_planned().plan["steps"], "{slot}");
    }
}

#[test]
fn a_plan_that_is_not_over_in_time_is_refused() {
    let pieces = ["plan.toml", "`slot.until`", "a slot of 600 s", "request fewer maneuvers"];
    refused(&study(DEPARTURE, "until = \"2026-06-01T08:10:00Z\""), 4, PLAN, &pieces);
    // Off Helsinki the sun sets at a quarter past three then, 13:14 in UTC.
    let late = study("2026-12-21T13:05:00Z", "until = \"2026-12-21T14:00:00Z\"\ndaylight = true");
    refused(&late, 4, PLAN, &["plan.toml", "`slot.daylight`", "a slot of ", "begin earlier"]);
}

#[test]
fn slots_that_make_no_sense_and_departures_outside_of_them_are_refused() {
    let cases: [(&str, &str, &[&str]); 9] = [
        (DEPARTURE, "daylight = false", &["`slot`", "none of its keys", "daylight = true"]),
        (DEPARTURE, "from = \"noon\"", &["`slot.from`", "`noon`", "2026-06-01T08:00:00Z"]),
        (
            DEPARTURE,
            "from = \"2026-06-01T12:00:00Z\"\nuntil = \"2026-06-01T07:00:00Z\"",
            &["`slot.until`", "2026-06-01T07:00:00Z", "after `slot.from`, 2026-06-01T12:00:00Z"],
        ),
        (
            DEPARTURE,
            "from = \"2026-06-01T09:00:00Z\"",
            &["`departure`", "2026-06-01T09:00:00Z or later, by `slot.from`"],
        ),
        (
            DEPARTURE,
            "until = \"2026-06-01T08:00:00Z\"",
            &["`departure`", "before 2026-06-01T08:00:00Z, by `slot.until`"],
        ),
        ("2026-12-21T07:00:00Z", "daylight = true", &["`departure`", "2026-12-21T07:2", "`slot.daylight`"]),
        ("2026-12-21T18:00:00Z", "daylight = true", &["`departure`", "2026-12-21T13:1", "`slot.daylight`"]),
        (DEPARTURE, "dawn = true", &["`dawn`", "`daylight`"]),
        (DEPARTURE, "daylight = \"yes\"", &["daylight"]),
    ];
    for (departure, slot, pieces) in cases {
        refused(&study(departure, slot), 3, PLAN, &[&["plan.toml"], pieces].concat());
    }
    let undated = small_with(&[("[start]", "[slot]\ndaylight = true\n[start]")]);
    refused(&undated, 3, PLAN, &["plan.toml", "`departure`", "none", "since there is a [slot]"]);
}

#[test]
fn there_is_no_daylight_in_the_polar_night_and_always_in_the_polar_day() {
    for (departure, code) in [("2026-12-21T10:00:00Z", 3), ("2026-06-21T22:00:00Z", 0)] {
        let folder = study(departure, "daylight = true");
        for (from, to) in [
            ("west_deg = 24.98", "west_deg = 24.94"),
            ("east_deg = 25.02", "east_deg = 25.06"),
            ("south_deg = 59.99", "south_deg = 79.99"),
            ("north_deg = 60.01", "north_deg = 80.01"),
            ("longitude_deg = 24.985", "longitude_deg = 24.955"),
            ("latitude_deg = 60.0", "latitude_deg = 80.0"),
        ] {
            edit(&folder, "plan.toml", from, to);
        }
        put(&folder, "land.geojson", &ISLAND.replace("59.999", "79.999").replace("60.001", "80.001"));
        if code == 0 {
            run(&folder, PLAN).succeeds();
        } else {
            refused(&folder, code, PLAN, &["plan.toml", "`slot.daylight`", "no sunrise", "80.0"]);
        }
    }
}
