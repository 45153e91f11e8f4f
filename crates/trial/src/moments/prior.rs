//! What is known of parameters before a trial.

use std::collections::BTreeMap;

use estimation::pooled::Covariance;
use numerics::scaled_inverse;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::Model;

use super::Moments;

impl Moments {
    /// The same for a trial of `samples`, to each sample of which adds its part what is known before.
    #[must_use]
    pub fn with_prior(mut self, samples: f64) -> Self {
        let (Some(prior), Some(model)) = (&self.prior, &self.output_error) else { return self };
        for moments in self.maneuvers.iter_mut().filter_map(|maneuver| maneuver.output_error.as_mut()) {
            for matrix in [Some(&mut moments.f), moments.e.as_mut()].into_iter().flatten() {
                if matrix.len() == model.rows.len() * model.rows.len() {
                    prior.add_to(matrix, &model.rows, samples);
                }
            }
        }
        self
    }

    /// How much of each estimate is known before, from 0 to 1, after `samples` of these `shares` of the maneuvers, of moments
    /// with that; `None` where nothing is, or the information is singular.
    pub fn prior_shares(&self, shares: &[f64], samples: f64) -> Option<BTreeMap<String, f64>> {
        let (prior, rows) = (self.prior.as_ref()?, &self.output_error.as_ref()?.rows);
        let n = rows.len();
        let mut sum = vec![0.0; n * n];
        for (share, maneuver) in shares.iter().zip(&self.maneuvers) {
            let f = &maneuver.output_error.as_ref()?.f;
            sum.iter_mut().zip(f).for_each(|(sum, entry)| *sum += share * samples * entry);
        }
        let mut known = vec![0.0; n * n];
        prior.add_to(&mut known, rows, 1.0);
        let inverse = scaled_inverse(n, &sum)?;
        let share = |i: usize| (0..n).map(|j| inverse[i * n + j] * known[j * n + i]).sum::<f64>();
        let parameters = self.degrees.iter().flat_map(|degree| &degree.parameters);
        let place = |name: &String| rows.iter().position(|row| row == name);
        parameters.map(|name| Some((name.clone(), share(place(name)?).clamp(0.0, 1.0)))).collect()
    }
}

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
    /// What the priors of `model`'s parameters know; `None` without any.
    pub fn of(model: &Model) -> Option<Self> {
        let deviations = model.prior_deviations();
        let known = |name: &str| {
            let place = model.parameter_names().position(|other| other == name)?;
            deviations[place]
        };
        Self::new(model.parameter_names(), None, known)
    }

    /// The information in `covariance` about the parameters of `names` that it knows, whatever others are; what else `known` has
    /// is 1/σ². `None` where there is nothing.
    pub fn new<'n>(
        names: impl Iterator<Item = &'n str>,
        covariance: Option<&Covariance>,
        known: impl Fn(&str) -> Option<f64>,
    ) -> Option<Self> {
        let place = |name: &str| {
            let fitted = covariance?;
            let place = fitted.names.iter().position(|other| other == name)?;
            // Estimates at bounds have no variance.
            (fitted.entries[place * (fitted.names.len() + 1)] > 0.0).then_some(place)
        };
        let all: Vec<(&str, Option<usize>)> = names
            .map(|name| (name, place(name)))
            .filter(|(name, place)| place.is_some() || known(name).is_some())
            .collect();
        let n = all.len();
        let variances = |k: usize| match (all[k / n], all[k % n]) {
            ((_, Some(row)), (_, Some(column))) => {
                covariance.map_or(0.0, |matrix| matrix.entries[row * matrix.names.len() + column])
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
        let place = |name: &String| rows.iter().position(|row| row == name);
        let (n, places) = (rows.len(), self.parameters.iter().map(place).collect::<Vec<_>>());
        let of = |k: usize| Some((places[k / places.len()]?, places[k % places.len()]?));
        for (k, known) in self.information.iter().enumerate() {
            if let Some((row, column)) = of(k) {
                matrix[row * n + column] += known / samples;
            }
        }
    }
}
