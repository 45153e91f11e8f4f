//! Hand-written and machine-written files that are refused, and outputs that cannot be written.

use std::sync::LazyLock;

use crate::planned::*;
use crate::support::*;

/// Maneuvers and design of the paper's model ship.
static OTHER_VESSEL: LazyLock<Study> = LazyLock::new(|| Study::make(1, &STAGES[..3]));

/// Refuses the small study after a change of plan.toml.
#[track_caller]
fn edited(from: &str, to: &str, pieces: &[&str]) {
    refused(&small_with(&[(from, to)]), 3, PLAN, &[&["plan.toml"], pieces].concat());
}

#[test]
fn unknown_keys_are_refused_with_the_nearest_known_key() {
    edited("cell_m", "cel_m", &["`cel_m`", "`cell_m`?"]);
    edited("margin_m", "margn_m", &["`margn_m`", "`margin_m`?"]);
    edited("length_m", "lenght_m", &["`lenght_m`", "`length_m`?"]);
    edited("count = 1 }, {", "cuont = 1 }, {", &["`cuont`", "`count`?"]);
    edited("lookahead_m", "look_ahead_m", &["`look_ahead_m`", "`lookahead_m`?"]);
    edited("kind = \"home\"", "kind = \"hame\"", &["`hame`", "`home`"]);
    edited("kind = \"home\"", "kind = \"home\"\nplace = []", &["`place`"]);
    edited("secondary = \"seconds\"", "secondary = \"turn\"", &["`turn`", "`turns`?"]);
    edited("speed_m_s = 1.5", "speed_kn = 3.0", &["`speed_kn`", "`speed_m_s`?"]);
    edited("kind = \"land\"", "kind = \"land\"\ncsr = \"WGS84\"", &["`csr`", "`crs`?"]);
    edited("uncharted = \"water\"", "uncharted = \"watr\"", &["`watr`", "`water`?"]);
}

#[test]
fn names_that_no_route_file_holds_are_refused() {
    edited("small trial", "", &["`name` of the trial", "no name"]);
    edited("small trial", "a\\nb", &["`name` of the trial", "U+000A"]);
}

#[test]
fn charts_by_a_name_that_no_file_has_are_refused() {
    let folder = small_with(&[("\"land.geojson\"", "\"\\u0000\"")]);
    refused(&folder, 3, PLAN, &["a file without a name", "a name that a file can have"]);
}

#[test]
fn cells_without_size_are_refused() {
    for cell in ["0.0", "-120.0", "nan", "inf"] {
        edited("cell_m = 120.0", &format!("cell_m = {cell}"), &["`cell_m`", "above 0 m"]);
    }
    edited("cell_m = 120.0", "cell_m = 1e-9", &["`cell_m`"]);
    edited("cell_m = 120.0", "cell_m = 1e9", &["`cell_m`"]);
}

#[test]
fn numbers_that_are_not_finite_are_refused_wherever_they_stand() {
    for (from, key) in [
        ("west_deg = 24.98", "area"),
        ("north_deg = 60.01", "area"),
        ("length_m = 30.0", "hull.length_m"),
        ("beam_m = 8.0", "hull.beam_m"),
        ("margin_m = 20.0", "safety.margin_m"),
        ("unknown_current_m_s = 0.05", "safety.unknown_current_m_s"),
        ("turn_rate_rad_s = 0.05", "handling.turn_rate_rad_s"),
        ("speed_m_s = 1.5", "speed mode `half`"),
        ("longitude_deg = 24.985", "start"),
        ("latitude_deg = 60.0", "start"),
        ("heading_deg = 0.0", "start"),
    ] {
        let (name, _) = from.split_once(" = ").unwrap();
        for number in ["nan", "inf", "-inf"] {
            edited(from, &format!("{name} = {number}"), &[key]);
        }
    }
}

#[test]
fn optional_numbers_that_are_not_finite_are_refused_too() {
    for (from, to, key) in [
        ("beam_m = 8.0", "beam_m = 8.0\nreference_m = #", "hull.reference_m"),
        ("runs = 4", "runs = 4\nparameter_error = #", "safety.parameter_error"),
        ("runs = 4", "runs = 4\ntransit_depth_m = #", "safety.transit_depth_m"),
        ("runs = 4", "runs = 4\ntrial_depth_m = #", "safety.trial_depth_m"),
        ("count = 1 }, {", "count = 1, piece_s = # }, {", "piece_s"),
        ("headings = 4", "headings = 4\ninformative_s = #", "informative_s"),
        ("[start]", "[approach]\nrun_in_s = #\n[start]", "approach.run_in_s"),
        ("[start]", "[approach]\ntolerance_cells = #\n[start]", "approach.tolerance_cells"),
        ("[start]", "[known_current]\nspeed_m_s = #\ntowards_deg = 0.0\n[start]", "known_current.speed_m_s"),
        (
            "[start]",
            "[known_current]\nspeed_m_s = 0.1\ntowards_deg = #\n[start]",
            "known_current.towards_deg",
        ),
    ] {
        for number in ["nan", "inf", "-inf"] {
            edited(from, &to.replace('#', number), &[key]);
        }
    }
}

