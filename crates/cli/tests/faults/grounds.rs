//! Studies as small as possible, and the stages that read and write them.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use tempfile::TempDir;

use crate::planned::{ISLAND, SMALL};
use crate::support::{FEW_ROUNDS, craft, edit, in_rounds, put, repository, run};

/// Files by their paths below a folder.
pub type Files = BTreeMap<String, Vec<u8>>;

/// A command line on a ground.
#[derive(Debug)]
pub struct Stage {
    /// Without an output.
    pub line: &'static str,
    /// Its main output.
    pub out: &'static str,
    /// A replacement in the line that gives another result from the same files.
    pub other: [&'static str; 2],
    /// The inputs that are damaged.
    pub reads: &'static [&'static str],
}

impl Stage {
    /// The command line that writes into the folder `out`.
    pub fn line_into(&self, folder: &str) -> String {
        format!("{} --out {folder}{} --allow=mixed", self.line, self.out)
    }

    /// The command line with the other result.
    pub fn other_into(&self, folder: &str) -> String {
        let [from, to] = self.other;
        assert!(self.line.contains(from), "{}: no `{from}`", self.line);
        format!("{} --out {folder}{} --allow=mixed", self.line.replacen(from, to, 1), self.out)
    }
}

pub const fn stage(
    line: &'static str,
    out: &'static str,
    other: [&'static str; 2],
    reads: &'static [&'static str],
) -> Stage {
    Stage { line, out, other, reads }
}

/// Turns a command line into one with another seed.
const SEED: [&str; 2] = ["--vessel", "--seed 2 --vessel"];

