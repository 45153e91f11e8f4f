use regression::pooled::{AnyParts, PartView, Unread};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Follow, Searched};
use crate::additional::UnknownCurrent;
use crate::predictor::{AMBIENT, Unknown};

/// Water and wind that were found with a model in one run, or in a part of one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Surroundings {
    /// The run or recording.
    pub source: String,
    /// Which of the parts that simulations start anew with, from 0.
    pub part: u64,
    /// `earth`: it keeps its direction over ground as the vessel turns; `body`: from the bow.
    pub axes: String,
    /// What was found, along and across the vessel as she heads where the part starts: a current, its change with time (drift),
    /// and a wind's push.
    pub found: Vec<FoundUnknown>,
}

/// An unknown beside the parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FoundUnknown {
    /// What it is: `current along` and the like.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The estimate.
    pub value: f64,
    /// Its standard error; null where it has none, as where it makes no difference.
    pub standard_error: Option<f64>,
}

/// Their names in reports, and their units.
const NAMES: [(&str, &str); AMBIENT] = [
    ("current along", "m/s"),
    ("current across", "m/s"),
    ("drift along", "m/s^2"),
    ("drift across", "m/s^2"),
    ("wind along", "m/s^2"),
    ("wind across", "m/s^2"),
];

impl Surroundings {
    /// Values and standard errors of the ambient unknowns of part `part` of `source`; `None` if there are none.
    pub(crate) fn of(
        unknown: Unknown,
        (source, part): (&str, usize),
        [values, errors]: &[[f64; AMBIENT]; 2],
    ) -> Option<Self> {
        let found = |i: usize| {
            // Converts an increment per sample to one per second.
            let per = if i < 2 { 1.0 } else { unknown.interval_s };
            let (name, unit) = NAMES[i];
            FoundUnknown {
                name: name.to_owned(),
                unit: unit.to_owned(),
                value: values[i] / per,
                standard_error: Some(errors[i] / per).filter(|error| *error > 0.0),
            }
        };
        let found: Vec<FoundUnknown> = unknown.ambient().map(found).collect();
        let axes = if unknown.current == UnknownCurrent::Body { "body" } else { "earth" };
        let (source, part, axes) = (source.to_owned(), part as u64, axes.to_owned());
        (!found.is_empty()).then_some(Self { source, part, axes, found })
    }

    /// The surroundings of all parts that were `searched`.
    ///
    /// # Errors
    /// Parts that cannot be read.
    pub(super) fn all(parts: &AnyParts, searched: &Searched, follow: &Follow) -> Result<Vec<Self>, Unread> {
        let (Follow::Simulated(unknown), mut ambient) = (follow, searched.ambient.iter().enumerate()) else {
            return Ok(Vec::new());
        };
        let mut all = Vec::new();
        let mut add = |part: PartView| {
            let own = ambient.next();
            all.extend(own.and_then(|(i, own)| Self::of(*unknown, (part.source, i), own)));
        };
        if !searched.ambient.is_empty() {
            parts.each(&mut add)?;
        }
        Ok(all)
    }
}
