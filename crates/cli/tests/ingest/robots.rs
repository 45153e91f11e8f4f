//! Bags of ROS 1, of ROS 2 in SQLite, ULogs of PX4 and sentences (`fixtures/field`, written by scripts/field_bags.py and
//! field_logs.py): from the file by way of the `ingest.toml` that `new --logs` writes to trajectories, and what is refused.

use std::fs;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

use crate::field::{motion, revolutions, rudder};
use crate::runner::*;

/// Most lines of an `ingest.toml`.
const LINES: usize = 40;

/// A folder with a set's files called `names`.
fn logs(set: &str, names: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in names {
        let from = repository("fixtures/field").join(set).join(name);
        fs::copy(from, folder.path().join(name)).unwrap();
    }
    folder
}

/// The `ingest.toml` that `new` writes for the logs in `folder`.
#[track_caller]
fn begun(folder: &Path) -> String {
    begun_with(folder, "0 channels missing")
}

/// As [`begun`], where `new` says `missing`.
#[track_caller]
fn begun_with(folder: &Path, missing: &str) -> String {
    let mine = tempfile::tempdir().unwrap();
    let study = mine.path().join("mine");
    let mut new = Command::new(env!("CARGO_BIN_EXE_seatrial"));
    new.args(["new", study.to_str().unwrap(), "--vessel", "esso-osaka", "--logs", folder.to_str().unwrap()]);
    let ran = new.output().unwrap();
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let said = String::from_utf8_lossy(&ran.stdout).into_owned();
    assert!(said.contains(missing), "{said}");
    fs::read_to_string(study.join("ingest.toml")).unwrap()
}

/// A value over time.
type Truth<'a> = &'a dyn Fn(f64) -> f64;

/// The root mean square of `name` less `truth` over all rows but the last.
fn off(made: &Made, name: &str, truth: Truth) -> f64 {
    let (values, times) = (made.f64(name), made.f64("t"));
    let rows = values.len() - 1;
    let squares = (0..rows).map(|k| (values[k] - truth(times[k])).powi(2));
    (squares.sum::<f64>() / rows as f64).sqrt()
}

/// What `new` writes for these files of a set must be that of its folder, and give the motion within the noise of the logs.
#[track_caller]
fn law_of(set: &str, names: &[&str]) {
    let folder = logs(set, names);
    let text = begun(folder.path());
    let kept = fs::read_to_string(repository("fixtures/field").join(set).join("ingest.toml")).unwrap();
    assert_eq!(text, kept, "what `new` writes for {set}:\n{text}");
    assert!(text.lines().count() <= LINES, "{} lines:\n{text}", text.lines().count());
    fs::write(folder.path().join("ingest.toml"), &text).unwrap();
    let made = ingest(folder.path(), &["--config", "ingest.toml"]);
    assert_eq!((made.rows, made.summary.recordings.len()), (120, 1), "{set}: {}", made.line);
    // White noise of 0.02 m/s, 0.001 rad/s and 0.001 rad, of which two or three samples are averaged; places of 1 cm.
    let heading = |t: f64| 1.2 + 0.08 / 0.13 * (0.13 * t).sin();
    let truths: [(&str, f64, Truth); 6] = [
        ("y_u", 0.02, &|t| motion(t)[0]),
        ("y_v", 0.02, &|t| motion(t)[1]),
        ("y_r", 0.001, &|t| motion(t)[2]),
        ("psi", 0.001, &heading),
        ("delta", 0.002, &rudder),
        ("n", 0.01, &revolutions),
    ];
    for (name, noise, truth) in truths {
        let found = off(&made, name, truth);
        assert!(found < noise, "{set}: {name} is {found} off");
    }
}

const ROS2: [&str; 3] = ["mission_0.db3", "mission_1.db3", "metadata.yaml"];

#[test]
fn law_a_bag_of_ros_1_becomes_the_motion_that_it_was_made_of() {
    law_of("ros1", &["mission.bag"]);
}

#[test]
fn law_a_split_bag_of_ros_2_in_sqlite_becomes_the_motion_that_it_was_made_of() {
    law_of("ros2", &ROS2);
}

#[test]
fn law_a_ulog_becomes_the_motion_that_it_was_made_of() {
    law_of("px4", &["mission.ulg"]);
}

