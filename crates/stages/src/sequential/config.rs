use serde::Deserialize;
use vessel::Invalid;

/// `sequential.toml`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SequentialFile {
    /// Realizations of every arm.
    pub realizations: u32,
    /// Sea time in all \[s\].
    pub duration_s: f64,
    /// Rounds of equal length that it is cut into.
    pub rounds: u32,
    /// How crude the first model is: the nominal parameters are multiplied by e^(this times a standard normal number), drawn
    /// anew for every realization.
    pub nominal_spread: f64,
    /// The trial may stop where the predicted error falls below this: 2-norm over the parameters of standard error over
    /// parameter.
    pub accuracy: f64,
}

impl SequentialFile {
    /// Refuses numbers without meaning.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self) -> Result<(), Invalid> {
        let positive = [
            ("realizations", f64::from(self.realizations)),
            ("duration_s", self.duration_s),
            ("rounds", f64::from(self.rounds)),
            ("accuracy", self.accuracy),
        ];
        let wrong = positive.into_iter().find(|(_, value)| !(value.is_finite() && *value > 0.0));
        if let Some((key, value)) = wrong {
            return Err(Invalid::new(format!("`{key}`"), value.to_string(), "more than zero", "correct it"));
        }
        if !(self.nominal_spread.is_finite() && (0.0..=2.0).contains(&self.nominal_spread)) {
            let found = self.nominal_spread.to_string();
            return Err(Invalid::new("`nominal_spread`", found, "a number from 0 to 2", "correct it"));
        }
        Ok(())
    }
}
