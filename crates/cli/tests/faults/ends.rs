//! How runs end, and checks of that.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::places::{Place, is_unfinished};
use crate::support::{SEATRIAL, is_progress};

/// Limit of a run's time, unless it reports progress, and of its memory.
const LIMIT: Duration = Duration::from_secs(45);
const MEMORY_KIB: u64 = 1 << 20;
/// Maximum number of characters of its messages.
const LONGEST: usize = 500;

/// What must not happen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wrong {
    Panic,
    Abort,
    TimeOut,
    /// A refusal of several lines, or of none.
    Lines,
    /// One of more than 500 characters.
    Long,
    /// A system failure without one.
    Code,
    /// A refusal without found, expected and remedy, in words of the programming language, or that blames an output.
    Words,
    /// Unfinished files, or outputs of a failed run.
    Left,
    /// Files of two runs in one set.
    Mixed,
    /// An undocumented exit code, a success without output, a changed input.
    Other,
}

const WRONGS: [(Wrong, &str); 10] = [
    (Wrong::Panic, "panics"),
    (Wrong::Abort, "aborts"),
    (Wrong::TimeOut, "time-outs"),
    (Wrong::Lines, "refusals of several lines"),
    (Wrong::Long, "messages over 500 characters"),
    (Wrong::Code, "wrong exit codes"),
    (Wrong::Words, "refusals badly said"),
    (Wrong::Left, "files left"),
    (Wrong::Mixed, "sets mixed"),
    (Wrong::Other, "other faults"),
];

/// Instead of the exit code of a run that was stopped while it reported progress.
pub const AT_WORK: i32 = -1;

/// A bug, and its details.
pub type Fault = (Wrong, String);

/// The results of cases.
#[derive(Default)]
pub struct Tally {
    /// Damaged inputs and command lines.
    pub cases: u64,
    /// Kills, failing places, full disks, closed outputs, two writers.
    pub faults: u64,
    /// How the cases ended.
    pub codes: BTreeMap<i32, u64>,
    /// Cases that were stopped at long work with progress.
    pub at_work: u64,
    /// The number of faults that left the old files, some that are refused, and the new.
    pub left: [u64; 3],
    pub wrong: Vec<Fault>,
    pub seconds: f64,
}

/// The results of all cases of this process.
static ALL: Mutex<Tally> = Mutex::new(Tally {
    cases: 0,
    faults: 0,
    codes: BTreeMap::new(),
    at_work: 0,
    left: [0; 3],
    wrong: Vec::new(),
    seconds: 0.0,
});

impl Tally {
    pub fn add(&mut self, other: &Self) {
        self.cases += other.cases;
        self.faults += other.faults;
        self.seconds += other.seconds;
        self.wrong.extend(other.wrong.iter().cloned());
        self.at_work += other.at_work;
        self.left = [0, 1, 2].map(|i| self.left[i] + other.left[i]);
        for (code, count) in &other.codes {
            *self.codes.entry(*code).or_default() += count;
        }
    }

    /// Counts a case by its exit code.
    pub fn case(&mut self, name: &str, ended: Result<i32, Fault>) {
        self.cases += 1;
        match ended {
            Ok(AT_WORK) => self.at_work += 1,
            Ok(code) => *self.codes.entry(code).or_default() += 1,
            Err(fault) => self.wrong(name, fault),
        }
    }

    /// Counts a kill or another fault by whether the new files are there; `None`: files that are refused.
    pub fn fault(&mut self, name: &str, new: Result<impl Into<Option<bool>>, Fault>) {
        self.faults += 1;
        match new {
            Ok(new) => self.left[new.into().map_or(1, |new| 2 * usize::from(new))] += 1,
            Err(fault) => self.wrong(name, fault),
        }
    }

    /// Reports an error at once, without waiting for a long run.
    fn wrong(&mut self, name: &str, (wrong, told): Fault) {
        println!("{wrong:?}: {name}: {told}");
        self.wrong.push((wrong, format!("{name}: {told}")));
    }

