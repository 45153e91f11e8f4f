//! Vessels at another sampling rate than their own.

use std::path::Path;

use files::{Error, Provenance};
use serde_json::json;
use ship::model::Vessel;
use trial::campaign::{Maneuvers, Refusal};

/// The vessel at `path` at the rate that was requested \[Hz\], if one was; notes both.
///
/// # Errors
/// A rate that its terms per sample cannot have.
pub fn at_rate(
    path: &Path,
    vessel: Vessel,
    rate_hz: Option<f64>,
    provenance: &mut Provenance,
) -> Result<Vessel, Error> {
    let Some(rate_hz) = rate_hz else { return Ok(vessel) };
    let sample_rate_hz = vessel.sample_rate_hz;
    let vessel = vessel.at_rate(rate_hz).map_err(|e| crate::invalid(path, &e))?;
    provenance.settings.insert("rate_hz".into(), json!(rate_hz));
    provenance.settings.insert("vessel_rate_hz".into(), json!(sample_rate_hz));
    Ok(vessel)
}

/// Notes how well samples that are parts of the vessel's steps follow these, and says it; nothing for other samples.
///
/// # Errors
/// Samples that are off by more than 0.2 % of a standard deviation; maneuvers that cannot be simulated.
pub fn note_divided(maneuvers: &Maneuvers, provenance: &mut Provenance) -> Result<Option<String>, Refusal> {
    let Some(divided) = maneuvers.divided()? else { return Ok(None) };
    let statement = divided.statement().map_err(Refusal::Vessel)?;
    provenance.settings.insert("divided".into(), json!(statement));
    Ok(Some(statement))
}
