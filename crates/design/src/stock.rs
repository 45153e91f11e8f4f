use std::collections::BTreeMap;

use serde::Deserialize;

use crate::dictionary::Dictionary;
use crate::scarce::Scarce;

/// The available amount of every maneuver. Maneuvers in neither table are not limited.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stock {
    /// Maneuver → maximum time \[s\].
    #[serde(default)]
    pub seconds: BTreeMap<String, f64>,
    /// Maneuver → maximum number of whole segments.
    #[serde(default)]
    pub segments: BTreeMap<String, u64>,
}

/// The length of the experiment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Length {
    /// Its samples, if known.
    pub samples: Option<f64>,
    /// Whole segments and the samples of each, if requested.
    pub segments: Option<(u64, u64)>,
}

/// Upper bounds, one per maneuver in the dictionary's order.
#[derive(Clone, Debug, PartialEq)]
pub struct Available {
    /// On the share; 1 without a limit.
    pub shares: Vec<f64>,
    /// On the count of whole segments; the number of segments without a limit.
    pub counts: Option<Vec<u64>>,
}

impl Stock {
    /// The bounds for an experiment of `length`.
    ///
    /// # Errors
    /// [`Scarce`].
    pub fn within(&self, dictionary: &Dictionary, length: &Length) -> Result<Available, Scarce> {
        if !self.segments.is_empty() && length.segments.is_none() {
            return Err(Scarce::NoSegments);
        }
        let samples = match length.samples {
            Some(samples) => samples,
            None if self.seconds.is_empty() => 1.0,
            None => return Err(Scarce::NoLength),
        };
        let rate = dictionary.sample_rate_hz;
        let share = |name: &String| match (self.seconds.get(name), self.segments.get(name)) {
            (Some(seconds), _) => seconds * rate / samples,
            (_, Some(segments)) => *segments as f64 / length.segments.map_or(1.0, |(n, _)| n as f64),
            _ => 1.0,
        };
        let count = |name: &String, (total, each): (u64, u64)| match (
            self.seconds.get(name),
            self.segments.get(name),
        ) {
            // Rounding must not remove a segment that just fits.
            (Some(seconds), _) => (seconds * rate / each as f64 + 1e-9).floor() as u64,
            (_, Some(segments)) => *segments,
            _ => total,
        };
        let names = || dictionary.maneuvers.iter();
        let found = Available {
            shares: names().map(|name| share(name).min(1.0)).collect(),
            counts: length
                .segments
                .map(|about| names().map(|name| count(name, about).min(about.0)).collect()),
        };
        found.check_enough(length)?;
        Ok(found)
    }
}

impl Available {
    fn check_enough(&self, length: &Length) -> Result<(), Scarce> {
        let share: f64 = self.shares.iter().sum();
        if share < 1.0 - 1e-12 {
            return Err(Scarce::Time { share });
        }
        if let (Some(counts), Some((expected, _))) = (&self.counts, length.segments) {
            let found: u128 = counts.iter().map(|a| u128::from(*a)).sum();
            if found < u128::from(expected) {
                return Err(Scarce::Segments { found, expected });
            }
        }
        Ok(())
    }
}
