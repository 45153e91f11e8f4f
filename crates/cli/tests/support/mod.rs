//! A small study on real files, and a runner of the real program.
#![allow(dead_code)]

pub mod craft;
pub mod draw;

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use assert_cmd::Command;
use files::Document;
use serde_json::{Map, Value};
use tempfile::TempDir;

/// Runs per design of the small study.
pub const RUNS: u64 = 24;

pub const DICTIONARY: &str =
    "simulate dictionary --vessel vessel.toml --dictionary dictionary.toml --out dictionary.parquet";
pub const MOMENTS: &str = "moments --vessel vessel.toml --trajectories dictionary.parquet --out moments.json";
pub const DESIGN: &str = "design --moments moments.json --out design.json";
pub const CAMPAIGN: &str = "simulate campaign --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml \
     --design design.json --out campaign.parquet";
pub const VALIDATION: &str =
    "simulate validation --vessel vessel.toml --campaign campaign.toml --out validation.parquet";
pub const ESTIMATE: &str =
    "estimate --vessel vessel.toml --trajectories campaign.parquet --out estimates.parquet";
pub const VALIDATE: &str = "validate --vessel vessel.toml --campaign campaign.toml --estimates estimates.parquet \
     --validation validation.parquet --out scores.parquet";
pub const REPORT: &str = "report --study . --results . --out report.html";

/// Every stage in order, as run inside the folder of a study.
pub const STAGES: [&str; 8] = [DICTIONARY, MOMENTS, DESIGN, CAMPAIGN, VALIDATION, ESTIMATE, VALIDATE, REPORT];

/// The files that the stages write, except figures.
pub const MADE: [&str; 10] = [
    "dictionary.parquet",
    "moments.json",
    "design.json",
    "campaign.parquet",
    "validation.parquet",
    "estimates.parquet",
    "estimate.json",
    "scores.parquet",
    "validation.json",
    "report.html",
];

/// The hand-written files.
pub const WRITTEN: [&str; 3] = ["vessel.toml", "dictionary.toml", "campaign.toml"];

/// Top of the repository.
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A new folder with the hand-written files of the small study, `runs` runs per design.
pub fn written(runs: u64) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "vessel.toml", "preset = \"ljungberg-model-ship\"\n");
    for (name, of) in [("dictionary.toml", "scenarios"), ("campaign.toml", "paper")] {
        let text = fs::read_to_string(repository().join("pipelines").join(of).join(name)).unwrap();
        // The schema stands elsewhere, and released results are of files without its line.
        let own = text.split_inclusive('\n').filter(|line| !line.starts_with("#:schema "));
        put(&folder, name, &own.collect::<String>());
    }
    edit(&folder, "campaign.toml", "realizations = 500", &format!("realizations = {runs}"));
    folder
}

/// Files of a study, in memory, so that no files are left when the tests end.
pub struct Study(BTreeMap<String, Vec<u8>>);

impl Study {
    /// Runs `stages` on the small study with `runs` runs per design.
    pub fn make(runs: u64, stages: &[&str]) -> Self {
        let folder = written(runs);
        stages.iter().for_each(|stage| drop(run(&folder, stage).succeeds()));
        Self::of(&folder)
    }

    /// The files in `folder`.
    pub fn of(folder: &TempDir) -> Self {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let file = |path: PathBuf| {
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            (name, fs::read(path).unwrap())
        };
        Self(entries.filter(|path| path.is_file()).map(file).collect())
    }

    /// The bytes of a file.
    #[track_caller]
    pub fn bytes(&self, name: &str) -> &[u8] {
        self.0.get(name).unwrap_or_else(|| panic!("the study has no {name}"))
    }

    pub fn has(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    /// A new folder with copies of the hand-written files and of `names`.
    pub fn with(&self, names: &[&str]) -> TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in WRITTEN.iter().chain(names) {
            fs::write(folder.path().join(name), self.bytes(name)).unwrap();
        }
        folder
    }
}

/// The small study with all outputs of the stages.
pub fn study() -> &'static Study {
    static STUDY: OnceLock<Study> = OnceLock::new();
    STUDY.get_or_init(|| Study::make(RUNS, &STAGES))
}

/// A new folder with copies of the small study's hand-written files and of `names`.
pub fn with(names: &[&str]) -> TempDir {
    study().with(names)
}

