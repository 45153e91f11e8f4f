//! `ingest.toml`: what is in measured logs.

mod check;
pub mod read;
pub mod recordings;

use std::fmt::Write;
use std::path::Path;

use files::{Digest, Error, Provenance, exists, read_document};
use logs::{
    Body, Conventions, Cut, Derived, FileSpec, ForceTable, Formula, Frame, Heading, Interval, Law, Lever,
    ManeuverKind, Method, Naming, NonMonotonic, Propulsor, Segmentation, Setup, Source, SpeedClasses,
    Template, Thruster,
};
use refusal::Invalid;
use schemars::{JsonSchema, schema_for};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::documents::{SIMULATED_FILE, SimulatedLogsDocument};
use crate::tables::trajectories::DataLabel;

/// `ingest.toml` as written.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IngestFile {
    /// Name of the design that the runs belong to.
    #[serde(default = "measured")]
    pub design: String,
    /// The common rate \[Hz\].
    #[schemars(range(min = 1e-6, max = 1e6))]
    pub sample_rate_hz: f64,
    /// Channels are not interpolated over longer gaps: the recording is split there \[s\].
    #[schemars(range(min = 1e-9, max = 1e9))]
    pub max_gap_s: f64,
    /// Every channel is averaged over this long before it is resampled \[s\].
    #[schemars(range(min = 1e-9, max = 1e5))]
    pub average_s: Option<f64>,
    /// What to do where time goes backwards.
    #[serde(default)]
    pub non_monotonic: NonMonotonic,
    /// The speed that the ship does not exceed \[m/s\]: faster ones, and places that it would not get to, are left out.
    #[serde(default = "thirty")]
    #[schemars(range(min = 1e-6, max = 1e4))]
    pub max_speed_m_s: f64,
    /// Axes of `x` and `y`.
    #[serde(default)]
    pub frame: Frame,
    /// How `psi` counts, if not as in `frame`.
    pub heading: Option<Heading>,
    /// Axes of `y_u`, `y_v`, `y_r`.
    #[serde(default)]
    pub body: Body,
    /// The antenna, or whatever positions and velocities were measured at, from the reference point: forward, to starboard
    /// \[m\].
    #[serde(default)]
    #[schemars(inner(range(min = -1e4, max = 1e4)))]
    pub antenna_m: [f64; 2],
    /// What the trajectories' positions and velocities are those of, in words.
    pub reference_point: Option<String>,
    /// How velocities are made from positions.
    #[serde(default)]
    pub velocities: VelocitySpec,
    /// Files, one group per kind of file.
    pub file: Vec<FileSpec>,
    /// Computed channels.
    #[serde(default)]
    pub derived: Vec<DerivedSpec>,
    /// Thrusters, whose forces make up `tau1`, `tau2`, `tau3`.
    #[serde(default)]
    pub thruster: Vec<ThrusterSpec>,
    /// The maneuver of all recordings.
    pub maneuver: Option<String>,
    /// Template that finds `{kind}` in a file's name, or in its path where the template has a `/`.
    pub maneuver_from_file: Option<String>,
    /// Sub-experiments are windows of this length \[s\] …
    #[schemars(range(min = 1e-6, max = 1e7))]
    pub window_s: Option<f64>,
    /// … what is left at the end of a stretch being a last, shorter one if it is this long \[s\], a quarter of `window_s` if
    /// that is not said …
    #[schemars(range(min = 1e-9, max = 1e7))]
    pub tail_s: Option<f64>,
    /// … named by kind and class of mean speed, with these bounds \[m/s\].
    #[serde(default)]
    #[schemars(extend("items" = {"type": "number", "exclusiveMinimum": 0, "maximum": 1e3}))]
    pub speed_classes_m_s: Vec<f64>,
    /// Names of the speed classes, one more than bounds.
    pub speed_class_names: Option<Vec<String>>,
    /// Sub-experiments by time.
    #[serde(default)]
    pub segment: Vec<Interval>,
    /// Shorter sub-experiments are left out \[s\].
    #[schemars(range(min = 1e-9, max = 1e9))]
    pub min_s: Option<f64>,
    /// Whether every sub-experiment becomes a run of its own.
    #[serde(default)]
    pub each_segment_is_a_run: bool,
}

