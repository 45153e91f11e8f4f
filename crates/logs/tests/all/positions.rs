//! Positions of ships from tables and sentences.

use logs::{Format, LogError, LoggedPosition, LoggedPositions, Since, read_positions};

fn read(text: &str, format: Format) -> Result<LoggedPositions, String> {
    read_positions(text.as_bytes(), format, &["tau"]).map_err(|error| match error {
        LogError::Invalid(invalid) => invalid.to_string(),
        LogError::Unreadable(error) => panic!("{error}"),
    })
}

fn sentence(body: &str) -> String {
    format!("${body}*{:02X}\n", body.bytes().fold(0, |sum, byte| sum ^ byte))
}

#[test]
fn tables_are_read_by_their_header_in_any_order() {
    let text = "latitude_deg, time, heading_deg, longitude_deg, speed_m_s\n60.5,12.5,359.5,-24.25,1.5\n\n-1,13,,180,\n";
    let found = read(text, Format::Csv).unwrap();
    assert_eq!(found.since, Since::Departure);
    let row = |line, at_s, longitude_deg, latitude_deg, heading_deg, speed_m_s| LoggedPosition {
        line,
        at_s,
        longitude_deg,
        latitude_deg,
        heading_deg,
        speed_m_s,
    };
    let expected =
        [row(2, 12.5, -24.25, 60.5, Some(359.5), Some(1.5)), row(4, 13.0, 180.0, -1.0, None, None)];
    assert_eq!(found.rows, expected);
}

#[test]
fn times_of_day_have_offsets_or_are_utc() {
    let head = "time,longitude_deg,latitude_deg\n";
    let found =
        read(&format!("{head}2026-06-01T11:00:00.5+03:00,25,60\n2026-06-01T08:00:01Z,25,60\n"), Format::Csv);
    let found = found.unwrap();
    let times: Vec<f64> = found.rows.iter().map(|row| row.at_s).collect();
    assert_eq!((found.since, times), (Since::Epoch, vec![1_780_300_800.5, 1_780_300_801.0]));
}

#[test]
fn sentences_give_one_position_a_time_with_the_heading_before_it() {
    let log = [
        sentence("HEHDT,68.7,T"),
        sentence("GPGGA,235959.00,6008.916,N,02457.180,E,1,8,0.9,5.0,M,18.0,M,,"),
        sentence("GPZDA,235959.00,31,05,2026,00,00"),
        sentence("GPGGA,235959.00,6008.916,N,02457.180,E,1,8,0.9,5.0,M,18.0,M,,"),
        sentence("GPGGA,235959.00,6008.916,N,02457.180,E,1,8,0.9,5.0,M,18.0,M,,"),
        // Another receiver, no fix, a wrong checksum.
        sentence("GLGGA,235959.50,6108.916,N,02457.180,E,1,8,0.9,5.0,M,18.0,M,,"),
        sentence("GPGGA,235959.60,6008.916,N,02457.180,E,0,8,0.9,5.0,M,18.0,M,,"),
        "$GPGGA,235959.70,6008.916,N,02457.180,E,1,8,0.9,5.0,M,18.0,M,,*00\n".to_owned(),
        // After midnight, before the next date.
        sentence("GPGGA,000001.00,6008.928,S,02457.180,W,2,8,0.9,5.0,M,18.0,M,,"),
    ];
    let found = read(&log.concat(), Format::Nmea).unwrap();
    assert_eq!(found.since, Since::Epoch);
    let [first, second] = &found.rows[..] else { panic!("{found:?}") };
    assert_eq!((first.line, first.at_s, first.heading_deg), (4, 1_780_271_999.0, Some(68.7)));
    assert_eq!((second.line, second.at_s, second.heading_deg), (9, 1_780_272_001.0, None));
    assert!((first.latitude_deg - (60.0 + 8.916 / 60.0)).abs() < 1e-12);
    assert!((second.latitude_deg + (60.0 + 8.928 / 60.0)).abs() < 1e-12);
    assert!((first.longitude_deg + second.longitude_deg).abs() < 1e-12);
}

#[test]
fn sentences_that_go_back_in_time_or_have_none_are_refused() {
    let rmc = |time: &str| sentence(&format!("GPRMC,{time},A,6008.916,N,02457.180,E,3.0,90.0,010626,,,A"));
    let found = read(&(rmc("080002.00") + &rmc("080001.00")), Format::Nmea).unwrap_err();
    assert!(found.contains("line 2, `time`") && found.contains("1.000 s before"), "{found}");
    assert!(read("no sentence\n", Format::Nmea).unwrap_err().contains("positions: found none"));
    let found = read(&rmc("089002.00"), Format::Nmea).unwrap_err();
    assert!(found.contains("line 1, GPRMC"), "{found}");
    assert!(read("", Format::Mcap).unwrap_err().contains("a table or a bag"));
}

