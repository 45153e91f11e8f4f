//! Values of a log that count as missing, and logs with many of them.

use std::path::Path;
use std::process::Command;

use crate::known::*;
use crate::runner::*;

/// Channel, reason and count of the values that were left out of the first recording.
fn omitted(made: &Made) -> Vec<(String, String, u64)> {
    let all = made.summary.recordings[0].omitted.iter();
    all.map(|one| (one.channel.clone(), one.reason.to_string(), one.count)).collect()
}

/// The healthy table with `keys` for the channel of `column`, whose cells at `rows` are `cell`.
fn faulty(column: &str, keys: &str, rows: &[usize], cell: &str) -> tempfile::TempDir {
    let place = 1 + COLUMNS.iter().position(|own| *own == column).unwrap();
    let config = table_config("*.csv", "unit = \"s\"", "");
    let own = format!("column = \"{column}\"");
    let config = config.replace(&own, &format!("{own}{keys}"));
    let changed = |(row, line): (usize, &str)| {
        let mut cells: Vec<&str> = line.split(',').collect();
        if row > 0 && rows.contains(&(row - 1)) {
            cells[place] = cell;
        }
        cells.join(",") + "\n"
    };
    let log: String = csv(60, |k| k.to_string()).lines().enumerate().map(changed).collect();
    folder(&[("ingest.toml", &config), ("a.csv", &log)])
}

fn told(one: (&str, &str, u64)) -> Vec<(String, String, u64)> {
    vec![(one.0.to_owned(), one.1.to_owned(), one.2)]
}

#[test]
fn numbers_that_stand_for_no_value_are_left_out_and_named() {
    let made = read(faulty("psi", ", missing = [65535, -9999]", &[20, 21, 40], "65535").path());
    assert_eq!(omitted(&made), told(("psi", "missing", 3)));
    assert!(made.line.contains("3 values left out: 3 of `psi` (missing)"), "{}", made.line);
    let made = read(faulty("psi", "", &[20, 21, 40], "327.67").path());
    assert_eq!(omitted(&made), told(("psi", "missing", 3)), "a known number that stands apart");
    let made = read(faulty("psi", ", missing = []", &[20, 21, 40], "327.67").path());
    assert_eq!(omitted(&made), vec![], "the configuration says that there are none");
}

#[test]
fn what_instruments_write_for_no_information_is_none_in_their_units() {
    let per_minute = 60.0 * 1.0_f64.to_degrees();
    for (place, factor, units, cell) in [
        (2, per_minute, ["rad/s", "deg/min"], "720"),
        (2, per_minute, ["rad/s", "deg/min"], "-127"),
        (0, 3600.0 / 1852.0, ["m/s", "kn"], "102.3"),
        (3, 1.0, ["deg", "deg"], "511"),
    ] {
        let channel = ["y_u", "y_v", "y_r", "psi"][place];
        let [from, to] = units.map(|unit| format!("channel = \"{channel}\", unit = \"{unit}\""));
        let config = table_config("*.csv", "unit = \"s\"", "").replace(&from, &to);
        let line = |(k, mut row): (usize, [f64; 6])| {
            row[place] *= factor;
            let mut cells = row.map(|cell| format!("{cell:.6}"));
            if [20, 21, 40].contains(&k) {
                cells[place] = cell.to_owned();
            }
            format!("{k},{}\n", cells.join(","))
        };
        let log: String = rows(60).into_iter().enumerate().map(line).collect();
        let log = format!("t,{}\n{log}", COLUMNS.join(","));
        let made = read(folder(&[("ingest.toml", &config), ("a.csv", &log)]).path());
        let left_out = omitted(&made);
        assert_eq!(left_out.iter().map(|(_, _, count)| count).sum::<u64>(), 3, "{cell}: {}", made.line);
        assert_eq!(left_out[0].0, channel, "{cell}: {}", made.line);
    }
}

/// The healthy table with the cells of `column` from row `from` on `factor` times as large.
fn rescaled(column: &str, from: usize, factor: f64) -> tempfile::TempDir {
    let place = COLUMNS.iter().position(|own| *own == column).unwrap();
    let line = |(k, mut row): (usize, [f64; 6])| {
        row[place] *= if k < from { 1.0 } else { factor };
        format!("{k},{}\n", row.map(|cell| format!("{cell:.6}")).join(","))
    };
    let log: String = rows(60).into_iter().enumerate().map(line).collect();
    let log = format!("t,{}\n{log}", COLUMNS.join(","));
    folder(&[("ingest.toml", &table_config("*.csv", "unit = \"s\"", "")), ("a.csv", &log)])
}