fn measured() -> String {
    "measured".to_owned()
}

fn thirty() -> f64 {
    30.0
}

/// A channel computed from others.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DerivedSpec {
    /// Its name.
    pub channel: String,
    /// A product, such as `negative(n)` or `-1 wind^2 cos(gamma)`, or a sum or difference of such: `left - right`.
    pub formula: String,
    /// Its unit.
    pub unit: String,
}

/// How velocities are made from positions.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct VelocitySpec {
    /// Explicit Euler differences, or slopes of local parabolas.
    pub method: Method,
    /// Length of the parabolas \[s\]; also of those that measured velocities are compared with.
    #[schemars(range(min = 1e-6, max = 1e5))]
    pub window_s: f64,
}

impl Default for VelocitySpec {
    fn default() -> Self {
        Self { method: Method::default(), window_s: 1.0 }
    }
}

/// A thruster. Axes: x forward, y starboard, z down. It has a coefficient or a table.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum ThrusterSpec {
    /// Turns about the vertical.
    Azimuth {
        /// Channel of its speed.
        speed: String,
        /// Channel of its angle: where it pushes, from forward to starboard.
        angle: String,
        /// Channel of its pitch, for a table over pitches.
        pitch: Option<String>,
        /// Force per speed squared, or per speed \[N\].
        #[schemars(range(min = -1e12, max = 1e12))]
        coefficient: Option<f64>,
        /// Force from speed.
        #[serde(default)]
        law: Law,
        /// Force from speed, and pitch.
        table: Option<TableSpec>,
        /// Forward and to starboard of the reference point \[m\].
        #[schemars(inner(range(min = -1e4, max = 1e4)))]
        position_m: [f64; 2],
    },
    /// Pushes to starboard for positive speed.
    Tunnel {
        /// Channel of its speed.
        speed: String,
        /// Channel of its pitch, for a table over pitches.
        pitch: Option<String>,
        /// Force per speed squared, or per speed \[N\].
        #[schemars(range(min = -1e12, max = 1e12))]
        coefficient: Option<f64>,
        /// Force from speed.
        #[serde(default)]
        law: Law,
        /// Force from speed, and pitch.
        table: Option<TableSpec>,
        /// Forward and to starboard of the reference point \[m\].
        #[schemars(inner(range(min = -1e4, max = 1e4)))]
        position_m: [f64; 2],
    },
}

/// Forces of a thruster; between the places of a table they are interpolated linearly, beyond them there are none.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableSpec {
    /// Speeds, increasing \[1/s\].
    pub speed: Vec<f64>,
    /// Pitches, increasing, in the SI unit of their channel.
    pub pitch: Option<Vec<f64>>,
    /// The force at each speed \[N\], of a table without pitches.
    pub force: Option<Vec<f64>>,
    /// A row of forces for each pitch \[N\].
    pub forces: Option<Vec<Vec<f64>>>,
}

/// The rest at the end of a stretch is a window if it is longer than this fraction of one, by default.
const USUAL_TAIL: usize = 4;

impl IngestFile {
    /// The setup of the logs.
    ///
    /// # Errors
    /// A formula that cannot be parsed, a thruster with an invalid table.
    pub fn setup(&self) -> Result<Setup, Invalid> {
        let conventions = Conventions {
            frame: self.frame,
            heading: self.heading.unwrap_or(self.frame.heading()),
            body: self.body,
            lever: Lever(self.antenna_m),
            window_s: self.velocities.window_s,
            derived: self.derived.iter().map(derived).collect::<Result<_, _>>()?,
            thrusters: self.thruster.iter().cloned().map(thruster).collect::<Result<_, _>>()?,
            method: self.velocities.method,
            rate_hz: self.sample_rate_hz,
            average_s: self.average_s,
        };
        Ok(Setup {
            written_in: "ingest.toml",
            files: self.file.clone(),
            conventions,
            max_gap_s: self.max_gap_s,
            non_monotonic: self.non_monotonic,
            max_speed_m_s: self.max_speed_m_s,
        })
    }