/// The paper's study with two runs per design, in all its forms.
static PAPER: [Stage; 19] = [
    stage(
        "simulate dictionary --vessel vessel.toml --dictionary dictionary.toml",
        "dictionary.parquet",
        ["dictionary.toml", "dictionary-2.toml"],
        &["vessel.toml", "dictionary.toml"],
    ),
    stage(
        "moments --vessel vessel.toml --trajectories dictionary.parquet",
        "moments.json",
        ["--vessel", "--estimator ls --vessel"],
        &["vessel.toml", "dictionary.parquet"],
    ),
    stage(
        "design --moments moments.json",
        "design.json",
        ["--moments", "--segments 20 --segment-samples 50 --moments"],
        &["moments.json"],
    ),
    stage(
        "simulate campaign --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml \
         --design design.json",
        "campaign.parquet",
        SEED,
        &["vessel.toml", "dictionary.toml", "campaign.toml", "design.json"],
    ),
    stage(
        "simulate validation --vessel vessel.toml --campaign campaign.toml",
        "validation.parquet",
        ["campaign.toml", "campaign-2.toml"],
        &["vessel.toml", "campaign.toml"],
    ),
    stage(
        "estimate --vessel vessel.toml --trajectories campaign.parquet --estimator ls",
        "estimates.parquet",
        ["ls", "iv"],
        &["vessel.toml", "campaign.parquet"],
    ),
    stage(
        "validate --vessel vessel.toml --campaign campaign.toml --estimates estimates.parquet \
         --validation validation.parquet",
        "scores.parquet",
        ["campaign.toml", "campaign-2.toml"],
        &["campaign.toml", "estimates.parquet", "validation.parquet"],
    ),
    stage(
        "monte-carlo --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --design design.json \
         --estimator ls,iv --keep estimates",
        "kept-validation.json",
        SEED,
        &["vessel.toml", "dictionary.toml", "campaign.toml", "design.json"],
    ),
    stage(
        "moments --vessel vessel.toml --trajectories dictionary.parquet --campaign campaign.toml \
         --estimator output-error",
        "moments-2.json",
        ["campaign.toml", "campaign-2.toml"],
        &["vessel.toml", "campaign.toml", "dictionary.parquet"],
    ),
    stage(
        "design --moments moments-2.json --for output-error --criterion a-relative --relative-to value",
        "design-2.json",
        ["a-relative --relative-to value", "a"],
        &["moments-2.json"],
    ),
    stage(
        "design --refine design-2.json --vessel vessel.toml --dictionary dictionary.toml --campaign campaign-2.toml",
        "refined-design.json",
        ["campaign-2.toml", "campaign.toml"],
        &["vessel.toml", "dictionary.toml", "design-2.json", "campaign-2.toml"],
    ),
    stage(
        "estimate --structure own --vessel vessel.toml --trajectories campaign.parquet --runs random/0,random/1 --bootstrap 3",
        "pooled.parquet",
        SEED,
        &["vessel.toml", "campaign.parquet"],
    ),
    stage(
        "estimate --structure own --folds each --vessel vessel.toml --trajectories campaign.parquet --runs random/0,random/1 \
         --window-s 10 --estimator ls",
        "scores.json",
        ["--window-s 10", "--window-s 20"],
        &["vessel.toml", "campaign.parquet"],
    ),
    stage(
        "monte-carlo --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml",
        "rounds-scores.parquet",
        SEED,
        &["vessel.toml", "dictionary.toml", "campaign.toml"],
    ),
    stage(
        "simulate campaign --gather part-1.parquet part-2.parquet",
        "gathered.parquet",
        ["part-1.parquet part-2.parquet", "other-1.parquet other-2.parquet"],
        &["part-1.parquet", "part-2.parquet"],
    ),
    stage(
        "estimate --vessel vessel.toml --gather estimates-1.parquet estimates-2.parquet",
        "estimates-3.parquet",
        ["estimates-1.parquet estimates-2.parquet", "estimates-4.parquet estimates-5.parquet"],
        &["estimates-1.parquet", "estimates-2.parquet"],
    ),
    stage(
        "validate --vessel vessel.toml --campaign campaign.toml --validation validation.parquet \
         --gather scores-1.parquet scores-2.parquet",
        "scores-3.parquet",
        ["scores-1.parquet scores-2.parquet", "scores-4.parquet scores-5.parquet"],
        &["scores-1.parquet", "scores-2.parquet", "validation.parquet"],
    ),
    // Into a folder of its own.
    stage(
        "export --vessel vessel.toml --to c --parameters value",
        "",
        ["--parameters value", "--parameters nominal"],
        &["vessel.toml"],
    ),
    stage(
        "report --study . --results .",
        "report.html",
        ["--study .", "--study . --dictionary dictionary-2.toml"],
        &[
            "campaign.toml",
            "design.json",
            "validation.json",
            "estimate.json",
            "scores.parquet",
            "scores.json",
        ],
    ),
];

/// A plan round an island, on polygons, on a grid, and of a problem file.
static PLANS: [Stage; 6] = [
    stage(
        "simulate dictionary --vessel vessel.toml --dictionary dictionary.toml",
        "dictionary.parquet",
        ["dictionary.toml", "dictionary-2.toml"],
        &["dictionary.toml"],
    ),
    stage(
        "plan --vessel vessel.toml --trajectories dictionary.parquet --config plan.toml --time-limit-s 8 --memory-mib 1024",
        "plan.json",
        SEED,
        &["plan.toml", "plan.toml", "land.geojson", "land.geojson", "dictionary.parquet", "vessel.toml"],
    ),
    stage(
        "plan --vessel vessel.toml --trajectories dictionary.parquet --config plan-2.toml --time-limit-s 8 --memory-mib 1024",
        "plan-2.json",
        SEED,
        &["own.asc", "plan-2.toml"],
    ),
    stage(
        "plan --problem problem.json --time-limit-s 8 --memory-mib 1024",
        "plan-3.json",
        ["problem.json", "problem-2.json"],
        &["problem.json"],
    ),
    stage(
        "simulate plan --vessel vessel.toml --campaign campaign.toml --plan plan.json",
        "planned.parquet",
        SEED,
        &["plan.json", "track.parquet", "campaign.toml"],
    ),
    stage(
        "report --study . --results .",
        "report.html",
        ["--study .", "--study . --dictionary dictionary-2.toml"],
        &["plan.json", "track.parquet", "plan.toml"],
    ),
];

