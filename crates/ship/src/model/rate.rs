use std::sync::Arc;

use refusal::Invalid;

use crate::model::{ForceModel, ORDER, RateChange, Vessel};

/// Most samples that a step of terms is divided into, and most that are one sample.
const MOST: f64 = 10.0;
const MOST_REPEATED: f64 = 1000.0;

impl Vessel {
    /// The same vessel sampled at another rate \[Hz\]. Forces are integrated in other steps. Terms per sample are repeated, or
    /// divided by Newton's forward formula.
    ///
    /// # Errors
    /// For terms: a rate of which neither is a whole multiple of the other, or above tenfold.
    pub fn at_rate(mut self, rate_hz: f64) -> Result<Self, Invalid> {
        let sample_rate_hz = self.sample_rate_hz;
        self.sample_rate_hz = rate_hz;
        if let Some(moved) = &self.model.forces {
            let forces = moved.forces.clone();
            self.model.forces = Some(Arc::new(ForceModel { forces, sample_s: 1.0 / rate_hz }));
            return Ok(self);
        }
        let refused = |expected: String, remedy: &str| {
            Err(Invalid::new("sampling rate", format!("{rate_hz} Hz wanted"), expected, remedy))
        };
        let whole = |ratio: f64| ((ratio - ratio.round()).abs() <= 1e-9 * ratio).then(|| ratio.round());
        self.model.pace = match (whole(rate_hz / sample_rate_hz), whole(sample_rate_hz / rate_hz)) {
            (Some(1.0), _) => RateChange::Own,
            (Some(by), _) if (2.0..=MOST).contains(&by) => {
                RateChange::Divided { by: by as u32, order: ORDER }
            }
            (_, Some(count)) if (2.0..=MOST_REPEATED).contains(&count) => RateChange::Repeated(count as u32),
            (Some(by), _) if by > MOST => {
                let expected = format!(
                    "at most {} Hz, {MOST} times the vessel's {sample_rate_hz} Hz",
                    MOST * sample_rate_hz
                );
                return refused(expected, "take a lower rate, or a vessel with `model = \"forces\"`");
            }
            _ => {
                let expected = format!("a whole multiple or part of the vessel's {sample_rate_hz} Hz");
                return refused(expected, "take such a rate, or estimate a model at this one");
            }
        };
        Ok(self)
    }
}
