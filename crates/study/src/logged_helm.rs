//! Maneuvers that are steered by the sensors that are logged: their inputs follow the noise of the log.

use std::path::Path;

use estimation::Estimator;
use files::{Error, Provenance};
use maneuver::Generator;
use serde_json::json;

/// The setting of trajectories that lists them.
const LOGGED_HELM: &str = "steered_by_logged_sensors";

/// Their names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoggedHelm(Vec<String>);

impl LoggedHelm {
    /// Those of a dictionary.
    pub fn among(generator: &Generator) -> Self {
        let logged = generator.maneuvers().iter().filter(|maneuver| maneuver.is_steered_by_the_log());
        Self(logged.map(|maneuver| maneuver.name.clone()).collect())
    }

    /// Those of the trajectories of `provenance`.
    pub fn of(provenance: &Provenance) -> Self {
        let noted = provenance.settings.get(LOGGED_HELM).cloned();
        Self(noted.and_then(|noted| serde_json::from_value(noted).ok()).unwrap_or_default())
    }

    /// Notes them, if there are any, in `provenance`.
    pub fn note(&self, provenance: &mut Provenance) {
        if !self.0.is_empty() {
            provenance.settings.insert(LOGGED_HELM.to_owned(), json!(self.0));
        }
    }

    /// Refuses instruments that are simulated over recorded inputs, since these follow the noise of the regressors: estimates
    /// were wrong by 80 % where that was tried.
    ///
    /// # Errors
    /// Names the maneuver and the estimator.
    pub fn check(&self, file: &Path, estimators: &[Estimator]) -> Result<(), Error> {
        let by_instruments = |own: &&Estimator| own.by_instruments() || **own == Estimator::Auto;
        let (Some(name), Some(estimator)) = (self.0.first(), estimators.iter().find(by_instruments)) else {
            return Ok(());
        };
        Err(Error::refuse(
            file,
            format!("maneuver `{name}`"),
            format!(
                "inputs that follow the noise of the logged sensors, by which it is steered, and --estimator {estimator}"
            ),
            "an estimator that takes no recorded input as free of that noise",
            "use --estimator output-error, or steer by sensors of the helmsman's own (`sensors = \"own\"`)",
        ))
    }
}
