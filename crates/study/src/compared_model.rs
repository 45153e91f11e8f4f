//! The subject of `validate --model`: a model, or several whose trajectories are averaged.

use std::path::Path;

use estimation::pooled::Covered;
use files::{Error, Provenance, read_document};
use refusal::Invalid;
use ship::model::Vessel;
use validation::comparison::{EstimatedErrors, Magnitudes, Standing};

use crate::documents::ModelDocument;
use crate::tables::trajectories::rate_of;
use crate::written::files::read_any_vessel_as;

/// A `model.json`, with the models that it averages.
pub struct Tried {
    models: Vec<ModelDocument>,
    vessels: Vec<Vessel>,
    output_rmse: Option<[f64; 3]>,
    by_least_squares: Option<Vessel>,
}

impl Tried {
    /// Reads it as the input `model`; of a vessel.toml the nominal numbers are tried.
    ///
    /// # Errors
    /// A file of another kind, or a damaged one; models that do not belong together.
    pub fn read(path: &Path, provenance: &mut Provenance) -> Result<Self, Error> {
        if path.extension().is_some_and(|extension| extension == "toml") {
            let vessel = read_any_vessel_as("model", path, provenance)?;
            return Ok(Self {
                models: Vec::new(),
                vessels: vec![vessel],
                output_rmse: None,
                by_least_squares: None,
            });
        }
        let model = read_document::<ModelDocument>(path)?;
        provenance.made("model", path, model.digest, &model.provenance)?;
        Self::of(model.data).map_err(|e| crate::invalid(path, &e))
    }

    /// A ship with forces that was not fitted, at the rate of the trajectories at `path`; others keep theirs.
    #[must_use]
    pub fn at_rate_of(mut self, path: &Path) -> Self {
        if let (true, Some(rate_hz)) = (self.models.is_empty(), rate_of(path)) {
            let ships = self.vessels.iter_mut().filter(|vessel| !vessel.model.has_regressors());
            ships.for_each(|vessel| {
                *vessel = vessel.clone().at_rate(rate_hz).unwrap_or_else(|_| vessel.clone())
            });
        }
        self
    }

    /// From a model in memory.
    ///
    /// # Errors
    /// A model that does not give a valid vessel.
    pub fn of(model: ModelDocument) -> Result<Self, Invalid> {
        let (models, output_rmse) = if model.members.is_empty() {
            let output_rmse = model.output_rmse();
            (vec![model], output_rmse)
        } else {
            (model.members.into_iter().map(|member| member.model).collect(), model.average_rmse)
        };
        let vessels = models.iter().map(ModelDocument::vessel).collect::<Result<Vec<_>, _>>()?;
        let by_least_squares = match models.as_slice() {
            [model] => model.by_least_squares()?,
            _ => None,
        };
        Ok(Self { models, vessels, output_rmse, by_least_squares })
    }

    /// Its standing in the comparison.
    pub fn standing(&self) -> Standing {
        if self.models.len() > 1 { Standing::Average } else { Standing::Model }
    }

    /// Its models, with the values that were found.
    pub fn vessels(&self) -> &[Vessel] {
        &self.vessels
    }

    /// The vessel, by the first of its models.
    pub fn vessel(&self) -> &Vessel {
        &self.vessels[0]
    }

    /// The same structure by least squares of the same data, if available.
    pub fn by_least_squares(&self) -> Option<&Vessel> {
        self.by_least_squares.as_ref()
    }

    /// Its estimated errors.
    pub fn known(&self) -> Option<EstimatedErrors<'_>> {
        let rmse = self.output_rmse?;
        match self.models.as_slice() {
            // Errors on left-out recordings include all sources, so that no covariance of the parameters is needed.
            [model] => match (model.errors_of_parameters(), model.left_out_rmse) {
                (None, None) => None,
                (None, Some(rmse)) => Some(EstimatedErrors { covariance: None, rmse }),
                (covariance, _) => Some(EstimatedErrors { covariance, rmse }),
            },
            _ => Some(EstimatedErrors { covariance: None, rmse }),
        }
    }

    /// The ranges that it was fitted on; all models of an average were fitted to the same data.
    pub fn covered(&self) -> &[Covered] {
        self.models.first().map_or(&[], |model| model.covered.as_slice())
    }

    /// The magnitudes of the motions that it was fitted to.
    pub fn magnitudes(&self) -> Option<&Magnitudes> {
        self.models.first()?.magnitudes.as_ref()
    }
}
