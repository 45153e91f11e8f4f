//! The same inputs and seed give the same bytes, for any number of threads and any sharding.

use std::sync::LazyLock;

use tempfile::TempDir;

use crate::support::*;

/// A campaign of four blocks, two per design.
static CAMPAIGN_STUDY: LazyLock<Study> = LazyLock::new(|| Study::make(70, &STAGES[..4]));

/// Estimates and scores from trajectories of one run per block and estimates of one row per block: many blocks.
static BLOCKS_STUDY: LazyLock<Study> = LazyLock::new(|| {
    let folder = with(&["campaign.parquet", "validation.parquet"]);
    let (campaign, estimates) =
        (folder.path().join("campaign.parquet"), folder.path().join("estimates.parquet"));
    craft::read(&campaign, "trajectories").in_blocks_of(1001).write(&campaign);
    run(&folder, ESTIMATE).succeeds();
    let whole = bytes(&folder, "estimates.parquet");
    craft::read(&estimates, "estimates").in_blocks_of(1).write(&estimates);
    run(&folder, VALIDATE).succeeds();
    std::fs::rename(&estimates, folder.path().join("rows.parquet")).unwrap();
    std::fs::write(&estimates, whole).unwrap();
    Study::of(&folder)
});

/// A stage whose work can be split, in a study with many blocks of work.
struct Splittable {
    study: &'static Study,
    line: String,
    gather: &'static str,
    writes: &'static [&'static str],
}

fn splittable() -> [Splittable; 3] {
    [
        Splittable {
            study: &CAMPAIGN_STUDY,
            line: CAMPAIGN.to_owned(),
            gather: "simulate campaign",
            writes: &["campaign.parquet"],
        },
        Splittable {
            study: &BLOCKS_STUDY,
            line: ESTIMATE.to_owned(),
            gather: "estimate --vessel vessel.toml",
            writes: &["estimates.parquet", "estimate.json"],
        },
        Splittable {
            study: &BLOCKS_STUDY,
            line: VALIDATE.replace("estimates.parquet", "rows.parquet"),
            gather: "validate --vessel vessel.toml --campaign campaign.toml --validation validation.parquet",
            writes: &["scores.parquet", "validation.json"],
        },
    ]
}

impl Splittable {
    /// The inputs of the stage.
    fn folder(&self) -> TempDir {
        let made = ["design.json", "campaign.parquet", "validation.parquet", "rows.parquet"];
        let there: Vec<&str> = made.into_iter().filter(|name| self.study.has(name)).collect();
        self.study.with(&there)
    }

    #[track_caller]
    fn assert_same(&self, folder: &TempDir) {
        for name in self.writes {
            assert!(bytes(folder, name) == self.study.bytes(name), "{name} has other bytes");
        }
    }

    /// Runs the stage in `count` shards, the last first.
    fn shards(&self, folder: &TempDir, count: u32) -> String {
        let (line, _) = self.line.split_once(" --out ").unwrap();
        let mut names = Vec::new();
        for k in (1..=count).rev() {
            let name = format!("part-{k}.parquet");
            let before = listing(folder.path()).len();
            run(folder, &format!("{line} --shard {k}/{count} --out {name}")).succeeds();
            assert_eq!(listing(folder.path()).len(), before + 1, "a shard writes its table only");
            names.push(name);
        }
        names.join(" ")
    }
}

#[test]
fn law_threads_do_not_change_bytes() {
    for stage in splittable() {
        for threads in [1, 2, 5] {
            let folder = stage.folder();
            run(&folder, &format!("{} --threads {threads}", stage.line)).succeeds();
            stage.assert_same(&folder);
        }
    }
}

#[test]
fn law_shards_gather_to_the_same_bytes() {
    for stage in splittable() {
        for count in [1, 4, 7] {
            let folder = stage.folder();
            let parts = stage.shards(&folder, count);
            let gathered = stage.writes[0];
            run(&folder, &format!("{} --out {gathered} --gather {parts}", stage.gather)).succeeds();
            stage.assert_same(&folder);
        }
    }
}

#[test]
fn law_same_seed_same_bytes_other_seed_other_bytes() {
    let folder = CAMPAIGN_STUDY.with(&["design.json", "campaign.parquet"]);
    let seeded = |seed: u64| {
        run(&folder, &format!("{CAMPAIGN} --seed {seed}")).succeeds();
        bytes(&folder, "campaign.parquet")
    };
    let (configured, other) = (seeded(1), seeded(2));
    assert!(
        configured == CAMPAIGN_STUDY.bytes("campaign.parquet"),
        "--seed 1 is the configuration's own seed"
    );
    assert!(other != configured && other.len() > 1000);
    assert!(other == seeded(2));
}

#[test]
fn a_random_run_is_five_of_the_dictionarys_maneuvers() {
    let folder = CAMPAIGN_STUDY.with(&["design.json", "campaign.parquet"]);
    let campaign = craft::read(&folder.path().join("campaign.parquet"), "trajectories");
    let names: Vec<String> = json(&folder, "design.json")["data"]["order"]
        .as_array()
        .unwrap()
        .iter()
        .map(|name| name.as_str().unwrap().to_owned())
        .collect();
    let mut drawn = std::collections::BTreeSet::new();
    let mut random_rows = 0;
    for block in &campaign.blocks {
        let [design, run, segment, maneuver] = [0, 1, 2, 3].map(|i| &block.columns[i]);
        for row in (0..design.len()).filter(|row| design.text_at(*row) == Some("random")) {
            let maneuver = maneuver.text_at(row).unwrap();
            assert!(names.iter().any(|name| name == maneuver), "{maneuver}");
            drawn.insert((run.as_i32().unwrap()[row], segment.as_i32().unwrap()[row], maneuver.to_owned()));
            random_rows += 1;
        }
    }
    assert_eq!(random_rows, 70 * 1001);
    assert_eq!(drawn.len(), 70 * 5, "one maneuver per segment");
    assert!(drawn.iter().all(|(run, segment, _)| (0..70).contains(run) && (0..5).contains(segment)));
    let occurring: std::collections::BTreeSet<&str> =
        drawn.iter().map(|(_, _, name)| name.as_str()).collect();
    assert_eq!(occurring.len(), names.len(), "350 draws leave out none of eleven");
}
