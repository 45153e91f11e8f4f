use std::fmt;

use refusal::Invalid;
use ship::model::Vessel;

use super::input_table::{InputTable, Resampling};
use super::settings::check_range;
use super::spec::{Kind, ManeuverSpec};

/// A maneuver whose inputs come from a table. It is played as written, at its own length.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayedTable {
    /// The maneuver.
    pub maneuver: String,
    /// Name of the table's file.
    pub file: String,
    /// Its length.
    pub samples: usize,
    /// The clock of its rows.
    pub pace: Resampling,
    rate_hz: f64,
    /// Samples × inputs, row-major.
    inputs: Vec<f64>,
}

impl PlayedTable {
    /// The table of `maneuver`, read by `read` (name → CSV); `None` for a generated maneuver.
    ///
    /// # Errors
    /// A table that is refused; a duration other than the table's.
    pub(super) fn of(
        maneuver: &ManeuverSpec,
        vessel: &Vessel,
        read: impl Fn(&str) -> Result<String, Invalid>,
    ) -> Result<Option<Self>, Invalid> {
        let Kind::Inputs { file, resample, .. } = &maneuver.kind else { return Ok(None) };
        let (width, rate_hz) = (vessel.model.inputs, vessel.sample_rate_hz);
        let named = |e: Invalid| Invalid { thing: format!("{file}: {}", e.thing), ..e };
        let table = InputTable::parse(&read(file)?, &vessel.model).map_err(named)?;
        for (row, inputs) in table.inputs.chunks_exact(width).enumerate() {
            check_range(vessel, inputs, || format!("{file}: row {}", row + 1))?;
        }
        let (inputs, pace) = table.played(width, rate_hz, *resample).map_err(named)?;
        let (samples, maneuver_name) = (inputs.len() / width, maneuver.name.clone());
        let own = Self { maneuver: maneuver_name, file: file.clone(), samples, pace, rate_hz, inputs };
        match maneuver.duration_s {
            Some(s) if vessel.samples(s) != samples => Err(Invalid::new(
                format!("maneuver `{}`, `duration_s`", maneuver.name),
                format!("{s} s"),
                format!("{} s, as long as its table {file}", own.duration_s()),
                "remove it",
            )),
            _ => Ok(Some(own)),
        }
    }

    /// Its duration \[s\].
    pub fn duration_s(&self) -> f64 {
        self.samples as f64 / self.rate_hz
    }

    /// Its inputs in its first `samples` samples.
    pub(super) fn first(&self, samples: usize) -> Result<&[f64], Invalid> {
        let width = self.inputs.len() / self.samples.max(1);
        self.inputs.get(..samples * width).ok_or_else(|| {
            Invalid::new(
                format!("maneuver `{}`, table {}", self.maneuver, self.file),
                format!("{} samples", self.samples),
                format!("at least the {samples} of the request, since a table is not stretched"),
                "lengthen the table, or request fewer",
            )
        })
    }
}

impl fmt::Display for PlayedTable {
    /// How the table is played, for users.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { maneuver, file, rate_hz, .. } = self;
        write!(f, "{maneuver}: {file} is played in {} s, ", self.duration_s())?;
        match self.pace {
            Resampling::Samples => write!(f, "a row per sample of {rate_hz} Hz (it has no column `t`)"),
            Resampling::Stamps => write!(f, "by its column `t`"),
            Resampling::Resampled(own) => {
                // To three figures: stamps are rounded.
                let own = format!("{own:.3}").parse().unwrap_or(own);
                write!(f, "resampled from {own} to {rate_hz} Hz on straight lines")
            }
        }
    }
}
