//! Quaternions, and velocities along the axes of the earth.

use crate::runner::*;

const CONFIG: [&str; 2] = ["--config", "ingest.toml"];

/// Ten samples a second of a ship at 2 m/s that oscillates about a heading of a radian and heels a little: position,
/// velocities along the ship's axes and along north and east, its attitude as a quaternion.
fn swinging(rows: usize) -> String {
    let (mut x, mut y) = (0.0, 0.0);
    let mut csv = "t,x,y,u,v,north,east,r,w,qx,qy,qz\n".to_owned();
    for k in 0..rows {
        let t = 0.1 * k as f64;
        let psi = 1.0 + 0.5 * (0.6 * t).sin();
        let (roll, u, v) = (0.1 * (0.9 * t).sin(), 2.0 + 0.5 * (0.4 * t).sin(), 0.3 * (0.5 * t).cos());
        let (north, east) = (u * psi.cos() - v * psi.sin(), u * psi.sin() + v * psi.cos());
        let ((sz, cz), (sx, cx)) = ((0.5 * psi).sin_cos(), (0.5 * roll).sin_cos());
        let r = 0.3 * (0.6 * t).cos();
        csv += &format!(
            "{t},{x},{y},{u},{v},{north},{east},{r},{},{},{},{}\n",
            cz * cx,
            cz * sx,
            sz * sx,
            sz * cx
        );
        x += 0.1 * north;
        y += 0.1 * east;
    }
    csv
}

/// A configuration for [`swinging`] with these channels in addition to positions and attitude.
fn with(channels: &[(&str, &str, &str)]) -> String {
    let channel = |(column, channel, unit): &(&str, &str, &str)| {
        format!("{{ column = \"{column}\", channel = \"{channel}\", unit = \"{unit}\" }}, ")
    };
    let positions = [("x", "x", "m"), ("y", "y", "m")];
    format!(
        "sample_rate_hz = 10.0\nmax_gap_s = 0.3\n[[file]]\npattern = [\"*.csv\"]\n\
         time = {{ column = \"t\", unit = \"s\" }}\nchannel = [{}]\n\
         quaternion = [{{ w = \"w\", x = \"qx\", y = \"qy\", z = \"qz\", roll = \"roll\" }}]\n",
        positions.iter().chain(channels).map(channel).collect::<String>()
    )
}

#[test]
fn law_a_quaternion_becomes_the_heading_and_roll_that_it_was_made_of() {
    let made = ingest(folder(&[("ingest.toml", &with(&[])), ("a.csv", &swinging(300))]).path(), &CONFIG);
    assert_eq!(made.rows, 300);
    for k in 0..300 {
        let t = 0.1 * k as f64;
        assert!((made.f64("psi")[k] - 1.0 - 0.5 * (0.6 * t).sin()).abs() < 1e-12);
        assert!((made.f64("roll")[k] - 0.1 * (0.9 * t).sin()).abs() < 1e-12);
    }
    assert_eq!(made.units["roll"], "rad");
}

#[test]
fn quaternions_of_another_length_or_upside_down_are_refused() {
    let csv = swinging(40);
    let row = csv.lines().nth(21).unwrap().to_owned();
    let cells: Vec<&str> = row.split(',').collect();
    let longer = [&cells[..8], &["0.9", "0", "0", "0.9"]].concat().join(",");
    let pieces = ["a.csv: line 22, column", "`w`, `qx`, `qy`, `qz`", "length 1.27", "`tolerance`"];
    refused(&with(&[]), &csv.replace(&row, &longer), &pieces);
    let text = with(&[]).replace("w = \"w\", x = \"qx\"", "w = \"qx\", x = \"w\"");
    refused(&text, &csv, &["a.csv: line 2", "upside down", "order of the columns"]);
}

#[test]
fn velocities_along_the_axes_of_the_earth_are_refused_as_such_of_the_ship_and_turned_by_name() {
    let csv = swinging(600);
    let body = with(&[("u", "y_u", "m/s"), ("v", "y_v", "m/s")]);
    let expected = ingest(folder(&[("ingest.toml", &body), ("a.csv", &csv)]).path(), &CONFIG);
    let earth = with(&[("north", "y_u", "m/s"), ("east", "y_v", "m/s")]);
    refused(&earth, &csv, &["a.csv: channels `y_u` and `y_v`", "axes of the earth", "`v_x` and `v_y`"]);
    let swapped = with(&[("east", "y_u", "m/s"), ("north", "y_v", "m/s")]);
    refused(&swapped, &csv, &["a.csv: channels `y_u` and `y_v`", "`v_y` and `v_x`"]);
    let named = with(&[("north", "v_x", "m/s"), ("east", "v_y", "m/s")]);
    let found = ingest(folder(&[("ingest.toml", &named), ("a.csv", &csv)]).path(), &CONFIG);
    for name in ["y_u", "y_v"] {
        for (a, b) in found.f64(name).iter().zip(expected.f64(name)) {
            assert!((a - b).abs() < 1e-12, "{name}: {a} {b}");
        }
    }
    refused(&with(&[("north", "v_x", "m/s")]), &csv, &["ingest.toml: velocities", "without the other"]);
}

#[test]
fn an_unwrapped_angle_in_radians_is_no_angle_in_degrees() {
    // A direction that keeps rotating, an azimuth in degrees declared as radians.
    let row = |k: usize| {
        let t = 0.5 * k as f64;
        format!("{t},1,0.1,0.01,{},{},{}\n", 60 + k % 3, 0.2 * t, if k % 60 < 30 { 10.0 } else { -10.0 })
    };
    let csv = "t,u,v,r,n,wind,azimuth\n".to_owned() + &(0..400).map(row).collect::<String>();
    let mut text = config("");
    for column in ["wind", "azimuth"] {
        text += &format!("[[file.channel]]\ncolumn = \"{column}\"\nchannel = \"{column}\"\nunit = \"rad\"\n");
    }
    let made = ingest(folder(&[("ingest.toml", &text), ("a.csv", &csv)]).path(), &CONFIG);
    let warnings = &made.summary.recordings[0].warnings;
    let units = warnings.iter().filter(|w| w.text.contains("may be in degrees"));
    assert_eq!(units.map(|w| w.channel.as_str()).collect::<Vec<_>>(), ["azimuth"], "{warnings:?}");
}
