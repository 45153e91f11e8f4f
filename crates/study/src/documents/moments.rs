use files::{Document, Units};
use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trial::moments::{Moments, malformed};

/// `moments.json`: the lifted moment matrices of every maneuver.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct MomentsDocument(pub Moments);

impl Document for MomentsDocument {
    const ID: &'static str = "moments";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("Hz", "sample_rate_hz"),
        ("1", "samples shape nonstationarity ships"),
        ("unit of regressor i times unit of instrument j", "M"),
    ];
}

impl MomentsDocument {
    /// The moments of the document.
    ///
    /// # Errors
    /// A matrix with another shape than its degree of freedom.
    pub fn moments(self) -> Result<Moments, Invalid> {
        for maneuver in &self.0.maneuvers {
            for degree in &maneuver.degrees {
                let [rows, columns] = degree.shape;
                if rows != columns || rows.checked_mul(columns) != Some(degree.m.len() as u64) {
                    let found = format!("{} entries in {}", degree.m.len(), degree.name);
                    return Err(malformed(&maneuver.name, &found));
                }
            }
        }
        Ok(self.0)
    }
}
