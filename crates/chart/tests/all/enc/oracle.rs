//! Cells with updates, against what GDAL reads of it (`scripts/independent/enc.py`).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use chart::enc::{CATCOV, DRVAL1, OBJNAM, VALDCO, VALSOU, VERCLR, WATLEV};
use chart::enc::{Cell, Feature, Geometry, Identity, Purpose, class_name};
use serde_json::Value;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A cell with its updates; `None`, with a message, if it is missing.
fn cell(base: &str, updates: usize) -> Option<Cell> {
    let base = root().join(base);
    let Ok(bytes) = std::fs::read(&base) else {
        println!("skipped: {} is not there", base.display());
        return None;
    };
    let mut cell = Cell::read(&bytes).unwrap();
    for number in 1..=updates {
        cell.update(&std::fs::read(base.with_extension(format!("{number:03}"))).unwrap()).unwrap();
    }
    Some(cell)
}

const CHESAPEAKE: &str = "../shared/data/charts/enc/US4MD81M.000";
const BAY: &str = "fixtures/charts/enc/ZZ5BAY01.000";

/// The compared properties of a class.
#[derive(Default)]
struct Summary {
    counts: BTreeMap<&'static str, u64>,
    sum: [f64; 3],
    length_deg: f64,
    area_deg2: f64,
    /// South-western and north-eastern corner.
    corners: Option<[[f64; 2]; 2]>,
    numbers: BTreeMap<&'static str, (u64, f64)>,
    codes: BTreeMap<(&'static str, String), u64>,
}

fn length(line: &[[f64; 2]]) -> f64 {
    line.windows(2).map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1])).sum()
}

fn area(ring: &[[f64; 2]]) -> f64 {
    let o = ring[0];
    let about = |p: [f64; 2], q: [f64; 2]| (p[0] - o[0]) * (q[1] - o[1]) - (q[0] - o[0]) * (p[1] - o[1]);
    ring.windows(2).map(|w| about(w[0], w[1])).sum::<f64>().abs() / 2.0
}

impl Summary {
    fn count(&mut self, what: &'static str, by: usize) {
        *self.counts.entry(what).or_default() += by as u64;
    }

    fn extend(&mut self, places: &[[f64; 2]]) {
        for place in places {
            let own = self.corners.get_or_insert([*place, *place]);
            own[0] = [0, 1].map(|k: usize| own[0][k].min(place[k]));
            own[1] = [0, 1].map(|k: usize| own[1][k].max(place[k]));
        }
    }

    fn take(&mut self, feature: &Feature) {
        self.count("features", 1);
        for own in [VALSOU, DRVAL1, VALDCO, VERCLR] {
            if let Some(value) = feature.number(own).unwrap() {
                let entry = self.numbers.entry(own.1).or_default();
                *entry = (entry.0 + 1, entry.1 + value);
            }
        }
        for (code, name) in [WATLEV, CATCOV] {
            if let Some(value) = feature.attributes.get(&code).filter(|v| !v.is_empty()) {
                *self.codes.entry((name, value.clone())).or_default() += 1;
            }
        }
        match &feature.geometry {
            Geometry::None => {}
            Geometry::Points(points) => {
                self.count("points", 1);
                self.count("places", points.len());
                points.iter().for_each(|p| (0..2).for_each(|k| self.sum[k] += p[k]));
                self.extend(points);
            }
            Geometry::Soundings(points) => {
                self.count("points", 1);
                self.count("places", points.len());
                points.iter().for_each(|p| (0..3).for_each(|k| self.sum[k] += p[k]));
                points.iter().for_each(|p| self.extend(&[[p[0], p[1]]]));
            }
            Geometry::Lines(lines) => {
                self.count("lines", 1);
                self.length_deg += lines.iter().map(|line| length(line)).sum::<f64>();
                lines.iter().for_each(|line| self.extend(line));
            }
            Geometry::Area(polygons) => {
                self.count("areas", 1);
                for rings in polygons {
                    self.count("holes", rings.len() - 1);
                    self.area_deg2 += area(&rings[0]) - rings[1..].iter().map(|r| area(r)).sum::<f64>();
                    rings.iter().for_each(|ring| self.extend(ring));
                }
            }
        }
    }

