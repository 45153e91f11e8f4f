//! Bags in parts, of several publishers, and with definitions or chunks that never end.

use std::fs;
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::known::*;
use crate::runner::*;
use crate::silent::{Faulty, none_is_silent};

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode], &(body.len() as u64).to_le_bytes()[..], body].concat()
}

fn schema(id: u16, name: &str, definition: &str) -> Vec<u8> {
    let body = [&id.to_le_bytes()[..], &text(name), &text("ros2msg"), &text(definition)].concat();
    record(3, &body)
}

fn channel(id: u16, schema: u16, topic: &str, encoding: &str, metadata: &[[&str; 2]]) -> Vec<u8> {
    let pairs: Vec<u8> = metadata.iter().flatten().flat_map(|part| text(part)).collect();
    let ids = [id.to_le_bytes(), schema.to_le_bytes()].concat();
    record(
        4,
        &[&ids, &text(topic), &text(encoding), &(pairs.len() as u32).to_le_bytes()[..], &pairs].concat(),
    )
}

/// A message at `t` \[s\].
fn message(channel: u16, t: usize, data: &[u8]) -> Vec<u8> {
    let time = ((1_744_373_300 + t as u64) * 1_000_000_000).to_le_bytes();
    record(5, &[&channel.to_le_bytes()[..], &[0; 4], &time, &time, data].concat())
}

fn bag(records: &[Vec<u8>]) -> Vec<u8> {
    let magic = b"\x89MCAP0\r\n".to_vec();
    let head = record(1, &[text(""), text("")].concat());
    [magic.clone(), head, records.concat(), record(15, &[0; 4]), record(2, &[0; 20]), magic].concat()
}

/// The motion in second `k`, in JSON.
pub fn motion_in_json(k: usize) -> Vec<u8> {
    let values = rows(k)[k];
    let pairs = COLUMNS.iter().zip(values).map(|(name, value)| format!("\"{name}\":{value:.6}"));
    format!("{{{}}}", pairs.collect::<Vec<_>>().join(",")).into_bytes()
}

/// The messages of some seconds.
fn messages(of: u16, seconds: std::ops::Range<usize>) -> Vec<Vec<u8>> {
    seconds.map(|k| message(of, k, &motion_in_json(k))).collect()
}

fn config(keys: &str) -> String {
    let base = table_config("*.mcap", "unit = \"s\"", "")
        .replace("column = \"t\", unit = \"s\"", "column = \"log_time\"");
    base.replace("time =", &format!("topic = \"/s\"\n{keys}\ntime ="))
}

pub fn bags(keys: &str, bags: &[(&str, Vec<u8>)]) -> TempDir {
    let folder = folder(&[("ingest.toml", &config(keys))]);
    bags.iter().for_each(|(name, bytes)| fs::write(folder.path().join(name), bytes).unwrap());
    folder
}

#[test]
fn bags_of_one_run_are_one_recording() {
    let part = |seconds| bag(&[vec![channel(1, 0, "/s", "json", &[])], messages(1, seconds)].concat());
    let parts = [("trial_0.mcap", part(0..31)), ("trial_1.mcap", part(31..61))];
    let made = read(bags("run_from_file = \"{run}_*.mcap\"", &parts).path());
    healthy(&made, 61);
    assert_eq!(made.summary.recordings.len(), 1);
    let again = [("trial_0.mcap", part(0..61)), ("trial_1.mcap", part(31..61))];
    let pieces = ["files of one recording", "`trial_1.mcap`", "follow each other"];
    refused_in(bags("run_from_file = \"{run}_*.mcap\"", &again).path(), &[], &pieces);
}

