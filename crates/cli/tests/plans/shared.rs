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
    for name in ["01", "28"] {
        let Some(folder) = case(name) else { return };
        let ran = run(&folder, PLAN);
        ran.refuses(4, &["`start`", "from an obstacle"]);
    }
    let Some(folder) = case("02") else { return };
    run(&folder, PLAN).refuses(3, &["found NetCDF", "gdal_translate feet.nc feet.tif"]);
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

/// A folder with a case of `../shared/cases-2`, and the plan that its ship follows.
fn followed(case: &str) -> Option<TempDir> {
    let all = repository().join("../shared/cases-2");
    if !all.is_dir() {
        eprintln!("skipped: there is no {}", all.display());
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    for entry in [case, "follow"].into_iter().flat_map(|own| fs::read_dir(all.join(own)).unwrap()) {
        let path = entry.unwrap().path();
        fs::write(folder.path().join(path.file_name().unwrap()), fs::read(&path).unwrap()).unwrap();
    }
    fs::create_dir(folder.path().join("rest")).unwrap();
    Some(folder)
}

const FOLLOW: &str = "plan --rest-of plan.json --vessel vessel.toml --trajectories dictionary.parquet --config plan.toml \
     --set plan.safety.runs=8 --out rest/plan.json --from ";

#[test]
fn logs_that_leave_the_place_of_a_ship_in_doubt_are_refused() {
    for (case, file, pieces) in [
        (
            "104-follow-lat-lon-swapped",
            "positions.csv",
            ["exchanged they are near it", "exchange them in the file"],
        ),
        ("113-follow-speed-knots", "positions.csv", ["as in knots", "convert the speed"]),
        ("122-follow-nmea-two-receivers", "positions.nmea", ["GNRMC 200 m away from GPRMC", "grep -v GNRMC"]),
        ("124-follow-frozen-at-end", "positions.nmea", ["no motion since line", "her speed is 1.5 m/s"]),
    ] {
        let Some(folder) = followed(case) else { return };
        refused(&folder, 3, &format!("{FOLLOW}{file}"), &[&[file][..], &pieces].concat());
        assert!(fs::read_dir(folder.path().join("rest")).unwrap().next().is_none(), "{case}");
    }
}

#[test]
fn a_route_of_rtz_is_called_as_its_file() {
    let Some(folder) = followed("138-rtz-route-name") else { return };
    for name in ["plan", "plan-b", "rest"] {
        run(
            &folder,
            &PLAN.replace("--out plan.json", &format!("--set plan.safety.runs=8 --out rest/{name}.json")),
        )
        .succeeds();
    }
    let routes = fs::read_dir(folder.path().join("rest")).unwrap().map(|entry| entry.unwrap().path());
    // Those of aborts are named after their legs.
    let is_whole = |path: &std::path::PathBuf| {
        path.extension().is_some_and(|end| end == "rtz") && !path.to_string_lossy().contains("abort-")
    };
    let routes: Vec<_> = routes.filter(is_whole).collect();
    assert_eq!(routes.len(), 3);
    for route in routes {
        let name = route.file_stem().unwrap().to_str().unwrap();
        assert!(fs::read_to_string(&route).unwrap().contains(&format!("routeName=\"{name}\"")), "{name}");
    }
}
