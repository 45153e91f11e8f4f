//! `track.parquet`: the planned trajectory, one row per sample.

use std::path::{Path, PathBuf};

use chart::Plane;
use files::{Columns, Error, Loaded, Provenance, Staged, TableReader, TableWriter, read_document};
use plan::voyage::{Inputs, TrackPoint, compass_deg};
use plan::{Sailed, Sample};
use ship::engine::Pose;
use ship::model::Vessel;

use crate::documents::PlanDocument;

/// Schema id.
pub const TRACK: &str = "track";
/// Version of the schema.
pub const TRACK_VERSION: u32 = 1;

const FLOATS: [(&str, &str); 9] = [
    ("t", "s"),
    ("x", "m"),
    ("y", "m"),
    ("psi", "rad"),
    ("u", "m/s"),
    ("v", "m/s"),
    ("r", "rad/s"),
    ("longitude", "deg"),
    ("latitude", "deg"),
];

/// One sample of the planned trajectory. The last row is the end of the trial.
#[derive(Clone)]
struct TrackRow {
    /// Number of the leg's step in the plan.
    step: i32,
    /// Name of its maneuver.
    maneuver: String,
    /// Whether it is an informative one.
    informative: bool,
    /// The values of [`FLOATS`].
    floats: [f64; FLOATS.len()],
    /// The vessel's inputs; `None` in the last row.
    inputs: Vec<Option<f64>>,
}

impl TrackRow {
    fn blank(vessel: &Vessel) -> Self {
        Self {
            step: 0,
            maneuver: String::new(),
            informative: false,
            floats: [0.0; FLOATS.len()],
            inputs: vec![None; vessel.model.inputs],
        }
    }
}

fn columns(vessel: &Vessel) -> Columns<TrackRow> {
    let mut columns = Columns::<TrackRow>::new(TRACK, TRACK_VERSION)
        .integer("step", "1", |r| r.step, |r, step| r.step = step)
        .text("maneuver", |r| &r.maneuver, |r, maneuver| r.maneuver = maneuver.to_owned())
        .integer("informative", "1", |r| i32::from(r.informative), |r, yes| r.informative = yes == 1);
    for (i, (name, unit)) in FLOATS.into_iter().enumerate() {
        columns = columns.number(name, unit, move |r| r.floats[i], move |r, value| r.floats[i] = value);
    }
    for (i, input) in vessel.model.input_variables().iter().enumerate() {
        let (get, set) =
            (move |r: &TrackRow| r.inputs[i], move |r: &mut TrackRow, value| r.inputs[i] = value);
        columns = columns.optional(&input.name, &input.unit, get, set);
    }
    columns
}

/// Writes the samples and the end; `names`: of every leg.
///
/// # Errors
/// Output that fails.
pub fn stage_track(
    [out, plan]: [&Path; 2],
    provenance: &Provenance,
    vessel: &Vessel,
    plane: &Plane,
    names: &[String],
    sailed: &Sailed,
) -> Result<Staged, Error> {
    let row = |k: usize, leg: usize, pose: Pose, [u, v, r]: [f64; 3]| {
        let (longitude, latitude) = plane.to_geographic([pose.y, pose.x]);
        let t = k as f64 / vessel.sample_rate_hz;
        TrackRow {
            step: leg as i32,
            maneuver: names[leg].clone(),
            floats: [t, pose.x, pose.y, pose.psi, u, v, r, longitude, latitude],
            ..TrackRow::blank(vessel)
        }
    };
    let sample = |(k, s): (usize, &Sample)| TrackRow {
        informative: s.informative,
        inputs: s.inputs.iter().copied().map(Some).collect(),
        ..row(k, s.leg, s.pose, s.state)
    };
    let mut rows: Vec<TrackRow> = sailed.samples.iter().enumerate().map(sample).collect();
    let (pose, state) = sailed.ends.last().copied().unwrap_or_default();
    rows.push(row(rows.len(), sailed.samples.last().map_or(0, |s| s.leg), pose, state));
    let columns = columns(vessel);
    let mut writer = TableWriter::create(out, columns.schema(), provenance)?.with_document(plan);
    writer.push(columns.encode(&rows)?)?;
    writer.finish()
}

/// A planned trajectory, as read.
pub struct TrackTable {
    /// N × inputs, row-major.
    pub inputs: Vec<f64>,
    /// First sample and name of every informative maneuver and of every section between two.
    pub stretches: Vec<(usize, String)>,
    /// State at the start.
    pub initial: [f64; 3],
}