/// Writes a file.
pub fn put(folder: &TempDir, name: &str, text: &str) {
    fs::write(folder.path().join(name), text).unwrap();
}

/// Replaces the first `from` in a file, which must have one.
pub fn edit(folder: &TempDir, name: &str, from: &str, to: &str) {
    let text = fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(text.contains(from), "{name} has no `{from}`");
    put(folder, name, &text.replacen(from, to, 1));
}

/// The bytes of a file.
pub fn bytes(folder: &TempDir, name: &str) -> Vec<u8> {
    fs::read(folder.path().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// A file as JSON.
pub fn json(folder: &TempDir, name: &str) -> Value {
    serde_json::from_slice(&bytes(folder, name)).unwrap()
}

/// A file as the document that its reader makes of it.
pub fn document<D: Document>(folder: &TempDir, name: &str) -> files::Loaded<D> {
    files::read_document(folder.path().join(name)).unwrap()
}

/// The data that scripts draw on a page, which is small, whole and asks the network for nothing.
pub fn drawn(folder: &TempDir, name: &str) -> Value {
    let page = String::from_utf8(bytes(folder, name)).unwrap();
    assert!(page.len() < 2_000_000, "{name} has {} bytes", page.len());
    let (mut markup, mut data) = (String::new(), None);
    for part in page.split("</script>") {
        let (before, script) = part.split_once("<script").unwrap_or((part, ">"));
        let (attributes, body) = script.split_once('>').unwrap();
        assert!(!attributes.contains("src"), "{name}: <script{attributes}>");
        markup += before;
        if attributes.contains("application/json") {
            data = Some(serde_json::from_str(body).unwrap());
        }
    }
    for wrong in ["src=", "url(", "@import", "<link", "<img", "<iframe"] {
        assert!(!markup.contains(wrong), "{wrong} in {name}");
    }
    let mut links = markup.split("href=\"").skip(1);
    assert!(links.all(|link| link.starts_with('#') || link.starts_with("./")), "{name} links elsewhere");
    data.unwrap_or_else(|| Value::Array(Vec::new()))
}

/// The result of a binary.
pub struct Ran {
    pub line: String,
    pub folder: PathBuf,
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl fmt::Display for Ran {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { line, folder, code, stdout, stderr } = self;
        let folder = folder.display();
        write!(
            f,
            "\ncommand: {line}\nfolder: {folder}\nexit code: {code:?}\nstdout:\n{stdout}\nstderr:\n{stderr}"
        )
    }
}

impl Ran {
    /// Exit code 0.
    #[track_caller]
    pub fn succeeds(self) -> Self {
        assert_eq!(self.code, Some(0), "{self}");
        self
    }

    /// Exit code `code`, one line on stderr with every one of `pieces`, nothing on stdout or, with --json, one object.
    #[track_caller]
    pub fn refuses(self, code: i32, pieces: &[&str]) -> Self {
        assert_eq!(self.code, Some(code), "{self}");
        // Progress, which a slow machine reports after a second, may precede it.
        let mut lines = self.stderr.lines().skip_while(|line| is_progress(line));
        let error = lines.next().and_then(|line| line.strip_prefix("error: "));
        let error = error.unwrap_or_else(|| panic!("stderr is no line `error: …`{self}"));
        assert_eq!(lines.next(), None, "several lines{self}");
        for piece in pieces {
            assert!(error.contains(piece), "`{piece}` is missing{self}");
        }
        if code != 2 {
            for part in [": found ", ", expected ", "; "] {
                assert!(error.contains(part), "`{part}` is missing{self}");
            }
        }
        if self.line.contains("--json") {
            let said: Value = serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}{self}"));
            assert_eq!(said["exit_code"], code, "{self}");
            assert_eq!(said["error"], error, "{self}");
            assert_eq!(self.stdout.lines().count(), 1, "{self}");
        } else {
            assert_eq!(self.stdout, "", "{self}");
        }
        self
    }
}

/// The one program over all stages.
pub const SEATRIAL: &str = env!("CARGO_BIN_EXE_seatrial");

/// Runs a command line of `seatrial` in `folder`; its first word names the stage.
pub fn run(folder: &TempDir, line: &str) -> Ran {
    let mut command = Command::new(SEATRIAL);
    command.args(line.split_whitespace());
    finish(folder, line, command)
}

/// Trials in rounds, few and short.
pub const FEW_ROUNDS: &str =
    "realizations = 2\nduration_s = 60.0\nrounds = 2\nnominal_spread = 0.4\naccuracy = 0.5\n";

/// Writes `rounds` as the trials in rounds of campaign.toml, in place of those that it has.
pub fn in_rounds(folder: &TempDir, rounds: &str) {
    let text = String::from_utf8(bytes(folder, "campaign.toml")).unwrap();
    let campaign = text.split("\n[rounds]\n").next().unwrap();
    put(folder, "campaign.toml", &format!("{campaign}\n[rounds]\n{rounds}"));
}

/// Runs a command line with a variable of the environment.
pub fn run_with(folder: &TempDir, line: &str, (name, value): (&str, &str)) -> Ran {
    let mut command = Command::new(SEATRIAL);
    command.args(line.split_whitespace()).env(name, value);
    finish(folder, line, command)
}

/// Runs a command line where no file can grow beyond 32 KiB, as on a full disk.
pub fn run_on_full_disk(folder: &TempDir, line: &str) -> Ran {
    let mut command = Command::new("sh");
    command.args(["-c", "trap '' XFSZ; ulimit -f 64; exec \"$0\" \"$@\""]);
    command.arg(SEATRIAL).args(line.split_whitespace());
    finish(folder, line, command)
}

/// Runs a command line in 4 GiB of address space: a larger allocation fails, or aborts.
pub fn run_in_little_memory(folder: &TempDir, line: &str) -> Ran {
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -v 4194304; exec \"$0\" \"$@\""]);
    command.arg(SEATRIAL).args(line.split_whitespace());
    finish(folder, line, command)
}

