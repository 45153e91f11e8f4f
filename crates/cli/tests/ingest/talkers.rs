//! One sensor for each channel of sentences: several talkers, missing headings, two sensors under one name.

use tempfile::TempDir;

use crate::known::*;
use crate::runner::*;
use crate::silent::{Draw, Faulty, none_is_silent, said};

const SECONDS: usize = 60;

/// The healthy bodies after `change`, in a folder with a configuration.
fn log(config: &str, change: impl Fn(&str) -> Vec<String>) -> TempDir {
    folder(&[("ingest.toml", config), ("a.nmea", &changed(change))])
}

fn changed(change: impl Fn(&str) -> Vec<String>) -> String {
    let bodies = epochs(SECONDS).into_iter().flat_map(|epoch| epoch.bodies);
    bodies.flat_map(|body| change(&body)).map(|body| sentence(&body) + "\r\n").collect()
}

/// The heading in a body of HEHDT.
fn shown(body: &str) -> Option<f64> {
    body.strip_prefix("HEHDT,")?.strip_suffix(",T")?.parse().ok()
}

/// The heading of a second gyro in GPHDT, `off` degrees away.
fn with_second(body: &str, off: f64) -> Vec<String> {
    let second = shown(body).map(|own| format!("GPHDT,{:.3},T", (own + off).rem_euclid(360.0)));
    [body.to_owned()].into_iter().chain(second).collect()
}

fn hdt(heading: &str, file: &str) -> String {
    nmea_config("RMC", heading, file)
}

#[test]
fn a_heading_of_two_talkers_is_refused() {
    let folder = log(&hdt("HDT.heading", ""), |body| with_second(body, 3.0));
    let pieces =
        ["a.nmea: column `HDT.heading`", "HEHDT and GPHDT", "`HEHDT.heading`", "prefer = [\"HE\", \"GP\"]"];
    refused_in(folder.path(), &[], &pieces);
    let named = log(&hdt("HEHDT.heading", ""), |body| with_second(body, 3.0));
    healthy(&read(named.path()), 61);
}

#[test]
fn a_preferred_talker_counts_and_the_next_fills_its_gaps() {
    let second = |body: &str| {
        let with = with_second(body, 0.0);
        // The first is silent for eight seconds.
        let silent = shown(body).is_some_and(|own| (90.0..110.0).contains(&own));
        with.into_iter().filter(|body| !(silent && body.starts_with("HEHDT"))).collect()
    };
    let made = read(log(&hdt("HDT.heading", "prefer = [\"HE\", \"GP\"]"), second).path());
    healthy(&made, 61);
    let warnings = &made.summary.recordings[0].warnings;
    assert!(warnings.iter().any(|w| w.text.contains("is from GPHDT in")), "{warnings:?}");
    let alone = read(log(&hdt("HEHDT.heading", ""), second).path());
    assert!(alone.summary.recordings[0].splits > 0, "{}", alone.line);
    let wrong = log(&hdt("HDT.heading", "prefer = [\"HEHDT\"]"), second);
    refused_in(wrong.path(), &[], &["ingest.toml: `prefer`", "`HEHDT`", "two letters"]);
}

#[test]
fn a_talker_that_never_has_a_value_does_not_count() {
    let empty = |body: &str| {
        let second = shown(body).map(|_| "GPHDT,,T".to_owned());
        [body.to_owned()].into_iter().chain(second).collect()
    };
    let made = read(log(&hdt("HDT.heading", ""), empty).path());
    healthy(&made, 61);
    let said = said(&made.summary.recordings[0]);
    assert!(said.iter().any(|said| said.contains("GPHDT never has a value")), "{said:?}");
}

#[test]
fn two_gyros_of_one_talker_are_warned_of() {
    let mixed = |body: &str| {
        let second = shown(body).map(|own| format!("HEHDT,{:.3},T", (own + 3.0).rem_euclid(360.0)));
        [body.to_owned()].into_iter().chain(second).collect()
    };
    let made = read(log(&hdt("HDT.heading", ""), mixed).path());
    let said = said(&made.summary.recordings[0]);
    assert!(said.iter().any(|said| said.contains("two sensors may send HEHDT")), "{said:?}");
}