#[test]
fn sentences_of_two_receivers_are_refused_where_they_differ() {
    // A second apart, heading north at 3 m/s; the other receiver is `off` minutes of latitude farther north.
    let log = |other: &str, off: f64, later: f64| -> String {
        let fix = |address: &str, at: f64, minutes: f64| {
            let place = format!("60{minutes:09.6},N,02457.180,E");
            match &address[2..] {
                "RMC" => sentence(&format!("{address},0800{at:05.2},A,{place},6.0,0.0,010626,,,A")),
                _ => sentence(&format!("{address},0800{at:05.2},{place},1,8,0.9,5.0,M,18.0,M,,")),
            }
        };
        let both = (0..20).map(|k| {
            let (at, minutes) = (f64::from(k), 8.9 + 3.0 / 1852.0 * f64::from(k));
            fix("GPRMC", at, minutes) + &fix(other, at + later, minutes + 3.0 / 1852.0 * later + off)
        });
        both.collect()
    };
    let metres = 1.0 / 1852.0;
    for (other, off, later) in
        [("GPGGA", 0.0, 0.0), ("GNGGA", 2.0, 0.0), ("GNRMC", 3.0, 0.5), ("GPRMC", 2.0, 0.0)]
    {
        let found = read(&log(other, off * metres, later), Format::Nmea).unwrap();
        assert_eq!((found.rows.len(), found.left_out), (20, 0), "{other}");
    }
    for (other, off, later) in
        [("GNRMC", 12.0, 0.0), ("GNRMC", 200.0, 0.5), ("GNGGA", 200.0, 0.0), ("GPRMC", 12.0, 0.0)]
    {
        let found = read(&log(other, off * metres, later), Format::Nmea).unwrap_err();
        assert!(found.contains(&format!("{other} {off} m away from GPRMC at the same time")), "{found}");
    }
}

#[test]
fn logs_that_go_on_after_their_last_fix_are_refused() {
    let rmc = |at: u32, state: &str| {
        sentence(&format!("GPRMC,0800{at:02},{state},6008.916,N,02457.180,E,3.0,90.0,010626,,,A"))
    };
    let log = |last: u32| (0..=last).map(|at| rmc(at, if at > 20 { "V" } else { "A" })).collect::<String>();
    let found = read(&log(28), Format::Nmea).unwrap();
    assert_eq!((found.rows.len(), found.left_out), (21, 8));
    let found = read(&log(40), Format::Nmea).unwrap_err();
    assert!(found.contains("line 21: found the last fix, 20 s before the end of the log"), "{found}");
    // 0 N 0 E is no fix.
    let row = |at: u32| format!("{at},{}\n", if at > 20 || at == 7 { "0,0.0" } else { "24.95,60.15" });
    let log =
        |last: u32| "time,longitude_deg,latitude_deg\n".to_owned() + &(0..=last).map(row).collect::<String>();
    let found = read(&log(20), Format::Csv).unwrap();
    assert_eq!((found.rows.len(), found.left_out), (20, 1));
    assert!(read(&log(40), Format::Csv).unwrap_err().contains("line 22: found the last fix, 20 s before"));
    let none = "time,longitude_deg,latitude_deg\n0,0,0\n";
    assert!(read(none, Format::Csv).unwrap_err().contains("none but 0 N 0 E"));
}

#[test]
fn tables_have_other_separators_and_inputs() {
    let comma = "time,longitude_deg,latitude_deg,tau\n0,24.5,60.25,1.5\n1,24.5,60.25,\n";
    let expected = read(comma, Format::Csv).unwrap();
    assert_eq!(expected.inputs["tau"], [[0.0, 1.5]]);
    for separator in [";", "\t", "|"] {
        let own = comma.replace(',', separator);
        assert_eq!(read(&own, Format::Csv).unwrap(), expected);
        assert_eq!(read(&own.replace('.', ","), Format::Csv).unwrap(), expected);
    }
    assert!(read(&comma.replace(",1.5", ",much"), Format::Csv).unwrap_err().contains("`tau`: found `much`"));
    assert!(
        read(&comma.replace('.', ","), Format::Csv).unwrap_err().contains("decimal commas need semicolons")
    );
    let exchanged = "time,longitude_deg,latitude_deg\n0,-33.9,151.2\n";
    assert!(read(exchanged, Format::Csv).unwrap_err().contains("exchange longitude and latitude"));
}