    /// How recordings become runs.
    pub fn segmentation(&self) -> Segmentation {
        let cut = if self.file.iter().any(|file| file.label_column.is_some()) {
            Cut::Labels
        } else if let Some(window_s) = self.window_s {
            let samples = ((window_s * self.sample_rate_hz).round() as usize).max(1);
            let usual = samples.div_ceil(USUAL_TAIL);
            let tail = self.tail_s.map_or(usual, |tail_s| self.least_samples(tail_s).clamp(1, samples));
            Cut::Windows { samples, tail, classes: self.speed_classes() }
        } else if self.segment.is_empty() {
            Cut::Whole
        } else {
            Cut::Intervals(self.segment.clone())
        };
        let least = self.min_s.map_or(1, |min_s| self.least_samples(min_s));
        Segmentation { cut, least, each_is_a_run: self.each_segment_is_a_run }
    }

    /// Samples that take at least `seconds`.
    fn least_samples(&self, seconds: f64) -> usize {
        (seconds * self.sample_rate_hz - 1e-6).ceil() as usize
    }

    fn speed_classes(&self) -> Option<SpeedClasses> {
        let bounds_m_s = self.speed_classes_m_s.clone();
        let usual = || match bounds_m_s.len() {
            0 => None,
            1 => Some(["slow", "fast"].map(String::from).into()),
            _ => Some(["slow", "medium", "fast"].map(String::from).into()),
        };
        let names = self.speed_class_names.clone().or_else(usual)?;
        Some(SpeedClasses { bounds_m_s, names })
    }

    /// How recordings are identified by the names of their files.
    ///
    /// # Errors
    /// A template without its placeholder.
    pub fn naming(&self) -> Result<Naming, Invalid> {
        let recording = |file: &FileSpec| {
            file.run_from_file.as_deref().map(|text| template("run_from_file", text, "run")).transpose()
        };
        let kind = match (&self.maneuver_from_file, &self.maneuver) {
            (Some(text), _) => ManeuverKind::Named(template("maneuver_from_file", text, "kind")?),
            (None, Some(maneuver)) => ManeuverKind::Given(maneuver.clone()),
            (None, None) => ManeuverKind::Recording,
        };
        Ok(Naming { recordings: self.file.iter().map(recording).collect::<Result<_, _>>()?, kind })
    }
}

fn derived(spec: &DerivedSpec) -> Result<Derived, Invalid> {
    let formula = Formula::parse(&spec.formula).map_err(|malformed| {
        Invalid::new(
            format!("`formula` of channel `{}`", spec.channel),
            format!("`{}` with {malformed}", spec.formula),
            "a product such as `n |n|`, `negative(n)` or `-1 wind^2 cos(gamma)`",
            "write the formula again",
        )
    })?;
    Ok(Derived { channel: spec.channel.clone(), formula, unit: spec.unit.clone() })
}

fn thruster(spec: ThrusterSpec) -> Result<Propulsor, Invalid> {
    let (speed, angle, pitch, coefficient, law, spec, position_m) = match spec {
        ThrusterSpec::Azimuth { speed, angle, pitch, coefficient, law, table, position_m } => {
            (speed, Some(angle), pitch, coefficient, law, table, position_m)
        }
        ThrusterSpec::Tunnel { speed, pitch, coefficient, law, table, position_m } => {
            (speed, None, pitch, coefficient, law, table, position_m)
        }
    };
    let made = |law, coefficient, table| {
        let thruster = Thruster { law, coefficient, position_m };
        Propulsor { thruster, speed, angle, table }
    };
    let refused =
        |found: &str, expected, remedy| Err(Invalid::new("[[thruster]]", found.to_owned(), expected, remedy));
    match (coefficient, spec) {
        (Some(coefficient), None) if pitch.is_none() => Ok(made(law, coefficient, None)),
        (Some(_), None) => refused("a `pitch` without a table", "a table over pitches", "add it"),
        (None, Some(spec)) if pitch.is_some() == spec.pitch.is_some() => {
            // The table gives the force.
            Ok(made(Law::Linear, 1.0, Some((table(spec)?, pitch))))
        }
        (None, Some(_)) => refused(
            "`pitch` in the thruster or in its table alone",
            "the channel of the pitch, and pitches in the table",
            "add the other or remove it",
        ),
        (Some(_), Some(_)) | (None, None) => {
            refused("both or none of `coefficient` and `table`", "one of the two", "remove one or add one")
        }
    }
}

