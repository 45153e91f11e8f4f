//! Logs as recorded on ships (`fixtures/field`, written by scripts/field_logs.py): from file to trajectories, and
//! what is refused.

use std::fs;

use crate::runner::*;

const CONFIG: [&str; 2] = ["--config", "ingest.toml"];

/// Surge, sway \[m/s\] and yaw rate \[rad/s\] that all three were made of.
pub fn motion(t: f64) -> [f64; 3] {
    [2.0 + 0.4 * (0.11 * t).sin(), 0.2 * (0.17 * t).sin(), 0.08 * (0.13 * t).cos()]
}

pub fn rudder(t: f64) -> f64 {
    (15.0 * (0.13 * t + 0.4).sin()).to_radians()
}

pub fn revolutions(t: f64) -> f64 {
    8.0 + (0.11 * t + 0.2).sin()
}

/// Runs `ingest` on a set; its rows begin `from` seconds after the motion.
#[track_caller]
fn check(set: &str, from: f64, rows: usize, [speed, rate, inputs]: [f64; 3]) -> Made {
    let made = ingest(&repository("fixtures/field").join(set), &CONFIG);
    assert_eq!(made.rows, rows, "{set}");
    let off = |name: &str, truth: &dyn Fn(f64) -> f64| {
        let last = if ["delta", "n"].contains(&name) { rows - 1 } else { rows };
        let times = made.f64("t");
        let squares = (0..last).map(|k| (made.f64(name)[k] - truth(from + times[k])).powi(2));
        (squares.sum::<f64>() / last as f64).sqrt()
    };
    for (name, d, noise) in [("y_u", 0, speed), ("y_v", 1, speed), ("y_r", 2, rate)] {
        let found = off(name, &|t| motion(t)[d]);
        assert!(found < noise, "{set}: {name} is {found} off");
    }
    for (name, found) in [("delta", off("delta", &rudder)), ("n", off("n", &revolutions) / 8.0)] {
        assert!(found < inputs, "{set}: {name} is {found} off");
    }
    made
}

#[test]
fn an_autopilots_text_becomes_trajectories() {
    // White noise of 0.02 m/s and 0.001 rad/s, five samples averaged.
    let made = check("autopilot", 0.0, 240, [0.02, 0.001, 0.005]);
    assert!(made.columns.contains_key("roll"));
    let heading = made.f64("psi");
    assert!(heading.iter().enumerate().all(|(k, psi)| {
        let t = 0.5 * k as f64;
        (psi - 1.2 - 0.08 / 0.13 * (0.13 * t).sin()).abs() < 0.004
    }));
}

#[test]
fn a_survey_vessels_sentences_become_trajectories() {
    // Slopes of positions with a noise of 1 cm over five seconds.
    let made = check("survey", 0.0, 120, [0.02, 0.001, 0.005]);
    let rows = made.summary.recordings[0].rows;
    assert_eq!((rows.wrong_checksums, rows.repeated), (3, 0), "{rows:?}");
    assert!(rows.spread > 1000, "{rows:?}");
}

#[test]
fn a_bag_of_topics_on_their_own_clocks_becomes_trajectories() {
    // The propeller's topic begins half a second later.
    let made = check("robot", 0.5, 239, [0.02, 0.001, 0.005]);
    let rates = |name: &str| {
        let recording = &made.summary.recordings[0];
        recording.channels.iter().find(|channel| channel.name == name).unwrap().rate_hz.unwrap()
    };
    for (name, rate_hz) in [("y_u", 10.0), ("delta", 5.0), ("n", 2.0)] {
        assert!((rates(name) - rate_hz).abs() < 1e-3, "{name} at {} Hz", rates(name));
    }
}