/// Reads the track of `plan`, a `plan.json`.
///
/// # Errors
/// A plan of a lattice problem, which has no track; a track that was not written with the plan; those of
/// [`read_track`].
pub fn read_planned(plan: &Path, vessel: &Vessel, provenance: &mut Provenance) -> Result<TrackTable, Error> {
    let (document, path) = track_of(plan)?;
    provenance.made("plan", plan, document.digest, &document.provenance)?;
    read_track(&path, vessel, provenance)
}

/// The `plan.json` at `plan`, and the path of the track that was written with it.
fn track_of(plan: &Path) -> Result<(Loaded<PlanDocument>, PathBuf), Error> {
    let document = read_document::<PlanDocument>(plan)?;
    if document.data.voyage.is_none() {
        let given = "none: the plan of a lattice problem";
        let remedy = "plan on a chart, with --vessel, --trajectories and --config";
        return Err(Error::refuse(plan, "`data.voyage`", given, "a plan on a chart", remedy));
    }
    let path = crate::beside(plan, "plan.json", "track.parquet");
    let track = TableReader::open(&path, TRACK, TRACK_VERSION)?;
    let of = |p: &Provenance| (p.inputs.clone(), p.origins.clone(), p.settings.clone());
    if of(track.provenance()) != of(&document.provenance) {
        let expected = format!("the track that was written with {}", plan.display());
        let given = "a track planned from other inputs or with another seed";
        return Err(Error::refuse(&path, "provenance", given, expected, "plan again"));
    }
    Ok((document, path))
}

/// The points of the track of `plan`, a `plan.json`, on `plane`, and its inputs over time.
///
/// # Errors
/// As [`read_planned`]; a step that the plan lacks.
pub fn planned_points(
    plan: &Path,
    vessel: &Vessel,
    plane: &Plane,
) -> Result<(Vec<TrackPoint>, Inputs), Error> {
    let (document, path) = track_of(plan)?;
    let reader = TableReader::open(&path, TRACK, TRACK_VERSION)?;
    let rows = columns(vessel).read(&reader, &TrackRow::blank(vessel))?;
    let steps = document.data.steps.len();
    let point = |row: &TrackRow| {
        let step = usize::try_from(row.step).ok().filter(|step| *step < steps);
        let [at_s, _, _, psi, u, v, _, longitude, latitude] = row.floats;
        let place = plane.to_plane(longitude, latitude);
        Some(TrackPoint {
            at_s,
            place,
            heading_deg: compass_deg(psi - plane.north_rad(place)),
            speed_m_s: (u * u + v * v).sqrt(),
            step: step?,
            informative: row.informative,
        })
    };
    let points: Option<Vec<TrackPoint>> = rows.iter().map(point).collect();
    let input = |(i, input): (usize, &ship::model::Variable)| {
        let points = rows.iter().filter_map(|row| Some([row.floats[0], row.inputs[i]?]));
        (input.name.clone(), points.collect())
    };
    let inputs = vessel.model.input_variables().iter().enumerate().map(input).collect();
    points.filter(|points| !points.is_empty()).map(|points| (points, inputs)).ok_or_else(|| {
        let expected = format!("samples of the {steps} steps of {}", plan.display());
        Error::refuse(&path, "`step`", "other steps, or none", expected, "plan again")
    })
}

/// Reads `track.parquet`.
///
/// # Errors
/// A file that is not a track of this vessel.
pub fn read_track(path: &Path, vessel: &Vessel, provenance: &mut Provenance) -> Result<TrackTable, Error> {
    let reader = TableReader::open(path, TRACK, TRACK_VERSION)?;
    let rows = columns(vessel).read(&reader, &TrackRow::blank(vessel))?;
    provenance.made("track", path, reader.digest(), reader.provenance())?;
    let samples = rows.split_last().map_or(&[][..], |(_, samples)| samples);
    let Some(first) = samples.first() else {
        return Err(Error::refuse(path, "rows", "none", "at least one sample", "plan again"));
    };
    let [_, _, _, _, u, v, r, ..] = first.floats;
    let mut track = TrackTable { inputs: Vec::new(), stretches: Vec::new(), initial: [u, v, r] };
    let mut key = None;
    for (k, row) in samples.iter().enumerate() {
        let now = row.informative.then_some(row.step);
        if key != Some(now) {
            let name = if row.informative { row.maneuver.as_str() } else { "between" };
            track.stretches.push((k, name.to_owned()));
            key = Some(now);
        }
        for (input, variable) in row.inputs.iter().zip(vessel.model.input_variables()) {
            let missing = || {
                let thing = format!("column `{}`, row {}", variable.name, k + 1);
                Error::refuse(path, thing, "no value", "a number in every row but the last", "plan again")
            };
            track.inputs.push(input.ok_or_else(missing)?);
        }
    }
    Ok(track)
}