#[test]
fn several_publishers_of_a_topic_are_refused_until_one_is_named() {
    let channels = [("/gps_bow", 3), ("/gps_stern", 7)]
        .map(|(name, id)| channel(id, 0, "/s", "json", &[["callerid", name]]));
    // The other one is at the stern and has another speed.
    let both = (0..61).flat_map(|k| [message(3, k, &motion_in_json(k)), message(7, k, &motion_in_json(0))]);
    let both = bag(&[channels.to_vec(), both.collect()].concat());
    let pieces = ["publishers of topic `/s`", "`3` (callerid /gps_bow)", "/gps_stern", "`publisher = "];
    refused_in(bags("", &[("a.mcap", both.clone())]).path(), &[], &pieces);
    for name in ["3", "/gps_bow"] {
        let keys = format!("publisher = \"{name}\"");
        healthy(&read(bags(&keys, &[("a.mcap", both.clone())]).path()), 61);
    }
    let pieces = ["`publisher` of topic `/s`", "no `4`", "`7` (callerid /gps_stern)"];
    refused_in(bags("publisher = \"4\"", &[("a.mcap", both.clone())]).path(), &[], &pieces);
    let after = bag(&[channels.to_vec(), messages(3, 0..31), messages(7, 31..61)].concat());
    refused_in(bags("", &[("a.mcap", after)]).path(), &[], &["publishers of topic `/s`"]);
    let keys = "publisher = \"3\"\npattern = [\"*.csv\"]";
    let table = table_config("*.csv", "unit = \"s\"", "").replace("pattern = [\"*.csv\"]", keys);
    refused(&table, &csv(60, |k| k.to_string()), &["`publisher`", "of a bag"]);
}

#[test]
fn a_channel_that_goes_on_under_another_number_is_one() {
    let twice = [3, 7].map(|id| channel(id, 0, "/s", "json", &[]));
    let one = bag(&[twice.to_vec(), messages(3, 0..31), messages(7, 31..61)].concat());
    healthy(&read(bags("", &[("a.mcap", one)]).path()), 61);
}

/// Must be refused with `pieces` within some seconds.
#[track_caller]
fn refused_soon(bag: Vec<u8>, pieces: &[&str]) {
    let since = Instant::now();
    refused_in(bags("", &[("a.mcap", bag)]).path(), &[], pieces);
    assert!(since.elapsed() < Duration::from_secs(20), "{:?}", since.elapsed());
}

#[test]
fn definitions_that_never_end_are_refused() {
    let defined = |definition: &str| {
        let data = [&[0, 1, 0, 0][..], &[0; 64]].concat();
        bag(&[schema(1, "a/msg/A", definition), channel(1, 1, "/s", "cdr", &[]), message(1, 0, &data)])
    };
    let twice = |i: usize| format!("====\nMSG: a/T{i}\nT{} x\nT{} y\n", i + 1, i + 1);
    let laughs = "T0 x\n".to_owned() + &(0..28).map(twice).collect::<String>() + "====\nMSG: a/T28\nint8 z\n";
    refused_soon(defined(&laughs), &["schema `a/msg/A` of topic `/s`", "more than 20000 fields"]);
    refused_soon(
        defined(&format!("uint8{} x\n", "[2]".repeat(200_000))),
        &["schema `a/msg/A`", "one length"],
    );
    refused_soon(
        defined("uint8[0][4294967295][4294967295] u\nint8 x\n"),
        &["schema `a/msg/A`", "one length"],
    );
    refused_soon(defined(&"x".repeat(2_000_000)), &["schema `a/msg/A`", "more than 1048576"]);
    refused_soon(defined("float64[4294967295] u\n"), &["schema `a/msg/A`", "one length"]);
    let many: String = (0..5000).map(|i| format!("float64 f{i}\n")).collect();
    refused_soon(defined(&many), &["column of topic `/s`", "`u`", "more"]);
}

/// The known motion in messages of ROS 1 by `definition`, each after the bytes `first`.
fn of_ros_1(definition: &str, first: &[u8]) -> Vec<u8> {
    let body = [&[1, 0][..], &text("a/A"), &text("ros1msg"), &text(definition)].concat();
    let all = [record(3, &body), channel(1, 1, "/s", "ros1", &[])];
    let data = |k: usize| [first, &rows(k)[k].map(f64::to_le_bytes).concat()].concat();
    bag(&[all.to_vec(), (0..61).map(|k| message(1, k, &data(k))).collect()].concat())
}