/// Logs, simulated and read as if they were a ship's, as text and as Parquet.
static LOGS: [Stage; 9] = [
    stage(
        "simulate logs --vessel vessel.toml --dictionary dictionary.toml --logs logs.toml",
        "simulated.json",
        SEED,
        &["vessel.toml", "dictionary.toml", "logs.toml", "logs.toml"],
    ),
    stage(
        "ingest --config ingest.toml --vessel vessel.toml --logs logs",
        "trajectories.parquet",
        ["ingest.toml", "ingest-2.toml"],
        &["ingest.toml", "ingest.toml", "logs/decelerate_01.csv", "logs/spiral-slow_01.csv", "vessel.toml"],
    ),
    stage(
        "ingest --config ingest-3.toml --vessel vessel.toml --logs tables",
        "ingested.parquet",
        ["ingest-3.toml", "ingest-4.toml"],
        &["ingest-3.toml", "tables/run.parquet"],
    ),
    stage(
        "moments --vessel vessel.toml --trajectories trajectories.parquet --nominal least-squares",
        "moments.json",
        ["--nominal least-squares", "--estimator ls"],
        &["trajectories.parquet"],
    ),
    stage(
        "design --moments moments.json --segments 4 --segment-samples 75 --available ingest.json",
        "design.json",
        ["--segments 4", "--segments 3"],
        &["moments.json", "ingest.json"],
    ),
    stage(
        "estimate --structure own --vessel vessel.toml --trajectories trajectories.parquet \
         --nominal least-squares --bootstrap 3",
        "estimates.parquet",
        SEED,
        &["trajectories.parquet", "ingest.json", "vessel.toml"],
    ),
    stage(
        "estimate --structure own --folds each --vessel vessel.toml --trajectories trajectories.parquet \
         --nominal estimate.json --window-s 4 --estimator ls,iv",
        "scores.json",
        ["--window-s 4", "--window-s 3"],
        &["trajectories.parquet", "ingest.json", "estimate.json"],
    ),
    stage(
        "validate --vessel vessel.toml --trajectories trajectories.parquet \
         --design design.json --reference reference.toml --estimator iv --realizations 4",
        "scores.parquet",
        SEED,
        &["trajectories.parquet", "design.json", "reference.toml"],
    ),
    stage(
        "report --study . --results .",
        "report.html",
        ["--study .", "--study . --dictionary dictionary-2.toml"],
        &["ingest.json", "estimate.json", "validation.json", "reference.toml"],
    ),
];

/// A study with all inputs of its stages.
pub struct Ground {
    pub stages: &'static [Stage],
    pub files: Files,
    /// Limit of processor time of a run \[s\], if any.
    pub seconds: Option<u32>,
}

/// All grounds, made once.
pub static GROUNDS: LazyLock<[Ground; 3]> = LazyLock::new(|| [paper(), plans(), logs()]);

/// Every stage with its ground.
pub fn all() -> Vec<(&'static Ground, &'static Stage)> {
    stages_on(&*GROUNDS)
}

/// Every stage on `grounds`, with its ground.
pub fn stages_on(grounds: &'static [Ground]) -> Vec<(&'static Ground, &'static Stage)> {
    grounds.iter().flat_map(|ground| ground.stages.iter().map(move |stage| (ground, stage))).collect()
}

/// The files below `folder`.
pub fn files(folder: &Path) -> Files {
    let mut found = Files::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(below, bytes)| (format!("{name}/{below}"), bytes)));
        } else {
            found.insert(name, fs::read(&path).unwrap());
        }
    }
    found
}

/// Writes files below a folder.
pub fn write(folder: &Path, files: &Files) {
    for (name, bytes) in files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
}

/// Copies of the hand-written files of a study.
fn copied(study: &str, names: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in names {
        fs::copy(repository().join("pipelines").join(study).join(name), folder.path().join(name)).unwrap();
    }
    folder
}

