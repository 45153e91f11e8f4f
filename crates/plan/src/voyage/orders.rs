//! The orders of a plan's maneuvers, as a bridge gives them.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{Helm, Spoken};

use super::prepared::Prepared;
use super::sailing::SailedPlan;
use super::settled_legs::SettledLeg;
use crate::Sample;

/// Most orders of a maneuver that a helmsman is given one by one.
const MOST_ORDERS: usize = 40;
/// Change of heading that shows to which side a ship turns \[rad\].
const TURNS_RAD: f64 = 0.02;

/// To which side a ship turns first in a maneuver, in words; `None` if she goes straight on.
pub(super) fn first_side(samples: &[Sample]) -> Option<&'static str> {
    let begins = samples.iter().find(|sample| sample.informative)?;
    let open = samples.iter().filter(|sample| sample.informative);
    let mut turns = open.map(|sample| sample.pose.psi - begins.pose.psi);
    let turned = turns.find(|turned| turned.abs() > TURNS_RAD)?;
    Some(if turned > 0.0 { "first to starboard" } else { "first to port" })
}

/// An order of a maneuver: when and where the nominal vessel carries it out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WheelOver {
    /// When \[s\].
    pub start_s: f64,
    /// Longitude.
    pub longitude_deg: f64,
    /// Latitude.
    pub latitude_deg: f64,
    /// True heading.
    pub heading_deg: f64,
    /// The inputs from there on, in their units.
    pub inputs: BTreeMap<String, f64>,
}

impl SailedPlan<'_> {
    /// What the bridge is told of a maneuver: what, to which side first, how, and the true heading that it begins on.
    pub(super) fn order(&self, settled: &SettledLeg, samples: &[Sample]) -> Option<String> {
        let piece = settled.leg.purpose.piece()?;
        let begins = samples.iter().find(|sample| sample.informative)?;
        let heading = format!("{:03.0}°", self.prepared.true_deg(begins.pose).round() % 360.0);
        let side = first_side(samples).map_or_else(String::new, |side| format!(", {side}"));
        Some(match self.prepared.wanted[piece].piece.helm.as_ref().and_then(Helm::spoken) {
            Some(Spoken { what, has_side: true, how }) => format!("{what}{side}, {how} {heading}"),
            Some(Spoken { what, has_side: false, how }) => format!("{what}, {how} {heading}"),
            None => format!("{}{side}, from {heading}", settled.name),
        })
    }

    /// Where the nominal vessel's inputs change in a maneuver; empty where they change all the time.
    pub(super) fn wheel_over(
        &self,
        settled: &SettledLeg,
        start: usize,
        samples: &[Sample],
    ) -> Vec<WheelOver> {
        let Prepared { brief, chart, .. } = self.prepared;
        if !settled.is_informative() {
            return Vec::new();
        }
        let open: Vec<(usize, &Sample)> =
            samples.iter().enumerate().filter(|(_, sample)| sample.informative).collect();
        // An order that is executed within a sample changes the inputs in two of them.
        let same = |a: &Sample, b: &Sample| a.inputs == b.inputs;
        let mut changes: Vec<usize> = Vec::new();
        for k in 0..open.len() {
            let is_new = k == 0 || !same(open[k].1, open[k - 1].1);
            if is_new && (k == 0 || changes.last().is_none_or(|last| *last + 1 < k)) {
                changes.push(k);
            }
        }
        // What ends the maneuver is no order.
        changes.retain(|k| *k == 0 || k + 1 < open.len());
        if changes.len() > MOST_ORDERS || 4 * changes.len() > open.len() {
            return Vec::new();
        }
        let rate_hz = brief.vessel.sample_rate_hz;
        let model = &brief.vessel.model;
        let of = |k: &usize| {
            let (index, sample) = open[*k];
            let then = open.get(k + 1).map_or(sample, |(_, next)| next);
            let (longitude_deg, latitude_deg) = chart.plane().to_geographic(place(sample));
            let inputs = model.input_variables().iter().zip(&then.inputs);
            WheelOver {
                start_s: (start + index) as f64 / rate_hz,
                longitude_deg,
                latitude_deg,
                heading_deg: self.prepared.true_deg(sample.pose),
                inputs: inputs.map(|(input, value)| (input.name.clone(), *value + 0.0)).collect(),
            }
        };
        changes.iter().map(of).collect()
    }
}

/// East and north of a sample.
pub(super) fn place(sample: &Sample) -> [f64; 2] {
    [sample.pose.y, sample.pose.x]
}
