//! Whole segments of a design.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::dictionary::{Dictionary, Scarce};
use crate::{CountOptions, Counted, Criterion, Design, Error, apportion};

/// The requested whole segments.
#[derive(Clone, Debug, PartialEq)]
pub struct Segments {
    /// Their number n.
    pub total: u64,
    /// Samples of each.
    pub samples: u64,
    /// Maximum number of segments of every maneuver.
    pub limits: Option<Vec<u64>>,
}

impl Segments {
    /// So many segments of so many samples, within what is available; none of maneuvers that a restricted design does not use.
    pub fn within(
        (total, samples): (u64, u64),
        available: Option<&Available>,
        restricted: Option<&Design>,
    ) -> Self {
        let mut limits = available.and_then(|available| available.counts.clone());
        if let Some(design) = restricted {
            let known = limits.unwrap_or_else(|| vec![total; design.shares.len()]);
            let used = known.iter().zip(&design.shares);
            limits = Some(used.map(|(limit, share)| if *share > 0.0 { *limit } else { 0 }).collect());
        }
        Self { total, samples, limits }
    }
}

/// Counts of whole segments, and their efficiency against the shares.
#[derive(Clone, Debug, PartialEq)]
pub struct Whole {
    /// Segments of every maneuver.
    pub counts: Vec<u64>,
    /// The result of the search; `None` if all choices of so few segments are singular: then the shares are apportioned.
    pub found: Option<Counted>,
    /// Efficiency of the counts against the shares.
    pub efficiency: f64,
    /// Upper bound on the fraction of the experiment's time that the counts waste against the best shares.
    pub loss: f64,
    /// The fraction of the time that the counts need for the information of the apportioned shares.
    pub apportioned: f64,
}

/// The best counts. `parameters`: their number.
///
/// # Errors
/// As [`Criterion::count`].
pub fn counted(
    criterion: &Criterion,
    design: &Design,
    segments: &Segments,
    options: &CountOptions,
    parameters: usize,
) -> Result<Whole, Error> {
    let counted = match criterion.count(&design.shares, segments.total, segments.limits.as_deref(), options) {
        Err(Error::Solver(_)) => {
            let counts = apportion(&design.shares, segments.total);
            return Ok(Whole { counts, found: None, efficiency: 0.0, loss: 1.0, apportioned: 0.0 });
        }
        counted => counted?,
    };
    let shares: Vec<f64> = counted.counts.iter().map(|n| *n as f64 / segments.total as f64).collect();
    let degree = criterion.per_time(parameters);
    Ok(Whole {
        counts: counted.counts.clone(),
        efficiency: criterion.efficiency(design, &shares, parameters),
        loss: counted.loss_bound(design, degree),
        apportioned: libm::exp((counted.apportioned - counted.value) / degree),
        found: Some(counted),
    })
}

/// The available amount of every maneuver. Maneuvers in neither table are not limited.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stock {
    /// Maneuver → maximum time \[s\].
    #[serde(default)]
    #[schemars(extend("additionalProperties" = {"type": "number", "minimum": 0, "x-unit": "s"}))]
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
        let of = |name: &String| (self.seconds.get(name), self.segments.get(name));
        let share = |name: &String| match of(name) {
            (Some(seconds), _) => seconds * rate / samples,
            (_, Some(segments)) => *segments as f64 / length.segments.map_or(1.0, |(n, _)| n as f64),
            _ => 1.0,
        };
        let count = |name: &String, (total, each): (u64, u64)| match of(name) {
            // Rounding must not remove a segment that just fits.
            (Some(seconds), _) => (seconds * rate / each as f64 + 1e-9).floor() as u64,
            (_, Some(segments)) => *segments,
            _ => total,
        };
        let names = || dictionary.maneuvers.iter();
        let counts_of = |about: (u64, u64)| names().map(|name| count(name, about).min(about.0)).collect();
        let shares: Vec<f64> = names().map(|name| share(name).min(1.0)).collect();
        let counts: Option<Vec<u64>> = length.segments.map(counts_of);
        let share: f64 = shares.iter().sum();
        if share < 1.0 - 1e-12 {
            return Err(Scarce::Time { share });
        }
        if let (Some(counts), Some((expected, _))) = (&counts, length.segments) {
            let found: u128 = counts.iter().map(|a| u128::from(*a)).sum();
            if found < u128::from(expected) {
                return Err(Scarce::Segments { found, expected });
            }
        }
        Ok(Available { shares, counts })
    }
}