    /// Prints the results of the cases of `name` and of all so far, and fails if something is wrong.
    pub fn check(self, name: &str) {
        println!("{name}: {self}");
        let mut all = ALL.lock().unwrap();
        all.add(&self);
        println!("so far: {all}");
        drop(all);
        let told: Vec<String> = self.wrong.iter().map(|(wrong, told)| format!("{wrong:?}: {told}")).collect();
        assert!(told.is_empty(), "{name}: {self}\n{}", told.join("\n"));
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} cases, {} kills and other faults", self.cases, self.faults)?;
        for (kind, name) in WRONGS {
            write!(f, ", {} {name}", self.wrong.iter().filter(|(wrong, _)| *wrong == kind).count())?;
        }
        let [old, refused, new] = self.left;
        let rate = (self.cases + self.faults) as f64 / self.seconds.max(1e-9);
        write!(f, "; {} stopped at long work that says how long", self.at_work)?;
        write!(
            f,
            "; exit codes {:?}; {old} times all old, {refused} times refused, {new} times all new",
            self.codes
        )?;
        write!(f, "; {:.0} s, {rate:.0} a second", self.seconds)
    }
}

/// How a process ended, and its stderr.
pub struct Ended {
    pub status: Option<ExitStatus>,
    /// Stderr without progress.
    pub told: String,
    /// Whether it reported progress.
    pub is_at_work: bool,
}

/// Starts `line`; `fault`, such as `kill:3`, awaits it.
pub fn start(place: &Place, line: &str, fault: &str) -> Child {
    start_within(place, line, fault, MEMORY_KIB)
}

/// The same in less memory.
fn start_within(place: &Place, line: &str, fault: &str, memory_kib: u64) -> Child {
    let said = fs::File::create(place.path().join("said")).unwrap();
    let mut command = Command::new("sh");
    let seconds = place.ground.seconds.map_or(String::new(), |seconds| format!("ulimit -t {seconds}; "));
    command.args(["-c", &format!("{seconds}ulimit -v {memory_kib}; exec \"$0\" \"$@\""), SEATRIAL]);
    command.args(line.split_whitespace()).current_dir(place.path()).env("SEATRIAL_FAULT", fault);
    command
        .env("RUST_BACKTRACE", "0")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(said)
        .spawn()
        .unwrap()
}

/// Waits for a process, with a timeout.
pub fn wait(place: &Place, child: Child) -> Ended {
    wait_for(place, child, LIMIT)
}

fn wait_for(place: &Place, mut child: Child, limit: Duration) -> Ended {
    let started = Instant::now();
    let status = loop {
        match child.try_wait().unwrap() {
            Some(status) => break Some(status),
            None if started.elapsed() > limit => {
                child.kill().unwrap();
                child.wait().unwrap();
                break None;
            }
            None => std::thread::sleep(Duration::from_micros(500)),
        }
    };
    let said = place.path().join("said");
    let all = String::from_utf8_lossy(&fs::read(&said).unwrap()).into_owned();
    fs::remove_file(said).unwrap();
    let lines = all.split_inclusive('\n');
    let (progress, told): (Vec<&str>, Vec<&str>) = lines.partition(|line| is_progress(line.trim_end()));
    Ended { status, told: told.concat(), is_at_work: !progress.is_empty() }
}

