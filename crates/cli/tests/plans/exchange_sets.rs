//! Plans on cells in practice: updates anywhere in an exchange set, catalogues with checksums, whole folders.

use std::fs;
use std::path::{Path, PathBuf};

use chart::{Bounds, Plane};
use files::{Budget, Provenance};
use serde_json::Value;
use study::plan::{Means, PlanFile, read_charts};
use tempfile::TempDir;

use crate::made::catalogue;
use crate::planned::*;
use crate::support::*;

const OWN_CHART: &str = "file = \"land.geojson\"\nkind = \"land\"";
const STEM: &str = "ZZ5BAY01";

/// A file of the bay's cell.
fn of_bay(suffix: &str) -> Vec<u8> {
    fs::read(repository().join("fixtures/charts/enc").join(format!("{STEM}.{suffix}"))).unwrap()
}

/// The file with all places of `from` changed into `to`, of the same length.
fn changed(mut file: Vec<u8>, from: &[u8], to: &[u8]) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    while let Some(at) = file.windows(from.len()).position(|w| w == from) {
        file[at..at + to.len()].copy_from_slice(to);
    }
    file
}

/// The small study of a ship that needs `depth_m`, on a chart.
fn study_on(chart: &str, depth_m: f64) -> TempDir {
    let depths = format!("margin_m = 20.0\ntransit_depth_m = {depth_m:?}\ntrial_depth_m = {depth_m:?}");
    small_with(&[(OWN_CHART, &format!("file = \"{chart}\"")), ("margin_m = 20.0", &depths)])
}

/// The same that starts over the wreck that has 30 m over it, and 7.5 m after update 1.
fn over_the_wreck(chart: &str) -> TempDir {
    let folder = study_on(chart, 8.0);
    edit(
        &folder,
        "plan.toml",
        "longitude_deg = 24.985\nlatitude_deg = 60.0",
        "longitude_deg = 25.012\nlatitude_deg = 59.996",
    );
    folder
}

fn stand(folder: &TempDir, place: &str, bytes: &[u8]) {
    let path = folder.path().join(place);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, bytes).unwrap();
}

/// Cell and updates, each in the folder of `place`.
fn bay_in(folder: &TempDir, place: impl Fn(usize) -> String) {
    for (number, suffix) in ["000", "001", "002"].into_iter().enumerate() {
        stand(folder, &format!("{}{STEM}.{suffix}", place(number)), &of_bay(suffix));
    }
}

/// The bay as an exchange set, in the folders of the standard, with its catalogue; files as `change` leaves them.
fn exchange_set(folder: &TempDir, change: impl Fn(&str, Vec<u8>) -> Vec<u8>) {
    let mut listed = vec![("CATALOG.031".to_owned(), String::new())];
    for suffix in ["000", "001", "002"] {
        let number = suffix.trim_start_matches("00");
        let whole = of_bay(suffix);
        listed.push((
            format!("US\\{STEM}\\2\\{number}\\{STEM}.{suffix}"),
            format!("{:08X}", chart::enc::crc(&whole)),
        ));
        stand(folder, &format!("ENC_ROOT/US/{STEM}/2/{number}/{STEM}.{suffix}"), &change(suffix, whole));
    }
    let listed: Vec<(&str, &str)> = listed.iter().map(|(file, crc)| (file.as_str(), crc.as_str())).collect();
    stand(folder, "ENC_ROOT/CATALOG.031", &catalogue(&listed));
}

const IN_SET: &str = "ENC_ROOT/US/ZZ5BAY01/2/0/ZZ5BAY01.000";

/// The notes on the first chart of a plan.
fn notes(folder: &TempDir) -> String {
    let chart = &Planned::of(folder).plan["charts"][0];
    chart["notes"].as_array().into_iter().flatten().filter_map(Value::as_str).collect::<Vec<_>>().join("; ")
}

/// A stream of choices.
struct Draw(u64);

impl Draw {
    fn of(&mut self, most: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % most
    }

    fn yes(&mut self) -> bool {
        self.of(2) == 1
    }
}

