//! `track.parquet`: the planned trajectory, one row per sample.

use std::path::Path;

use artifact::{
    Column, ColumnSpec, Error, Kind, Provenance, Staged, Table, TableReader, TableSchema, TableWriter,
    encode_block, read_document,
};
use chart::Plane;
use trial::Sailed;
use vessel::{Pose, Vessel};

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

fn schema(vessel: &Vessel) -> TableSchema {
    let mut columns = vec![
        ColumnSpec::new("step", "1", Kind::I32, false),
        ColumnSpec::new("maneuver", "1", Kind::Text, false),
        ColumnSpec::new("informative", "1", Kind::I32, false),
    ];
    columns.extend(FLOATS.map(|(name, unit)| ColumnSpec::new(name, unit, Kind::F64, false)));
    columns.extend(inputs(vessel));
    TableSchema { id: TRACK, version: TRACK_VERSION, columns }
}

/// The inputs' columns; null in the last row, where the trial is over.
fn inputs(vessel: &Vessel) -> Vec<ColumnSpec> {
    let own = &vessel.model.variables[3..3 + vessel.model.inputs];
    own.iter().map(|v| ColumnSpec::new(&v.name, &v.unit, Kind::F64, true)).collect()
}

/// Writes the samples and the end; `names`: of every leg.
///
/// # Errors
/// Output that fails.
pub fn stage_track(
    out: &Path,
    provenance: &Provenance,
    vessel: &Vessel,
    plane: &Plane,
    names: &[String],
    sailed: &Sailed,
) -> Result<Staged, Error> {
    let schema = schema(vessel);
    let mut labels: Vec<String> = names.to_vec();
    labels.sort();
    labels.dedup();
    let code = |leg: usize| labels.iter().position(|l| *l == names[leg]).unwrap_or(0) as u32;
    let last_leg = sailed.samples.last().map_or(0, |s| s.leg);
    let rows = sailed.samples.len() + 1;
    let end = sailed.ends.last().copied().unwrap_or_default();
    let row = |k: usize| -> (usize, bool, Pose, [f64; 3]) {
        sailed
            .samples
            .get(k)
            .map_or((last_leg, false, end.0, end.1), |s| (s.leg, s.informative, s.pose, s.state))
    };
    let mut floats = vec![Vec::with_capacity(rows); FLOATS.len()];
    for k in 0..rows {
        let (_, _, pose, state) = row(k);
        let (longitude, latitude) = plane.to_geographic([pose.y, pose.x]);
        let [u, v, r] = state;
        let values =
            [k as f64 / vessel.sample_rate_hz, pose.x, pose.y, pose.psi, u, v, r, longitude, latitude];
        floats.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
    }
    let mut columns = vec![
        Column::i32((0..rows).map(|k| row(k).0 as i32).collect()),
        Column::text(labels.clone(), (0..rows).map(|k| code(row(k).0)).collect()),
        Column::i32((0..rows).map(|k| i32::from(row(k).1)).collect()),
    ];
    columns.extend(floats.into_iter().map(Column::f64));
    let present: Vec<bool> = (0..rows).map(|k| k + 1 < rows).collect();
    for i in 0..vessel.model.inputs {
        let values = (0..rows).map(|k| sailed.samples.get(k).map_or(0.0, |s| s.inputs[i])).collect();
        columns.push(Column::nullable_f64(values, present.clone()));
    }
    let mut writer = TableWriter::create(out, &schema, provenance)?;
    writer.push(encode_block(&schema, &Table { columns })?)?;
    writer.finish()
}

/// A planned trajectory, as read.
pub struct Track {
    /// N × inputs, row-major.
    pub inputs: Vec<f64>,
    /// First sample and name of every stretch that is one informative maneuver or what lies between two.
    pub stretches: Vec<(usize, String)>,
    /// State at the start.
    pub initial: [f64; 3],
}

/// Reads the track beside `plan`, a `plan.json`.
///
/// # Errors
/// A plan of a lattice problem, which has no track; a track that was not written with the plan; as [`read_track`].
pub fn read_planned(plan: &Path, vessel: &Vessel, provenance: &mut Provenance) -> Result<Track, Error> {
    let document = read_document::<PlanDocument>(plan)?;
    if document.data.voyage.is_none() {
        let found = "none: the plan of a lattice problem";
        let remedy = "plan on a chart, with --vessel, --trajectories and --config";
        return Err(Error::refuse(plan, "`data.voyage`", found, "a plan on a chart", remedy));
    }
    let path = plan.with_file_name("track.parquet");
    let track = TableReader::open(&path, TRACK, TRACK_VERSION)?;
    let of = |p: &Provenance| (p.inputs.clone(), p.settings.clone());
    if of(track.provenance()) != of(&document.provenance) {
        let expected = format!("the track that was written with {}", plan.display());
        let found = "a track planned from other inputs or with another seed";
        return Err(Error::refuse(&path, "provenance", found, expected, "plan again"));
    }
    provenance.inputs.insert("plan".into(), document.digest);
    read_track(&path, vessel, provenance)
}

/// Reads `track.parquet`.
///
/// # Errors
/// A file that is no track of this vessel.
pub fn read_track(path: &Path, vessel: &Vessel, provenance: &mut Provenance) -> Result<Track, Error> {
    let reader = TableReader::open(path, TRACK, TRACK_VERSION)?;
    let required = schema(vessel).columns;
    reader.require(&required)?;
    provenance.inputs.insert("track".into(), reader.digest());
    let mut track = Track { inputs: Vec::new(), stretches: Vec::new(), initial: [0.0; 3] };
    let states = ["u", "v", "r"];
    let own = inputs(vessel);
    let mut names = vec!["step", "maneuver", "informative"];
    names.extend(states);
    names.extend(own.iter().map(|c| c.name.as_str()));
    let mut key = None;
    for block in 0..reader.blocks() {
        let table = reader.read_block(block, &names)?;
        let wrong = |i: usize| {
            let thing = format!("column `{}`", names[i]);
            Error::refuse(path, thing, "another type", "the type of its schema", "plan again")
        };
        let steps = table.columns[0].as_i32().ok_or_else(|| wrong(0))?;
        let informative = table.columns[2].as_i32().ok_or_else(|| wrong(2))?;
        let whole = reader.blocks() == block + 1;
        for row in 0..steps.len() - usize::from(whole) {
            if track.inputs.is_empty() {
                track.initial = [3, 4, 5].map(|i| table.columns[i].value_at(row).unwrap_or(0.0));
            }
            let now = (informative[row] == 1).then_some(steps[row]);
            if key != Some(now) {
                let name =
                    if now.is_some() { table.columns[1].text_at(row).unwrap_or("") } else { "between" };
                track.stretches.push((track.inputs.len() / vessel.model.inputs, name.to_owned()));
                key = Some(now);
            }
            for (i, column) in table.columns[6..].iter().enumerate() {
                let thing = || format!("column `{}`, row {}", own[i].name, row + 1);
                let missing = || {
                    Error::refuse(
                        path,
                        thing(),
                        "no value",
                        "a number in every row but the last",
                        "plan again",
                    )
                };
                track.inputs.push(column.value_at(row).ok_or_else(missing)?);
            }
        }
    }
    if track.inputs.is_empty() {
        return Err(Error::refuse(path, "rows", "none", "at least one sample", "plan again"));
    }
    Ok(track)
}
