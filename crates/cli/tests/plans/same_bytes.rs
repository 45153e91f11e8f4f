//! The same files for any number of threads.

use crate::planned::*;
use crate::support::*;

#[test]
fn law_threads_do_not_change_bytes_of_any_file() {
    for threads in [1, 2, 5] {
        let folder = small();
        run(&folder, &format!("{PLAN} --threads {threads}")).succeeds();
        for name in PLANNED {
            assert!(bytes(&folder, name) == small_planned().study.bytes(name), "{name}, {threads} threads");
        }
    }
}

#[test]
fn law_same_seed_same_bytes_other_seed_other_currents() {
    let folder = small();
    let seeded = |seed: u64| {
        run(&folder, &format!("{PLAN} --seed {seed}")).succeeds();
        PLANNED.map(|name| bytes(&folder, name))
    };
    let (first, second) = (seeded(7), seeded(8));
    assert!(first == seeded(7), "the same seed gives other bytes");
    let differ: Vec<&str> =
        (0..PLANNED.len()).filter(|i| first[*i] != second[*i]).map(|i| PLANNED[i]).collect();
    // Other vessels are sampled: the check, the corridors and the map depend on them, and a leg may have to be
    // longer.
    assert!(["plan.json", "route.rtz", "map.svg"].iter().all(|name| differ.contains(name)), "{differ:?}");
}

#[test]
fn no_file_tells_a_folder() {
    let folder = small();
    run(&folder, PLAN).succeeds();
    let path = folder.path().to_string_lossy().into_owned();
    for name in PLANNED {
        assert!(!String::from_utf8_lossy(&bytes(&folder, name)).contains(&path), "{name}");
    }
}

#[test]
fn plan_json_tells_the_digests_of_what_it_was_made_from() {
    let folder = small();
    run(&folder, PLAN).succeeds();
    let inputs = json(&folder, "plan.json")["inputs"].take();
    for (role, file) in [
        ("vessel", "vessel.toml"),
        ("plan", "plan.toml"),
        ("trajectories", "dictionary.parquet"),
        ("chart:land.geojson", "land.geojson"),
    ] {
        let digest = files::Digest::of_bytes(&bytes(&folder, file));
        assert_eq!(inputs[role], serde_json::to_value(digest).unwrap(), "{role}: {inputs}");
    }
}

#[test]
fn one_line_or_one_object_and_nothing_on_stderr() {
    let folder = small();
    let ran = run(&folder, &format!("{PLAN} --quiet")).succeeds();
    assert!(ran.stdout.lines().count() == 1 && ran.stdout.starts_with("plan.json: optimal, "), "{ran}");
    assert_eq!(ran.stderr, "", "{ran}");
    let ran = run(&folder, &format!("{PLAN} --json")).succeeds();
    let said: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(said["out"], "plan.json", "{ran}");
    assert_eq!(said["cost"], small_planned().plan["cost"], "{ran}");
    std::fs::create_dir(folder.path().join("out")).unwrap();
    run(&folder, &PLAN.replace("--out plan.json", "--out out/")).succeeds();
    for name in PLANNED {
        assert!(bytes(&folder, name) == bytes(&folder, &format!("out/{name}")), "{name}");
    }
}