    fn agrees(&self, class: &str, expected: &Value) {
        let number = |value: &Value| value.as_f64().unwrap_or(0.0);
        let near = |what: &str, found: f64, expected: &Value| {
            let scale = number(expected).abs().max(1e-3);
            assert!((found - number(expected)).abs() <= 1e-9 * scale, "{class} {what}: {found} {expected}");
        };
        for what in ["features", "points", "lines", "areas", "holes", "places"] {
            let found = self.counts.get(what).copied().unwrap_or(0);
            assert_eq!(found, expected[what].as_u64().unwrap_or(0), "{class} {what}");
        }
        near("length", self.length_deg, &expected["length_deg"]);
        near("area", self.area_deg2, &expected["area_deg2"]);
        (0..3).for_each(|k| near("sum", self.sum[k], &expected["sum"][k]));
        for (k, corner) in self.corners.iter().flatten().flatten().enumerate() {
            near("box", *corner, &expected["box"][k]);
        }
        for (name, value) in expected["numbers"].as_object().into_iter().flatten() {
            let (count, sum) = self.numbers.get(&**name).copied().unwrap_or_default();
            assert_eq!(Some(count), value["count"].as_u64(), "{class} {name}");
            near(name, sum, &value["sum"]);
        }
        for (name, value) in expected["codes"].as_object().into_iter().flatten() {
            for (value, count) in value.as_object().into_iter().flatten() {
                let own = self.codes.iter().find(|((n, v), _)| n == name && v == value).map(|(_, c)| *c);
                assert_eq!(own, count.as_u64(), "{class} {name} {value}");
            }
        }
    }
}

#[track_caller]
fn agrees(cell: &Cell, oracle: &str) {
    let expected = std::fs::read(root().join("fixtures/oracle").join(oracle)).unwrap();
    let expected: Value = serde_json::from_slice(&expected).unwrap();
    let mut classes: BTreeMap<&str, Summary> = BTreeMap::new();
    for feature in cell.features().unwrap() {
        classes.entry(class_name(feature.class).unwrap()).or_default().take(&feature);
    }
    let expected = expected["classes"].as_object().unwrap();
    let found: Vec<&str> = classes.keys().copied().collect();
    assert_eq!(found, expected.keys().map(String::as_str).collect::<Vec<_>>());
    classes.iter().for_each(|(class, summary)| summary.agrees(class, &expected[*class]));
}

#[test]
fn oracle_a_whole_cell_with_updates_is_what_gdal_reads() {
    let Some(cell) = cell(CHESAPEAKE, 3) else { return };
    agrees(&cell, "enc.json");
    let identity = Identity {
        purpose: Purpose::Base,
        name: "US4MD81M.000".into(),
        edition: "31".into(),
        update: 3,
        issued: "20250923".into(),
    };
    assert_eq!((cell.identity(), cell.scale()), (&identity, 80_000));
}

#[test]
fn oracle_every_kind_of_update_is_what_gdal_makes_of_it() {
    agrees(&cell(BAY, 2).unwrap(), "enc_bay.json");
}

#[test]
fn text_is_read_in_latin_letters_and_in_national_ones() {
    let features = cell(BAY, 2).unwrap().features().unwrap();
    let island = features.iter().find(|f| f.class == chart::enc::class("LNDARE").unwrap()).unwrap();
    let text = |code: u16| island.attributes[&code].as_str();
    assert_eq!((text(OBJNAM.0), text(301)), ("Träholm", "Träholmen"));
    assert_eq!((island.id.as_str(), &island.position_quality[..]), ("65535-1005-1", &[4][..]));
}