/// The sentences of the survey vessel after `change`, in a file called `name`.
fn sentences(name: &str, change: impl Fn(&str) -> String) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(repository("fixtures/field/survey/line.nmea")).unwrap();
    let lines: Vec<String> = text.lines().map(change).filter(|line| !line.is_empty()).collect();
    fs::write(folder.path().join(name), lines.join("\r\n")).unwrap();
    folder
}

#[test]
fn law_sentences_become_the_motion_that_they_were_made_of() {
    for (name, kind) in [("line.nmea", "pattern = [\"*.nmea\"]"), ("line.log", "format = \"nmea\"")] {
        let folder = sentences(name, str::to_owned);
        let text = begun(folder.path());
        assert!(text.contains(kind) && text.lines().count() <= LINES, "{text}");
        fs::write(folder.path().join("ingest.toml"), &text).unwrap();
        let made = ingest(folder.path(), &["--config", "ingest.toml"]);
        assert_eq!((made.rows, made.summary.recordings.len()), (120, 1), "{}", made.line);
        // Slopes of positions with a noise of 1 cm over five seconds; rudder and propeller once a second.
        let truths: [(&str, f64, Truth); 5] = [
            ("y_u", 0.02, &|t| motion(t)[0]),
            ("y_v", 0.02, &|t| motion(t)[1]),
            ("y_r", 0.001, &|t| motion(t)[2]),
            ("delta", 0.005, &rudder),
            ("n", 0.04, &revolutions),
        ];
        for (name, noise, truth) in truths {
            let found = off(&made, name, truth);
            assert!(found < noise, "{name} is {found} off");
        }
    }
}

#[test]
fn of_several_talkers_the_one_that_says_most_comes_first() {
    // A second compass that speaks once a second.
    let folder = sentences("line.nmea", |line| match line.starts_with("$GPRMC") {
        true => format!("{line}\r\n$GPHDT,68.775,T*0E"),
        false => line.to_owned(),
    });
    let text = begun(folder.path());
    assert!(text.contains("prefer = [\"HE\", \"GP\"]  # guessed"), "{text}");
    fs::write(folder.path().join("ingest.toml"), &text).unwrap();
    assert_eq!(ingest(folder.path(), &["--config", "ingest.toml"]).rows, 120);
}

#[test]
fn a_field_that_is_missing_works_once_it_is_named() {
    let folder = sentences("line.nmea", |line| line.replace("IIRSA", "IIXDR"));
    let text = begun_with(folder.path(), "1 channels missing");
    let template = "#    { column = \"\", channel = \"delta\", unit = \"rad\" },\n";
    assert!(text.contains(template), "{text}");
    let named = "channel = [\n    { column = \"RPM-S1.pitch\", channel = \"delta\", unit = \"%\" },";
    let text = text.replace(template, "").replacen("channel = [", named, 1);
    fs::write(folder.path().join("ingest.toml"), &text).unwrap();
    assert_eq!(ingest(folder.path(), &["--config", "ingest.toml"]).rows, 120);
}

#[test]
fn sentences_without_a_time_are_refused() {
    let is_timed = |line: &str| line.contains("RMC") || line.contains("GGA");
    let folder = sentences("line.nmea", |line| if is_timed(line) { String::new() } else { line.to_owned() });
    let mut new = Command::new(env!("CARGO_BIN_EXE_seatrial"));
    let logs = folder.path().to_str().unwrap();
    let words = ["new", &format!("{logs}/mine"), "--vessel", "coaster", "--logs", logs];
    let ran = new.args(words).output().unwrap();
    let said = String::from_utf8_lossy(&ran.stderr).into_owned();
    assert!(ran.status.code() == Some(3) && said.lines().count() == 1, "{said}");
    assert!(said.contains("line.nmea: time: found none, expected sentences with a time: RMC, ZDA"), "{said}");
    assert!(!folder.path().join("mine").exists());
}

#[test]
fn bags_of_ros_2_in_folders_of_their_own_are_recordings_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["zigzag", "turning"] {
        let own = logs("ros2", &ROS2);
        fs::rename(own.keep(), folder.path().join(name)).unwrap();
    }
    let text = begun(folder.path());
    assert!(text.contains("run_from_file = \"{run}/*.db3\""), "{text}");
    fs::write(folder.path().join("ingest.toml"), text).unwrap();
    let made = ingest(folder.path(), &["--config", "ingest.toml"]);
    let names: Vec<&str> = made.summary.recordings.iter().map(|own| own.name.as_str()).collect();
    assert_eq!((names, made.rows), (vec!["turning", "zigzag"], 240), "{}", made.line);
}