#[test]
fn proprietary_sentences_and_those_of_other_ships_are_no_source() {
    let other = |body: &str| {
        let strange = body.starts_with("HEHDT").then(|| ["PGRMC,A,1,2,3", "PXHDT,12.0,T"].map(String::from));
        [body.to_owned()].into_iter().chain(strange.into_iter().flatten()).collect()
    };
    let config = hdt("HDT.heading", "");
    let text = changed(other).replace("$HEROT", "!AIVDM,1,1,,A,13u?etPv2;0n:dDPwUM1U1Cb069D,0*23\r\n$HEROT");
    healthy(&read(folder(&[("ingest.toml", &config), ("a.nmea", &text)]).path()), 61);
}

/// The heading as a compass shows it where deviation and variation are so, in HDG.
fn compass(body: &str, deviation: f64, variation: f64) -> String {
    let lettered = |value: f64| format!("{:.1},{}", value.abs(), if value < 0.0 { "W" } else { "E" });
    match shown(body) {
        Some(own) => {
            let magnetic = (own - deviation - variation).rem_euclid(360.0);
            format!("HCHDG,{magnetic:.3},{},{}", lettered(deviation), lettered(variation))
        }
        None => body.to_owned(),
    }
}

#[test]
fn a_compass_with_deviation_and_variation_is_a_true_heading() {
    for (deviation, variation) in [(-5.0, -10.0), (2.5, 12.0), (-3.0, 170.0)] {
        let made = read(log(&hdt("HDG.heading", ""), |b| vec![compass(b, deviation, variation)]).path());
        healthy(&made, 61);
    }
}

#[test]
fn a_magnetic_heading_is_no_psi() {
    for column in ["HDG.magnetic", "HCHDG.magnetic"] {
        let folder = log(&hdt(column, ""), |body| vec![compass(body, -5.0, -10.0)]);
        let pieces = ["channel `psi`", &format!("magnetic heading `{column}`"), "`HDG.heading`", "`offset`"];
        refused_in(folder.path(), &[], &pieces);
    }
    let offset = "channel = \"psi\", unit = \"deg\", offset = -0.2617993878";
    let config = hdt("HDG.magnetic", "").replace("channel = \"psi\", unit = \"deg\"", offset);
    healthy(&read(log(&config, |body| vec![compass(body, -5.0, -10.0)]).path()), 61);
}

#[test]
fn a_compass_without_variation_has_no_true_heading_and_one_without_deviation_is_warned_of() {
    let cut = |body: &str, from: &str, to: &str| vec![compass(body, 0.0, -10.0).replace(from, to)];
    let without = log(&hdt("HDG.heading", ""), |body| cut(body, "10.0,W", ","));
    let ran = run(without.path(), &["--config", "ingest.toml", "--out", "t.parquet"]);
    assert_eq!(ran.code, Some(3), "{}{}", ran.stdout, ran.stderr);
    let made = read(log(&hdt("HDG.heading", ""), |body| cut(body, ",0.0,E,", ",,,")).path());
    healthy(&made, 61);
    let said = said(&made.summary.recordings[0]);
    assert!(said.iter().any(|said| said.contains("without deviation in 305 sentences of HCHDG")), "{said:?}");
}

#[test]
fn a_course_over_ground_as_a_heading_is_warned_of() {
    let made = read(log(&hdt("RMC.course", ""), |body| vec![body.to_owned()]).path());
    let said = said(&made.summary.recordings[0]);
    assert!(said.iter().any(|said| said.contains("course over ground of RMC.course")), "{said:?}");
}