#[test]
fn law_a_unit_that_changes_within_a_log_is_named_and_a_ship_that_slows_down_is_not() {
    for (column, from, factor, piece) in [
        ("delta", 30, 1.0_f64.to_radians(), "`delta` is 57.296 times smaller from 30.0 s"),
        ("delta", 22, 1.0_f64.to_degrees(), "`delta` is 57.296 times larger from 22.0 s"),
        ("n", 40, 1.0 / 60.0, "`n` is 60.000 times smaller from 40.0 s"),
        ("u", 25, 3600.0 / 1852.0, "`y_u` is 1.944 times larger from 25.0 s"),
    ] {
        // Angles of the rudder beyond 90 deg would be refused.
        let range = if factor > 50.0 { 0.01 } else { 1.0 };
        let folder = rescaled(column, from, factor);
        let path = folder.path().join("ingest.toml");
        let config = std::fs::read_to_string(&path).unwrap();
        let wide = format!("channel = \"{column}\", scale = {range}, ");
        std::fs::write(&path, config.replace(&format!("channel = \"{column}\", "), &wide)).unwrap();
        let made = read(folder.path());
        assert!(made.line.contains("doubtful") && made.line.contains(piece), "{piece}: {}", made.line);
    }
    for (column, factor) in [("delta", 0.2), ("n", 0.5), ("n", 0.0), ("u", 0.9)] {
        let made = read(rescaled(column, 30, factor).path());
        assert!(!made.line.contains("its unit may change"), "{column} {factor}: {}", made.line);
    }
}

#[test]
fn a_column_of_nothing_but_no_information_is_refused() {
    let rows: Vec<usize> = (0..61).collect();
    refused_in(
        faulty("delta", "", &rows, "65.535").path(),
        &[],
        &["channel `delta`", "61 missing", "`missing`"],
    );
}

#[test]
fn numbers_out_of_range_are_left_out_as_they_stand_in_the_column() {
    let made = read(faulty("delta", ", sign = -1, valid = [-14.5, 15]", &[], "").path());
    let below = rows(60).iter().filter(|row| row[4] < -14.5).count() as u64;
    assert_eq!(omitted(&made), told(("delta", "range", below)));
    let made = read(faulty("delta", "", &[20, 21, 40], "-9999").path());
    assert_eq!(omitted(&made), told(("delta", "range", 3)), "no rudder");
    let made = read(faulty("psi", "", &[20, 21, 40], "655.35").path());
    assert_eq!(made.summary.recordings[0].omitted.iter().map(|one| one.count).sum::<u64>(), 3, "no heading");
    let made = read(faulty("n", "", &[20], "70000").path());
    assert_eq!(omitted(&made), told(("n", "range", 1)), "no shaft");
}

#[test]
fn a_channel_of_which_much_is_left_out_is_refused_with_channel_reason_and_share() {
    let rows: Vec<usize> = (0..20).collect();
    let few = faulty("delta", "", &rows, "-9999");
    let pieces = [
        "channel `delta`",
        "20 of 61 values left out (33 %): 20 range",
        "at most 20 %",
        "-90 to 90, what is possible for rudder angles",
        "`max_omitted`",
    ];
    refused_in(few.path(), &[], &pieces);
    let more = faulty("delta", ", max_omitted = 0.5", &rows, "-9999");
    assert_eq!(omitted(&read(more.path())), told(("delta", "range", 20)));
    refused_in(
        faulty("u", "", &(0..61).collect::<Vec<_>>(), "200").path(),
        &[],
        &["`max_speed_m_s`", "`y_u`"],
    );
}

#[test]
fn keys_of_the_gate_without_meaning_are_refused() {
    for (keys, piece) in [
        (", valid = [3, -3]", "`valid` of channel `psi`"),
        (", max_omitted = 1.5", "`max_omitted` of channel `psi`"),
        (", missing = [nan]", "`missing` of channel `psi`"),
    ] {
        refused_in(faulty("psi", keys, &[], "").path(), &[], &[piece]);
    }
}

