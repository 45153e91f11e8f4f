//! What is known of parameters before a trial.

use estimation::pooled::Covariance;
use numerics::scaled_inverse;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is known of parameters before the trial: it counts once for the whole trial, as `F` times samples does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PriorInformation {
    /// The parameters that something is known of.
    pub parameters: Vec<String>,
    /// The inverse of their covariance, row-major: that of a fit, or 1/σ² of each by its prior, σ its standard deviation.
    pub information: Vec<f64>,
}

impl PriorInformation {
    /// The information in `covariance` about the parameters of `names` that it knows, whatever others are; what else `known` has
    /// is 1/σ². `None` where there is nothing.
    pub fn new<'n>(
        names: impl Iterator<Item = &'n str>,
        covariance: Option<&Covariance>,
        known: impl Fn(&str) -> Option<f64>,
    ) -> Option<Self> {
        let place = |name: &str| {
            let own = covariance?;
            let place = own.names.iter().position(|other| other == name)?;
            // Estimates at bounds have no variance.
            (own.entries[place * (own.names.len() + 1)] > 0.0).then_some(place)
        };
        let all: Vec<(&str, Option<usize>)> = names
            .map(|name| (name, place(name)))
            .filter(|(name, place)| place.is_some() || known(name).is_some())
            .collect();
        let n = all.len();
        let variances = |k: usize| match (all[k / n], all[k % n]) {
            ((_, Some(row)), (_, Some(column))) => {
                covariance.map_or(0.0, |own| own.entries[row * own.names.len() + column])
            }
            ((name, None), _) if k / n == k % n => known(name).map_or(0.0, |sigma| sigma * sigma),
            _ => 0.0,
        };
        let variances: Vec<f64> = (0..n * n).map(variances).collect();
        let information = scaled_inverse(n, &variances)?;
        let parameters = all.into_iter().map(|(name, _)| name.to_owned()).collect();
        (n > 0).then_some(Self { parameters, information })
    }

    /// Adds its part in each of `samples` to `matrix`, whose rows and columns are `rows`.
    pub(crate) fn add_to(&self, matrix: &mut [f64], rows: &[String], samples: f64) {
        let place = |name: &String| rows.iter().position(|own| own == name);
        let (n, places) = (rows.len(), self.parameters.iter().map(place).collect::<Vec<_>>());
        let of = |k: usize| Some((places[k / places.len()]?, places[k % places.len()]?));
        for (k, known) in self.information.iter().enumerate() {
            if let Some((row, column)) = of(k) {
                matrix[row * n + column] += known / samples;
            }
        }
    }
}