/// Writes `name` again as `other`, changed.
fn varied(folder: &TempDir, name: &str, other: &str, from: &str, to: &str) {
    fs::copy(folder.path().join(name), folder.path().join(other)).unwrap();
    edit(folder, other, from, to);
}

/// Outputs that no stage reads, some of them next to files that others read.
const LAST: [&str; 4] = ["refined-design.json", "simulated.json", "report.html", ""];

/// Runs every stage in `folder`.
fn made(folder: &TempDir, stages: &'static [Stage]) -> Ground {
    let read = stages.iter().filter(|stage| !LAST.contains(&stage.out));
    read.for_each(|stage| drop(run(folder, &stage.line_into("")).succeeds()));
    Ground { stages, files: files(folder.path()), seconds: None }
}

fn paper() -> Ground {
    let folder = copied("paper", &["campaign.toml"]);
    let dictionary = repository().join("pipelines/scenarios/dictionary.toml");
    fs::copy(dictionary, folder.path().join("dictionary.toml")).unwrap();
    put(&folder, "vessel.toml", "preset = \"ljungberg-model-ship\"\n");
    edit(&folder, "campaign.toml", "realizations = 500", "realizations = 2");
    edit(&folder, "campaign.toml", "duration_s = 125.0", "duration_s = 40.0");
    edit(&folder, "campaign.toml", "duration_s = 125.0", "duration_s = 20.0");
    edit(&folder, "campaign.toml", "0.15811388300841897", "0.02");
    in_rounds(&folder, FEW_ROUNDS);
    varied(
        &folder,
        "campaign.toml",
        "campaign-2.toml",
        "parameter_error_bound = 5.0",
        "parameter_error_bound = 6.0",
    );
    edit(&folder, "campaign-2.toml", "seed = 1", "seed = 2");
    edit(&folder, "campaign-2.toml", "duration_s = 40.0", "duration_s = 15.0");
    edit(&folder, "campaign-2.toml", "std_u_m_s = 0.15811388300841897", "std_u_m_s = 0.1");
    edit(&folder, "campaign-2.toml", "speed_amplitude_m_s = 0.3", "speed_amplitude_m_s = 0.2");
    varied(&folder, "dictionary.toml", "dictionary-2.toml", "duration_s = 37.5", "duration_s = 30.0");
    let part = |stage: &Stage, name: &str, more: &str| {
        drop(run(&folder, &format!("{} --out {name} {more}", stage.line)).succeeds());
    };
    PAPER[..5].iter().for_each(|stage| drop(run(&folder, &stage.line_into("")).succeeds()));
    part(&PAPER[5], "estimates.parquet", "");
    for (k, half) in [(1, "1/2"), (2, "2/2")] {
        part(&PAPER[3], &format!("part-{k}.parquet"), &format!("--shard {half}"));
        part(&PAPER[3], &format!("other-{k}.parquet"), &format!("--shard {half} --seed 2"));
        part(&PAPER[5], &format!("estimates-{k}.parquet"), &format!("--shard {half}"));
        part(
            &PAPER[5],
            &format!("estimates-{}.parquet", k + 3),
            &format!("--shard {half} --mean-removal batch"),
        );
        part(&PAPER[6], &format!("scores-{k}.parquet"), &format!("--shard {half}"));
    }
    edit(&folder, "campaign.toml", "parameter_error_bound = 5.0", "parameter_error_bound = 4.0");
    for (k, half) in [(4, "1/2"), (5, "2/2")] {
        part(&PAPER[6], &format!("scores-{k}.parquet"), &format!("--shard {half} --allow=mixed"));
    }
    edit(&folder, "campaign.toml", "parameter_error_bound = 4.0", "parameter_error_bound = 5.0");
    made(&folder, &PAPER)
}

/// A grid of depths with one shoal, in the zone of the small plan.
pub fn grid() -> String {
    let header =
        "ncols 16\nnrows 16\nxllcorner 386100\nyllcorner 6650600\ncellsize 300\nNODATA_value -9999\n";
    let cell = |i: usize| if i == 8 * 16 + 8 { "-2" } else { "20" };
    let row = |r: usize| (0..16).map(|c| cell(r * 16 + c)).collect::<Vec<_>>().join(" ") + "\n";
    header.to_owned() + &(0..16).map(row).collect::<String>()
}

