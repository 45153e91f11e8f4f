//! Clocks of receivers: cold starts, no date, late sentences, midnights, leap seconds, week rollovers.

use crate::known::*;
use crate::runner::*;
use crate::silent::{Draw, Faulty, Verdict, none_is_silent, said, verdict};

fn config(clock: &str) -> String {
    nmea_config(clock, "HDT.heading", "")
}

fn made(clock: &str, epochs: &[Epoch]) -> Made {
    read(folder(&[("ingest.toml", &config(clock)), ("a.nmea", &nmea(epochs))]).path())
}

/// The healthy log from `start`, seconds of the day `ddmmyy`.
fn from(start: usize, day: &str, next: &str) -> Vec<Epoch> {
    let mut all = epochs(60);
    for epoch in &mut all {
        let now = clock_from(start, epoch.second);
        let date = if start + epoch.second < 86_400 { day } else { next };
        for body in &mut epoch.bodies {
            *body = body.replace(&clock(epoch.second), &now).replace("110425", date);
        }
    }
    all
}

/// A clock's sentence of a receiver without a fix.
fn void(time: &str, date: &str) -> String {
    format!("GPRMC,{time},V,,,,,,,{date},,,N")
}

#[test]
fn a_void_sentence_without_a_date_is_a_gap() {
    for date in ["", "000000"] {
        for time in [true, false] {
            let mut all = epochs(60);
            for epoch in &mut all[29..31] {
                let own = if time { clock(epoch.second) } else { String::new() };
                epoch.bodies[0] = void(&own, date);
                epoch.bodies[1] = format!("GPGGA,{own},,,,,0,00,,,M,,M,,");
            }
            let made = made("RMC", &all);
            let recording = &made.summary.recordings[0];
            assert_eq!(
                (recording.splits, recording.rows.without_time > 0),
                (1, true),
                "{date}: {}",
                made.line
            );
        }
    }
}

#[test]
fn what_comes_before_a_receiver_knows_the_time_is_left_out() {
    for date in ["060180", "220899", "070419", "110424"] {
        let mut all = epochs(60);
        let first = all[0].bodies.clone();
        for second in (0..4).rev() {
            let mut bodies = first[2..].to_vec();
            bodies.iter_mut().for_each(|body| *body = body.replace("68.755", "12.000"));
            bodies.insert(0, void(&format!("0000{:02}.00", 12 + second), date));
            all.insert(0, Epoch { second: 0, bodies });
        }
        let made = made("RMC", &all);
        healthy(&made, 61);
        let said = said(&made.summary.recordings[0]);
        assert!(said.contains(&"psi time 20".to_owned()), "{date}: {said:?}");
    }
}

/// The healthy log with the date and time in ZDA in place of RMC.
fn of_zda(year: impl Fn(usize) -> usize) -> Vec<Epoch> {
    let mut all = epochs(60);
    for epoch in &mut all {
        let time = clock(epoch.second);
        epoch.bodies[0] = match year(epoch.second) {
            1980 => format!("GPZDA,{time},06,01,1980,00,00"),
            year => format!("GPZDA,{time},11,04,{year},00,00"),
        };
    }
    all
}

#[test]
fn a_date_that_the_receiver_does_not_know_is_no_other_recording() {
    let made = made("ZDA", &of_zda(|second| if second < 4 { 1980 } else { 2025 }));
    let said = said(&made.summary.recordings[0]);
    assert!(said.contains(&"psi time 20".to_owned()), "{said:?}");
    assert_eq!((made.rows, made.summary.runs), (57, 1), "{}", made.line);
}

#[test]
fn dates_years_apart_are_refused() {
    let folder = folder(&[
        ("ingest.toml", &config("ZDA")),
        ("a.nmea", &nmea(&of_zda(|second| if second < 30 { 2021 } else { 2025 }))),
    ]);
    refused_in(folder.path(), &[], &["time of sentences", "2021-04-11T", "2025-04-11T", "cut the file"]);
}

#[test]
fn weeks_that_begin_anew_are_undone() {
    // 1024 weeks before 2025-04-11.
    for (first, then) in [("260805", "110425"), ("110425", "260805")] {
        let mut all = epochs(60);
        for epoch in &mut all {
            let date = if epoch.second < 20 { first } else { then };
            epoch.bodies[0] = epoch.bodies[0].replace("110425", date);
        }
        let made = made("RMC", &all);
        healthy(&made, 61);
        let said = said(&made.summary.recordings[0]);
        assert!(said.iter().any(|said| said.contains("1024 weeks")), "{said:?}");
    }
}

