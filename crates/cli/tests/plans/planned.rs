//! Planned studies, and the files of `plan`.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use files::{Kind, TableReader};
use serde_json::Value;
use tempfile::TempDir;

use crate::support::*;

pub const PLAN: &str =
    "plan --vessel vessel.toml --trajectories dictionary.parquet --config plan.toml --out plan.json";

/// The files that `plan` writes.
pub const PLANNED: [&str; 10] = [
    "plan.json",
    "track.parquet",
    "track.geojson",
    "route.rtz",
    "route.gpx",
    "route.plan",
    "aborts.gpx",
    "aborts.geojson",
    "map.json",
    "map.svg",
];

/// A plan of two maneuvers around an island, which is fast.
pub const SMALL: &str = r#"name = "small trial"
cell_m = 120.0
headings = 4
uncharted = "water"
maneuver = [{ name = "zig-zag-steep", count = 1 }, { name = "sway-zig-zag", count = 1 }]

[area]
west_deg = 24.98
south_deg = 59.99
east_deg = 25.02
north_deg = 60.01

[[chart]]
file = "land.geojson"
kind = "land"

[hull]
length_m = 30.0
beam_m = 8.0

[safety]
margin_m = 20.0
unknown_current_m_s = 0.05
runs = 4

[handling]
turn_rate_rad_s = 0.05
crawl_m_s = 0.5
acceleration_m_s2 = 0.05
response_s = 30.0
lookahead_m = 60.0

[[speed_mode]]
name = "half"
speed_m_s = 1.5

[start]
longitude_deg = 24.985
latitude_deg = 60.0
heading_deg = 0.0

[goal]
kind = "home"

[cost]
primary = "basic-moves"
secondary = "seconds"
"#;

/// An island in the middle of the small study.
pub const ISLAND: &str = r#"{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {}, "geometry":
    {"type": "Polygon", "coordinates": [[[24.998, 59.999], [25.002, 59.999], [25.002, 60.001], [24.998, 60.001], [24.998, 59.999]]]}}]}"#;

static WRITTEN_SMALL: LazyLock<Study> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    for name in WRITTEN {
        fs::copy(repository().join("pipelines/helsinki").join(name), folder.path().join(name)).unwrap();
    }
    fs::copy(repository().join(ZIG_ZAGS), folder.path().join("dictionary.toml")).unwrap();
    put(&folder, "plan.toml", SMALL);
    put(&folder, "land.geojson", ISLAND);
    run(&folder, DICTIONARY).succeeds();
    Study::of(&folder)
});

/// A new folder with everything that the small study starts from.
pub fn small() -> TempDir {
    WRITTEN_SMALL.with(&["plan.toml", "land.geojson", "dictionary.parquet"])
}

/// [`small`] with `from` turned into `to` in plan.toml.
pub fn small_with(changes: &[(&str, &str)]) -> TempDir {
    let folder = small();
    changes.iter().for_each(|(from, to)| edit(&folder, "plan.toml", from, to));
    folder
}

/// Plans the small study with changes.
pub fn plan_small(changes: &[(&str, &str)]) -> Planned {
    let folder = small_with(changes);
    run(&folder, PLAN).succeeds();
    Planned::of(&folder)
}

/// The small study, planned.
pub fn small_planned() -> &'static Planned {
    static PLANNED: LazyLock<Planned> = LazyLock::new(|| plan_small(&[]));
    &PLANNED
}

/// The trial off Helsinki, with 8 and with 4 headings.
pub fn helsinki_planned() -> [&'static Planned; 2] {
    static PLANNED: [LazyLock<Planned>; 2] =
        [LazyLock::new(|| helsinki("plan.toml")), LazyLock::new(|| helsinki("plan-4-headings.toml"))];
    [&PLANNED[0], &PLANNED[1]]
}

fn helsinki(config: &str) -> Planned {
    let folder = small();
    let repository = repository();
    for below in ["pipelines/helsinki", "fixtures/charts"] {
        fs::create_dir_all(folder.path().join(below)).unwrap();
    }
    for file in [&format!("pipelines/helsinki/{config}"), HELSINKI_LAND] {
        fs::copy(repository.join(file), folder.path().join(file)).unwrap();
    }
    fs::copy(repository.join("pipelines/helsinki/dictionary.toml"), folder.path().join("dictionary.toml"))
        .unwrap();
    run(&folder, DICTIONARY).succeeds();
    let line =
        PLAN.replace("plan.toml", &format!("pipelines/helsinki/{config} --dictionary dictionary.toml"));
    run(&folder, &line).succeeds();
    Planned::of(&folder)
}

/// Maneuvers by tables of inputs.
pub const ZIG_ZAGS: &str = "fixtures/dictionaries/dictionary-zig-zags.toml";

pub const HELSINKI_LAND: &str = "fixtures/charts/helsinki_land_gshhg.geojson";

