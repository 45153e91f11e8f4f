//! Logs of a known motion, as sentences or CSV, and their ingestion.
#![allow(dead_code)]

use std::path::Path;

use crate::runner::*;

/// Samples per second of the sensors that are faster than a fix.
const FAST: usize = 5;

/// Surge, sway \[m/s\] and yaw rate \[rad/s\] at `t` \[s\].
pub fn motion(t: f64) -> [f64; 3] {
    [2.0 + 0.4 * (0.11 * t).sin(), 0.2 * (0.17 * t).sin(), 0.08 * (0.13 * t).cos()]
}

/// Heading, clockwise from north \[rad\].
pub fn heading(t: f64) -> f64 {
    1.2 + 0.08 / 0.13 * (0.13 * t).sin()
}

/// Rudder \[deg\].
pub fn rudder(t: f64) -> f64 {
    15.0 * (0.13 * t + 0.4).sin()
}

/// Propeller \[1/min\].
pub fn revolutions(t: f64) -> f64 {
    60.0 * (8.0 + (0.11 * t + 0.2).sin())
}

/// Places from 0 to `seconds`, one a second: metres to the north and to the east of the first.
pub fn track(seconds: usize) -> Vec<[f64; 2]> {
    const STEPS: usize = 200;
    let over_ground = |t: f64| {
        let ([u, v, _], psi) = (motion(t), heading(t));
        [u * psi.cos() - v * psi.sin(), u * psi.sin() + v * psi.cos()]
    };
    let (mut place, mut places) = ([0.0; 2], vec![[0.0; 2]]);
    for second in 0..seconds {
        for step in 0..STEPS {
            let middle = over_ground(second as f64 + (step as f64 + 0.5) / STEPS as f64);
            place = [0, 1].map(|k| place[k] + middle[k] / STEPS as f64);
        }
        places.push(place);
    }
    places
}

/// Latitude and longitude \[deg\] of a place some metres from 60°06'N 24°54'E.
fn on_earth([north, east]: [f64; 2]) -> [f64; 2] {
    // Radii of curvature of WGS84 at 60.1°.
    let sin = 60.1_f64.to_radians().sin();
    let (a, e2) = (6_378_137.0, 0.006_694_379_990_14);
    let across = a / (1.0 - e2 * sin * sin).sqrt();
    let along = a * (1.0 - e2) / (1.0 - e2 * sin * sin).powf(1.5);
    [60.1 + (north / along).to_degrees(), 24.9 + (east / (across * 60.1_f64.to_radians().cos())).to_degrees()]
}

/// `6006.0000000,N` of a latitude, or `02454.0000000,E` of a longitude: `digits` before the minutes.
pub fn minutes(angle: f64, digits: usize, letters: [&str; 2]) -> String {
    let letter = letters[usize::from(angle < 0.0)];
    let (degrees, rest) = (angle.abs().floor(), angle.abs().fract());
    format!("{degrees:0digits$}{:010.7},{letter}", 60.0 * rest)
}

/// A body with its `$` and checksum.
pub fn sentence(body: &str) -> String {
    format!("${body}*{:02X}", body.bytes().fold(0, |sum, byte| sum ^ byte))
}

/// `hhmmss.00` of a second after 09:08:20.
pub fn clock(second: usize) -> String {
    clock_from(9 * 3600 + 8 * 60 + 20, second)
}

/// `hhmmss.00` of a second after `start`, seconds of a day.
pub fn clock_from(start: usize, second: usize) -> String {
    let now = (start + second) % 86_400;
    format!("{:02}{:02}{:02}.00", now / 3600, now / 60 % 60, now % 60)
}

/// The sentences of one second.
pub struct Epoch {
    /// Which.
    pub second: usize,
    /// Its sentences without `$` and checksum: `GPRMC`, `GPGGA`, `IIRPM`, `IIRSA`, then `HEHDT` and `HEROT` in turn.
    pub bodies: Vec<String>,
}

/// The healthy log, second by second from 0 to `seconds`.
pub fn epochs(seconds: usize) -> Vec<Epoch> {
    let of = |(second, place): (usize, &[f64; 2])| {
        let [latitude, longitude] = on_earth(*place);
        let place = format!("{},{}", minutes(latitude, 2, ["N", "S"]), minutes(longitude, 3, ["E", "W"]));
        let t = second as f64;
        let mut bodies = vec![
            format!("GPRMC,{},A,{place},3.9,68.8,110425,,,A", clock(second)),
            format!("GPGGA,{},{place},4,12,0.7,2.1,M,18.0,M,1.0,0001", clock(second)),
            format!("IIRPM,S,1,{:.1},100.0,A", revolutions(t)),
            format!("IIRSA,{:.2},A,,V", rudder(t)),
        ];
        for fifth in 0..FAST {
            let t = t + fifth as f64 / FAST as f64;
            bodies.push(format!("HEHDT,{:.3},T", heading(t).to_degrees().rem_euclid(360.0)));
            bodies.push(format!("HEROT,{:.2},A", motion(t)[2].to_degrees() * 60.0));
        }
        Epoch { second, bodies }
    };
    track(seconds).iter().enumerate().map(of).collect()
}