#[test]
fn absurd_but_finite_numbers_are_refused() {
    edited("length_m = 30.0", "length_m = 1e12", &["hull"]);
    edited("margin_m = 20.0", "margin_m = 1e12", &["margin"]);
    edited("beam_m = 8.0", "beam_m = 8.0\nreference_m = 100.0", &["hull.reference_m", "the hull"]);
    edited("count = 1 }, {", "count = 1, piece_s = 1e18 }, {", &["`piece_s`", "zig-zag-steep"]);
    edited("count = 1 }, {", "count = 1, piece_s = -5.0 }, {", &["piece_s", "zig-zag-steep"]);
    edited("runs = 4", "runs = 4\nparameter_error = 1.5", &["safety.parameter_error", "0.99"]);
    edited("runs = 4", "runs = 0", &["safety.runs", "from 1"]);
    edited("[start]", "[approach]\nrun_in_s = 1e12\n[start]", &["run_in_s"]);
    edited("crawl_m_s = 0.5", "crawl_m_s = 1e-12", &["crawl_m_s"]);
    // A cell would take 24,000 s.
    edited("crawl_m_s = 0.5", "crawl_m_s = 0.005", &["over 20001 s", "at most 20000 samples", "`handling`"]);
    edited("speed_m_s = 1.5", "speed_m_s = 1e9", &["half", "50 m/s"]);
}

#[test]
fn changes_of_current_and_wind_without_meaning_are_refused() {
    let current = |keys: &str| format!("[changing_current]\n{keys}\n\n[start]");
    let wind = |std: f64| {
        format!("[wind]\nstd_surge_m_s2 = {std}\nstd_sway_m_s2 = 0.0\nstd_yaw_rad_s2 = 0.0\n\n[start]")
    };
    edited(
        "[start]",
        &current("std_m_s = 20.0\ntime_constant_s = 60.0"),
        &["changing_current.std_m_s", "15"],
    );
    edited(
        "[start]",
        &current("std_m_s = 0.1\ntime_constant_s = 0.0"),
        &["changing_current.time_constant_s"],
    );
    edited("[start]", &wind(-1.0), &["wind.std_surge_m_s2", "0 to 100 m/s²"]);
}

#[test]
fn tolerances_below_what_the_sensors_tell_apart_are_refused() {
    // The small study's tolerances: 0.1 of 120 m, 6 degrees, 0.1 m/s, and 15 % of 0.05 rad/s.
    for (key, refused, kept, tolerance) in [
        ("position_m", "6.1", "6.0", "tolerance_cells"),
        ("heading_deg", "3.1", "3.0", "tolerance_deg"),
        ("speed_m_s", "0.051", "0.05", "tolerance_m_s"),
        ("yaw_rate_rad_s", "0.0038", "0.00374", "tolerance_rad_s"),
    ] {
        let sensors = |value: &str| format!("[sensors]\n{key} = {value}\n\n[start]");
        let pieces =
            [&format!("`approach.{tolerance}`"), "2 standard deviations", &format!("`sensors.{key}`")];
        edited("[start]", &sensors(refused), &pieces);
        edited("[start]", &sensors("-0.1"), &[&format!("`sensors.{key}`")]);
        edited("[start]", &sensors("nan"), &[&format!("`sensors.{key}`")]);
        // That is no refusal of the file, though the noise may leave no leg.
        let ran = run(&small_with(&[("[start]", &sensors(kept))]), PLAN);
        assert!(!ran.stderr.contains("standard deviations"), "{ran}");
        assert!(ran.code == Some(0) || ran.code == Some(4), "{ran}");
    }
    edited("[start]", "[sensors]\nposition = 1.0\n\n[start]", &["`position`", "`position_m`?"]);
}

