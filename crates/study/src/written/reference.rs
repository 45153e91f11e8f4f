use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use refusal::{Invalid, check_numbers};
use validation::selection::PublishedLimits;

/// `reference.toml` of a study: results published elsewhere, for comparison. They change no result: the limits of a
/// selection study only set from where realizations are counted.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// The publication.
    pub source: String,
    /// Other uses than comparison, if any: sentences for the page.
    pub used: Option<String>,
    /// Published shares of the optimized design, by maneuver.
    #[serde(default)]
    pub shares: BTreeMap<String, f64>,
    /// Published shares of runs under the bounds, by design.
    #[serde(default)]
    pub designs: BTreeMap<String, Published>,
    /// A published selection study.
    pub selection: Option<PublishedSelection>,
    /// Values of captive tests for numbers of a ship with forces, by name: in the prime system where a number has one, else in
    /// SI units.
    #[serde(default)]
    pub derivatives: BTreeMap<String, f64>,
}

impl Reference {
    /// Refuses invalid numbers.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self) -> Result<(), Invalid> {
        let limits = self.selection.iter().flat_map(|s| {
            [
                ("limit_u", s.limit_u),
                ("limit_v", s.limit_v),
                ("limit_r", s.limit_r),
                ("limit_norm", s.limit_norm),
            ]
        });
        let limits = limits.map(|(key, value)| (format!("selection.{key}"), value));
        check_numbers(limits, "more than zero", |value| value > 0.0)?;
        let maneuvers = self.shares.iter().map(|(name, share)| (format!("shares.{name}"), *share));
        let degenerate =
            self.selection.iter().flat_map(|s| [("optimized", &s.optimized), ("random", &s.random)]);
        let degenerate = degenerate.filter_map(|(name, picks)| {
            Some((format!("selection.{name}.degenerate_share"), picks.degenerate_share?))
        });
        let designs = self.designs.iter().flat_map(|(name, published)| {
            let keys = ["parameter_error_share", "simulation_error_share"]
                .map(|key| format!("designs.{name}.{key}"));
            let shares = [published.parameter_error_share, published.simulation_error_share];
            keys.into_iter().zip(shares.map(PublishedShare::printed))
        });
        let derivatives =
            self.derivatives.iter().map(|(name, value)| (format!("derivatives.{name}"), *value));
        check_numbers(derivatives, "a finite number", f64::is_finite)?;
        let shares = maneuvers.chain(degenerate).chain(designs);
        check_numbers(shares, "a share from 0 to 1", |value| (0.0..=1.0).contains(&value))
    }
}

impl PublishedShare {
    fn printed(self) -> f64 {
        match self {
            Self::Value(share) | Self::Above { above: share } => share,
        }
    }
}

/// A published selection study: the limits of its figures, and its statements.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedSelection {
    /// RMSE in surge from which values are truncated \[m/s\].
    pub limit_u: f64,
    /// In sway \[m/s\].
    pub limit_v: f64,
    /// In yaw rate \[rad/s\].
    pub limit_r: f64,
    /// The norm of the three.
    pub limit_norm: f64,
    /// Statements about the result.
    #[serde(default)]
    pub statements: Vec<String>,
    /// The optimized selection.
    #[serde(default)]
    pub optimized: PublishedPicks,
    /// The random selection.
    #[serde(default)]
    pub random: PublishedPicks,
}

impl From<&PublishedSelection> for PublishedLimits {
    fn from(published: &PublishedSelection) -> Self {
        Self {
            rmse_norm: published.limit_norm,
            rmse_u: published.limit_u,
            rmse_v: published.limit_v,
            rmse_r: published.limit_r,
        }
    }
}

/// The published results of one way of picking.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedPicks {
    /// Share of degenerate realizations.
    pub degenerate_share: Option<f64>,
    /// The best case, shown next to the other's.
    pub best: Option<String>,
    /// The worst case, shown next to the other's.
    pub worst: Option<String>,
}

/// Published shares of one design.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Share of runs below the bound on the parameter error.
    pub parameter_error_share: PublishedShare,
    /// Share of runs below the bound on the simulation error.
    pub simulation_error_share: PublishedShare,
}

/// A share as printed: a value, or more than a value.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum PublishedShare {
    /// As printed.
    Value(f64),
    /// Printed as "more than".
    Above {
        /// The printed bound.
        above: f64,
    },
}