/// A set in a folder with its `ingest.toml` after `change`, its only log called `name` after `damage`.
fn changed(set: &str, name: &str, change: &[(&str, &str)], damage: impl Fn(Vec<u8>) -> Vec<u8>) -> TempDir {
    let own = repository("fixtures/field").join(set);
    let mut text = fs::read_to_string(own.join("ingest.toml")).unwrap();
    for (from, to) in change {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let folder = folder(&[("ingest.toml", &text)]);
    fs::write(folder.path().join(name), damage(fs::read(own.join(name)).unwrap())).unwrap();
    folder
}

fn same(bytes: Vec<u8>) -> Vec<u8> {
    bytes
}

fn half(bytes: Vec<u8>) -> Vec<u8> {
    bytes[..bytes.len() / 2].to_vec()
}

#[test]
fn a_bag_of_lz4_chunks_and_one_of_compressed_messages_without_definitions_are_read() {
    let bag = changed("ros1", "short-lz4.bag", &[], same);
    let made = ingest(bag.path(), &["--config", "ingest.toml"]);
    assert!((9..=10).contains(&made.rows), "{}", made.rows);
    assert!(off(&made, "delta", &rudder) < 0.002);
    // Its propeller is in a message of an unknown type.
    let text = fs::read_to_string(repository("fixtures/field/ros2/ingest.toml")).unwrap();
    let known = text.split("\n[[file]]").filter(|group| !group.contains("/propeller"));
    let known = known.collect::<Vec<_>>().join("\n[[file]]").replace("{run}_*.db3", "{run}.db3");
    let bag = folder(&[("ingest.toml", &known)]);
    fs::copy(repository("fixtures/field/ros2/short-bare.db3"), bag.path().join("short-bare.db3")).unwrap();
    let made = ingest(bag.path(), &["--config", "ingest.toml"]);
    assert!((9..=10).contains(&made.rows), "{}", made.rows);
    assert!(off(&made, "delta", &rudder) < 0.002 && off(&made, "y_u", &|t| motion(t)[0]) < 0.02);
}

#[test]
fn topics_publishers_and_times_act_as_in_other_bags() {
    let refused = |set: &str, name: &str, change: (&str, &str), pieces: &[&str]| {
        refused_in(changed(set, name, &[change], same).path(), &[], pieces);
    };
    let bag = |change, pieces: &[&str]| refused("ros1", "mission.bag", change, pieces);
    bag(("/odometry", "/odometri"), &["mission.bag: topic", "did you mean `/odometry`?"]);
    bag(
        ("twist.twist.linear.x", "twist.twist.linear.w"),
        &["column of topic `/odometry`", "nav_msgs/Odometry"],
    );
    bag(("\"log_time\"", "\"publish_time\""), &["ingest.toml: `time`", "`publish_time`", "`log_time`"]);
    let ulog = |change, pieces: &[&str]| refused("px4", "mission.ulg", change, pieces);
    ulog(
        ("publisher = \"0\"", ""),
        &["publishers of topic `propeller`", "2 channels, `0`, `1`", "`publisher = \"0\"`"],
    );
    ulog(("publisher = \"0\"", "publisher = \"2\""), &["`publisher` of topic `propeller`", "no `2`"]);
    ulog(("speed_rpm", "speed"), &["column of topic `propeller`", "did you mean `speed_rpm`?"]);
    ulog(
        ("column = \"timestamp\", unit = \"us\"", "column = \"log_time\""),
        &["ingest.toml: `time`", "`column = \"timestamp\"`"],
    );
    ulog((", unit = \"us\" }", " }"), &["ingest.toml: `time`", "no `unit`"]);
    // Of two instances the other one stands still.
    let other = changed("px4", "mission.ulg", &[("publisher = \"0\"", "publisher = \"1\"")], same);
    let made = ingest(other.path(), &["--config", "ingest.toml"]);
    assert!(made.f64("n")[..100].iter().all(|n| *n == 0.0));
}

/// A header's fields, or data, after their length.
fn sized(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes()[..], bytes].concat()
}

/// A record of a bag of ROS 1.
fn record(fields: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let field = |(name, value): &(&str, &[u8])| sized(&[name.as_bytes(), b"=", value].concat());
    [sized(&fields.iter().flat_map(field).collect::<Vec<_>>()), sized(data)].concat()
}

