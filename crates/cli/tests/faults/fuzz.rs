//! Inputs damaged at random: no panic, no endless run, one line, no files left.
//!
//! The cases are the same in every run. `make faults CASES=100000` tries more of them and prints the results.
//! SEATRIAL_CASE=1:5388 tries one of them again, its kind before the colon, and keeps its folder.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use crate::asked;
use crate::damage::{Draw, damaged, damaged_bytes};
use crate::ends::{Tally, ends};
use crate::grounds::{GROUNDS, Ground, Stage, stages_on};
use crate::places::{Place, unsealed};
use crate::readers::{READERS, strange};
use crate::support::SEATRIAL;

/// Values of flags, valid and invalid.
const WORDS: [&str; 34] = [
    "0",
    "1",
    "2",
    "7",
    "-1",
    "1e9",
    "1e-9",
    "0.5",
    "1e300",
    "nan",
    "inf",
    "18446744073709551615",
    "4294967296",
    "0/0",
    "2/2",
    "1/1000000",
    "campaign.parquet",
    "trajectories.parquet",
    "dictionary.parquet",
    "none/none",
    "vessel.toml",
    ".",
    "a",
    "d",
    "ls",
    "iv",
    "auto",
    "estimate.json",
    "design.json",
    "decelerate=1",
    "random/0",
    "output-error",
    "complete",
    "\u{7f}",
];

/// The flags of a stage, with the dashes, and whether each takes a value: those that its help names.
pub fn flags(line: &str) -> Vec<(String, bool)> {
    static KNOWN: Mutex<BTreeMap<String, Vec<(String, bool)>>> = Mutex::new(BTreeMap::new());
    let words: Vec<&str> = line.split_whitespace().take_while(|word| !word.starts_with("--")).collect();
    let mut known = KNOWN.lock().unwrap();
    let asked = || {
        let help = Command::new(SEATRIAL).args(&words).arg("--help").output().unwrap();
        let help = String::from_utf8(help.stdout).unwrap();
        let lines = help.lines().map(str::trim).filter_map(|line| line.strip_prefix("--"));
        let flag = |line: &str| {
            let name = line.split([' ', '=']).next().unwrap_or_default();
            (format!("--{name}"), line[name.len()..].starts_with(" <"))
        };
        // Help and version do no work.
        lines.map(flag).filter(|(name, _)| !["--help", "--version"].contains(&&**name)).collect()
    };
    known.entry(words.join(" ")).or_insert_with(asked).clone()
}

/// Up to three flags of the stage with random values, rarely something else.
fn strange_words(draw: &mut Draw, line: &str) -> String {
    let flags = flags(line);
    let word = |draw: &mut Draw| {
        let (flag, with_value) = &flags[draw.below(flags.len())];
        match (draw.below(8), with_value) {
            (0, _) => format!(" {}", draw.one_of(&WORDS)),
            (_, true) => format!(" {flag} {}", draw.one_of(&WORDS)),
            (_, false) => format!(" {flag}"),
        }
    };
    (0..=draw.below(3)).map(|_| word(draw)).collect()
}

/// Cases of this kind: all of them when asked for, otherwise so many that all kinds together are 250.
fn count(part: u64) -> u64 {
    asked().unwrap_or(250) / part
}

/// The range of the one case to retry, if it is of `kind`.
fn again(kind: u64) -> Option<Range<u64>> {
    let wanted = std::env::var("SEATRIAL_CASE").ok()?;
    let (own, case) = wanted.split_once(':')?;
    let case = case.parse().ok()?;
    Some(if own.parse() == Ok(kind) { case..case + 1 } else { 0..0 })
}

/// Runs the cases of one kind on all processors: `damage` changes a file and returns additional words of the command
/// line; all files are restored afterwards.
fn try_all(
    (name, kind, grounds): (&str, u64, &'static [Ground]),
    count: u64,
    damage: impl Fn(&mut Draw, &mut Place, &Stage, &str) -> String + Sync,
) {
    let started = Instant::now();
    let cases = again(kind).unwrap_or(0..count);
    let (next, found) = (AtomicU64::new(cases.start), Mutex::new(Tally::default()));
    let work = || {
        let mut places: Vec<Place> = grounds.iter().map(Place::on).collect();
        let mut tally = Tally::default();
        loop {
            let case = next.fetch_add(1, Ordering::Relaxed);
            if case >= cases.end {
                break found.lock().unwrap().add(&tally);
            }
            let mut draw = Draw::of(kind, case);
            let stages = stages_on(grounds);
            let (ground, stage) = stages[draw.below(stages.len())];
            let place = places.iter_mut().find(|place| std::ptr::eq(place.ground, ground)).unwrap();
            let file = draw.one_of(stage.reads);
            let words = damage(&mut draw, place, stage, file);
            let threads = if draw.below(4) == 0 { "" } else { " --threads 1" };
            let line = format!("{}{threads}{words}", stage.line_into("out/"));
            if again(kind).is_some() {
                place.folder.disable_cleanup(true);
                println!("{}: {file}: {line}", place.path().display());
            }
            tally.case(&format!("kind {kind}, case {case}, {file}: {line}"), ends(place, &line));
            if again(kind).is_none() {
                place.restore();
            }
        }
    };
    let workers = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    std::thread::scope(|scope| (0..workers).for_each(|_| drop(scope.spawn(work))));
    let mut tally = found.into_inner().unwrap();
    tally.seconds = started.elapsed().as_secs_f64();
    tally.check(name);
}

/// Half of the damaged files have matching digests in the documents written with them.
fn damage(draw: &mut Draw, place: &mut Place, name: &str, bytes: &[u8]) {
    place.put(name, bytes);
    if draw.below(2) == 0 {
        place.vouch(name);
    }
}

#[test]
fn law_damaged_contents_are_refused_in_one_line_or_used() {
    try_all(("contents", 1, &*GROUNDS), count(2), |draw, place, _, name| {
        let bytes = damaged(draw, name, place.original(name));
        damage(draw, place, name, &bytes);
        String::new()
    });
}

#[test]
fn law_damaged_bytes_are_refused_in_one_line_or_used() {
    try_all(("bytes", 2, &*GROUNDS), count(4), |draw, place, _, name| {
        let bytes = damaged_bytes(draw, unsealed(place.original(name)));
        damage(draw, place, name, &bytes);
        String::new()
    });
}

#[test]
fn law_strange_command_lines_are_refused_in_one_line_or_obeyed() {
    try_all(("command lines", 3, &*GROUNDS), count(4), |draw, _, stage, _| strange_words(draw, stage.line));
}

#[test]
fn law_logs_and_charts_of_strangers_are_refused_in_one_line_or_read() {
    try_all(("logs and charts", 4, &*READERS), count(4), |draw, place, _, name| {
        let bytes = strange(draw, name, place.original(name));
        place.put(name, &bytes);
        String::new()
    });
}