#[test]
fn a_bag_of_lz4_chunks_is_read() {
    let text = config("")
        .replace("*.csv", "*.mcap")
        .replace("unit = \"s\" }", "}")
        .replace("column = \"t\",", "column = \"log_time\"")
        .replace("time =", "topic = \"/speeds\"\ntime =");
    let folder = folder(&[("ingest.toml", &text)]);
    fs::copy(repository("fixtures/field/robot/short-lz4.mcap"), folder.path().join("a.mcap")).unwrap();
    let made = ingest(folder.path(), &CONFIG);
    assert_eq!(made.rows, 20);
    approx::assert_relative_eq!(made.f64("y_u")[7], 1.7, max_relative = 1e-12);
}

/// Must be refused with the set's configuration after `change`, and its log after `damage`.
#[track_caller]
fn refused_set(
    set: &str,
    log: &str,
    change: &[(&str, &str)],
    damage: impl Fn(Vec<u8>) -> Vec<u8>,
    pieces: &[&str],
) {
    let set = repository("fixtures/field").join(set);
    let mut text = fs::read_to_string(set.join("ingest.toml")).unwrap();
    for (from, to) in change {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let folder = folder(&[("ingest.toml", &text)]);
    fs::write(folder.path().join(log), damage(fs::read(set.join(log)).unwrap())).unwrap();
    refused_in(folder.path(), &[], pieces);
}

#[test]
fn a_bag_without_the_topic_or_of_another_encoding_is_refused() {
    let same = |bytes: Vec<u8>| bytes;
    let bag =
        |change: (&str, &str), pieces: &[&str]| refused_set("robot", "mission.mcap", &[change], same, pieces);
    let topics = [
        "mission.mcap: topic",
        "no `/joint`",
        "`/camera`, `/joints`, `/odometry`, `/propeller`",
        "did you mean `/joints`?",
    ];
    bag(("\"/joints\"", "\"/joint\""), &topics);
    bag(
        ("\"/joints\"", "\"/camera\""),
        &["encoding of topic `/camera`", "messages in `protobuf`", "cdr with ros2msg, or json"],
    );
    bag(
        ("position[1]", "positions[1]"),
        &["column of topic `/joints`", "`positions[1]`", "`position[0]`, `velocity[0]`"],
    );
    bag(("position[1]", "name[1]"), &["column of topic `/joints`", "a number in sensor_msgs/msg/JointState"]);
    bag(("shaft[0].rps", "shaft[0].rpm"), &["column", "`shaft[0].rpm` in none of"]);
    bag(("topic = \"/joints\"\n", ""), &["ingest.toml: `topic`", "mission.mcap"]);
    let unit = ("{ column = \"publish_time\" }", "{ column = \"publish_time\", unit = \"ns\" }");
    bag(unit, &["ingest.toml: `time`", "`unit` of `publish_time`"]);
}

#[test]
fn damaged_bags_are_refused() {
    let half = |bytes: Vec<u8>| bytes[..bytes.len() / 2].to_vec();
    refused_set(
        "robot",
        "mission.mcap",
        &[],
        half,
        &["mission.mcap: file", "an end within a record", "mcap recover"],
    );
    let text = |_| b"t,u\n0,1\n".to_vec();
    refused_set("robot", "mission.mcap", &[], text, &["mission.mcap: format", "a bag of MCAP"]);
    let flipped = |mut bytes: Vec<u8>| {
        let middle = bytes.len() / 2;
        bytes[middle] ^= 0xff;
        bytes
    };
    refused_set("robot", "mission.mcap", &[], flipped, &["mission.mcap: chunk", "mcap recover"]);
}

#[test]
fn sentences_with_wrong_checksums_are_refused_beyond_a_share() {
    let wrong = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap().replace("HEHDT,7", "HEHDT,9").into_bytes();
    let pieces = ["line.nmea: checksums", "wrong ones of", "at most 0.01", "`max_wrong_checksums`"];
    refused_set("survey", "line.nmea", &[], wrong, &pieces);
    let stricter = ("[[file]]", "[[file]]\nmax_wrong_checksums = 0.0005");
    let same = |bytes: Vec<u8>| bytes;
    refused_set(
        "survey",
        "line.nmea",
        &[stricter],
        same,
        &["checksums", "found 3 wrong ones of", "the first in line"],
    );
}

#[test]
fn sentences_and_fields_that_there_are_not_are_refused() {
    let same = |bytes: Vec<u8>| bytes;
    let nmea =
        |change: (&str, &str), pieces: &[&str]| refused_set("survey", "line.nmea", &[change], same, pieces);
    nmea(("HDT.heading", "HDT.headin"), &["column", "`HDT.headin`", "did you mean `HDT.heading`?"]);
    nmea(("HDT.heading", "THS.heading"), &["column `THS.heading`", "no such sentence", "HEHDT"]);
    nmea(("RPM-S1.speed", "RPM.speed"), &["column", "`RPM.speed`", "RPM-S1.speed"]);
    nmea(("unit = \"deg/min\"", "unit = \"deg/s\""), &["unit of column `ROT.rate`", "expected `deg/min`"]);
    nmea(("\"RMC\", repeated", "\"ZDA\", repeated"), &["column `ZDA`", "no such sentence"]);
    nmea(("\"RMC\", repeated", "\"HDT\", repeated"), &["time of sentences", "`HDT`", "RMC, ZDA"]);
    nmea((", repeated = \"spread\"", ""), &["column `RMC`", "the time of an earlier row", "\"spread\""]);
    let wrong = |bytes: Vec<u8>| {
        let text = String::from_utf8(bytes).unwrap();
        text.replacen("$IIRSA,5.84,A,,V*40", "$IIRSA,5x84,A,,V*16", 1).into_bytes()
    };
    refused_set(
        "survey",
        "line.nmea",
        &[],
        wrong,
        &["line.nmea: line 5, column `IIRSA.starboard`", "`5x84`", "a number"],
    );
}

#[test]
fn a_stamp_before_each_sentence_is_its_time() {
    let stamped = |k: usize, body: &str| {
        let checksum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        format!("[2025-04-11 12:08:{:02}.{}] ${body}*{checksum:02X}\n", k / 5, k % 5 * 2)
    };
    let row = |k: usize| {
        stamped(k, &format!("VDVBW,,,V,{:.2},0.10,A", 1.0 + 0.1 * k as f64))
            + &stamped(k, "HEROT,0.0,A")
            + &stamped(k, "ERRPM,S,1,60,,A")
    };
    let log: String = (0..60).map(row).collect();
    let text = "sample_rate_hz = 5.0\nmax_gap_s = 0.5\n[[file]]\npattern = [\"*.log\"]\nformat = \"nmea\"\n\
         time = { column = \"prefix\", format = \"%Y-%m-%d %H:%M:%S%.f\" }\nchannel = [\n\
         { column = \"VBW.surge\", channel = \"y_u\", unit = \"knot\" },\n\
         { column = \"VDVBW.sway\", channel = \"y_v\", unit = \"knot\" },\n\
         { column = \"ROT.rate\", channel = \"y_r\", unit = \"deg/min\" },\n\
         { column = \"RPM-S1.speed\", channel = \"n\", unit = \"rpm\" },\n]\n";
    let made = ingest(folder(&[("ingest.toml", text), ("a.log", &log)]).path(), &CONFIG);
    assert_eq!(made.rows, 60);
    for k in 0..60 {
        assert!((made.f64("y_u")[k] - (1.0 + 0.1 * k as f64) * 1852.0 / 3600.0).abs() < 1e-6, "{k}");
    }
    assert_eq!(made.summary.recordings[0].rows.repeated, 0, "sentences of one time are one row");
    let other = log.replacen("12:08:03.4", "12:08", 1);
    let pieces = ["a.log: line", "column `prefix`", "`2025-04-11 12:08`", "as a whole"];
    refused_in(folder(&[("ingest.toml", text), ("a.log", &other)]).path(), &[], &pieces);
}