/// A plan with its files.
pub struct Planned {
    pub study: Study,
    /// `data` of plan.json.
    pub plan: Value,
    pub track: Track,
}

impl Planned {
    /// Reads the plan in `folder`.
    pub fn of(folder: &TempDir) -> Self {
        Self {
            study: Study::of(folder),
            plan: json(folder, "plan.json")["data"].take(),
            track: Track::read(&folder.path().join("track.parquet")),
        }
    }

    pub fn text(&self, name: &str) -> &str {
        std::str::from_utf8(self.study.bytes(name)).unwrap()
    }

    pub fn voyage(&self) -> &Value {
        &self.plan["voyage"]
    }

    pub fn legs(&self) -> &[Value] {
        self.voyage()["legs"].as_array().unwrap()
    }

    pub fn steps(&self) -> &[Value] {
        self.plan["steps"].as_array().unwrap()
    }

    /// Number of turns.
    pub fn turns(&self) -> usize {
        self.steps().iter().filter(|s| s["action"].as_str().unwrap().starts_with("turn-")).count()
    }

    pub fn number(&self, pointer: &str) -> f64 {
        self.plan.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("no number {pointer}"))
    }
}

/// `track.parquet`, one entry per row.
pub struct Track {
    pub step: Vec<i32>,
    pub informative: Vec<bool>,
    pub maneuver: Vec<String>,
    pub t: Vec<f64>,
    /// North, east, heading.
    pub pose: Vec<[f64; 3]>,
    /// u, v, r.
    pub state: Vec<[f64; 3]>,
    /// Longitude, latitude.
    pub place: Vec<[f64; 2]>,
    /// One row fewer.
    pub inputs: Vec<[f64; 3]>,
}

const COLUMNS: [(&str, &str, Kind, bool); 15] = [
    ("step", "1", Kind::I32, false),
    ("maneuver", "1", Kind::Text, false),
    ("informative", "1", Kind::I32, false),
    ("t", "s", Kind::F64, false),
    ("x", "m", Kind::F64, false),
    ("y", "m", Kind::F64, false),
    ("psi", "rad", Kind::F64, false),
    ("u", "m/s", Kind::F64, false),
    ("v", "m/s", Kind::F64, false),
    ("r", "rad/s", Kind::F64, false),
    ("longitude", "deg", Kind::F64, false),
    ("latitude", "deg", Kind::F64, false),
    ("tau1", "kN", Kind::F64, true),
    ("tau2", "kN", Kind::F64, true),
    ("tau3", "kN m", Kind::F64, true),
];

impl Track {
    fn read(path: &Path) -> Self {
        let reader = TableReader::open(path, "track", 1).unwrap();
        let found = reader.columns().iter().map(|c| (c.name.as_str(), c.unit.as_str(), c.kind, c.nullable));
        assert_eq!(found.collect::<Vec<_>>(), COLUMNS);
        assert_eq!(reader.blocks(), 1);
        let table = reader.read_block(0, &COLUMNS.map(|c| c.0)).unwrap();
        let rows = reader.rows();
        let float = |i: usize, row: usize| table.columns[i].value_at(row).unwrap();
        let row3 = |first: usize, row: usize| [0, 1, 2].map(|k| float(first + k, row));
        assert!((12..15).all(|i| table.columns[i].nulls() == 1 && table.columns[i].is_null(rows - 1)));
        Self {
            step: table.columns[0].as_i32().unwrap().to_vec(),
            informative: table.columns[2].as_i32().unwrap().iter().map(|i| *i == 1).collect(),
            maneuver: (0..rows).map(|row| table.columns[1].text_at(row).unwrap().to_owned()).collect(),
            t: (0..rows).map(|row| float(3, row)).collect(),
            pose: (0..rows).map(|row| row3(4, row)).collect(),
            state: (0..rows).map(|row| row3(7, row)).collect(),
            place: (0..rows).map(|row| [float(10, row), float(11, row)]).collect(),
            inputs: (0..rows - 1).map(|row| row3(12, row)).collect(),
        }
    }

    /// First row of every step, and the last row of all.
    pub fn starts(&self) -> Vec<usize> {
        let last = self.step.len() - 1;
        let begins = (0..last).filter(|row| *row == 0 || self.step[*row] != self.step[*row - 1]);
        begins.chain([last]).collect()
    }

    /// Rows of every informative maneuver.
    pub fn stretches(&self) -> Vec<std::ops::Range<usize>> {
        let mut found: Vec<std::ops::Range<usize>> = Vec::new();
        for row in (0..self.inputs.len()).filter(|row| self.informative[*row]) {
            match found.last_mut() {
                Some(range) if range.end == row && self.step[row] == self.step[row - 1] => range.end += 1,
                _ => found.push(row..row + 1),
            }
        }
        found
    }
}