/// A ULog of messages by `formats`.
fn ulog(formats: &[&str]) -> Vec<u8> {
    let part = |kind: u8, body: &[u8]| [&(body.len() as u16).to_le_bytes()[..], &[kind], body].concat();
    let data = |k: u64| [&[0; 2][..], &(250_000 * k).to_le_bytes(), &[0; 48]].concat();
    let defined: Vec<u8> = formats.iter().flat_map(|format| part(b'F', format.as_bytes())).collect();
    let all: Vec<u8> = (0..40).flat_map(|k| part(b'D', &data(k))).collect();
    [&b"ULog\x01\x12\x35\x01"[..], &[0; 8], &defined, &part(b'A', b"\0\0\0T"), &all].concat()
}

/// What `new` says of a bag that it refuses within some seconds.
pub fn new_refuses(name: &str, bag: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(name), bag).unwrap();
    let (since, study) = (Instant::now(), folder.path().join("mine"));
    let mut new = std::process::Command::new(env!("CARGO_BIN_EXE_seatrial"));
    let words =
        ["new", study.to_str().unwrap(), "--vessel", "coaster", "--logs", folder.path().to_str().unwrap()];
    let ran = new.args(words).output().unwrap();
    assert!(since.elapsed() < Duration::from_secs(20), "{:?}", since.elapsed());
    assert!(ran.status.code() == Some(3) && !study.exists(), "{ran:?}");
    String::from_utf8(ran.stderr).unwrap()
}

#[test]
fn elements_that_take_no_bytes_are_counted() {
    let numbers = COLUMNS.map(|name| format!("float64 {name}\n")).concat();
    let nothing = "===\nMSG: a/E\n# nothing\n";
    let within = format!("a/F[134217727] y\n{numbers}===\nMSG: a/F\na/E[134217727] z\n{nothing}");
    let pieces = ["a.mcap: message 1 of topic `/s`", "elements without end", "elements that take bytes"];
    refused_soon(of_ros_1(&within, &[]), &pieces);
    let as_many = format!("a/E[] y\n{numbers}{nothing}");
    refused_soon(of_ros_1(&as_many, &[0xFF; 4]), &pieces);
    // A few of them are no fault.
    healthy(&read(bags("", &[("a.mcap", of_ros_1(&as_many, &[3, 0, 0, 0]))]).path()), 61);
    for last in ["C:", "C:uint8_t[1] _padding0;"] {
        let numbers = COLUMNS.map(|name| format!("double {name};")).concat();
        let first = format!("T:uint64_t timestamp;{numbers}A[20000] a;");
        let bag = ulog(&[&first, "A:B[20000] b;", "B:C[20000] c;", last]);
        let folder = bags("", &[("a.ulg", bag)]);
        let text = fs::read_to_string(folder.path().join("ingest.toml")).unwrap();
        let text = text.replace("*.mcap", "*.ulg").replace("\"/s\"", "\"T\"");
        let text = text.replace("column = \"log_time\"", "column = \"timestamp\", unit = \"us\"");
        fs::write(folder.path().join("ingest.toml"), text).unwrap();
        refused_in(folder.path(), &[], &["a.ulg: message 1 of topic `T`", pieces[1], pieces[2]]);
    }
    // As many paths that lead to nothing.
    let eights = (0..28).map(|k| format!("===\nMSG: a/T{k}\na/T{}[8] p\n", k + 1)).collect::<String>();
    let eights = format!("a/T0[2] q\n{numbers}{eights}===\nMSG: a/T28\n# nothing\n");
    let said = new_refuses("a.mcap", &of_ros_1(&eights, &[]));
    assert!(said.contains("a.mcap: definitions: found definitions of more elements"), "{said}");
}

