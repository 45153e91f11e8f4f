use regression::pooled::{AnyParts, Unread};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Searched;

/// A current over ground that was found with a model in one run, or in a part of one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Surroundings {
    /// The run or recording.
    pub source: String,
    /// Which of the parts that simulations start anew with, from 0.
    pub part: u64,
    /// What was found, along and across the vessel as she heads where the part starts.
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

impl Surroundings {
    /// The current in part `part` of `source`: values and standard errors.
    pub(crate) fn of((source, part): (&str, usize), [values, errors]: [[f64; 2]; 2]) -> Self {
        let found = |(i, name): (usize, &str)| FoundUnknown {
            name: name.to_owned(),
            unit: "m/s".to_owned(),
            value: values[i],
            standard_error: Some(errors[i]).filter(|error| *error > 0.0),
        };
        let found = ["current along", "current across"].into_iter().enumerate().map(found).collect();
        Self { source: source.to_owned(), part: part as u64, found }
    }

    /// The surroundings of all parts that were `searched`.
    ///
    /// # Errors
    /// Parts that cannot be read.
    pub(super) fn all(parts: &AnyParts, searched: &Searched) -> Result<Vec<Self>, Unread> {
        let mut all = Vec::new();
        if !searched.currents.is_empty() {
            parts.each(&mut |part| {
                all.push(Self::of((part.source, all.len()), searched.currents[all.len()]))
            })?;
        }
        Ok(all)
    }
}