/// Updates are applied wherever they are: the ship does not start over the wreck.
#[test]
fn law_a_shoal_of_an_update_is_seen_wherever_the_update_stands() {
    for seed in 0..25 {
        let mut draw = Draw(seed);
        let root = ["", "charts/", "ENC_ROOT/", "enc_root/", "Enc_Root/"][draw.of(5)];
        let cell = if draw.yes() { STEM.to_owned() } else { STEM.to_lowercase() };
        let (agency, layout, lower) = (["", "US/", "zz/"][draw.of(3)], draw.of(4), draw.yes());
        let place = |number: usize| match layout {
            0 => root.to_owned(),
            1 if number == 0 => root.to_owned(),
            1 => format!("{root}{number}/"),
            2 => format!("{root}{agency}{cell}/2/{number}/"),
            _ if number == 0 => format!("{root}{agency}{cell}/"),
            _ => format!("{root}{agency}{cell}/{number}/"),
        };
        let named = |number: usize| {
            let name = format!("{STEM}.00{number}");
            if lower && (number != 0 || draw.0.is_multiple_of(3)) { name.to_lowercase() } else { name }
        };
        let files: Vec<String> = (0..3).map(|number| place(number) + &named(number)).collect();
        let in_set = root.eq_ignore_ascii_case("enc_root/");
        let chart = match draw.of(3) {
            0 if !root.is_empty() => root.trim_end_matches('/').to_owned(),
            1 if in_set => format!("{root}Catalog.031"),
            _ => files[0].clone(),
        };
        let folder = over_the_wreck(&chart);
        for (number, file) in files.iter().enumerate() {
            stand(&folder, file, &of_bay(&format!("00{number}")));
        }
        if in_set {
            let listed: Vec<(String, String)> = (0..3)
                .map(|k| {
                    (
                        files[k][root.len()..].replace('/', "\\"),
                        format!("{:08x}", chart::enc::crc(&of_bay(&format!("00{k}")))),
                    )
                })
                .collect();
            let listed: Vec<(&str, &str)> = listed.iter().map(|(file, crc)| (&**file, &**crc)).collect();
            stand(&folder, &format!("{root}catalog.031"), &catalogue(&listed));
        }
        // Next to it: another cell, its update, an update of an older edition, and one of the updates once more.
        let other = |suffix: &str| {
            changed(changed(of_bay(suffix), STEM.as_bytes(), b"ZZ5BAY99"), b"7.5\x1f", b"9.5\x1f")
        };
        stand(&folder, &format!("{root}NL/ZZ5BAY99/ZZ5BAY99.000"), &other("000"));
        stand(&folder, &format!("{root}NL/ZZ5BAY99/1/ZZ5BAY99.001"), &other("001"));
        if !in_set && layout < 2 {
            let older = changed(of_bay("001"), b".001\x1f2\x1f", b".001\x1f1\x1f");
            stand(&folder, &format!("{root}old/{STEM}.001"), &older);
            stand(&folder, &format!("{root}again/{STEM}.002"), &of_bay("002"));
        }
        run(&folder, PLAN).refuses(4, &["start", "m away"]);
    }
}

#[test]
fn without_its_updates_the_same_start_is_planned_and_that_is_said() {
    let folder = over_the_wreck("ZZ5BAY01.000");
    stand(&folder, "ZZ5BAY01.000", &of_bay("000"));
    let told = run(&folder, PLAN).succeeds();
    for piece in
        ["no updates found beside ZZ5BAY01.000", "no CATALOG.031", "depths below lowest astronomical tide"]
    {
        assert!(told.stderr.contains(piece), "{piece}: {told}");
    }
    let chart = &Planned::of(&folder).plan["charts"][0];
    assert_eq!(chart["sounding_datum"], "lowest astronomical tide");
    assert_eq!(chart["vertical_datum"], "mean sea level");
    assert!(notes(&folder).contains("no updates found beside ZZ5BAY01.000"), "{}", notes(&folder));
}

