use design::{Candidates, Criterion, CriterionName, Dictionary, NoDesign, Norm, WeightedFigure};
use refusal::Invalid;
use ship::model::Source;

use super::{Estimated, Moments};

/// A criterion and what it is of.
#[derive(Clone, Debug)]
pub struct CriterionOf<'a> {
    /// Its name.
    pub name: CriterionName,
    /// The estimate.
    pub estimated: Estimated,
    /// The parameters that errors are relative to.
    pub relative_to: Source,
    /// The figures of [`CriterionName::Figures`], and the parameters, not 0, that these were differentiated at.
    pub figures: (&'a [WeightedFigure], &'a [f64]),
}

/// Why moments have no criterion.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum NoCriterion {
    /// What the moments lack.
    #[error("{0}")]
    Moments(Invalid),
    /// A covariance that is not defined.
    #[error(transparent)]
    Design(#[from] NoDesign),
}

impl From<Invalid> for NoCriterion {
    fn from(invalid: Invalid) -> Self {
        Self::Moments(invalid)
    }
}

impl Moments {
    /// The criterion over the maneuvers of `dictionary`, and B_q of these where it is one of the covariance.
    ///
    /// # Errors
    /// Moments without what the criterion is computed from; a singular covariance.
    pub fn criterion(
        &self,
        dictionary: &Dictionary,
        of: &CriterionOf,
    ) -> Result<(Criterion, Option<Candidates>), NoCriterion> {
        if of.name == CriterionName::DHessian {
            return Ok((Criterion::Information(dictionary.information.clone()), None));
        }
        // Checked before the meat: its refusals name the parameter.
        let weights = match of.name {
            CriterionName::ARelative => self.squares(of.relative_to)?.iter().map(|s| 1.0 / s).collect(),
            _ => vec![1.0; dictionary.parameters()],
        };
        let meat = self.middle(of.estimated)?;
        let criterion = match of.name {
            CriterionName::V => Criterion::of_free_runs(dictionary, &meat, self.free_run_weights()?),
            CriterionName::Figures => Criterion::of_figures(dictionary, &meat, of.figures.0, of.figures.1),
            CriterionName::D => Criterion::of_covariance(dictionary, &meat, weights, Norm::LogDet),
            _ => Criterion::of_covariance(dictionary, &meat, weights, Norm::Trace),
        };
        Ok((criterion?, Some(meat)))
    }
}
