//! The sheet of a plan as a table, and which part of the track belongs to which of its steps.

use serde_json::{Value, json};
use study::documents::{MapTrack, MapTrackKind, PlanDocument, Voyage, VoyageLeg};

use super::embedded::{column, number};
use crate::study::Study;
use crate::trajectory::words::{action, heading, knots, latitude, longitude};

/// A row per step of the plan.
pub(super) fn sheet(study: &Study, plan: &PlanDocument, voyage: &Voyage) -> Value {
    let inputs = study.inputs();
    let mut columns = vec![
        column("step", "", "number"),
        column("maneuver no.", "", "number"),
        column("time", "h:min:s", "clock"),
        column("what", "", "text"),
        column("heading", "", "text"),
        column("speed", "m/s", "number"),
        column("speed", "kn", "number"),
        column("duration", "s", "number"),
        column("latitude", "", "text"),
        column("longitude", "", "text"),
    ];
    columns
        .extend(inputs.iter().map(|input| column(&format!("largest {}", input.name), &input.unit, "number")));
    let mut maneuvers = 0;
    let rows = plan.steps.iter().zip(&voyage.legs).enumerate();
    let rows = rows.map(|(index, (step, leg))| {
        maneuvers += usize::from(leg.informative);
        let mut row = vec![
            json!(index + 1),
            json!(leg.informative.then_some(maneuvers)),
            number(leg.start_s),
            json!(action(step, leg, &voyage.lattice)),
            json!(heading(leg.heading_deg)),
            number(leg.speed_m_s),
            number(knots(leg.speed_m_s).parse().ok()),
            number(leg.duration_s),
            json!(latitude(leg.latitude_deg)),
            json!(longitude(leg.longitude_deg)),
        ];
        row.extend(inputs.iter().map(|input| number(leg.largest_inputs.get(&input.name).copied())));
        Value::Array(row)
    });
    json!({"rows": rows.collect::<Value>(), "columns": columns})
}

/// The step of the plan that each part of the track belongs to; `None` if they are not of the same plan.
///
/// A basic step has one part. An informative one has its approach, the maneuver and, unless it ends with it, its recovery.
pub(super) fn steps_of(tracks: &[MapTrack], legs: &[VoyageLeg]) -> Option<Vec<usize>> {
    let mut next = 0;
    let mut steps = Vec::with_capacity(tracks.len());
    for (index, track) in tracks.iter().enumerate() {
        let begins = match track.kind {
            MapTrackKind::Basic => true,
            MapTrackKind::Maneuver => !approached(tracks, index),
            MapTrackKind::RunIn => leads(tracks, index),
        };
        next += usize::from(begins);
        let leg = legs.get(next.checked_sub(1)?)?;
        if leg.informative == (track.kind == MapTrackKind::Basic) {
            return None;
        }
        steps.push(next - 1);
    }
    (next == legs.len()).then_some(steps)
}

/// Whether an approach leads to the maneuver at `index`.
fn approached(tracks: &[MapTrack], index: usize) -> bool {
    index.checked_sub(1).is_some_and(|before| tracks[before].kind == MapTrackKind::RunIn)
}

/// Whether the part at `index` is an approach: a maneuver follows.
fn leads(tracks: &[MapTrack], index: usize) -> bool {
    tracks.get(index + 1).is_some_and(|after| after.kind == MapTrackKind::Maneuver)
}