#[test]
fn slopes_over_more_time_than_the_log_has_are_refused() {
    for (window_s, is_read) in [("60.0", true), ("61.0", false), ("1e5", false)] {
        let top = format!("velocities = {{ window_s = {window_s} }}");
        let config = table_config("*.csv", "unit = \"s\"", &top);
        let log = folder(&[("ingest.toml", &config), ("a.csv", &csv(60, |k| k.to_string()))]);
        match is_read {
            true => assert_eq!(read(log.path()).rows, 61),
            false => {
                refused_in(log.path(), &[], &["`velocities.window_s`", "at most the 60.0 s of the recording"])
            }
        }
    }
}

#[test]
fn a_heading_that_counts_on_beyond_a_turn_stays() {
    // Some 29 deg a second, first unwrapped from 400 deg on, then within a turn: the latter is every number of its kind.
    for wraps in [false, true] {
        let psi = |t: usize| {
            let angle = 400.0 + 28.65 * t as f64;
            if wraps { angle.rem_euclid(360.0) } else { angle }
        };
        let line = |t: usize| format!("{t},2,{:.3},0.5,{:.2},{}\n", 0.1 * (t as f64).sin(), psi(t), 60 + t);
        let log = "t,u,v,r,psi,n\n".to_owned() + &(0..61).map(line).collect::<String>();
        let config = config("").replace(
            "[[file.channel]]\ncolumn = \"n\"",
            "[[file.channel]]\ncolumn = \"psi\"\nchannel = \"psi\"\nunit = \"deg\"\n[[file.channel]]\ncolumn = \"n\"",
        );
        let made = read(folder(&[("ingest.toml", &config), ("a.csv", &log)]).path());
        assert_eq!((omitted(&made), made.rows), (vec![], 61), "wraps: {wraps}");
    }
}

#[test]
fn what_is_held_or_at_rest_is_not_frozen() {
    // At rest for 20 s, then steady ahead by a constant propeller, then a turn by a rudder that is held.
    let row = |t: f64| {
        let (u, r) = (
            2.0 * (1.0 - (-(t - 20.0).max(0.0) / 5.0).exp()),
            0.05 * (1.0 - (-(t - 60.0).max(0.0) / 4.0).exp()),
        );
        (u, -2.0 * r, r, if t >= 60.0 { 20.0 } else { 0.0 })
    };
    let (mut psi, mut place, mut log) = (0.0_f64, [0.0; 2], "t,x,y,u,v,r,psi,n,delta\n".to_owned());
    for k in 0..1200 {
        let t = 0.1 * f64::from(k);
        let (u, v, r, delta) = row(t);
        log += &format!("{t:.1},{:.3},{:.3},{u:.4},{v:.4},{r:.5},{psi:.5},8,{delta}\n", place[0], place[1]);
        place[0] += 0.1 * (u * psi.cos() - v * psi.sin());
        place[1] += 0.1 * (u * psi.sin() + v * psi.cos());
        psi += 0.1 * r;
    }
    let channels = [("x", "x", "m"), ("y", "y", "m"), ("psi", "psi", "rad"), ("delta", "delta", "deg")];
    let more: String = channels
        .into_iter()
        .map(|(column, channel, unit)| {
            format!("[[file.channel]]\ncolumn = \"{column}\"\nchannel = \"{channel}\"\nunit = \"{unit}\"\n")
        })
        .collect();
    let made = read(folder(&[("ingest.toml", &(config("") + &more)), ("a.csv", &log)]).path());
    assert_eq!(omitted(&made), vec![], "{}", made.line);
}

#[test]
fn what_all_sensors_repeat_at_once_is_frozen() {
    // A logger that hangs for 15 s while the ship moves: no sensor shows that the others stood still.
    let line = |k: u32| {
        let (t, from) = (f64::from(k) / 8.0, f64::from(if (160..280).contains(&k) { 160 } else { k }));
        let noise = |d: f64| 0.02 * (from * from * (1.3 + d)).sin();
        let (u, v, r) = (2.0, 0.1 * (from / 56.0).sin(), 0.05 * (from / 72.0).cos());
        format!("{t:.3},{:.4},{:.4},{:.5},8\n", u + noise(0.0), v + noise(0.1), r + noise(0.2))
    };
    let log = "t,u,v,r,n\n".to_owned() + &(0..800).map(line).collect::<String>();
    let made = read(folder(&[("ingest.toml", &config("")), ("a.csv", &log)]).path());
    // A channel that continues nearly as it stood cannot be distinguished from a steady one; one channel's gap splits
    // the recording.
    let found = omitted(&made);
    assert!(found.len() >= 2 && found.iter().all(|own| own.1 == "frozen" && own.2 == 119), "{}", made.line);
    assert!(made.line.contains("1 gaps that split a recording"), "{}", made.line);
}