#[test]
fn choices_that_no_lattice_has_are_refused() {
    for headings in ["5", "0", "3", "32", "1000000000"] {
        edited("headings = 4", &format!("headings = {headings}"), &["`headings`", headings, "4, 8 or 16"]);
    }
    edited("headings = 4", "headings = -4", &["headings", "-4"]);
    edited("headings = 4", "headings = 4\nraster_per_cell = 3", &["`raster_per_cell`", "even"]);
    edited(
        "runs = 4",
        "runs = 4\ntransit_depth_m = 9.0\ntrial_depth_m = 4.0",
        &["`safety.trial_depth_m`", "9"],
    );
    let turned = ["west_deg = 24.98", "east_deg = 25.02"];
    refused(
        &small_with(&[(turned[0], "west_deg = 25.02"), (turned[1], "east_deg = 24.98")]),
        3,
        PLAN,
        &["`area`", "25.02 to 24.98 E", "west below east"],
    );
    edited("north_deg = 60.01", "north_deg = 59.9", &["`area`", "south below north"]);
    edited("north_deg = 60.01", "north_deg = 96.0", &["`area`"]);
    edited("kind = \"home\"", "kind = \"places\"\nplaces = []", &["`goal.places`", "at least one"]);
    edited(
        "heading_deg = 0.0",
        "heading_deg = 0.0\nmode = \"fast\"",
        &["start.mode", "`fast`", "at rest, half"],
    );
}

#[test]
fn speed_modes_that_cannot_be_told_apart_are_refused() {
    let second = |name: &str, speed: &str| {
        format!("speed_m_s = 1.5\n[[speed_mode]]\nname = \"{name}\"\nspeed_m_s = {speed}")
    };
    edited("speed_m_s = 1.5", &second("half", "3.0"), &["speed mode `half`", "twice"]);
    edited("speed_m_s = 1.5", &second("also", "1.5"), &["speed mode", "1.5"]);
    edited("speed_m_s = 1.5", &second("at rest", "3.0"), &["speed mode `at rest`"]);
    edited("speed_m_s = 1.5", "speed_m_s = 0.0", &["speed mode `half`", "above 0"]);
}

#[test]
fn a_count_without_a_maneuver_of_that_name_is_refused_with_the_nearest() {
    edited(
        "zig-zag-steep",
        "zig-zag-step",
        &["maneuver `zig-zag-step`", "dictionary.parquet", "did you mean `zig-zag-steep`?"],
    );
    edited("\"sway-zig-zag\", count", "\"zig-zag-steep\", count", &["maneuver `zig-zag-steep`", "twice"]);
    edited("count = 1 }, {", "count = -1 }, {", &["-1", "line 5"]);
    let none = [
        ("count = 1 }, {", "count = 0 }, {"),
        ("\"sway-zig-zag\", count = 1", "\"sway-zig-zag\", count = 0"),
    ];
    refused(&small_with(&none), 3, PLAN, &["plan.toml", "at least one use"]);
    edited("count = 1 }, {", "count = 4000000000 }, {", &["required uses in total", "at most"]);
}

#[test]
fn a_maneuver_that_starts_at_a_speed_that_no_mode_has_is_refused() {
    edited(
        "\"zig-zag-steep\"",
        "\"zig-zag-wide\"",
        &["maneuver `zig-zag-wide`", "3 m/s", "`half` 1.5 m/s", "[[speed_mode]]"],
    );
}

#[test]
fn counts_that_want_a_design_say_so() {
    edited(
        "\"zig-zag-steep\", count = 1",
        "\"zig-zag-steep\"",
        &["maneuver `zig-zag-steep`", "no `count` and no design", "--design"],
    );
    let folder = small_with(&[("\"zig-zag-steep\", count = 1", "\"zig-zag-steep\"")]);
    run(&folder, MOMENTS).succeeds();
    run(&folder, DESIGN).succeeds();
    let line = format!("{PLAN} --design design.json");
    refused(&folder, 3, &line, &["maneuver `zig-zag-steep`", "`informative_s`"]);
    edit(&folder, "plan.toml", "headings = 4", "headings = 4\ninformative_s = 1.0");
    refused_or_planned(&folder, &line);
}

/// A time too short for one use leaves the other maneuver, or is refused with the remaining counts.
fn refused_or_planned(folder: &tempfile::TempDir, line: &str) {
    let ran = run(folder, line).succeeds();
    assert_eq!(json(folder, "plan.json")["data"]["counts"]["sway-zig-zag"], 1, "{ran}");
}

#[test]
fn a_design_of_other_maneuvers_is_refused() {
    let folder = small_with(&[
        ("\"zig-zag-steep\", count = 1", "\"zig-zag-steep\""),
        ("headings = 4", "headings = 4\ninformative_s = 600.0"),
    ]);
    let other = OTHER_VESSEL.with(&["design.json"]);
    std::fs::copy(other.path().join("design.json"), folder.path().join("design.json")).unwrap();
    let line = format!("{PLAN} --design design.json --allow=mixed");
    refused(&folder, 3, &line, &["design.json", "maneuver", "make the design again"]);
    let all = small_with(&[(
        "maneuver = [{ name = \"zig-zag-steep\", count = 1 }, { name = \"sway-zig-zag\", count = 1 }]",
        "informative_s = 600.0",
    )]);
    refused(&all, 3, PLAN, &["plan.toml", "[[maneuver]]", "--design"]);
    std::fs::copy(other.path().join("design.json"), all.path().join("design.json")).unwrap();
    refused(&all, 3, &line, &["maneuver"]);
}