#[test]
fn lengths_that_lie_and_chunks_that_never_end_are_refused() {
    let mut lying = schema(1, "a/A", "int8 u\n");
    let end = lying.len() - 11;
    lying[end..end + 4].fill(0xFF);
    refused_soon(bag(&[lying]), &["a.mcap: file", "an end within a record"]);
    // 100 MB of zeros in 3 kB, by runs of one byte: a record that is not requested.
    let size = 800 * (1 << 17) + 9_u64;
    let mut data = b"\x28\xB5\x2F\xFD\0\x38".to_vec();
    data.extend([[9 << 3, 0, 0].to_vec(), vec![0x80], (size - 9).to_le_bytes().to_vec()].concat());
    for block in 0..800 {
        let header = (1_u32 << 20) | 2 | u32::from(block == 799);
        data.extend([&header.to_le_bytes()[..3], &[0]].concat());
    }
    let head =
        [&[0; 16][..], &size.to_le_bytes(), &[0; 4], &text("zstd"), &(data.len() as u64).to_le_bytes()];
    let chunk = record(6, &[head.concat(), data].concat());
    let bomb = bag(&[vec![channel(1, 0, "/s", "json", &[])], vec![chunk; 1000]].concat());
    refused_soon(bomb, &["a.mcap: chunks", "times as many"]);
}

#[test]
fn what_a_bag_says_is_short_in_messages() {
    let topics =
        |count: u16| (1..=count).map(|id| channel(id, 0, &format!("/topic_{id:05}"), "json", &[])).collect();
    let many: Vec<Vec<u8>> = topics(20_000);
    let long = format!("{{\"u\": \"{}\"}}", "\u{202e}x".repeat(300_000));
    let long = vec![channel(1, 0, "/s", "json", &[]), message(1, 0, long.as_bytes())];
    let odd = vec![channel(1, 0, "/s", &"\u{202e}".repeat(99_999), &[])];
    for (records, pieces) in
        [(many, ["topic", "19988 more"]), (long, ["message 1", "a number"]), (odd, ["encoding", "json"])]
    {
        let folder = bags("", &[("a.mcap", bag(&records))]);
        let said = run(folder.path(), &["--config", "ingest.toml", "--out", "t.parquet"]).stderr;
        assert!(said.chars().count() < 500 && !said.contains('\u{202e}'), "{said}");
        refused_in(folder.path(), &[], &pieces);
    }
}

/// One fault of a bag, of nine kinds: what was recorded, and what it is.
fn spoilt(draw: &mut crate::silent::Draw) -> (Vec<u8>, &'static str) {
    let (at, count) = (draw.between(1, 54), draw.between(1, 6));
    let one = |id| channel(id, 0, "/s", "json", &[]);
    let said = |from: &str, to: &str| {
        let text = String::from_utf8(motion_in_json(at)).unwrap();
        message(1, at, text.replacen(from, to, 1).as_bytes())
    };
    let mut all = messages(1, 0..61);
    let mut heads = vec![one(1)];
    let kind = draw.below(9);
    match kind {
        0 => drop(all.drain(at..at + count)),
        1 => all[at..at + count].reverse(),
        2 => all.insert(at, all[at - 1].clone()),
        3 => all[at][15..31].fill(0),
        4 => all[at] = said("\"u\"", "\"w\""),
        5 => {
            all[at] =
                said(&format!("\"u\":{:.6}", motion(at as f64)[0]), ["\"u\":null", "\"u\":65535"][count % 2])
        }
        6 => {
            heads.push(one(7));
            (at..at + count).for_each(|k| all[k] = message(7, k, &motion_in_json(0)));
        }
        7 => all[at] = message(1, at, &motion_in_json(at)[..count]),
        _ => {}
    }
    let whole = bag(&[heads, all].concat());
    let names = [
        "lost",
        "backwards",
        "twice",
        "without a time",
        "another field",
        "no value",
        "two publishers",
        "cut short",
        "cut",
    ];
    let end = if kind == 8 { draw.between(whole.len() / 2, whole.len() - 1) } else { whole.len() };
    (whole[..end].to_vec(), names[kind])
}

#[test]
fn law_a_fault_of_a_bag_is_never_silent() {
    let tally = none_is_silent(111, |draw| {
        let (bag, what) = spoilt(draw);
        let named = &["splits", "backwards", "sorted", "repeated", "late", "unset", "time", "no value", "u "];
        Faulty::new(&config(""), "a.mcap", bag, 61).named(named).what(what)
    });
    assert!(tally.refused > 0 && tally.counted > 0, "{tally:?}");
}