fn finish(folder: &TempDir, line: &str, mut command: Command) -> Ran {
    let output = command.current_dir(folder).env("RUST_BACKTRACE", "0").output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    Ran {
        line: line.split_whitespace().collect::<Vec<_>>().join(" "),
        folder: folder.path().to_owned(),
        code: output.status.code(),
        stdout: text(output.stdout),
        stderr: text(output.stderr),
    }
}

/// Every file and folder below `folder`: name, length and time of its last change.
pub fn listing(folder: &Path) -> BTreeMap<PathBuf, (u64, std::time::SystemTime)> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let about = entry.metadata().unwrap();
        if about.is_dir() {
            all.extend(listing(&entry.path()));
        }
        all.insert(entry.path(), (about.len(), about.modified().unwrap()));
    }
    all
}

/// Asserts that `found` are the numbers in the golden file at `path`, up to `tolerance`.
pub fn are_golden(path: &Path, found: &Map<String, Value>, tolerance: f64) {
    let remedy = "`make golden` writes it again, once you know why";
    let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}; {remedy}", path.display()));
    let golden: Map<String, Value> = serde_json::from_str(&text).unwrap();
    assert!(golden.keys().eq(found.keys()), "other numbers than in {}; {remedy}", path.display());
    for (name, golden) in &golden {
        let (golden, found) = (golden.as_f64().unwrap(), found[name].as_f64().unwrap());
        let same = approx::relative_eq!(golden, found, max_relative = tolerance, epsilon = 1e-12);
        assert!(same, "{name}: found {found}, golden {golden}; {remedy}");
    }
}

/// Runs a command line that must be refused, without and with --json, and must leave the folder as it was.
#[track_caller]
pub fn refused(folder: &TempDir, code: i32, line: &str, pieces: &[&str]) {
    let before = listing(folder.path());
    for line in [line.to_owned(), format!("{line} --json")] {
        let ran = run(folder, &line).refuses(code, pieces);
        assert_eq!(listing(folder.path()), before, "the folder changed{ran}");
    }
}

/// `label: done of all, about n s left`.
pub fn is_progress(line: &str) -> bool {
    let counted = line.split_once(", about ").map_or(line, |(counted, _)| counted);
    let counts = counted.rsplit_once(": ").and_then(|(_, counts)| counts.split_once(" of "));
    counts.is_some_and(|(done, all)| [done, all].iter().all(|n| n.parse::<u64>().is_ok()))
}
