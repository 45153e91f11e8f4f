//! Unit and datum of the depths of a chart.

use chart::{Measured, UnitFrom};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the depths, or heights, of a chart are measured in, and from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanDepths {
    /// Their unit, as in `plan.toml`: m, dm, cm, mm, km, ft, us-ft or fathom.
    pub unit: String,
    /// Where that comes from.
    pub unit_from: PlanUnitFrom,
    /// The file's numbers were multiplied by this.
    pub scale: f64,
    /// This was added then, in the unit.
    pub offset: f64,
    /// The vertical datum; absent where the file does not state one.
    pub datum: Option<String>,
    /// Cells outside of a range that the file calls valid: none, since no format that is read has one.
    pub invalid: u64,
}

refusal::choices! {
    /// Where the unit of a chart comes from.
    pub enum PlanUnitFrom {
        /// The file states it.
        File = "file",
        /// `depth_unit` in plan.toml states it.
        PlanToml = "plan.toml",
        /// Nobody states it.
        Assumed = "assumed",
    }
}

impl PlanDepths {
    /// In words: `ft (file), datum not stated`.
    pub fn words(&self) -> String {
        let from = match self.unit_from {
            PlanUnitFrom::File => "as the file says",
            PlanUnitFrom::PlanToml => "as plan.toml says",
            PlanUnitFrom::Assumed => "assumed, for neither the file nor plan.toml says",
        };
        let mut words = format!("depths in {} ({from})", self.unit);
        if self.scale != 1.0 || self.offset != 0.0 {
            words += &format!(" after scale {} and offset {}", self.scale, self.offset);
        }
        words += &format!(", datum {}", self.datum.as_deref().unwrap_or("not stated"));
        if self.invalid > 0 {
            words += &format!(", {} cells outside of the valid range without data", self.invalid);
        }
        words
    }
}

impl PlanDepths {
    /// From a chart that was read.
    pub(crate) fn of(measured: &Measured) -> Self {
        let unit_from = match measured.unit_from {
            UnitFrom::File => PlanUnitFrom::File,
            UnitFrom::Declared => PlanUnitFrom::PlanToml,
            UnitFrom::Assumed => PlanUnitFrom::Assumed,
        };
        Self {
            unit: measured.unit.name().to_owned(),
            unit_from,
            scale: measured.scale,
            offset: measured.offset,
            datum: measured.datum.clone(),
            invalid: 0,
        }
    }
}