#[test]
fn midnight_passes_with_and_without_a_date() {
    for clock in ["RMC", "GGA"] {
        healthy(&made(clock, &from(86_375, "310725", "010825")), 61);
        healthy(&made(clock, &from(86_400 - 61, "310725", "010825")), 61);
    }
}

#[test]
fn a_recording_in_parts_is_one_over_midnight_too() {
    for (clock, cut) in [("RMC", 25), ("GGA", 25), ("GGA", 40), ("RMC", 10)] {
        let all = from(86_375, "310725", "010825");
        let (first, then) = all.split_at(cut);
        let config = nmea_config(clock, "HDT.heading", "run_from_file = \"{run}_*.nmea\"");
        let parts = [("ingest.toml", config.as_str()), ("a_1.nmea", &nmea(first)), ("a_2.nmea", &nmea(then))];
        healthy(&read(folder(&parts).path()), 61);
    }
}

#[test]
fn a_late_sentence_is_no_new_day() {
    for clock in ["RMC", "GGA"] {
        for late in [1, 2, 5] {
            let mut all = from(86_380, "310725", "010825");
            let place = usize::from(clock == "GGA");
            let body = all[20 - late].bodies[place].clone();
            all[20].bodies.push(body);
            let made = made(clock, &all);
            healthy(&made, 61);
            let rows = made.summary.recordings[0].rows;
            assert_eq!(rows.late, 1, "{clock} {late}: {rows:?}");
        }
    }
}

#[test]
fn a_clock_that_is_set_back_is_refused() {
    let mut all = epochs(60);
    for epoch in all.iter_mut().filter(|epoch| epoch.second >= 30) {
        let (own, earlier) = (clock(epoch.second), clock(epoch.second - 18));
        epoch.bodies[..2].iter_mut().for_each(|body| *body = body.replace(&own, &earlier));
    }
    let folder = folder(&[("ingest.toml", &config("RMC")), ("a.nmea", &nmea(&all))]);
    refused_in(folder.path(), &[], &["column `RMC`", "time that does not go backwards"]);
}

#[test]
fn a_leap_second_is_a_second() {
    for clock in ["RMC", "GGA"] {
        let mut all = from(86_370, "311216", "010117");
        for epoch in &mut all {
            let (own, date) = match epoch.second {
                0..30 => continue,
                30 => ("235960.00".to_owned(), "311216"),
                second => (clock_from(86_370, second - 1), "010117"),
            };
            let before = clock_from(86_370, epoch.second);
            let body = |body: &String| body.replace(&before, &own).replace("010117", date);
            epoch.bodies = epoch.bodies.iter().map(body).collect();
        }
        let made = made(clock, &all);
        healthy(&made, 61);
        let said = said(&made.summary.recordings[0]);
        assert!(said.iter().any(|said| said.contains("leap second")), "{said:?}");
    }
}

#[test]
fn times_without_decimals_are_read() {
    let log = nmea(&epochs(60));
    let bodies = log.lines().map(|line| line[1..].split('*').next().unwrap().to_owned());
    let whole = |body: String| match body.split_once(".00,") {
        Some((head, rest)) if head.starts_with("GPRMC") || head.starts_with("GPGGA") => {
            format!("{head},{rest}")
        }
        _ => body,
    };
    let text: String = bodies.map(|body| sentence(&whole(body)) + "\r\n").collect();
    assert!(text.contains("$GPRMC,090820,A"), "{text}");
    healthy(&read(folder(&[("ingest.toml", &config("RMC")), ("a.nmea", &text)]).path()), 61);
}

