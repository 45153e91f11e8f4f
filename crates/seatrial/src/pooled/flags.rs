use std::path::PathBuf;

use artifact::Provenance;
use clap::Args;
use serde_json::{Value, json};

use super::Nominal;
use crate::failure::Failure;

/// Flags of stages that pool sub-experiments.
#[derive(Clone, Debug, Default, Args)]
pub struct PoolFlags {
    /// What `ingest` wrote beside the trajectories: names the recordings that runs were cut from
    #[arg(long, value_name = "ingest.json")]
    pub recordings: Option<PathBuf>,
    /// Only these runs or recordings
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    pub runs: Vec<String>,
    /// All but these runs or recordings
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    pub leave_out: Vec<String>,
    /// Cuts longer sub-experiments, so that instruments start anew at least this often [s]
    #[arg(long, value_name = "S")]
    pub part_s: Option<f64>,
    /// The nominal model that instruments are simulated with: `given` in vessel.toml, `least-squares` (the fit of the same
    /// data), or a previous estimate.json
    #[arg(long, value_name = "given|least-squares|FILE")]
    pub nominal: Option<Nominal>,
    /// Pull towards the nominal model, on the scale of correlations; 0.03 is mild
    #[arg(long, value_name = "STRENGTH")]
    pub prior: Option<f64>,
}

impl PoolFlags {
    /// Notes a stage's `own` settings, and which runs were pooled in what parts; none that is empty or absent.
    pub fn note<const N: usize>(&self, own: [(&str, Value); N], provenance: &mut Provenance) {
        let pooled = [
            ("runs", json!(self.runs)),
            ("leave_out", json!(self.leave_out)),
            ("part_s", json!(self.part_s)),
        ];
        let given = |(_, value): &(&str, Value)| *value != json!([]) && !value.is_null();
        let all = own.into_iter().chain(pooled).filter(given);
        provenance.settings.extend(all.map(|(key, value)| (key.to_owned(), value)));
    }

    /// Strength of the prior.
    ///
    /// # Errors
    /// Usage: below 0 or no number.
    pub fn strength(&self) -> Result<f64, Failure> {
        not_below("--prior", self.prior.unwrap_or(0.0), 0.0)
    }

    /// Where instruments come from.
    pub fn nominal(&self) -> Nominal {
        self.nominal.clone().unwrap_or_default()
    }

    /// Longest part in samples.
    ///
    /// # Errors
    /// Usage: less than a sample.
    pub fn part_samples(&self, rate_hz: f64) -> Result<Option<usize>, Failure> {
        self.part_s.map(|s| samples("--part-s", s, rate_hz)).transpose()
    }
}

/// `value`, which must not be below `least`.
///
/// # Errors
/// Usage, naming the flag.
pub fn not_below(flag: &str, value: f64, least: f64) -> Result<f64, Failure> {
    if value.is_finite() && value >= least {
        return Ok(value);
    }
    Err(Failure::Usage(format!("{flag}: found {value}, expected a number from {least} on; correct it")))
}

/// Seconds in samples.
///
/// # Errors
/// Usage: less than a sample.
pub fn samples(flag: &str, seconds: f64, rate_hz: f64) -> Result<usize, Failure> {
    let samples = (seconds * rate_hz).round();
    if (1.0..1e9).contains(&samples) {
        return Ok(samples as usize);
    }
    let expected = format!("at least a sample, {} s", 1.0 / rate_hz);
    Err(Failure::Usage(format!("{flag}: found {seconds}, expected {expected}; correct it")))
}