#[test]
fn an_exchange_set_is_named_by_its_cell_its_folder_or_its_catalogue() {
    for chart in [IN_SET, "ENC_ROOT", "enc_root/catalog.031", "ENC_ROOT/CATALOG.031"] {
        let folder = study_on(chart, 6.0);
        exchange_set(&folder, |_, bytes| bytes);
        if chart == "enc_root/catalog.031" {
            fs::rename(folder.path().join("ENC_ROOT"), folder.path().join("enc_root")).unwrap();
        }
        run(&folder, PLAN).succeeds();
        let chart = &Planned::of(&folder).plan["charts"][0];
        assert_eq!((chart["file"].as_str(), chart["update"].as_u64()), (Some("ZZ5BAY01.000"), Some(2)));
        assert!(notes(&folder).contains("all 3 files agree with CATALOG.031"), "{}", notes(&folder));
    }
}

#[test]
fn what_a_catalogue_lists_and_is_not_there_is_refused_by_name() {
    let folder = study_on(IN_SET, 6.0);
    exchange_set(&folder, |_, bytes| bytes);
    fs::remove_file(folder.path().join("ENC_ROOT/US/ZZ5BAY01/2/2/ZZ5BAY01.002")).unwrap();
    refused(&folder, 3, PLAN, &["CATALOG.031", "US/ZZ5BAY01/2/2/ZZ5BAY01.002", "which it lists"]);
}

#[test]
fn an_update_that_is_there_twice_is_refused_unless_both_are_the_same() {
    let folder = study_on("ZZ5BAY01.000", 6.0);
    bay_in(&folder, |_| String::new());
    stand(&folder, "again/ZZ5BAY01.001", &of_bay("001"));
    run(&folder, PLAN).succeeds();
    let other = changed(of_bay("001"), b"\x1f7.5", b"\x1f9.5");
    stand(&folder, "again/ZZ5BAY01.001", &changed(other, b"7.5\x1f", b"9.5\x1f"));
    fs::remove_file(folder.path().join("plan.json")).unwrap();
    run(&folder, PLAN).refuses(3, &["again/ZZ5BAY01.001", "another update 1", "ZZ5BAY01.001"]);
}

#[test]
fn other_editions_are_said_or_refused_if_they_are_newer() {
    let folder = study_on("ZZ5BAY01.000", 6.0);
    bay_in(&folder, |_| String::new());
    let of_edition = |suffix: &str, edition: u8| {
        let [from, to] = [b'2', edition].map(|e| [b".", suffix.as_bytes(), &[0x1f, e, 0x1f]].concat());
        changed(of_bay(suffix), &from, &to)
    };
    stand(&folder, "old/ZZ5BAY01.000", &of_edition("000", b'1'));
    stand(&folder, "old/ZZ5BAY01.001", &of_edition("001", b'1'));
    run(&folder, PLAN).succeeds();
    for piece in [
        "1 updates of edition 1 not applied to edition 2",
        "another base cell (edition 1, update 0) not used",
    ] {
        assert!(notes(&folder).contains(piece), "{}", notes(&folder));
    }
    stand(&folder, "new/ZZ5BAY01.000", &of_edition("000", b'3'));
    run(&folder, PLAN).refuses(3, &["ZZ5BAY01.000", "new/ZZ5BAY01.000 with edition 3", "newest"]);
    // A folder names the newest.
    edit(&folder, "plan.toml", "file = \"ZZ5BAY01.000\"", "file = \".\"");
    run(&folder, PLAN).succeeds();
    assert_eq!(Planned::of(&folder).plan["charts"][0]["edition"], "3");
    stand(&folder, "cancelled/ZZ5BAY01.003", &changed(of_edition("001", b'0'), b".001", b".003"));
    run(&folder, PLAN).refuses(3, &["ZZ5BAY01.003", "cancellation"]);
}

#[cfg(unix)]
#[test]
fn links_are_not_followed() {
    let folder = study_on("bay/ZZ5BAY01.000", 6.0);
    stand(&folder, "bay/ZZ5BAY01.000", &of_bay("000"));
    stand(&folder, "elsewhere/ZZ5BAY01.001", &of_bay("001"));
    std::os::unix::fs::symlink("../elsewhere", folder.path().join("bay/1")).unwrap();
    run(&folder, PLAN).succeeds();
    assert!(notes(&folder).contains("1 folders not looked into"), "{}", notes(&folder));
    std::os::unix::fs::symlink("../elsewhere/ZZ5BAY01.001", folder.path().join("bay/ZZ5BAY01.001")).unwrap();
    run(&folder, PLAN).refuses(3, &["bay/ZZ5BAY01.001", "a link"]);
}

