use std::collections::BTreeMap;

use refusal::{Invalid, check_numbers, check_ranges};
use schemars::JsonSchema;
use serde::Deserialize;
use ship::model::{Source, Vessel};
use trial::rounds::Knowledge;

/// `sequential.toml`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SequentialFile {
    /// Realizations of every arm.
    pub realizations: u32,
    /// Total sea time \[s\].
    pub duration_s: f64,
    /// Number of rounds of equal length.
    pub rounds: u32,
    /// Spread of the crude model before the trial: its parameters are the central ones times e^(this times a standard
    /// normal number), drawn for every realization.
    pub nominal_spread: f64,
    /// The central parameters of crude models; nominal parameters that are zero stay zero and need a floor.
    #[serde(default)]
    pub crude_about: Source,
    /// The trial may stop when the predicted error falls to this: 2-norm over the parameters of standard error over
    /// parameter.
    pub accuracy: f64,
    /// Smallest moduli of parameters by name, in their units: errors of a smaller parameter are relative to this, and
    /// the crude model's uncertainty is at least this.
    #[serde(default)]
    pub floor: BTreeMap<String, f64>,
}

impl SequentialFile {
    /// Refuses invalid numbers.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self) -> Result<(), Invalid> {
        let keys = [
            ("realizations", f64::from(self.realizations)),
            ("duration_s", self.duration_s),
            ("rounds", f64::from(self.rounds)),
            ("accuracy", self.accuracy),
        ];
        let floors = self.floor.iter().map(|(name, value)| (format!("floor.{name}"), *value));
        let positive = keys.into_iter().map(|(key, value)| (key.to_owned(), value)).chain(floors);
        check_numbers(positive.clone(), "more than zero", |value| value > 0.0)?;
        check_ranges(positive.map(|(key, value)| (key, value, 1e-12..=1e9, "")))?;
        let spread = [("nominal_spread", self.nominal_spread)];
        check_numbers(spread, "a number from 0 to 2", |value| (0.0..=2.0).contains(&value))
    }

    /// The knowledge of the parameters before a trial; `seed`: of the crude models.
    ///
    /// # Errors
    /// See [`SequentialFile::floors`]; a vessel without the central parameters of crude models.
    pub fn knowledge(&self, vessel: &Vessel, seed: u64) -> Result<Knowledge, Invalid> {
        let about = vessel.parameters(self.crude_about)?;
        let floor = self.floors(vessel, &about)?;
        Ok(Knowledge { about, spread: self.nominal_spread, floor, seed })
    }

    /// The floor of every parameter of `vessel`, 0 if not stated.
    ///
    /// # Errors
    /// A floor of an unknown parameter; a central parameter in `about` that is zero and has no floor.
    fn floors(&self, vessel: &Vessel, about: &[f64]) -> Result<Vec<f64>, Invalid> {
        let names = || vessel.model.parameter_names();
        if let Some(unknown) = self.floor.keys().find(|key| names().all(|name| name != key.as_str())) {
            return Err(Invalid::unknown("`floor`", unknown, names()));
        }
        let floors: Vec<f64> = names().map(|name| self.floor.get(name).copied().unwrap_or(0.0)).collect();
        let zero =
            names().zip(about).zip(&floors).find(|((_, about), floor)| **about == 0.0 && **floor == 0.0);
        match zero {
            None => Ok(floors),
            Some(((name, _), _)) => Err(Invalid::new(
                format!("`floor.{name}`"),
                format!("none, and `{}` of `{name}` is zero", self.crude_about.name()),
                "the smallest modulus that counts, since errors are relative",
                "state it, or take `crude_about = \"value\"`",
            )),
        }
    }
}
