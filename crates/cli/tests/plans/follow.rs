//! `plan --rest-of` by positions: where the ship is in a plan, and the plan of the rest from there.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::planned::*;
use crate::support::*;

const FOLLOW: &str = "plan --rest-of plan.json --from positions.csv --vessel vessel.toml \
     --trajectories dictionary.parquet --config plan.toml --out rest/plan.json";

/// A folder with a plan of the small study with changes, its files, and a folder for the rest.
fn planned(changes: &[(&str, &str)]) -> (TempDir, Planned) {
    let folder = small_with(changes);
    run(&folder, PLAN).succeeds();
    fs::create_dir(folder.path().join("rest")).unwrap();
    let planned = Planned::of(&folder);
    (folder, planned)
}

/// Numbers that look drawn from a normal distribution, the same in every run.
fn noise(k: usize) -> f64 {
    let uniform = |k: u64| {
        let mixed = k.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        ((mixed ^ (mixed >> 32)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    let [a, b] = [2 * k as u64 + 1, 2 * k as u64 + 2].map(uniform);
    (-2.0 * (1.0 - a).ln()).sqrt() * (TAU * b).cos()
}

/// A ship's position: time, longitude, latitude.
type Row = [f64; 3];

/// Every `apart` samples of a track until `until_s`, off it by `noise_m`.
fn along(track: &Track, until_s: f64, apart: usize, noise_m: f64) -> Vec<Row> {
    let metre = 1.0 / 111_195.0;
    let row = |k: usize| {
        let [longitude, latitude] = track.place[k];
        let [east, north] = [noise(2 * k), noise(2 * k + 1)].map(|own| noise_m * metre * own);
        [track.t[k], longitude + east / latitude.to_radians().cos(), latitude + north]
    };
    (0..track.t.len()).step_by(apart).filter(|k| track.t[*k] <= until_s).map(row).collect()
}

/// Positions as CSV; times as `time` writes them.
fn table(rows: &[Row], time: impl Fn(f64) -> String) -> String {
    let mut text = "time,longitude_deg,latitude_deg\n".to_owned();
    for [at_s, longitude, latitude] in rows {
        writeln!(text, "{},{longitude:.8},{latitude:.8}", time(*at_s)).unwrap();
    }
    text
}

fn seconds(rows: &[Row]) -> String {
    table(rows, |at_s| format!("{at_s}"))
}

/// Seconds after 08:00 as a time of `day`.
fn of_day(day: &str, at_s: f64) -> String {
    let whole = at_s as u64;
    format!("{day}T{:02}:{:02}:{:02}Z", 8 + whole / 3600, whole / 60 % 60, whole % 60)
}

fn cost(steps: &[Value]) -> f64 {
    steps.iter().map(|step| step["cost"].as_f64().unwrap()).sum()
}

#[test]
fn law_positions_on_the_plan_end_at_their_step_and_the_best_rest_follows() {
    let (folder, planned) = planned(&[]);
    for (step, leg) in planned.legs().iter().enumerate() {
        let start_s = leg["start_s"].as_f64().unwrap();
        put(&folder, "positions.csv", &seconds(&along(&planned.track, start_s, 1, 0.0)));
        run(&folder, FOLLOW).succeeds();
        let rest = json(&folder, "rest/plan.json");
        let follow = &rest["data"]["begun"];
        assert_eq!((&follow["step"], &follow["status"]), (&(step + 1).into(), &"under-way".into()));
        for (k, own) in follow["steps"].as_array().unwrap().iter().enumerate() {
            let state = ["done", "under-way", "ahead"][(k + 1).saturating_sub(step).min(2)];
            assert_eq!((&own["state"], &own["action"]), (&state.into(), &planned.steps()[k]["action"]));
        }
        assert_eq!(rest["data"]["status"], "optimal");
        assert_eq!(rest["data"]["cost"].as_f64().unwrap(), cost(&planned.steps()[step..]), "step {step}");
        PLANNED.iter().for_each(|name| assert!(folder.path().join("rest").join(name).exists(), "{name}"));
    }
}

#[test]
fn law_noise_and_rate_of_positions_move_no_step() {
    let (folder, planned) = planned(&[]);
    for (step, leg) in planned.legs().iter().enumerate().filter(|(step, _)| step % 3 == 0) {
        let [start_s, duration_s] = ["start_s", "duration_s"].map(|key| leg[key].as_f64().unwrap());
        for apart in [1, 5] {
            let rows = along(&planned.track, start_s + 0.5 * duration_s, apart, 3.0);
            put(&folder, "positions.csv", &seconds(&rows));
            // Where the middle of a maneuver leaves no way on, the exit code is that of a plan that there is none of.
            run(&folder, FOLLOW).succeeds();
            let follow = json(&folder, "rest/plan.json")["data"]["begun"].take();
            assert_eq!(follow["step"], step + 1, "{apart}: {}", follow["statement"]);
            assert!(follow["delay_s"].as_f64().unwrap().abs() < 12.0, "{follow}");
        }
    }
}

#[test]
fn law_following_the_rest_goes_on_where_following_the_plan_would() {
    let (folder, whole) = planned(&[("headings = 4", "departure = \"2026-06-01T08:00:00Z\"\nheadings = 4")]);
    let start = |planned: &Planned, step: usize| planned.legs()[step]["start_s"].as_f64().unwrap();
    put(&folder, "positions.csv", &seconds(&along(&whole.track, start(&whole, 2), 1, 0.0)));
    run(&folder, FOLLOW).succeeds();
    let first = json(&folder, "rest/plan.json");
    // The rest departs when the last position was.
    let departure = of_day("2026-06-01", start(&whole, 2));
    assert_eq!(first["data"]["voyage"]["passage"]["departure"], departure);
    // Its own positions, now with times of day.
    let rest = Study::of(&folder).with(&["plan.toml", "land.geojson", "dictionary.parquet"]);
    for name in PLANNED {
        fs::copy(folder.path().join("rest").join(name), rest.path().join(name)).unwrap();
    }
    fs::create_dir(rest.path().join("rest")).unwrap();
    let own = Planned::of(&rest);
    assert_eq!(own.number("/cost"), cost(&whole.steps()[2..]));
    let began_s = start(&whole, 2);
    for step in [1, own.steps().len() - 2] {
        let rows = along(&own.track, start(&own, step), 1, 0.0);
        put(&rest, "positions.csv", &table(&rows, |at_s| of_day("2026-06-01", began_s + at_s)));
        run(&rest, FOLLOW).succeeds();
        let second = json(&rest, "rest/plan.json");
        assert_eq!(second["data"]["begun"]["step"], step + 1);
        assert_eq!(second["data"]["begun"]["at"], of_day("2026-06-01", began_s + start(&own, step)));
        assert_eq!(second["data"]["cost"].as_f64().unwrap(), cost(&own.steps()[step..]));
        let uses = |name: &str| own.steps()[step..].iter().filter(|own| own["action"] == name).count();
        for (name, count) in second["data"]["counts"].as_object().unwrap() {
            assert_eq!(count.as_u64().unwrap() as usize, uses(name), "{name}");
        }
    }
}

#[test]
fn law_information_grows_to_all_of_it_and_a_done_plan_is_said_to_be() {
    let (folder, planned) = planned(&[]);
    let mut last = 0.0;
    let ends = planned.legs().iter().map(|leg| leg["start_s"].as_f64().unwrap() + 2.0);
    for until_s in ends.skip(1).step_by(2).chain([f64::INFINITY]) {
        put(&folder, "positions.csv", &seconds(&along(&planned.track, until_s, 1, 0.0)));
        for name in PLANNED {
            let _ = fs::remove_file(folder.path().join("rest").join(name));
        }
        let ran = run(&folder, FOLLOW).succeeds();
        let share =
            json(&folder, "rest/plan.json")["data"]["begun"]["information"]["share"].as_f64().unwrap();
        assert!(share >= last && ran.stdout.contains("information"), "{share} after {last}{ran}");
        last = share;
        if until_s.is_infinite() {
            assert!((share - 1.0).abs() < 1e-6 && ran.stdout.contains("The plan is done."), "{ran}");
            assert_eq!(json(&folder, "rest/plan.json")["data"]["begun"]["status"], "finished");
            assert!(PLANNED[1..].iter().all(|name| !folder.path().join("rest").join(name).exists()));
        }
    }
}

#[test]
fn after_the_last_maneuver_the_plan_is_sailed_to_its_end() {
    let one = "maneuver = [{ name = \"zig-zag-steep\", count = 1 }]";
    let two = "maneuver = [{ name = \"zig-zag-steep\", count = 1 }, { name = \"sway-zig-zag\", count = 1 }]";
    let (folder, planned) = planned(&[(two, one)]);
    let after = planned.legs().iter().position(|leg| leg["informative"] == true).unwrap() + 1;
    let until_s = planned.legs()[after]["start_s"].as_f64().unwrap() + 30.0;
    put(&folder, "positions.csv", &seconds(&along(&planned.track, until_s, 1, 3.0)));
    let ran = run(&folder, &format!("{FOLLOW} --json")).succeeds();
    assert!(ran.stdout.contains("maneuvers-done"), "{ran}");
    let rest = json(&folder, "rest/plan.json")["data"].take();
    assert!(
        rest["steps"].as_array().unwrap().is_empty() && rest["begun"]["status"] == "maneuvers-done",
        "{rest}"
    );
    assert!(!folder.path().join("rest/track.parquet").exists());
}

#[test]
fn a_maneuver_that_is_missed_is_planned_again() {
    let (folder, planned) = planned(&[]);
    let step = planned.legs().iter().position(|leg| leg["informative"] == true).unwrap();
    let [start_s, end_s] = [step, step + 1].map(|step| planned.legs()[step]["start_s"].as_f64().unwrap());
    let aside = |mut row: Row| {
        let ramp = ((row[0] - start_s).min(end_s - row[0]) / 60.0).clamp(0.0, 1.0);
        row[2] += 0.0011 * ramp;
        row
    };
    let next = planned.legs()[step + 2]["start_s"].as_f64().unwrap();
    let rows: Vec<Row> = along(&planned.track, next, 1, 0.0).into_iter().map(aside).collect();
    put(&folder, "positions.csv", &seconds(&rows));
    run(&folder, FOLLOW).succeeds();
    let rest = json(&folder, "rest/plan.json");
    let follow = &rest["data"]["begun"];
    assert_eq!(follow["steps"][step]["state"], "missed");
    let own = ["deviation_m", "within_m"].map(|key| follow["steps"][step][key].as_f64().unwrap());
    assert!(own[0] > own[1] && own[1] > 27.0, "{own:?}");
    assert_eq!(rest["data"]["counts"], planned.plan["counts"]);
    // So it is after the end of the plan, from wherever the ship is.
    let mut left: Vec<Row> = along(&planned.track, f64::INFINITY, 1, 0.0).into_iter().map(aside).collect();
    let end = left[left.len() - 1];
    left.extend((1..100).map(|k| [end[0] + f64::from(k), end[1] + 2e-5 * f64::from(k), end[2]]));
    put(&folder, "positions.csv", &seconds(&left));
    run(&folder, FOLLOW).succeeds();
    let counts = json(&folder, "rest/plan.json")["data"]["counts"].take();
    assert_eq!(counts, serde_json::json!({"zig-zag-steep": 1}));
}

/// A sentence with its checksum.
fn sentence(body: &str) -> String {
    format!("${body}*{:02X}\r\n", body.bytes().fold(0, |sum, byte| sum ^ byte))
}

/// Degrees and minutes, and the letter of the side.
fn minutes(degrees: f64, width: usize, sides: [char; 2]) -> String {
    let (whole, side) = (degrees.abs().trunc(), sides[usize::from(degrees < 0.0)]);
    format!("{whole:0width$}{:010.7},{side}", 60.0 * (degrees.abs() - whole))
}

#[test]
fn law_sentences_and_a_table_of_the_same_positions_say_the_same() {
    let (folder, planned) =
        planned(&[("headings = 4", "departure = \"2026-06-01T08:00:00Z\"\nheadings = 4")]);
    let rows = along(&planned.track, 560.0, 1, 3.0);
    put(&folder, "positions.csv", &seconds(&rows));
    run(&folder, FOLLOW).succeeds();
    let table = json(&folder, "rest/plan.json")["data"]["begun"].take();
    let mut log = "noise\r\n".to_owned();
    for [at_s, longitude, latitude] in rows {
        let time = of_day("", at_s).replace([':', 'T', 'Z'], "");
        let place = format!("{},{}", minutes(latitude, 2, ['N', 'S']), minutes(longitude, 3, ['E', 'W']));
        log += &sentence(&format!("GPRMC,{time}.00,A,{place},3.0,90.0,010626,,,A"));
        log += &sentence(&format!("GPGGA,{time}.00,{place},1,8,0.9,5.0,M,18.0,M,,"));
        log += &sentence(&format!("GPRMC,{time}.00,V,,,,,,,010626,,,N"));
    }
    put(&folder, "positions.nmea", &log);
    run(&folder, &FOLLOW.replace("positions.csv", "positions.nmea")).succeeds();
    let logged = json(&folder, "rest/plan.json")["data"]["begun"].take();
    for key in ["status", "step", "positions", "at_s", "at", "departure", "delay_s"] {
        assert_eq!(logged[key], table[key], "{key}");
    }
    let states =
        |own: &Value| own["steps"].as_array().unwrap().iter().map(|step| step["state"].clone()).collect();
    let (a, b): (Vec<Value>, Vec<Value>) = (states(&logged), states(&table));
    assert_eq!(a, b);
    // RMC has a speed of three knots, of which the table knows nothing.
    let speed = logged["from"]["speed_m_s"].as_f64().unwrap();
    assert!((speed - 3.0 * 1852.0 / 3600.0).abs() < 1e-9, "{speed}");
    put(&folder, "positions.nmea", "$GPRMC,080000.00,V,,,,,,,010626,,,N*00\n");
    let line = FOLLOW.replace("positions.csv", "positions.nmea");
    refused(&folder, 3, &line, &["positions.nmea", "positions: found none", "a right checksum"]);
}

#[test]
fn positions_that_are_not_of_the_plan_are_refused() {
    let (folder, planned) =
        planned(&[("headings = 4", "departure = \"2026-06-01T08:00:00Z\"\nheadings = 4")]);
    let rows = along(&planned.track, 900.0, 1, 3.0);
    let check = |text: &str, pieces: &[&str]| {
        put(&folder, "positions.csv", text);
        refused(&folder, 3, FOLLOW, &[&["positions.csv"], pieces].concat());
    };
    let changed = |change: &dyn Fn(usize, Row) -> Option<Row>| {
        let rows = rows.iter().enumerate().filter_map(|(k, row)| change(k, *row));
        seconds(&rows.collect::<Vec<_>>())
    };
    // Another plan: half a nautical mile farther north.
    check(
        &changed(&|_, [t, lon, lat]| Some([t, lon, lat + 0.0083])),
        &["positions", "all positions are displaced by 9", "convert their datum"],
    );
    // Another day, and another year.
    for day in ["2026-06-02", "2026-05-31"] {
        let text = table(&rows, |at_s| of_day(day, at_s));
        check(&text, &["`time`", "of the plan", "within 12 h", "the log of the trial's day"]);
    }
    check(&changed(&|_, [t, lon, lat]| Some([t + 1e6, lon, lat])), &["277.", "h after the end of the plan"]);
    check(&changed(&|_, [t, lon, lat]| Some([t - 1e6, lon, lat])), &["h before the departure of the plan"]);
    // Gaps in the first maneuver, at its beginning, and of the first half of the trial.
    let leg = planned.legs().iter().find(|leg| leg["informative"] == true).unwrap();
    let begins_s = leg["maneuver_start_s"].as_f64().unwrap();
    check(
        &changed(&|_, row| (row[0] < begins_s + 50.0 || row[0] > begins_s + 90.0).then_some(row)),
        &[
            "line ",
            "42 s since line ",
            "in `zig-zag-steep` of step ",
            "at most 30 s in a maneuver",
            "give a log without the gap",
            "--done STEPS --from LON,LAT,HEADING",
        ],
    );
    check(
        &changed(&|_, row| (row[0] > begins_s + 190.0).then_some(row)),
        &["line 2", "a beginning at step ", "after `zig-zag-steep`", "give the whole log"],
    );
    // A jump: half a nautical mile in a second, for longer than a spike.
    check(
        &changed(&|k, [t, lon, lat]| {
            Some([t, lon, if (300..310).contains(&k) { lat + 0.0083 } else { lat }])
        }),
        &["line 302", "a jump of 9", " m in 1.0 s", "of another ship"],
    );
    // After the end: the ship has left.
    let mut left = along(&planned.track, f64::INFINITY, 1, 0.0);
    let end = left[left.len() - 1];
    left.extend((1..200).map(|k| [end[0] + f64::from(k), end[1] - 2e-5 * f64::from(k), end[2]]));
    check(&seconds(&left), &["m from the end of the plan, ", "up to the end", "cut the log where it ends"]);
    // A gap outside of maneuvers is none of these.
    put(&folder, "positions.csv", &changed(&|_, row| (row[0] < 150.0 || row[0] > 250.0).then_some(row)));
    run(&folder, FOLLOW).succeeds();
}

#[test]
fn positions_on_land_are_refused_with_what_they_are_on() {
    let (folder, planned) = planned(&[]);
    put(&folder, "positions.csv", &seconds(&along(&planned.track, 400.0, 1, 3.0)));
    // The chart was corrected since: the track of the second step is on an island now.
    let leg = &planned.legs()[1];
    let [x, y] = ["longitude_deg", "latitude_deg"].map(|key| leg[key].as_f64().unwrap());
    let (head, _) = ISLAND.split_once("{\"type\": \"Polygon\"").unwrap();
    let named = head.replace("\"properties\": {}", "\"properties\": {\"name\": \"Kari\"}");
    let [west, east, south, north] = [x - 1e-4, x + 1e-3, y - 1e-4, y + 1e-3];
    let ring =
        format!("[[{west},{south}],[{east},{south}],[{east},{north}],[{west},{north}],[{west},{south}]]");
    let geometry = format!("{{\"type\": \"Polygon\", \"coordinates\": [{ring}]}}}}]}}");
    put(&folder, "land.geojson", &(named + &geometry));
    refused(&folder, 3, FOLLOW, &["positions.csv", "line 1", "in `land Kari`", "one of them is displaced"]);
}

#[test]
fn positions_that_are_no_positions_are_refused() {
    let (folder, _) = planned(&[]);
    let head = "time,longitude_deg,latitude_deg\n";
    let row = "0,24.98537,60.00023\n";
    let cases: [(String, &[&str]); 16] = [
        (String::new(), &["line 1, column `time`", "none"]),
        (head.to_owned(), &["positions: found none", "at least one row"]),
        (format!("{head}{row}{row}"), &["line 3, `time`", "the time of line 2", "a later time"]),
        (format!("{head}5,24.985,60.0\n3.5,24.985,60.0\n"), &["line 3, `time`", "1.500 s before"]),
        (format!("{head}0,nan,60.0\n"), &["line 2", "`longitude_deg`", "`nan`", "from -180 to 180"]),
        (format!("{head}0,24.985,inf\n"), &["`latitude_deg`", "`inf`", "from -89 to 89"]),
        (format!("{head}nan,24.985,60.0\n"), &["`time`", "`nan`"]),
        (format!("{head}0,24.985,\n"), &["`latitude_deg`", "from -89 to 89"]),
        (format!("{head}0,24.985,95.0\n"), &["`latitude_deg`", "`95.0`"]),
        (format!("{head}noon,24.985,60.0\n"), &["`time`", "`noon`", "2026-06-01T08:00:00Z"]),
        (format!("{head}0,24.985\n{row}"), &["line 2", "2 cells", "3, as in the header"]),
        (
            format!("{head}{row}2026-06-01T08:00:00Z,24.985,60.0\n"),
            &["line 3", "a date and time", "seconds since the departure, as in the first row"],
        ),
        ("time,lon,lat\n".to_owned(), &["line 1, column `lon`", "longitude_deg"]),
        ("time,time,latitude_deg\n".to_owned(), &["line 1, column `time`", "it twice"]),
        ("time,longitude_deg\n".to_owned(), &["line 1, column `latitude_deg`", "none"]),
        (
            "time,longitude_deg,latitude_deg,heading_deg\n0,24.985,60.0,400\n".to_owned(),
            &["`heading_deg`", "`400`", "from 0 to 360"],
        ),
    ];
    for (text, pieces) in cases {
        put(&folder, "positions.csv", &text);
        refused(&folder, 3, FOLLOW, &[&["positions.csv"], pieces].concat());
    }
    fs::copy(folder.path().join("track.parquet"), folder.path().join("positions.csv")).unwrap();
    refused(&folder, 3, FOLLOW, &["positions.csv", "Parquet"]);
    // A last line that is still being written is left out.
    put(&folder, "positions.csv", &format!("{head}{row}1,24.985"));
    run(&folder, FOLLOW).succeeds();
    assert_eq!(json(&folder, "rest/plan.json")["data"]["begun"]["positions"], 1);
}

#[test]
fn files_and_flags_that_make_no_sense_are_refused() {
    let (folder, planned) = planned(&[]);
    put(&folder, "positions.csv", &seconds(&along(&planned.track, 100.0, 1, 3.0)));
    refused(&folder, 2, &format!("{FOLLOW} --done 1"), &["--from", "file positions.csv", "leave --done out"]);
    refused(&folder, 2, &FOLLOW.replace("--rest-of plan.json ", ""), &["--rest-of"]);
    refused(&folder, 2, &FOLLOW.replace("--from positions.csv ", ""), &["--from"]);
    for line in [FOLLOW, &FOLLOW.replace("--rest-of plan.json ", "")] {
        refused(&folder, 2, &format!("{line} --design design.json"), &["--design"]);
    }
    let before =
        FOLLOW.replace("plan --rest-of plan.json --from", "plan follow --plan plan.json --positions");
    refused(&folder, 2, &before, &["'follow'"]);
    run(&folder, &FOLLOW.replace("--out rest/plan.json", "--out positions.csv")).refuses(2, &["--out"]);
    refused(&folder, 1, &FOLLOW.replace("positions.csv", "absent.csv"), &["absent.csv"]);
    fs::remove_file(folder.path().join("track.parquet")).unwrap();
    run(&folder, FOLLOW).refuses(1, &["track.parquet"]);
    let problem = repository().join("fixtures/lattice/channel.json");
    let line = format!("plan --problem {} --out plan.json", problem.display());
    run(&folder, &line).succeeds();
    refused(&folder, 3, FOLLOW, &["plan.json", "`data.voyage`", "a plan on a chart"]);
    assert!(fs::read_dir(folder.path().join("rest")).unwrap().next().is_none());
}

#[test]
fn the_model_identified_so_far_takes_the_vessels_place() {
    let (folder, planned) = planned(&[]);
    let until_s = planned.legs()[4]["start_s"].as_f64().unwrap();
    put(&folder, "positions.csv", &seconds(&along(&planned.track, until_s, 1, 3.0)));
    for stage in [MOMENTS, DESIGN, CAMPAIGN] {
        let few = if stage == CAMPAIGN { " --set campaign.realizations=2" } else { "" };
        run(&folder, &format!("{stage}{few}")).succeeds();
    }
    let pool = "estimate --structure own --vessel vessel.toml --trajectories campaign.parquet --out estimates.parquet";
    run(&folder, pool).succeeds();
    let line = FOLLOW.replace("--vessel vessel.toml", "--model model.json --allow=beyond-range");
    run(&folder, &format!("{line} --set plan.safety.standard_errors=2")).succeeds();
    let rest = json(&folder, "rest/plan.json");
    assert_eq!(rest["data"]["voyage"]["check"]["standard_errors"], 2.0);
    assert_ne!(rest["inputs"]["vessel"], json(&folder, "plan.json")["inputs"]["vessel"]);
}

/// Positions with a heading, a speed and an input, as CSV.
fn columns(
    track: &Track,
    rows: &[Row],
    heading: impl Fn(usize) -> f64,
    speed: impl Fn(usize) -> f64,
) -> String {
    let mut text = "time,longitude_deg,latitude_deg,heading_deg,speed_m_s\n".to_owned();
    for (k, [at_s, longitude, latitude]) in rows.iter().enumerate() {
        let heading = heading(k).rem_euclid(360.0);
        writeln!(text, "{at_s},{longitude:.8},{latitude:.8},{heading:.1},{:.2}", speed(k)).unwrap();
    }
    assert!(rows.len() <= track.t.len());
    text
}

#[test]
fn law_logs_that_contradict_themselves_or_the_plan_are_refused_and_their_healthy_neighbours_pass() {
    let (folder, planned) =
        planned(&[("headings = 4", "departure = \"2026-06-01T08:00:00Z\"\nheadings = 4")]);
    let track = &planned.track;
    let step = planned.legs().iter().position(|leg| leg["informative"] == true).unwrap() + 1;
    let until_s = planned.legs()[step]["start_s"].as_f64().unwrap() + 60.0;
    let rows = along(track, until_s, 1, 3.0);
    let changed = |change: &dyn Fn(usize, Row) -> Row| -> Vec<Row> {
        rows.iter().enumerate().map(|(k, row)| change(k, *row)).collect()
    };
    let held = |from: usize| {
        let noise_deg = |k: usize| 3.0 / 111_195.0 * noise(k);
        changed(&|k, [t, lon, lat]| {
            if k < from {
                [t, lon, lat]
            } else {
                [t, rows[from][1] + 2.0 * noise_deg(2 * k), rows[from][2] + noise_deg(2 * k + 1)]
            }
        })
    };
    let heading = |k: usize| track.pose[k][2].to_degrees();
    let speed = |k: usize| track.state[k][0].hypot(track.state[k][1]);
    let with = |rows: &[Row], turned: f64, times: f64| {
        columns(track, rows, |k| heading(k) + turned, |k| times * speed(k))
    };
    let north_deg = 1.0 / 111_195.0;
    let date = |row: f64| of_day("2026-06-01", row);
    let semicolons = seconds(&rows).replace(',', ";").replace('.', ",");
    let mut null = rows.clone();
    null[400][1..].fill(0.0);
    // Healthy neighbours pass without a word.
    for (name, text) in [
        ("noise", seconds(&rows)),
        ("columns", with(&rows, 0.0, 1.0)),
        ("crabbing and sailing through water", with(&rows, 3.0, 1.3)),
        ("slow", seconds(&changed(&|_, [t, lon, lat]| [1.3 * t, lon, lat]))),
        ("semicolons", semicolons),
        ("tabs", seconds(&rows).replace(',', "\t")),
        ("null", seconds(&null)),
        ("spike", seconds(&changed(&|k, [t, lon, lat]| [t, lon, lat + if k == 300 { 0.005 } else { 0.0 }]))),
        ("late", seconds(&changed(&|_, [t, lon, lat]| [t + 777.0, lon, lat]))),
    ] {
        put(&folder, "positions.csv", &text);
        let ran = run(&folder, FOLLOW);
        let follow = json(&folder, "rest/plan.json")["data"]["begun"].take();
        assert!(follow.get("doubts").is_none() && follow["step"] == step + 1, "{name}: {ran} {follow}");
        let left_out = u64::from(["null", "spike"].contains(&name));
        assert_eq!(follow["left_out"], left_out, "{name}");
        for name in PLANNED {
            let _ = fs::remove_file(folder.path().join("rest").join(name));
        }
    }
    // What is odd and does not move the ship is said.
    for (text, piece) in [
        (table(&rows, |at_s| date(at_s + 10_800.0)), "3 h late, as by a clock in local time"),
        (table(&rows, |at_s| date(at_s + 18.0)), "GPS time"),
        (seconds(&changed(&|_, [t, lon, lat]| [t, lon, lat + 14.0 * north_deg])), "all positions are"),
    ] {
        put(&folder, "positions.csv", &text);
        let ran = run(&folder, FOLLOW);
        assert!(ran.stderr.contains(piece), "{piece}: {ran}");
        assert_eq!(json(&folder, "rest/plan.json")["data"]["begun"]["step"], step + 1, "{piece}");
        for name in PLANNED {
            let _ = fs::remove_file(folder.path().join("rest").join(name));
        }
    }
    // What leaves her place or motion in doubt is refused.
    let exchanged =
        seconds(&rows).replace("time,longitude_deg,latitude_deg", "time,latitude_deg,longitude_deg");
    let frozen = held(rows.len() - 60);
    let cases: [(String, &[&str]); 11] = [
        (exchanged, &["exchanged they are near it"]),
        (with(&rows, 0.0, 1.944), &["speed: found 1.9", "as in knots", "convert the speed"]),
        (with(&rows, 12.0, 1.0), &["heading: found headings 12 deg right", "magnetic"]),
        (
            columns(track, &rows, |k| heading(k).to_radians(), speed),
            &["heading: found headings", "true heading in degrees"],
        ),
        (
            columns(track, &rows, |k| if speed(k) < 0.3 { 97.0 * k as f64 } else { heading(k) }, speed),
            &["heading: found jumps", "course over ground"],
        ),
        (
            columns(track, &frozen, heading, |_| 1.5),
            &["no motion since line", "her speed is 1.5 m/s", "--done STEPS --from LON,LAT,HEADING"],
        ),
        (
            table(&rows, |at_s| format!("{}", 1_780_300_800.0 + at_s)),
            &["line 2, column `time`", "as of 2026-06-01T08:00:00Z counted from 1970"],
        ),
        (table(&rows, |at_s| format!("{}", at_s / 60.0)), &["`time`", "as of minutes"]),
        (table(&rows, |at_s| format!("{}", 1e3 * at_s)), &["`time`", "as of milliseconds"]),
        (
            seconds(&changed(&|_, [t, lon, lat]| [t, lon, lat + 120.0 * north_deg])),
            &["all positions are", "the antenna's place"],
        ),
        (seconds(&rows).replace(".", ","), &["line 2", "cells", "decimal commas need semicolons"]),
    ];
    for (text, pieces) in cases {
        put(&folder, "positions.csv", &text);
        refused(&folder, 3, FOLLOW, &[&["positions.csv"], pieces].concat());
    }
}

#[test]
fn law_a_maneuver_that_was_not_sailed_as_planned_is_planned_again() {
    let (folder, planned) = planned(&[]);
    let step = planned.steps().iter().position(|own| own["action"] == "zig-zag-steep").unwrap();
    let leg = &planned.legs()[step];
    let [begins_s, lasts_s] = ["maneuver_start_s", "maneuver_s"].map(|key| leg[key].as_f64().unwrap());
    let until_s = planned.legs()[step + 1]["start_s"].as_f64().unwrap() + 20.0;
    let rows = along(&planned.track, until_s, 1, 3.0);
    let middle_s = begins_s + 0.5 * lasts_s;
    let [before, after]: [Vec<Row>; 2] = [0, 1]
        .map(|part| rows.iter().filter(|row| usize::from(row[0] > middle_s) == part).copied().collect());
    let last = before[before.len() - 1];
    let broken = |wait: usize, metres: f64| -> Vec<Row> {
        let loops = (1..=wait).map(|k| {
            let angle = TAU * k as f64 / wait as f64;
            let [east, north] =
                [metres * angle.sin(), metres * (1.0 - angle.cos())].map(|own| own / 111_195.0);
            let [x, y] = [2 * k, 2 * k + 1].map(|k| 3.0 * noise(k) / 111_195.0);
            [last[0] + k as f64, last[1] + 2.0 * (east + x), last[2] + north + y]
        });
        let later = after.iter().map(|row| [row[0] + wait as f64, row[1], row[2]]);
        before.iter().copied().chain(loops).chain(later).collect()
    };
    // On a straight line between the ends of the maneuver, and mirrored there.
    let aside = |part: f64| -> Vec<Row> {
        let at = |at_s: f64| *rows.iter().find(|row| row[0] >= at_s).unwrap();
        let (a, b) = (at(begins_s), at(begins_s + lasts_s));
        let own = |row: &Row| {
            let line = |c: usize| a[c] + (b[c] - a[c]) * (row[0] - a[0]) / (b[0] - a[0]);
            let is_in = row[0] > a[0] && row[0] < b[0];
            if is_in {
                [row[0], line(1) + part * (row[1] - line(1)), line(2) + part * (row[2] - line(2))]
            } else {
                *row
            }
        };
        rows.iter().map(own).collect()
    };
    for (rows, state, why) in [
        (broken(0, 0.0), "done", ""),
        (broken(10, 0.0), "done", ""),
        (aside(0.8), "done", ""),
        (broken(90, 0.0), "spoiled", "broken off"),
        (broken(300, 60.0), "spoiled", "broken off"),
        (aside(0.0), "spoiled", "its motion has"),
        (aside(-1.0), "spoiled", "to the other side"),
    ] {
        put(&folder, "positions.csv", &seconds(&rows));
        let ran = run(&folder, FOLLOW);
        let follow = json(&folder, "rest/plan.json")["data"]["begun"].take();
        let own = &follow["steps"][step];
        assert_eq!(own["state"], state, "{why}: {ran} {follow}");
        assert!(own["why"].as_str().unwrap_or_default().starts_with(why), "{own}");
        let of = |own: &Value| own["name"] == "zig-zag-steep" && own["done"] == u64::from(state == "done");
        assert!(follow["information"]["maneuvers"].as_array().unwrap().iter().any(of), "{follow}");
    }
    // Inputs say what positions do not: the helm amidships for a part of the time.
    let logged = |share: f64| {
        let mut text = "time,longitude_deg,latitude_deg,tau3\n".to_owned();
        for (k, [at_s, longitude, latitude]) in rows.iter().enumerate() {
            let is_off = *at_s > middle_s && *at_s < middle_s + share * lasts_s;
            let helm = if is_off { 0.0 } else { planned.track.inputs[k][2] };
            writeln!(text, "{at_s},{longitude:.8},{latitude:.8},{helm:.3}").unwrap();
        }
        text
    };
    for (share, state) in [(0.0, "done"), (0.4, "spoiled")] {
        put(&folder, "positions.csv", &logged(share));
        run(&folder, FOLLOW);
        let own = json(&folder, "rest/plan.json")["data"]["begun"]["steps"][step].take();
        assert!(
            own["state"] == state && (state == "done" || own["why"].as_str().unwrap().contains("`tau3`")),
            "{own}"
        );
    }
}