/// A bag of ROS 1 whose only topic has messages by this definition.
fn defined(definition: &str, index_at: Option<u64>) -> Vec<u8> {
    let text = |name: &str, value: &str| sized(&[name.as_bytes(), b"=", value.as_bytes()].concat());
    let about = [text("type", "boat_msgs/Shaft"), text("message_definition", definition)].concat();
    let connection = record(&[("op", &[7]), ("conn", &[0; 4]), ("topic", b"/odometry")], &about);
    let message = record(&[("op", &[2]), ("conn", &[0; 4]), ("time", &[1; 8])], &[0; 8]);
    let head = |at: u64| record(&[("op", &[3]), ("index_pos", &at.to_le_bytes())], &[]);
    let length = 13 + head(0).len() + connection.len() + message.len();
    [b"#ROSBAG V2.0\n".to_vec(), head(index_at.unwrap_or(length as u64)), connection, message].concat()
}

#[test]
fn messages_that_are_not_known_are_refused() {
    let bag = |definition: &str, at| changed("ros1", "mission.bag", &[], |_| defined(definition, at));
    let refused = |definition: &str, at, pieces: &[&str]| {
        refused_in(bag(definition, at).path(), &[], &[&["mission.bag: "], pieces].concat());
    };
    let remedy = "record the bag with its message definitions";
    let unknown =
        ["schema `boat_msgs/Shaft` of topic `/odometry`", "no definition of `boat_msgs/Gear`", remedy];
    refused("Gear gear\nfloat64 rps\n", None, &unknown);
    refused("float64 rps\n", None, &["column of topic `/odometry`", "a number in boat_msgs/Shaft: `rps`"]);
    refused("float64 rps\n", Some(0), &["column of topic"]);
    let own = "definition of `boat_msgs/msg/Shaft` of topic `/propeller`";
    let bag = changed("ros2", "short-bare.db3", &[("{run}_*.db3", "{run}.db3")], same);
    refused_in(bag.path(), &[], &["short-bare.db3: ", own, "none in the bag", "`ros2 bag convert`"]);
}

#[test]
fn damaged_bags_of_ros_1_are_refused() {
    let refused = |damage: &dyn Fn(Vec<u8>) -> Vec<u8>, pieces: &[&str]| {
        refused_in(changed("ros1", "mission.bag", &[], damage).path(), &[], pieces);
    };
    refused(&half, &["mission.bag: file", "an end within a record", "`rosbag reindex`"]);
    // Cut where a record ends: only its head says that there was more.
    let whole = |bytes: Vec<u8>| {
        let mut at = 13;
        while at < bytes.len() / 2 {
            for _ in 0..2 {
                at += 4 + u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
            }
        }
        bytes[..at].to_vec()
    };
    refused(&whole, &["mission.bag: file", "bytes early", "`rosbag reindex`"]);
    // Its recorder was stopped.
    let open = |mut bytes: Vec<u8>| {
        let at = bytes.windows(10).position(|part| part == b"index_pos=").unwrap() + 10;
        bytes[at..at + 8].fill(0);
        bytes
    };
    refused(&open, &["mission.bag: file", "a bag that was not closed", "`rosbag reindex`"]);
    let older = |bytes: Vec<u8>| [b"#ROSBAG V1.2\n", &bytes[13..]].concat();
    refused(&older, &["mission.bag: file", "`#ROSBAG V1.2`", "`#ROSBAG V2.0`"]);
    let flipped = |mut bytes: Vec<u8>| {
        // In the middle of the first chunk.
        bytes[8000] ^= 0xFF;
        bytes
    };
    refused(&flipped, &["mission.bag: chunk", "bytes that cannot be unpacked"]);
}