fn table(TableSpec { speed, pitch, force, forces }: TableSpec) -> Result<ForceTable, Invalid> {
    let forces = match (force, forces) {
        (Some(row), None) if pitch.is_none() => vec![row],
        (None, Some(rows)) if pitch.is_some() => rows,
        _ => {
            let given = "neither or both, or the wrong one, of `force` and `forces`";
            let expected = "`force`, or with pitches `forces`";
            return Err(Invalid::new("`table` of a thruster", given, expected, "correct it"));
        }
    };
    ForceTable::new(speed, pitch, forces)
}

/// The template under `key`, with the placeholder `part`.
fn template(key: &str, text: &str, part: &str) -> Result<Template, Invalid> {
    Template::new(text, part).ok_or_else(|| {
        let expected = format!("a template such as `{{{part}}}_*.csv`");
        Invalid::new(format!("`{key}`"), format!("`{text}`"), expected, format!("say where `{{{part}}}` is"))
    })
}

/// The label of the logs in `folder` if they are simulated: then each of `sources` must be unchanged, and its digest
/// is noted.
///
/// # Errors
/// A log that was changed, or that the document does not list.
pub fn simulated_label(
    folder: &Path,
    sources: &[Source],
    provenance: &mut Provenance,
) -> Result<Option<DataLabel>, Error> {
    let path = folder.join(SIMULATED_FILE);
    if !exists(&path) {
        return Ok(None);
    }
    let loaded = read_document::<SimulatedLogsDocument>(&path)?;
    for file in sources.iter().flat_map(|source| source.files.iter().flatten()) {
        let log = folder.join(file);
        let listed = loaded.data.recordings.iter().find(|recording| recording.file == *file);
        let expected = match listed {
            Some(recording) if recording.digest == Digest::of_file(&log)? => continue,
            Some(_) => "the log as it was simulated",
            None => "one of the logs that were simulated together",
        };
        let given = if listed.is_some() { "another digest" } else { "a log that is not listed" };
        let remedy = "simulate the logs again into an empty folder, or keep other logs elsewhere";
        let expected = format!("{expected}, as {} says", path.display());
        return Err(crate::refuse(&log, "simulated log", given, &expected, remedy));
    }
    provenance.made("simulated", &path, loaded.digest, &loaded.provenance)?;
    Ok(Some(loaded.data.label))
}

// All keys of `ingest.toml` as a JSON Schema and as a page, generated from the types that read it.

/// Tables of the file: their headers, and the definition with their keys.
const TABLES: [(&str, &str); 10] = [
    ("", ""),
    ("[velocities]", "VelocitySpec"),
    ("[[file]]", "FileSpec"),
    ("[file.time]", "TimeSpec"),
    ("[[file.channel]]", "ChannelSpec"),
    ("[[file.quaternion]]", "QuaternionSpec"),
    ("[[derived]]", "DerivedSpec"),
    ("[[thruster]]", "ThrusterSpec"),
    ("[thruster.table]", "TableSpec"),
    ("[[segment]]", "Interval"),
];

const HEAD: &str = "\
# Keys of ingest.toml

Written by `cargo run -q -p seatrial-cli --example write_schemas -- schemas` from the types that read the file; not to be edited. For editors
there is the same as a JSON Schema, [schemas/ingest-toml.schema.json](../schemas/ingest-toml.schema.json). [Your own
logs](own-logs.md) says what to do with them.
";

