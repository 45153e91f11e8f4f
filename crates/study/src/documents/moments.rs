use artifact::{Document, Units};
use design::Degree;
use identification::InstrumentKind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trial::moments::{Expected, FreeRunModel, ManeuverMoments, Moments, malformed};
use vessel::Invalid;

/// `moments.json`: the lifted moment matrices of every maneuver.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MomentsDocument {
    /// Name of the vessel.
    pub vessel: String,
    /// Sampling rate \[Hz\].
    pub sample_rate_hz: f64,
    /// What the instruments are made of.
    pub instruments: InstrumentKind,
    /// What each row and column of the matrices stands for.
    pub degrees: Vec<Degree>,
    /// One entry per maneuver, in the dictionary's order.
    pub maneuvers: Vec<ManeuverMoments>,
    /// What the matrices `B` were computed from, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disturbances: Option<Expected>,
    /// What the matrices `F` and `P` of an output-error estimate are about, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_error: Option<FreeRunModel>,
}

impl Document for MomentsDocument {
    const ID: &'static str = "moments";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("Hz", "sample_rate_hz"),
        ("1", "samples shape nonstationarity"),
        ("unit of regressor i times unit of instrument j", "M"),
    ];
}

impl From<Moments> for MomentsDocument {
    fn from(from: Moments) -> Self {
        Self {
            vessel: from.vessel,
            sample_rate_hz: from.sample_rate_hz,
            instruments: from.instruments,
            degrees: from.degrees,
            maneuvers: from.maneuvers,
            disturbances: from.expected,
            output_error: from.output_error,
        }
    }
}

impl MomentsDocument {
    /// What the document says.
    ///
    /// # Errors
    /// A matrix of another shape than its degree of freedom has.
    pub fn moments(self) -> Result<Moments, Invalid> {
        for maneuver in &self.maneuvers {
            for own in &maneuver.degrees {
                let [rows, columns] = own.shape;
                if rows != columns || rows.checked_mul(columns) != Some(own.m.len() as u64) {
                    let found = format!("{} entries in {}", own.m.len(), own.name);
                    return Err(malformed(&maneuver.name, &found));
                }
            }
        }
        Ok(Moments {
            vessel: self.vessel,
            sample_rate_hz: self.sample_rate_hz,
            instruments: self.instruments,
            degrees: self.degrees,
            maneuvers: self.maneuvers,
            expected: self.disturbances,
            output_error: self.output_error,
        })
    }
}
