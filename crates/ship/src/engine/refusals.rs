use crate::model::DegreeOfFreedom;
use refusal::Invalid;

use crate::engine::Diverged;

impl Diverged {
    /// The refusal of a vessel whose motion in `what`, with so many samples a second, diverges.
    pub fn invalid(self, what: impl Into<String>, rate_hz: f64) -> Invalid {
        let state = DegreeOfFreedom::ALL[self.state.min(2)].state();
        let (sample, seconds) = (self.sample, self.sample as f64 / rate_hz);
        Invalid::new(
            what,
            format!(
                "a simulation that diverges: {state} leaves every bound at sample {sample}, after {seconds:.1} s"
            ),
            "bounded motion",
            "check the signs of the terms; make the damping stronger (per sample between -1 and 0 for a linear one), or the inputs or the sampling interval smaller",
        )
    }
}

/// Most samples of a simulated run.
pub const MOST_SAMPLES: usize = 1 << 22;

/// Refuses runs of more than [`MOST_SAMPLES`] samples, which `thing` requests.
///
/// # Errors
/// States both numbers.
pub fn refuse_endless(thing: impl Into<String>, samples: usize) -> Result<(), Invalid> {
    if samples <= MOST_SAMPLES {
        return Ok(());
    }
    let (found, expected) = (format!("{samples} samples"), format!("at most {MOST_SAMPLES} samples"));
    Err(Invalid::new(thing, found, expected, "shorten it"))
}
