//! Positions of ships from tables and sentences.

use logs::{Format, LogError, LoggedPosition, LoggedPositions, Since, read_positions};

fn read(text: &str, format: Format) -> Result<LoggedPositions, String> {
    read_positions(text.as_bytes(), format).map_err(|error| match error {
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
