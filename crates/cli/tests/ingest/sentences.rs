//! Sentences as received: without ends of lines, without checksums, in other encodings, among others.

use crate::known::*;
use crate::runner::*;
use crate::silent::{Draw, Faulty, none_is_silent, said};

fn config(keys: &str) -> String {
    nmea_config("RMC", "HDT.heading", keys)
}

fn made(keys: &str, log: &str) -> Made {
    read(folder(&[("ingest.toml", &config(keys)), ("a.nmea", log)]).path())
}

fn log() -> String {
    nmea(&epochs(60))
}

fn without_checksums(log: &str) -> String {
    log.lines().map(|line| format!("{}\r\n", line.split('*').next().unwrap())).collect()
}

#[test]
fn sentences_that_share_a_line_are_read() {
    for every in [2, 7] {
        let lines = log();
        let lines = lines.lines().enumerate();
        let joined: String = lines
            .map(|(k, line)| if k % every == 1 { line.to_owned() } else { format!("{line}\r\n") })
            .collect();
        healthy(&made("", &joined), 61);
    }
}

#[test]
fn sentences_that_nobody_asks_for_need_no_checksum() {
    let strange = log().replace("$GPRMC", "$RPYL,15,9,314,11,0,1009,0\r\n$GPXTE,A,A,0.67,L,N*00\r\n$GPRMC");
    let found = made("", &strange);
    healthy(&found, 61);
    assert_eq!(found.summary.recordings[0].rows.wrong_checksums, 122);
}

#[test]
fn sentences_without_checksums_are_read_where_that_is_asked_for() {
    let bare = without_checksums(&log());
    healthy(&made("checksums = \"optional\"", &bare), 61);
    healthy(&made("max_wrong_checksums = 1.0", &bare), 61);
    let folder = folder(&[("ingest.toml", &config("")), ("a.nmea", &bare)]);
    refused_in(folder.path(), &[], &["checksums", "without any", "`checksums = \"optional\"`"]);
}

#[test]
fn torn_sentences_without_checksums_are_left_out() {
    let bare = without_checksums(&log());
    let torn = bare.replacen("$HEHDT,77.819,T", "$HEHDT,7", 1).replacen("$HEROT,248", "$HER", 1);
    let found = made("checksums = \"optional\"", &torn);
    healthy(&found, 61);
    assert!(found.summary.recordings[0].rows.wrong_checksums > 0);
}

#[test]
fn small_letters_blanks_and_commas_after_a_checksum_do_no_harm() {
    let lines = log();
    let ends = ["", " ", ",,,", "\t", "\0", ",,, \r"];
    let changed = lines.lines().enumerate().map(|(k, line)| {
        let (body, checksum) = line.split_once('*').unwrap();
        format!("{body}*{}{}\n", checksum.to_lowercase(), ends[k % ends.len()])
    });
    healthy(&made("", &changed.collect::<String>()), 61);
}

#[test]
fn what_stands_before_sentences_does_no_harm() {
    for before in
        ["UdPbC\0\\s:GP0001,n:1*34\\", "\\g:1-2-73874,c:1577836800*3D\\", "[12:00:01] ", "1577836800.123;"]
    {
        let changed: String = log().lines().map(|line| format!("{before}{line}\r\n")).collect();
        healthy(&made("", &changed), 61);
    }
}

#[test]
fn a_file_of_another_kind_is_refused_as_such() {
    for other in ["t,u,v\n0,1,2\n", "", "\u{0}\u{1}\u{2}"] {
        let folder = folder(&[("ingest.toml", &config("")), ("a.nmea", other)]);
        refused_in(folder.path(), &[], &["a.nmea: file", "no sentence of NMEA 0183", "`format`"]);
    }
}

#[test]
fn law_a_line_that_spoils_sentences_is_never_silent() {
    none_is_silent(241, |draw: &mut Draw| {
        let bare = draw.below(2) == 0;
        let log = if bare { without_checksums(&log()) } else { log() };
        let mut text = String::new();
        let share = 0.02 * draw.share();
        let count = log.lines().count();
        for (k, line) in log.lines().enumerate() {
            // Rows missing at the ends of a log cannot be detected.
            if !(14..count - 14).contains(&k) || draw.share() >= share {
                text += &format!("{line}\r\n");
                continue;
            }
            let cut = draw.below(line.len());
            match draw.below(5) {
                0 => text += line,
                1 => text += &format!("{}\r\n", &line[..cut]),
                2 => text += &line[..cut],
                3 => text += &format!("{}\r\n", &line[cut..]),
                // Without a checksum a digit more is a value like others.
                _ if bare => text += &format!("{line}\r\n{line}\r\n"),
                _ => text += &format!("{}{}{}\r\n", &line[..cut], 7, &line[cut..]),
            }
        }
        let keys = if bare { "checksums = \"optional\"" } else { "max_wrong_checksums = 0.1" };
        // A line may be lost as a whole.
        let named = &["wrong_checksums", "cut", "splits"];
        Faulty::new(&config(keys), "a.nmea", text, 61).named(named).what(format!("{keys}, {share}"))
    });
}

#[test]
fn sentences_that_come_twice_do_no_harm() {
    let lines = log();
    let twice = |(k, line): (usize, &str)| format!("{line}\r\n").repeat(if k % 7 < 3 { 2 } else { 1 });
    let found = made("", &lines.lines().enumerate().map(twice).collect::<String>());
    healthy(&found, 61);
    assert!(found.summary.recordings[0].rows.repeated > 0);
}

#[test]
fn what_is_left_out_is_said() {
    let wrong = log().replacen("$HEHDT,77.819,T", "$HEHDT,17.819,T", 1);
    let found = made("", &wrong);
    let said = said(&found.summary.recordings[0]);
    assert!(said.contains(&"rows wrong_checksums 1".to_owned()), "{said:?}");
}
