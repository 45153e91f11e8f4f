//! Charts on which other programs failed, of `../shared/cases`: without that folder these tests say so and pass. Other charts of the
//! same kinds are made in the tests of each kind.

use std::fs;
use std::sync::OnceLock;

use tempfile::TempDir;

use crate::planned::ZIG_ZAGS;
use crate::support::*;

/// Zig-zags of the vessel of Helsinki.
fn dictionary() -> &'static [(String, Vec<u8>)] {
    static MADE: OnceLock<Vec<(String, Vec<u8>)>> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        for (from, name) in [("pipelines/helsinki/vessel.toml", "vessel.toml"), (ZIG_ZAGS, "dictionary.toml")]
        {
            fs::copy(repository().join(from), folder.path().join(name)).unwrap();
        }
        run(&folder, DICTIONARY).succeeds();
        ["vessel.toml", "dictionary.parquet"].map(|name| (name.to_owned(), bytes(&folder, name))).into()
    })
}

/// A folder with a case, the vessel and its dictionary.
fn case(case: &str) -> Option<TempDir> {
    let own = repository().join("../shared/cases").join(case);
    if !own.is_dir() {
        eprintln!("skipped: there is no {}", own.display());
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(own).unwrap() {
        let path = entry.unwrap().path();
        fs::write(folder.path().join(path.file_name().unwrap()), fs::read(&path).unwrap()).unwrap();
    }
    dictionary().iter().for_each(|(name, bytes)| fs::write(folder.path().join(name), bytes).unwrap());
    Some(folder)
}

const PLAN: &str =
    "plan --vessel vessel.toml --trajectories dictionary.parquet --config plan.toml --out plan.json";

#[test]
fn a_start_over_a_shoal_is_refused_in_whatever_unit_its_depth_is_written() {
    for name in ["01", "02", "28"] {
        let Some(folder) = case(name) else { return };
        let ran = run(&folder, PLAN);
        ran.refuses(4, &["`start`", "from an obstacle"]);
    }
}

#[test]
fn a_start_over_a_wreck_is_refused_where_updates_stand_in_folders_of_their_own() {
    let Some(folder) = case("04") else { return };
    for (suffix, sub) in [("000", ""), ("001", "1/"), ("002", "2/")] {
        let name = format!("ZZ5BAY01.{suffix}");
        fs::create_dir_all(folder.path().join(sub)).unwrap();
        fs::copy(
            repository().join("fixtures/charts/enc").join(&name),
            folder.path().join(format!("{sub}{name}")),
        )
        .unwrap();
    }
    run(&folder, PLAN).refuses(4, &["`start`", "from an obstacle"]);
}