#[test]
fn a_maneuver_named_like_a_basic_move_is_refused() {
    for name in ["straight", "turn-port", "turn-starboard", "faster", "slower"] {
        let folder = small();
        edit(&folder, "dictionary.toml", "name = \"zig-zag-steep\"", &format!("name = \"{name}\""));
        run(&folder, DICTIONARY).succeeds();
        edit(&folder, "plan.toml", "zig-zag-steep", name);
        refused(&folder, 3, PLAN, &[&format!("maneuver `{name}`"), "basic move", "rename"]);
    }
}

#[test]
fn damaged_inputs_are_refused() {
    for (name, offsets) in [("dictionary.parquet", [0, 5000, 12000])] {
        for at in offsets {
            let folder = small();
            let mut damaged = bytes(&folder, name);
            damaged[at] ^= 0x10;
            std::fs::write(folder.path().join(name), &damaged).unwrap();
            refused(&folder, 3, PLAN, &[name]);
            std::fs::write(folder.path().join(name), &damaged[..at]).unwrap();
            refused(&folder, 3, PLAN, &[name]);
        }
    }
    let folder = small();
    put(&folder, "plan.toml", &SMALL[..SMALL.len() / 2]);
    refused(&folder, 3, PLAN, &["plan.toml"]);
    put(&folder, "plan.toml", "");
    refused(&folder, 3, PLAN, &["plan.toml"]);
    std::fs::remove_file(folder.path().join("plan.toml")).unwrap();
    refused(&folder, 1, PLAN, &["plan.toml"]);
}

#[test]
fn trajectories_of_another_vessel_are_refused() {
    let folder = small();
    let other = OTHER_VESSEL.with(&["dictionary.parquet"]);
    std::fs::copy(other.path().join("dictionary.parquet"), folder.path().join("dictionary.parquet")).unwrap();
    refused(&folder, 3, PLAN, &["dictionary.parquet", "kN"]);
}

#[test]
fn a_shard_of_trajectories_is_refused() {
    let folder = small_planned().study.with(&["plan.json", "track.parquet", "plan.toml", "land.geojson"]);
    let line = "simulate plan --vessel vessel.toml --campaign campaign.toml --plan plan.json --shard 1/2 --out dictionary.parquet";
    run(&folder, line).succeeds();
    std::fs::remove_file(folder.path().join("plan.json")).unwrap();
    refused(&folder, 3, PLAN, &["dictionary.parquet", "1/2"]);
}

#[test]
fn outputs_that_cannot_be_written_leave_nothing() {
    let folder = small();
    refused(&folder, 1, &PLAN.replace("--out plan.json", "--out nowhere/plan.json"), &["nowhere"]);
    refused(&folder, 1, &PLAN.replace("--out plan.json", "--out plan.toml/plan.json"), &["plan.toml"]);
    let before = listing(folder.path());
    run_on_full_disk(&folder, PLAN).refuses(1, &["track"]);
    assert_eq!(listing(folder.path()), before, "a full disk leaves files behind");
    for name in ["map.json", "map.svg", "route.gpx", "route.rtz", "track.parquet"] {
        let folder = small();
        std::fs::create_dir(folder.path().join(name)).unwrap();
        std::fs::write(folder.path().join(name).join("kept"), "kept").unwrap();
        refused(&folder, 1, PLAN, &[name]);
    }
}

#[test]
fn inputs_are_not_overwritten() {
    for input in ["vessel.toml", "plan.toml", "dictionary.parquet"] {
        refused(&small(), 2, &PLAN.replace("--out plan.json", &format!("--out {input}")), &["--out", input]);
    }
    // A chart with the name of a file written next to plan.json.
    let folder = small_with(&[("land.geojson", "track.geojson")]);
    std::fs::rename(folder.path().join("land.geojson"), folder.path().join("track.geojson")).unwrap();
    refused(&folder, 2, PLAN, &["--out", "track.geojson"]);
    let folder = small_with(&[]);
    refused(&folder, 2, &PLAN.replace("--out plan.json", "--out track.parquet"), &["--out", "track.parquet"]);
    refused(&folder, 2, &PLAN.replace("--out plan.json", "--out land.geojson"), &["--out", "land.geojson"]);
}

#[test]
fn plans_for_maps_are_named_where_a_geopackage_or_kml_is_asked_for() {
    for name in ["plan.gpkg", "route.kml", "route.GPKG"] {
        let line = PLAN.replace("--out plan.json", &format!("--out {name}"));
        refused(&small(), 2, &line, &["--out", name, "ends in .json", "track.geojson", "route.gpx"]);
    }
}