#[test]
fn the_vessels_range_counts_with_half_of_its_width_more() {
    const VESSEL: &str = "name = \"x\"\nsample_rate_hz = 1.0\n[[input]]\nname = \"delta\"\nunit = \"rad\"\nrange = [-0.1, 0.1]\n\
        [[surge]]\nparameter = \"X_u\"\nterm = \"u\"\nnominal = -0.1\n[[sway]]\nparameter = \"Y_v\"\nterm = \"v\"\nnominal = -0.1\n\
        [[yaw]]\nparameter = \"N_r\"\nterm = \"r\"\nnominal = -0.1\n[[yaw]]\nparameter = \"N_d\"\nterm = \"delta\"\nnominal = 0.01\n";
    let log = faulty("delta", "", &[], "");
    std::fs::write(log.path().join("vessel.toml"), VESSEL).unwrap();
    refused_in(
        log.path(),
        &["--vessel", "vessel.toml"],
        &["`delta`", "-11.459 to 11.459, the input's `range` in vessel.toml"],
    );
    let wide = VESSEL.replace("[-0.1, 0.1]", "[-0.2, 0.2]");
    std::fs::write(log.path().join("vessel.toml"), wide).unwrap();
    assert_eq!(omitted(&ingest(log.path(), &["--config", "ingest.toml", "--vessel", "vessel.toml"])), vec![]);
}

/// Runs `seatrial` in `folder`; its exit code and output.
fn stage(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_seatrial"));
    let ran = command.args(arguments).current_dir(folder).output().unwrap();
    (ran.status.code(), String::from_utf8(ran.stderr).unwrap())
}

#[test]
fn no_estimate_is_made_of_a_doubtful_recording_unless_asked() {
    let log = faulty("delta", "", &[10, 20, 30, 40], "-9999");
    std::fs::write(log.path().join("b.csv"), csv(60, |k| k.to_string())).unwrap();
    let vessel = repository("pipelines/esso-osaka/vessel.toml");
    std::fs::copy(vessel, log.path().join("vessel.toml")).unwrap();
    let config = std::fs::read_to_string(log.path().join("ingest.toml")).unwrap();
    let units = [
        ("wind_x", "m^2/s^2"),
        ("wind_y", "m^2/s^2"),
        ("wind_xy", "m^2/s^2"),
        ("wind", "m/s"),
        ("wind_from", "rad"),
    ];
    let measured = units.map(|(name, unit)| {
        format!("[[derived]]\nchannel = \"{name}\"\nformula = \"y_v cos(psi)\"\nunit = \"{unit}\"\n")
    });
    std::fs::write(log.path().join("ingest.toml"), config + &measured.concat()).unwrap();
    let made = stage(
        log.path(),
        &["ingest", "--config", "ingest.toml", "--vessel", "vessel.toml", "--out", "t.parquet"],
    );
    assert_eq!(made.0, Some(0), "{}", made.1);
    let asked = |stage_name: &[&str], more: &[&str]| {
        let usual = ["--vessel", "vessel.toml", "--trajectories", "t.parquet", "--out", "out/"];
        std::fs::create_dir_all(log.path().join("out")).unwrap();
        stage(log.path(), &[stage_name, &usual, more].concat())
    };
    for estimate in
        [&["estimate", "--fit", "each"][..], &["estimate"], &["estimate", "--structure", "library"]]
    {
        let (code, said) = asked(estimate, &[]);
        assert_eq!(code, Some(3), "{estimate:?}: {said}");
        for piece in ["t.parquet: recording `a`", "--allow=doubtful"] {
            assert!(said.contains(piece), "{estimate:?}: {said}");
        }
    }
    let pool = |more: &[&str]| asked(&["estimate"], &[&["--estimator", "ls"], more].concat());
    let (code, said) = pool(&["--allow=doubtful"]);
    assert!(code == Some(0) || code == Some(4), "{said}");
    let (code, said) = pool(&["--leave-out", "a"]);
    assert!(code == Some(0) || code == Some(4), "{said}");
}