#[test]
fn two_receivers_as_one_clock_are_refused() {
    let mut all = epochs(60);
    for epoch in &mut all {
        let own = epoch.bodies[0].replace("GPRMC", "GNRMC");
        let second = clock(epoch.second + 1);
        epoch.bodies.insert(1, own.replace(&clock(epoch.second), &second));
    }
    let with = |clock: &str, keys: &str| {
        let config = nmea_config(clock, "HDT.heading", keys);
        folder(&[("ingest.toml", &config), ("a.nmea", &nmea(&all))])
    };
    let pieces = ["time of sentences", "GPRMC and GNRMC", "name `GPRMC`", "prefer = [\"GP\", \"GN\"]"];
    refused_in(with("RMC", "").path(), &[], &pieces);
    healthy(&read(with("GPRMC", "").path()), 61);
    healthy(&read(with("RMC", "prefer = [\"GP\", \"GN\"]").path()), 61);
}

#[test]
fn a_clock_without_any_date_names_another() {
    let mut all = epochs(60);
    all.iter_mut().for_each(|epoch| epoch.bodies[0] = epoch.bodies[0].replace("110425", ""));
    let folder = folder(&[("ingest.toml", &config("RMC")), ("a.nmea", &nmea(&all))]);
    refused_in(folder.path(), &[], &["column `RMC`", "without a date", "GGA or ZDA"]);
}

/// The healthy log of some start with one fault of its clock.
fn with_fault(draw: &mut Draw) -> (String, Vec<Epoch>, &'static str) {
    let clock = ["RMC", "GGA"][draw.below(2)];
    let start = if draw.below(2) == 0 { 86_400 - draw.between(1, 60) } else { draw.below(86_000) };
    let mut all = from(start, "310725", "010825");
    let place = usize::from(clock == "GGA");
    // Rows missing at the ends of a log cannot be detected.
    let at = draw.between(5, 50);
    let what = ["late", "void", "cold", "back", "lost", "ahead", "early"][draw.below(7)];
    match what {
        "late" => {
            let late = draw.between(1, at.min(9));
            let body = all[at - late].bodies[place].clone();
            all[at].bodies.push(body);
        }
        "void" => {
            for epoch in &mut all[at..(at + 3).min(61)] {
                let time = clock_from(start, epoch.second);
                epoch.bodies[0] = void(&time, ["", "310725", "060180"][draw.below(3)]);
                epoch.bodies[1] = format!("GPGGA,{time},,,,,0,00,,,M,,M,,");
            }
        }
        "cold" => {
            let first = all[0].bodies.clone();
            for second in (0..draw.between(1, 9)).rev() {
                let time = format!("0000{:02}.00", 10 + second);
                let mut bodies = first[2..].to_vec();
                bodies.insert(0, void(&time, ["060180", "220899", "070419"][draw.below(3)]));
                bodies.insert(1, format!("GPGGA,{time},,,,,0,00,,,M,,M,,"));
                all.insert(0, Epoch { second: 0, bodies });
            }
        }
        "lost" => {
            for epoch in &mut all[at..(at + draw.between(1, 5)).min(61)] {
                epoch.bodies.remove(place);
            }
        }
        "back" | "ahead" => {
            let by = draw.between(2, 2000);
            for epoch in &mut all[at..] {
                let own = clock_from(start, epoch.second);
                let second = if what == "back" { 86_400 + epoch.second - by } else { epoch.second + by };
                let other = clock_from(start, second);
                epoch.bodies[..2].iter_mut().for_each(|body| *body = body.replace(&own, &other));
            }
        }
        _ => {
            let (own, other) = (clock_from(start, at), clock_from(start, at + draw.between(2, 9)));
            all[at].bodies[..2].iter_mut().for_each(|body| *body = body.replace(&own, &other));
        }
    }
    (clock.to_owned(), all, what)
}

#[test]
fn law_a_fault_of_the_clock_is_never_silent() {
    none_is_silent(231, |draw: &mut Draw| {
        let (clock, all, what) = with_fault(draw);
        let named = &["without_time", "splits", " time ", "late", "quality"];
        Faulty::new(&config(&clock), "a.nmea", nmea(&all), 61).named(named).what(format!("{what}, {clock}"))
    });
}

#[test]
fn a_stamp_ahead_of_its_time_is_no_silence() {
    let mut all = epochs(60);
    all[20].bodies[0] = all[20].bodies[0].replace(&clock(20), &clock(22));
    let folder = folder(&[("ingest.toml", &config("RMC")), ("a.nmea", &nmea(&all))]);
    let found = verdict(folder.path(), 61, &["without_time", "late"]);
    assert!(!matches!(found, Verdict::Silent(_)), "{found:?}");
}