impl Ended {
    /// The exit code, if the process ended as documented: 0, or a refusal of one line.
    pub fn judged(&self) -> Result<i32, Fault> {
        let told = || self.told.clone();
        let Some(status) = self.status else {
            if self.is_at_work {
                return Ok(AT_WORK);
            }
            return Err((Wrong::TimeOut, "does not end in time".to_owned()));
        };
        if self.told.contains("panicked at") || status.code() == Some(101) {
            return Err((Wrong::Panic, told()));
        }
        if status.code().is_none() && is_out_of_time(status) {
            return Err((Wrong::TimeOut, told()));
        }
        if let Some(long) = self.told.lines().map(|line| line.chars().count()).find(|long| *long > LONGEST) {
            return Err((Wrong::Long, format!("{long} characters: {}", told())));
        }
        match status.code() {
            None => Err((Wrong::Abort, format!("{status}: {}", told()))),
            Some(0) => Ok(0),
            Some(code @ 1..=4) if self.told.lines().count() == 1 => Ok(code),
            Some(code @ 1..=4) => Err((Wrong::Lines, format!("exit code {code}: {}", told()))),
            Some(code) => Err((Wrong::Other, format!("exit code {code}: {}", told()))),
        }
    }
}

/// Whether the system ended a process for its processor time.
fn is_out_of_time(status: ExitStatus) -> bool {
    use std::os::unix::process::ExitStatusExt;
    const XCPU: i32 = 24;
    matches!(status.signal(), Some(XCPU | 9))
}

/// Runs `line` where nothing is written yet: it writes files that its readers take, or refuses and leaves nothing.
pub fn ends(place: &Place, line: &str) -> Result<i32, Fault> {
    ends_within(place, line, LIMIT, MEMORY_KIB)
}

/// The same in less time and memory.
pub fn ends_within(place: &Place, line: &str, limit: Duration, memory_kib: u64) -> Result<i32, Fault> {
    let before = place.inputs();
    let ended = wait_for(place, start_within(place, line, "", memory_kib), limit);
    let code = ended.judged()?;
    if code == AT_WORK {
        return Ok(code);
    }
    // The only possible system error is a name without a file.
    let no_file = [": found No such file", ": found no folder", ": found Not a directory"];
    if code == 1 && !no_file.iter().any(|found| ended.told.contains(found)) {
        return Err((Wrong::Code, format!("exit code 1: {}", ended.told)));
    }
    if let Some(wrong) = badly_said(code, &ended.told) {
        return Err((Wrong::Words, format!("exit code {code}, {wrong}: {}", ended.told)));
    }
    if place.inputs() != before {
        return Err((
            Wrong::Other,
            format!("exit code {code}, but files beside the output changed: {}", ended.told),
        ));
    }
    let out = place.path().join("out");
    let written: Vec<String> = crate::grounds::files(&out).into_keys().collect();
    if let Some(left) = written.iter().find(|name| code != 0 || is_unfinished(name)) {
        return Err((Wrong::Left, format!("exit code {code}, but it left {left}: {}", ended.told)));
    }
    if code == 0 && written.is_empty() {
        return Err((Wrong::Other, "succeeds and writes nothing".to_owned()));
    }
    read(place, written.iter().map(String::as_str))?;
    Ok(code)
}

/// What is wrong with the words of a refusal.
fn badly_said(code: i32, told: &str) -> Option<&'static str> {
    const TYPES: [&str; 8] = ["::", "Some(", "Err(", "Ok(", "u64", "usize", "u32", ", expected struct"];
    let parts = [": found ", ", expected ", "; "];
    if !matches!(code, 3 | 4) {
        None
    } else if !told.starts_with("error: ") || parts.iter().any(|part| !told.contains(part)) {
        Some("which does not say what was found, what was expected and what helps")
    } else if told.starts_with("error: out/") {
        Some("which blames the output for its input")
    } else if TYPES.iter().any(|word| told.contains(word)) {
        Some("in words of the programming language")
    } else {
        None
    }
}

/// Reads outputs as the next stage would.
pub fn read<'a>(place: &Place, names: impl Iterator<Item = &'a str>) -> Result<(), Fault> {
    for name in names.filter(|name| !is_unfinished(name)) {
        let path = place.path().join("out").join(name);
        let read = files::inspect(&path).and_then(|found| {
            found.map_or(Ok(()), |found| files::check_members(&path, &found.members, |_| None))
        });
        read.map_err(|error| (Wrong::Mixed, format!("{name} is not taken by its reader: {error}")))?;
    }
    Ok(())
}