/// The file that `epochs` make.
pub fn nmea(epochs: &[Epoch]) -> String {
    let lines = epochs.iter().flat_map(|epoch| &epoch.bodies).map(|body| sentence(body) + "\r\n");
    lines.collect()
}

/// The configuration for [`epochs`] from `*.nmea`: sentences of kind `clock` have the time, `heading` is the
/// heading's column; `file` are more keys of its `[[file]]`.
pub fn nmea_config(clock: &str, heading: &str, file: &str) -> String {
    format!(
        "sample_rate_hz = 1.0\nmax_gap_s = 1.5\naverage_s = 1.0\nvelocities = {{ method = \"smoother\", window_s = 5.0 }}\n\
         [[file]]\npattern = [\"*.nmea\"]\ntime = {{ column = \"{clock}\", repeated = \"spread\" }}\n{file}\nchannel = [\n\
         {{ column = \"GGA.latitude\", channel = \"latitude_deg\", unit = \"deg\" }},\n\
         {{ column = \"GGA.longitude\", channel = \"longitude_deg\", unit = \"deg\" }},\n\
         {{ column = \"{heading}\", channel = \"psi\", unit = \"deg\" }},\n\
         {{ column = \"ROT.rate\", channel = \"y_r\", unit = \"deg/min\" }},\n\
         {{ column = \"RSA.starboard\", channel = \"delta\", unit = \"deg\" }},\n\
         {{ column = \"RPM-S1.speed\", channel = \"n\", unit = \"rpm\" }},\n]\n"
    )
}

/// The columns of [`rows`] without the time.
pub const COLUMNS: [&str; 6] = ["u", "v", "r", "psi", "delta", "n"];

/// Surge, sway \[m/s\], yaw rate \[rad/s\], heading, rudder \[deg\], propeller \[1/min\], one row a second from 0 to `seconds`.
pub fn rows(seconds: usize) -> Vec<[f64; 6]> {
    let row = |second: usize| {
        let t = second as f64;
        let [u, v, r] = motion(t);
        [u, v, r, heading(t).to_degrees(), rudder(t), revolutions(t)]
    };
    (0..=seconds).map(row).collect()
}

/// [`rows`] with a header, the time of second `k` being `time(k)`.
pub fn csv(seconds: usize, time: impl Fn(usize) -> String) -> String {
    let line = |(k, row): (usize, [f64; 6])| {
        let cells = row.map(|cell| format!("{cell:.6}")).join(",");
        format!("{},{cells}\n", time(k))
    };
    let lines = rows(seconds).into_iter().enumerate().map(line);
    format!("t,{}\n{}", COLUMNS.join(","), lines.collect::<String>())
}

/// The configuration for [`csv`] from files `pattern`; `time` are the keys of its clock besides the column, `top`
/// those before the files.
pub fn table_config(pattern: &str, time: &str, top: &str) -> String {
    format!(
        "sample_rate_hz = 1.0\nmax_gap_s = 1.5\n{top}\n[[file]]\npattern = [\"{pattern}\"]\n\
         time = {{ column = \"t\", {time} }}\nchannel = [\n\
         {{ column = \"u\", channel = \"y_u\", unit = \"m/s\" }},\n{{ column = \"v\", channel = \"y_v\", unit = \"m/s\" }},\n\
         {{ column = \"r\", channel = \"y_r\", unit = \"rad/s\" }},\n{{ column = \"psi\", channel = \"psi\", unit = \"deg\" }},\n\
         {{ column = \"delta\", channel = \"delta\", unit = \"deg\" }},\n{{ column = \"n\", channel = \"n\", unit = \"rpm\" }},\n]\n"
    )
}

/// Root mean squares of the states less the motion; the rows begin `from` seconds after it.
pub fn off(made: &Made, from: f64) -> [f64; 3] {
    let times = made.f64("t");
    ["y_u", "y_v", "y_r"].map(|name| {
        let state = ["y_u", "y_v", "y_r"].iter().position(|own| *own == name).unwrap_or(0);
        let squares =
            made.f64(name).iter().zip(times).map(|(value, t)| (value - motion(from + t)[state]).powi(2));
        (squares.sum::<f64>() / times.len() as f64).sqrt()
    })
}

/// Asserts that the states are the motion within 0.02 m/s and 0.002 rad/s, in `rows` rows.
#[track_caller]
pub fn healthy(made: &Made, rows: usize) {
    let [u, v, r] = off(made, 0.0);
    assert!(u < 0.02 && v < 0.02 && r < 0.002, "{u} {v} m/s, {r} rad/s off: {}", made.line);
    assert_eq!(made.rows, rows, "{}", made.line);
}

/// Runs `ingest` on the files in `folder`, with its `ingest.toml`.
#[track_caller]
pub fn read(folder: &Path) -> Made {
    ingest(folder, &["--config", "ingest.toml"])
}

#[test]
fn the_healthy_logs_are_read_as_the_motion_is() {
    let sentences = nmea(&epochs(60));
    let text = folder(&[("ingest.toml", &nmea_config("RMC", "HDT.heading", "")), ("a.nmea", &sentences)]);
    healthy(&read(text.path()), 61);
    let table = folder(&[
        ("ingest.toml", &table_config("*.csv", "unit = \"s\"", "")),
        ("a.csv", &csv(60, |k| format!("{k}"))),
    ]);
    healthy(&read(table.path()), 61);
}
