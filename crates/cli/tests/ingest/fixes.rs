//! Places that are no fix: dead reckoning, void sentences, modes of receivers.

use crate::known::*;
use crate::runner::*;
use crate::silent::{Draw, Faulty, none_is_silent, said};

/// The healthy log with `change` made to the bodies of seconds `from` to `to`.
fn changed(seconds: std::ops::Range<usize>, change: impl Fn(&str) -> String) -> String {
    let mut all = epochs(60);
    for epoch in all.iter_mut().filter(|epoch| seconds.contains(&epoch.second)) {
        epoch.bodies = epoch.bodies.iter().map(|body| change(body)).collect();
    }
    nmea(&all)
}

/// A place that stands still, of quality `fix`.
fn still(body: &str, fix: char) -> String {
    let mut fields: Vec<String> = body.split(',').map(str::to_owned).collect();
    if fields[0] == "GPGGA" {
        fields[2] = "6006.0100000".to_owned();
        fields[4] = "02454.0200000".to_owned();
        fields[6] = fix.to_string();
    }
    fields.join(",")
}

#[test]
fn places_of_dead_reckoning_are_left_out_and_counted() {
    for fix in ['6', '7', '8', '0'] {
        let log = changed(20..32, |body| still(body, fix));
        let config = nmea_config("RMC", "HDT.heading", "");
        let made = read(folder(&[("ingest.toml", &config), ("a.nmea", &log)]).path());
        let said = said(&made.summary.recordings[0]);
        for name in ["latitude_deg", "longitude_deg"] {
            assert!(said.contains(&format!("{name} quality 12")), "{said:?}");
        }
        assert_eq!((made.summary.recordings[0].splits, made.summary.runs), (1, 2), "{}", made.line);
        let first = made.rows_of(made.i32("run")[0]);
        for row in &first[2..first.len() - 2] {
            assert!((made.f64("y_u")[*row] - motion(made.f64("t")[*row])[0]).abs() < 0.02, "{row}");
        }
    }
}

#[test]
fn a_quality_that_is_asked_for_counts() {
    let log = changed(0..61, |body| body.replace(",E,4,12,", ",E,8,12,"));
    let with = |keys: &str| {
        let config = nmea_config("RMC", "HDT.heading", keys);
        folder(&[("ingest.toml", &config), ("a.nmea", &log)])
    };
    healthy(&read(with("quality = [8]").path()), 61);
    refused_in(with("quality = [4, 5]").path(), &[], &["no value in channel `x`"]);
    refused_in(with("quality = [\"fix\"]").path(), &[], &["ingest.toml", "quality"]);
}

/// The configuration with places from sentences of another kind.
fn places_of(kind: &str, keys: &str) -> String {
    nmea_config("RMC", "HDT.heading", keys).replace("GGA.l", &format!("{kind}.l"))
}

/// GGA as a sentence of `kind` with `mode`.
fn as_kind(body: &str, kind: &str, mode: &str) -> String {
    let fields: Vec<&str> = body.split(',').collect();
    match (fields[0], kind) {
        ("GPGGA", "GNS") => format!("GPGNS,{},{mode},12,0.7,2.1,18.0,,", fields[1..6].join(",")),
        ("GPGGA", "GLL") => format!("GPGLL,{},{},A,{mode}", fields[2..6].join(","), fields[1]),
        ("GPRMC", "RMC") => format!("{},{mode}", fields[..12].join(",")),
        _ => body.to_owned(),
    }
}

#[test]
fn modes_that_are_no_fix_are_left_out_in_every_sentence() {
    for (kind, good) in [("GNS", "RN"), ("GLL", "D"), ("RMC", "A"), ("GLL", ""), ("RMC", "")] {
        for bad in ["E", "M", "S", "N"] {
            let mut all = epochs(60);
            for epoch in &mut all {
                let mode = if (20..32).contains(&epoch.second) { bad } else { good };
                epoch.bodies = epoch.bodies.iter().map(|body| as_kind(body, kind, mode)).collect();
            }
            let folder = folder(&[("ingest.toml", &places_of(kind, "")), ("a.nmea", &nmea(&all))]);
            let made = read(folder.path());
            let said = said(&made.summary.recordings[0]);
            assert!(said.contains(&"latitude_deg quality 12".to_owned()), "{kind} {bad}: {said:?}");
        }
    }
}

#[test]
fn law_places_that_are_no_fix_are_never_silent() {
    none_is_silent(211, |draw: &mut Draw| {
        let (from, length) = (draw.below(61), draw.between(1, 15));
        let fix = *draw.one_of(&[&'0', &'6', &'7', &'8']);
        let log = changed(from..from + length, |body| still(body, fix));
        let what = format!("fix {fix} for {length} s from {from}");
        Faulty::new(&nmea_config("RMC", "HDT.heading", ""), "a.nmea", log, 61).named(&["quality"]).what(what)
    });
}