#[test]
fn a_ulog_that_is_cut_off_is_refused_and_the_remedy_reads_what_is_whole() {
    let cut = changed("px4", "mission.ulg", &[], |bytes| bytes[..40_001].to_vec());
    let pieces = ["mission.ulg: file", "an end within a message, after byte ", "a whole ULog", "`head -c "];
    refused_in(cut.path(), &[], &pieces);
    let said = run(cut.path(), &["--config", "ingest.toml", "--out", "t.parquet"]).stderr;
    let whole: usize = said.split("after byte ").nth(1).unwrap().split(',').next().unwrap().parse().unwrap();
    assert!(whole < 40_001 && said.contains(&format!("`head -c {whole} FILE")), "{said}");
    let mended = changed("px4", "mission.ulg", &[], |bytes| bytes[..whole].to_vec());
    let made = ingest(mended.path(), &["--config", "ingest.toml"]);
    assert!((60..100).contains(&made.rows) && off(&made, "delta", &rudder) < 0.002, "{}", made.rows);
    // What a logger appends after a crash continues at a stated byte, whatever was cut there.
    let appended = changed("px4", "mission.ulg", &[], |mut bytes| {
        let next = whole + 3 + usize::from(u16::from_le_bytes([bytes[whole], bytes[whole + 1]]));
        bytes[27] = 1;
        bytes[35..43].copy_from_slice(&40_001_u64.to_le_bytes());
        [&bytes[..40_001], &bytes[next..]].concat()
    });
    let made = ingest(appended.path(), &["--config", "ingest.toml"]);
    assert!(made.rows == 120 && off(&made, "delta", &rudder) < 0.002, "{}", made.rows);
    let odd = changed("px4", "mission.ulg", &[], |bytes| [&bytes[..16], &[3, 0, b'?', 0, 0, 0]].concat());
    refused_in(odd.path(), &[], &["mission.ulg: file", "a message `?`", "copy it again"]);
}

#[test]
fn databases_that_are_cut_open_or_no_bags_are_refused() {
    let refused = |change: &dyn Fn(&Path), pieces: &[&str]| {
        let folder = logs("ros2", &[&ROS2[..], &["ingest.toml"]].concat());
        change(folder.path());
        refused_in(folder.path(), &[], pieces);
    };
    let write = |name: &'static str, bytes: Vec<u8>| {
        move |folder: &Path| fs::write(folder.join(name), &bytes).unwrap()
    };
    let whole = fs::read(repository("fixtures/field/ros2/mission_1.db3")).unwrap();
    refused(
        &write("mission_1.db3", half(whole.clone())),
        &["mission_1.db3: file", "database disk image is malformed", "'.recover'"],
    );
    refused(
        &write("mission_1.db3-wal", b"unwritten".to_vec()),
        &["mission_1.db3: database", "changes in `mission_1.db3-wal`", "wal_checkpoint"],
    );
    refused(
        &|folder| fs::remove_file(folder.join("mission_1.db3")).unwrap(),
        &["metadata.yaml: parts", "no file `mission_1.db3`", "copy this part too"],
    );
    let other = |folder: &Path| {
        let path = folder.join("mission_1.db3");
        fs::remove_file(&path).unwrap();
        let made = rusqlite::Connection::open(path).unwrap();
        made.execute_batch("CREATE TABLE wind (t REAL, speed REAL); INSERT INTO wind VALUES (0, 5.5)")
            .unwrap();
    };
    let pieces = ["mission_1.db3: database", "no table `topics`", "a bag of ROS 2", "sqlite3 -header -csv"];
    refused(&other, &pieces);
    let text = |_: Vec<u8>| b"t,u\n0,1\n".to_vec();
    refused(&write("mission_1.db3", text(vec![])), &["mission_1.db3: format", "a bag of ROS 2 in SQLite"]);
}

/// A bag with messages in JSON after `more` statements, in a folder with its `ingest.toml`.
fn made_by(more: &str) -> TempDir {
    let folder = crate::bags::bags("", &[]);
    let text = fs::read_to_string(folder.path().join("ingest.toml")).unwrap();
    fs::write(folder.path().join("ingest.toml"), text.replace("*.mcap", "*.db3")).unwrap();
    let path = folder.path().join("a.db3");
    database(&path, 512, crate::bags::motion_in_json);
    rusqlite::Connection::open(path).unwrap().execute_batch(more).unwrap();
    folder
}

/// Names in a folder.
fn names(folder: &Path) -> Vec<String> {
    let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
    let mut all: Vec<String> = fs::read_dir(folder).unwrap().map(name).collect();
    all.sort();
    all
}

