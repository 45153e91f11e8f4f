//! Inputs damaged at random: no panic, no endless run, one line, nothing left behind.
//!
//! The cases are the same in every run. `make faults CASES=100000` tries more of them and prints what came of them.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::support::*;

/// What a stage reads.
const READS: [(&str, &[&str]); 8] = [
    (DICTIONARY, &["vessel.toml", "dictionary.toml"]),
    (MOMENTS, &["vessel.toml", "dictionary.parquet"]),
    (DESIGN, &["moments.json"]),
    (CAMPAIGN, &["vessel.toml", "dictionary.toml", "campaign.toml", "design.json"]),
    (VALIDATION, &["vessel.toml", "campaign.toml"]),
    (ESTIMATE, &["vessel.toml", "campaign.parquet"]),
    (VALIDATE, &["campaign.toml", "estimates.parquet", "validation.parquet"]),
    (REPORT, &["campaign.toml", "design.json", "validation.json", "estimate.json", "scores.parquet"]),
];

/// What stands in place of a number or a text.
const STRANGE: [&str; 26] = [
    "0",
    "-1",
    "-0.0",
    "-5",
    "7",
    "1e-12",
    "1e-300",
    "1e9",
    "1e12",
    "1e300",
    "nan",
    "inf",
    "9.97e36",
    "-32768",
    "18446744073709551616",
    "9007199254740993",
    "0.5",
    "true",
    "\"x\"",
    "\"\"",
    "[]",
    "{}",
    "[1, 2]",
    "null",
    "\"\\u0000\"",
    "\"../../x\"",
];

/// Words that follow a command line.
const WORDS: [&str; 22] = [
    "--threads",
    "0",
    "1",
    "-1",
    "1e9",
    "--seed",
    "18446744073709551615",
    "nan",
    "--shard",
    "0/0",
    "2/2",
    "1/1000000",
    "--gather",
    "campaign.parquet",
    "--out",
    "none/none",
    "vessel.toml",
    "--criterion",
    "a",
    "--segments",
    "--estimator",
    "ls",
];

/// A run may take so long and so much memory.
const LIMIT: Duration = Duration::from_secs(30);
const MEMORY_KIB: u64 = 8 << 20;

/// Numbers that look drawn and are the same in every run.
struct Draw(u64);

impl Draw {
    fn of(kind: u64, case: u64) -> Self {
        Self((kind << 40 ^ case).wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 33) as usize % bound.max(1)
    }

    fn one_of<'a, T: ?Sized>(&mut self, of: &[&'a T]) -> &'a T {
        of[self.below(of.len())]
    }
}

/// What came of the cases.
#[derive(Default)]
struct Found {
    cases: u64,
    ends: BTreeMap<i32, u64>,
    faults: Vec<String>,
}

impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} cases, exit codes {:?}, {} faults", self.cases, self.ends, self.faults.len())
    }
}

/// Runs the cases of one kind: `damage` changes a file in the folder, all of which are put back, and says what else stands on
/// the command line.
fn try_all(kind: u64, damage: impl Fn(&mut Draw, &TempDir, &str) -> String) {
    let folder = with(&MADE);
    fs::create_dir(folder.path().join("out")).unwrap();
    let before = Study::of(&folder);
    let mut found = Found::default();
    for case in 0..u64::from(cases() / 3) {
        let mut draw = Draw::of(kind, case);
        let (stage, reads) = READS[draw.below(READS.len())];
        let (line, name) = stage.rsplit_once(' ').unwrap();
        let file = draw.one_of(reads);
        let words = damage(&mut draw, &folder, file);
        let line = format!("{line} out/{name} --allow-mixed --quiet{words}");
        found.cases += 1;
        match ends(&folder, &line) {
            Ok(code) => *found.ends.entry(code).or_default() += 1,
            Err(fault) => found.faults.push(format!("kind {kind}, case {case}, {file}: {line}: {fault}")),
        }
        put_back(&folder, &before);
    }
    println!("{found}");
    assert!(found.faults.is_empty(), "{found}\n{}", found.faults.join("\n"));
}

/// The exit code, or what is wrong with how the run ended.
fn ends(folder: &TempDir, line: &str) -> Result<i32, String> {
    let said = folder.path().join("said");
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit -v {MEMORY_KIB}; exec \"$0\" \"$@\""), SEATRIAL]);
    command.args(line.split_whitespace()).current_dir(folder).stdout(Stdio::null());
    let mut child = command.stderr(fs::File::create(&said).unwrap()).spawn().unwrap();
    let started = Instant::now();
    let status = loop {
        match child.try_wait().unwrap() {
            Some(status) => break status,
            None if started.elapsed() > LIMIT => {
                child.kill().unwrap();
                child.wait().unwrap();
                return Err(format!("does not end within {} s", LIMIT.as_secs()));
            }
            None => std::thread::sleep(Duration::from_millis(1)),
        }
    };
    let told = String::from_utf8_lossy(&fs::read(&said).unwrap()).into_owned();
    fs::remove_file(said).unwrap();
    let written = listing(&folder.path().join("out")).len();
    match status.code() {
        Some(0) if written > 0 => Ok(0),
        Some(0) => Err("succeeds and writes nothing".to_owned()),
        Some(code @ 1..=4) if told.lines().count() != 1 => {
            Err(format!("exit code {code}, several lines: {told}"))
        }
        Some(code @ 1..=4) if written > 0 => Err(format!("exit code {code}, but it left files: {told}")),
        Some(code @ 1..=4) => Ok(code),
        other => Err(format!("ends with {other:?}: {told}")),
    }
}