#[test]
fn law_a_second_talker_is_never_silent() {
    let (healthy, config) = (epochs(SECONDS), hdt("HDT.heading", ""));
    none_is_silent(201, |draw: &mut Draw| {
        let kind = *draw.one_of(&[&"HEHDT", &"HEROT", &"IIRSA", &"IIRPM", &"GPGGA"]);
        let talker = *draw.one_of(&[&"II", &"GP", &"GN", &"TI", &"VD", &"U1"]);
        let talker = if kind.starts_with(talker) { "SN" } else { talker };
        let (every, from) = (draw.between(1, 3), draw.below(200));
        let mut seen = 0;
        let mut log = String::new();
        for body in healthy.iter().flat_map(|epoch| &epoch.bodies) {
            log += &(sentence(body) + "\r\n");
            if body.starts_with(kind) {
                seen += 1;
                if seen > from % 30 && seen % every == 0 {
                    let off = 1 + draw.below(8);
                    log += &(sentence(&format!("{talker}{}", shifted(&body[2..], off))) + "\r\n");
                }
            }
        }
        Faulty::new(&config, "a.nmea", log, 61)
            .named(&["two sensors", "quality"])
            .what(format!("{talker} beside {kind}"))
    });
}

/// `body` with another number in its first field that has one after the kind.
fn shifted(body: &str, off: usize) -> String {
    let mut done = false;
    let field = |field: &str| match field.parse::<f64>() {
        Ok(value) if !done && field.contains('.') && !field.starts_with('0') => {
            done = true;
            format!("{:.3}", value + off as f64)
        }
        _ => field.to_owned(),
    };
    body.split(',').map(field).collect::<Vec<_>>().join(",")
}

#[test]
fn law_a_second_sensor_under_the_same_name_is_never_silent() {
    let healthy = epochs(SECONDS);
    none_is_silent(202, |draw: &mut Draw| {
        let (off, every) = (2.5 + 20.0 * draw.share(), draw.between(1, 3));
        let mut seen = 0;
        let mut log = String::new();
        for body in healthy.iter().flat_map(|epoch| &epoch.bodies) {
            log += &(sentence(body) + "\r\n");
            if let Some(own) = shown(body) {
                seen += 1;
                if seen % every == 0 {
                    log += &(sentence(&format!("HEHDT,{:.3},T", (own + off).rem_euclid(360.0))) + "\r\n");
                }
            }
        }
        let what = format!("{off} degrees off, each {every}");
        Faulty::new(&hdt("HDT.heading", ""), "a.nmea", log, 61).named(&["two sensors"]).what(what)
    });
}

#[test]
fn law_a_compass_is_never_taken_for_a_true_heading() {
    let healthy = epochs(SECONDS);
    none_is_silent(203, |draw: &mut Draw| {
        let correction =
            |draw: &mut Draw, most: f64| (most * (2.0 * draw.share() - 1.0) * 10.0).round() / 10.0;
        let (deviation, variation) = (correction(draw, 8.0), correction(draw, 60.0));
        let (column, lack) = (draw.below(3), draw.below(4));
        let column = ["HDG.heading", "HDG.magnetic", "HDT.heading"][column];
        let lacking = |body: String| match (lack, body.split(',').collect::<Vec<_>>().as_slice()) {
            (0, [kind, shown, _, _, variation @ ..]) => {
                [&[*kind, *shown, "", ""], variation].concat().join(",")
            }
            (1, [kind, shown, deviation, letter, ..]) => {
                [*kind, *shown, *deviation, *letter, "", ""].join(",")
            }
            _ => body,
        };
        let bodies = healthy.iter().flat_map(|epoch| &epoch.bodies);
        let body = |body: &String| match shown(body) {
            Some(_) => lacking(compass(body, deviation, variation)),
            None => body.clone(),
        };
        let log: String = bodies.map(|own| sentence(&body(own)) + "\r\n").collect();
        let what = format!("{column}, deviation {deviation}, variation {variation}, lacks {lack}");
        let named = &["without deviation", "incomplete"];
        Faulty::new(&hdt(column, ""), "a.nmea", log, 61).named(named).what(what)
    });
}