#[test]
fn nothing_that_a_database_holds_is_run_and_nothing_is_written_beside_it() {
    let closed =
        made_by("PRAGMA journal_mode = WAL; CREATE INDEX by_time ON messages (topic_id, timestamp DESC)");
    assert_eq!(fs::read(closed.path().join("a.db3")).unwrap()[18], 2, "no journal of this kind");
    crate::known::healthy(&crate::known::read(closed.path()), 61);
    assert_eq!(names(closed.path()), ["a.db3", "ingest.toml"]);
    let no_table = ["a.db3: database", "no table `messages`", "sqlite3 -header -csv"];
    let endless =
        "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i, 3, i, 'x' FROM n";
    let view =
        format!("DROP TABLE messages; CREATE VIEW messages(id, topic_id, timestamp, data) AS {endless}");
    refused_in(made_by(&view).path(), &[], &no_table);
    // A view that the schema calls a table.
    let called = "; PRAGMA writable_schema = ON; UPDATE sqlite_schema SET type = 'table', rootpage = 2, sql = \
                  replace(sql, 'CREATE VIEW', 'CREATE TABLE x(a); CREATE VIEW') WHERE name = 'messages'";
    let ran = run(made_by(&(view + called)).path(), &["--config", "ingest.toml", "--out", "t.parquet"]);
    assert!(ran.code == Some(3) && ran.stderr.lines().count() == 1, "{}", ran.stderr);
    let module = "DROP TABLE messages; CREATE VIRTUAL TABLE messages USING fts5(topic_id, timestamp, data)";
    refused_in(made_by(module).path(), &[], &no_table);
    let generated = "ALTER TABLE messages DROP COLUMN data; \
                     ALTER TABLE messages ADD COLUMN data BLOB AS (zeroblob(1000000000)) VIRTUAL";
    refused_in(made_by(generated).path(), &[], &["a.db3: database", "no `data` in the table `messages`"]);
}

/// A row of a few bytes that says it has a million, whose last page follows on itself.
#[test]
fn rows_that_are_larger_than_their_file_are_not_fetched() {
    const USABLE: usize = 512 - 4;
    let folder = made_by("UPDATE messages SET data = zeroblob(30000) WHERE id = 61");
    let path = folder.path().join("a.db3");
    let mut bytes = fs::read(&path).unwrap();
    let varint =
        |number: usize| [0x80 | (number >> 14) as u8, 0x80 | (number >> 7 & 0x7F) as u8, number as u8 & 0x7F];
    // The header of the row: of 13 bytes, no number of its own, topic, time, a blob.
    let kinds = |blob: usize| [&[7, 0, 1, 6][..], &varint(2 * blob + 12)].concat();
    let size = |blob: usize| varint(7 + 1 + 8 + blob);
    let at = bytes.windows(7).position(|part| part == kinds(30_000)).unwrap();
    let more = 30_000 + 1900 * USABLE;
    bytes[at..at + 7].copy_from_slice(&kinds(more));
    assert_eq!(bytes[at - 4..at - 1], size(30_000));
    bytes[at - 4..at - 1].copy_from_slice(&size(more));
    fs::write(&path, &bytes).unwrap();
    refused_in(
        folder.path(),
        &["--memory-mib", "64"],
        &["a.db3: file", "bytes in the table `messages` of a file of", "copy it again"],
    );
}

/// A bag of ROS 2 on pages of `page` bytes with a message a second, of any length, that is made by `message`.
fn database(path: &Path, page: usize, message: impl Fn(usize) -> Vec<u8>) {
    let made = rusqlite::Connection::open(path).unwrap();
    made.execute_batch(&format!("PRAGMA page_size = {page};")).unwrap();
    made.execute_batch(
        "CREATE TABLE topics (id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
         CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);
         INSERT INTO topics VALUES (3, '/s', 'a', 'json'), (7, '/camera', 'b', 'protobuf');",
    )
    .unwrap();
    for k in 0..61 {
        let time = (1_744_373_300 + k as i64) * 1_000_000_000;
        let all = [(3, message(k)), (7, vec![k as u8; 100 * k])];
        for (topic, data) in all {
            let row = rusqlite::params![topic, time, data];
            made.execute("INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)", row).unwrap();
        }
    }
}

#[test]
fn law_messages_of_any_length_on_pages_of_any_size_are_read() {
    for page in [512, 1024, 4096, 65_536] {
        let folder = crate::bags::bags("", &[]);
        let text = fs::read_to_string(folder.path().join("ingest.toml")).unwrap();
        fs::write(folder.path().join("ingest.toml"), text.replace("*.mcap", "*.db3")).unwrap();
        // Blanks at the end bring every length from a part of a page to many.
        let padded = |k: usize| [crate::bags::motion_in_json(k), vec![b' '; k * page / 9]].concat();
        database(&folder.path().join("a.db3"), page, padded);
        crate::known::healthy(&crate::known::read(folder.path()), 61);
    }
}