fn plans() -> Ground {
    let folder = copied("helsinki", &["vessel.toml", "campaign.toml"]);
    let maneuvers = fs::read(repository().join("fixtures/dictionaries/dictionary-zig-zags.toml")).unwrap();
    fs::write(folder.path().join("dictionary.toml"), maneuvers).unwrap();
    edit(&folder, "campaign.toml", "realizations = 200", "realizations = 1");
    varied(&folder, "dictionary.toml", "dictionary-2.toml", "duration_s = 270.0", "duration_s = 180.0");
    // One maneuver of the two
    let one = SMALL.replace(", { name = \"sway-zig-zag\", count = 1 }", "").replace("runs = 4", "runs = 1");
    put(&folder, "plan.toml", &one);
    put(&folder, "land.geojson", ISLAND);
    let island = "file = \"land.geojson\"\nkind = \"land\"";
    let depths = "file = \"own.asc\"\nkind = \"depth\"\ncrs = \"EPSG:32635\"";
    varied(&folder, "plan.toml", "plan-2.toml", island, depths);
    put(&folder, "own.asc", &grid());
    let problem = fs::read(repository().join("fixtures/lattice/detour_seconds.json")).unwrap();
    fs::write(folder.path().join("problem.json"), problem).unwrap();
    let problem = fs::read(repository().join("fixtures/lattice/channel.json")).unwrap();
    fs::write(folder.path().join("problem-2.json"), problem).unwrap();
    made(&folder, &PLANS)
}

fn logs() -> Ground {
    let folder = copied(
        "model-ship",
        &["vessel.toml", "dictionary.toml", "logs.toml", "ingest.toml", "reference.toml"],
    );
    edit(&folder, "logs.toml", "repeats = 5", "repeats = 1");
    varied(
        &folder,
        "dictionary.toml",
        "dictionary-2.toml",
        "kind = \"decelerate\"",
        "kind = \"decelerate\" #",
    );
    varied(&folder, "ingest.toml", "ingest-2.toml", "max_gap_s = 0.3", "max_gap_s = 0.4");
    // As from a real ship: without documents that have their digests.
    fs::create_dir(folder.path().join("logs")).unwrap();
    drop(run(&folder, &format!("{} --out logs/", LOGS[0].line)).succeeds());
    fs::remove_file(folder.path().join("logs/simulated.json")).unwrap();
    tables(&folder);
    made(&folder, &LOGS)
}

/// The first recording as a table of another program, and its contents.
fn tables(folder: &TempDir) {
    drop(run(folder, &LOGS[1].line_into("")).succeeds());
    let whole = craft::read(&folder.path().join("trajectories.parquet"), "trajectories");
    let mut first = whole.in_blocks_of(76);
    first.blocks.truncate(1);
    fs::create_dir(folder.path().join("tables")).unwrap();
    first.write_foreign(&folder.path().join("tables/run.parquet"), "none", 0, 0.0);
    let channel = |(name, unit): (&str, &str)| {
        format!("[[file.channel]]\ncolumn = \"{name}\"\nchannel = \"{name}\"\nunit = \"{unit}\"\n")
    };
    let velocities = [("y_u", "m/s"), ("y_v", "m/s"), ("y_r", "rad/s")];
    let inputs = [("tau1", "N"), ("tau2", "N"), ("tau3", "N m")];
    let channels: String = velocities.into_iter().chain(inputs).map(channel).collect();
    let file = "[[file]]\npattern = [\"*.parquet\"]\ntime = { column = \"t\", unit = \"s\" }\n";
    put(folder, "ingest-3.toml", &format!("sample_rate_hz = 8.0\nmax_gap_s = 0.3\n{file}{channels}"));
    varied(folder, "ingest-3.toml", "ingest-4.toml", "max_gap_s = 0.3", "max_gap_s = 0.4");
}