#[test]
fn a_folder_without_a_cell_is_refused() {
    let folder = study_on("empty", 6.0);
    fs::create_dir(folder.path().join("empty")).unwrap();
    refused(&folder, 3, PLAN, &["empty", "no cell in it or below"]);
}

/// Damage anywhere in a cell or its updates is seen by the checksums of the catalogue.
#[test]
fn law_damage_inside_records_is_seen_where_there_is_a_catalogue() {
    let folder = study_on(IN_SET, 6.0);
    exchange_set(&folder, |_, bytes| bytes);
    let config: PlanFile =
        toml::from_str(&fs::read_to_string(folder.path().join("plan.toml")).unwrap()).unwrap();
    let budget = Budget::new(None);
    let (plane, bounds) = (Plane::new(25.0, 60.0).unwrap(), Bounds::new([-1e4; 2], [1e4; 2]).unwrap());
    let means = Means { area: (&plane, &bounds), budget: &budget, keep_going: &|| true };
    let read = || {
        let mut provenance = Provenance::default();
        read_charts(&folder.path().join("plan.toml"), &config, &means, &mut provenance).map(|_| ())
    };
    read().unwrap();
    let mut draw = Draw(540);
    for case in 0..540 {
        let number = case % 3;
        let path: PathBuf = folder.path().join(format!("ENC_ROOT/US/{STEM}/2/{number}/{STEM}.00{number}"));
        let whole = fs::read(&path).unwrap();
        let mut own = whole.clone();
        for _ in 0..=draw.of(4) {
            let at = draw.of(own.len());
            own[at] ^= 1 << draw.of(8);
        }
        fs::write(&path, &own).unwrap();
        let found = read();
        assert!(own == whole || found.is_err(), "case {case} was read");
        fs::write(&path, whole).unwrap();
    }
}

/// A charted turbine in the water, 14 m from the start: not on land, so it is in the way.
#[test]
fn a_turbine_beside_the_start_is_in_the_way_and_one_on_land_is_not() {
    let feature = |code: u16, properties: &str, geometry: String| {
        format!(
            "{{\"type\": \"Feature\", \"properties\": {{\"OBJL\": {code}{properties}}}, \"geometry\": {geometry}}}"
        )
    };
    let area = |[west, south, east, north]: [f64; 4]| {
        let ring = [[west, south], [east, south], [east, north], [west, north], [west, south]];
        format!("{{\"type\": \"Polygon\", \"coordinates\": [{ring:?}]}}")
    };
    let point = |place: [f64; 2]| format!("{{\"type\": \"Point\", \"coordinates\": {place:?}}}");
    let chart = |turbine: [f64; 2]| {
        let all = [
            feature(42, ", \"DRVAL1\": 20.0", area([24.9, 59.9, 25.1, 60.1])),
            feature(71, "", area([24.998, 59.999, 25.002, 60.001])),
            feature(74, ", \"CATLMK\": [\"19\"]", point(turbine)),
        ];
        format!("{{\"type\": \"FeatureCollection\", \"features\": [{}]}}", all.join(", "))
    };
    let folder = study_on("objects.geojson\"\nkind = \"objects", 6.0);
    put(&folder, "objects.geojson", &chart([24.985_25, 60.0]));
    refused(&folder, 4, PLAN, &["start", "m away"]);
    put(&folder, "objects.geojson", &chart([25.0, 60.0]));
    let told = run(&folder, PLAN).succeeds();
    assert!(told.stderr.contains("ignored 1 LNDMRK (on land)"), "{told}");
    let class = Planned::of(&folder).plan["charts"][0]["classes"]["LNDMRK"].clone();
    assert_eq!((&class["ignored"], &class["reasons"]["on land"]), (&1.into(), &1.into()));
}

/// The refusal of a missing file says where it was searched.
#[test]
fn a_cell_that_is_not_there_is_refused_as_before() {
    let folder = study_on("ZZ5BAY01.000", 6.0);
    assert!(!Path::new(&folder.path().join("ZZ5BAY01.000")).exists());
    refused(&folder, 1, PLAN, &["ZZ5BAY01.000", "an existing file"]);
}