fn put_back(folder: &TempDir, before: &Study) {
    let out = folder.path().join("out");
    if !listing(&out).is_empty() {
        fs::remove_dir_all(&out).unwrap();
        fs::create_dir(&out).unwrap();
    }
    for name in MADE.iter().chain(&WRITTEN) {
        let path = folder.path().join(name);
        if fs::read(&path).map_or(true, |bytes| bytes != before.bytes(name)) {
            fs::write(path, before.bytes(name)).unwrap();
        }
    }
}

/// Places of numbers and quoted texts that are values.
fn values(text: &str) -> Vec<std::ops::Range<usize>> {
    let bytes = text.as_bytes();
    let (mut found, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let start = at;
        if bytes[at] == b'"' {
            at += 1 + text[at + 1..].find('"').map_or(0, |end| end + 1);
            if !text[at..].trim_start().starts_with([':', '=']) {
                found.push(start..at);
            }
        } else if bytes[at].is_ascii_digit() || bytes[at] == b'-' {
            let more = text[at + 1..].find(|c: char| !(c.is_ascii_digit() || ".eE+-".contains(c)));
            at = more.map_or(bytes.len(), |end| at + 1 + end);
            if start == 0 || !bytes[start - 1].is_ascii_alphanumeric() {
                found.push(start..at);
            }
        } else {
            at += 1;
        }
    }
    found
}

/// Changes a value, or the lines, of a text.
fn damaged_text(draw: &mut Draw, text: &str) -> String {
    let values = values(text);
    let mut lines: Vec<&str> = text.lines().collect();
    let (one, other) = (draw.below(lines.len()), draw.below(lines.len()));
    match draw.below(8) {
        0 => drop(lines.remove(one)),
        1 => lines.insert(other, lines[one]),
        2 => lines.swap(one, other),
        3 => return text.chars().take(draw.below(text.len())).collect(),
        _ if !values.is_empty() => {
            let place = values[draw.below(values.len())].clone();
            return format!("{}{}{}", &text[..place.start], draw.one_of(&STRANGE), &text[place.end..]);
        }
        _ => {}
    }
    lines.join("\n")
}

/// Flips, cuts, blanks or repeats bytes.
fn damaged_bytes(draw: &mut Draw, mut bytes: Vec<u8>) -> Vec<u8> {
    let at = draw.below(bytes.len());
    let end = (at + 1 + draw.below(64)).min(bytes.len());
    match draw.below(5) {
        0 => bytes.truncate(at),
        1 => bytes[at..end].fill(0),
        2 => bytes[at..end].fill(0xff),
        3 => {
            let part = bytes[at..end].to_vec();
            bytes.splice(at..at, part);
        }
        _ => bytes[at] ^= 1 << draw.below(8),
    }
    bytes
}

/// Takes the seal off, so that what follows is looked at; the file keeps its length.
fn unsealed(bytes: &[u8]) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for seal in [&b"\"seal\":\"blake3:"[..], &b"\"seal\": \"blake3:"[..]] {
        if let Some(at) = out.windows(seal.len()).position(|window| window == seal) {
            let (start, end) = (at + seal.len() - 8, at + seal.len() + 65);
            out[start..end].fill(b' ');
            out[start..start + 4].copy_from_slice(b"null");
        }
    }
    out
}

#[test]
fn law_damaged_texts_are_refused_in_one_line_or_used() {
    try_all(1, |draw, folder, name| {
        match String::from_utf8(unsealed(&bytes(folder, name))) {
            Ok(text) => put(folder, name, &damaged_text(draw, &text)),
            // A table has no text but its envelope.
            Err(other) => put_bytes(folder, name, &damaged_bytes(draw, other.into_bytes())),
        }
        String::new()
    });
}

#[test]
fn law_damaged_bytes_are_refused_in_one_line_or_used() {
    try_all(2, |draw, folder, name| {
        let bytes = damaged_bytes(draw, unsealed(&bytes(folder, name)));
        put_bytes(folder, name, &bytes);
        String::new()
    });
}

#[test]
fn law_strange_command_lines_are_refused_in_one_line_or_obeyed() {
    try_all(3, |draw, _, _| (0..=draw.below(3)).map(|_| format!(" {}", draw.one_of(&WORDS))).collect());
}

fn put_bytes(folder: &TempDir, name: &str, bytes: &[u8]) {
    fs::write(folder.path().join(name), bytes).unwrap();
}