/// The page of all keys, docs/ingest-keys.md.
pub fn page() -> String {
    let schema = schema_for!(IngestFile).to_value();
    let mut page = HEAD.to_owned();
    for (heading, name) in TABLES {
        let table = if name.is_empty() { &schema } else { &schema["$defs"][name] };
        if !heading.is_empty() {
            let _ = write!(page, "\n## `{heading}`\n\n{}\n", text(table));
        }
        match table["oneOf"].as_array() {
            Some(variants) => variants.iter().for_each(|variant| {
                let kind = variant["properties"]["kind"]["const"].as_str().unwrap_or_default();
                let _ = write!(page, "\n`kind = \"{kind}\"`: {}\n", text(variant));
                keys(&mut page, variant, &schema);
            }),
            None => keys(&mut page, table, &schema),
        }
    }
    page
}

fn keys(page: &mut String, table: &Value, schema: &Value) {
    page.push_str("\n| key | takes | without it | meaning |\n|---|---|---|---|\n");
    let required: Vec<&str> =
        table["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    for (key, property) in table["properties"].as_object().unwrap_or(&Map::new()) {
        let without = match (required.contains(&key.as_str()), &property["default"]) {
            (true, _) => "refused".to_owned(),
            (false, Value::Null) => String::new(),
            (false, Value::Object(_)) => "as its keys say".to_owned(),
            (false, default) => format!("`{default}`"),
        };
        let _ =
            writeln!(page, "| `{key}` | {} | {without} | {} |", takes(key, property, schema), text(property));
    }
}

/// A description in one line, in a cell.
fn text(of: &Value) -> String {
    of["description"].as_str().unwrap_or_default().replace('\n', " ").replace('|', "\\|")
}

/// The values of `key`, in words.
fn takes(key: &str, property: &Value, schema: &Value) -> String {
    let name = |of: &Value| of["$ref"].as_str().and_then(|path| path.rsplit('/').next()).map(str::to_owned);
    if let Some(choices) = property["anyOf"].as_array() {
        return choices
            .iter()
            .find(|choice| choice["type"] != "null")
            .map_or(String::new(), |choice| takes(key, choice, schema));
    }
    if let Some(name) = name(property) {
        let heading =
            TABLES.iter().find(|(_, known)| *known == name).map(|(heading, _)| format!("`{heading}`"));
        return heading.unwrap_or_else(|| choices(&schema["$defs"][name.as_str()]));
    }
    let kind = match &property["type"] {
        Value::Array(kinds) => kinds[0].as_str(),
        kind => kind.as_str(),
    };
    match kind.unwrap_or_default() {
        "string" if property["maxLength"] == 1 => "a character".to_owned(),
        "string" if property["const"].is_string() => format!("`{}`", property["const"]),
        "string" => "text".to_owned(),
        "number" => refusal::bounds(key, property).unwrap_or("a number".to_owned()),
        "integer" => refusal::bounds(key, property).unwrap_or("a whole number".to_owned()),
        "boolean" => "`true` or `false`".to_owned(),
        "array" => match (property["minItems"].as_u64(), name(&property["items"])) {
            (_, Some(_)) => takes(key, &property["items"], schema),
            (Some(count), _) => format!("a list of {count} numbers"),
            _ => format!("a list: {}", takes(key, &property["items"], schema)),
        },
        _ => String::new(),
    }
}

/// The choices of a key, with their meanings if documented.
fn choices(of: &Value) -> String {
    let plain = of["enum"].as_array().into_iter().flatten();
    let documented = of["oneOf"].as_array().into_iter().flatten();
    let documented = documented.flat_map(|one| match one["const"].as_str() {
        Some(choice) => vec![choice.to_owned()],
        None => one["enum"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_str)
            .map(str::to_owned)
            .collect(),
    });
    let all: Vec<String> = plain.filter_map(Value::as_str).map(str::to_owned).chain(documented).collect();
    all.iter().map(|choice| format!("`\"{choice}\"`")).collect::<Vec<_>>().join(", ")
}
