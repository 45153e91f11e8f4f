use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::no_design::NoDesign;
use crate::{Candidates, Error};

/// Parts of a direction that are at least this fraction of the largest one count as large as it.
const ALIKE: f64 = 0.9;

/// One degree of freedom of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Degree {
    /// `surge`, `sway` or `yaw`.
    pub name: String,
    /// What each parameter multiplies, in order; the intercept, `1`, may follow.
    pub regressors: Vec<String>,
    /// Parameters θ in order.
    pub parameters: Vec<String>,
}

/// The information of a dictionary's maneuvers about a model's parameters.
#[derive(Clone, Debug)]
pub struct Dictionary {
    /// The degrees of freedom.
    pub degrees: Vec<Degree>,
    /// Names of the maneuvers, in the candidates' order.
    pub maneuvers: Vec<String>,
    /// Samples per second \[Hz\].
    pub sample_rate_hz: f64,
    /// Whether an intercept follows the parameters of every degree of freedom.
    pub intercepts: bool,
    /// The information of one sample of every maneuver: the rows of the degrees of freedom in order, in one block
    /// each or in a common block.
    pub information: Candidates,
}

impl Dictionary {
    /// Number of parameters, without intercepts.
    pub fn parameters(&self) -> usize {
        self.degrees.iter().map(|d| d.parameters.len()).sum()
    }

    /// Names of the parameters, without intercepts.
    pub fn parameter_names(&self) -> impl Iterator<Item = &str> {
        self.degrees.iter().flat_map(|d| d.parameters.iter().map(String::as_str))
    }

    /// One value per row: those of the parameters, 0 for the intercepts.
    pub fn by_row(&self, of_parameters: &[f64]) -> Vec<f64> {
        let mut rest = of_parameters.iter().copied();
        let mut rows = Vec::new();
        for degree in &self.degrees {
            rows.extend(rest.by_ref().take(degree.parameters.len()));
            rows.extend(self.intercepts.then_some(0.0));
        }
        rows
    }

    /// The rows of the parameters.
    pub fn parameter_rows(&self) -> Vec<usize> {
        let (mut rows, mut next) = (Vec::new(), 0);
        for degree in &self.degrees {
            rows.extend(next..next + degree.parameters.len());
            next += self.width(degree);
        }
        rows
    }

    /// Rows of a degree of freedom.
    fn width(&self, degree: &Degree) -> usize {
        degree.parameters.len() + usize::from(self.intercepts)
    }

    /// The degree of freedom of a row over all blocks, and the degree's first row.
    fn degree(&self, row: usize) -> (&Degree, usize) {
        let mut first = 0;
        for degree in &self.degrees {
            if row < first + self.width(degree) {
                return (degree, first);
            }
            first += self.width(degree);
        }
        (&self.degrees[0], 0)
    }

    /// Refuses maneuvers of which no mixture excites every parameter.
    ///
    /// # Errors
    /// [`NoDesign::Unexcited`] names one that is not; as [`Candidates::scaled`].
    pub fn check_excited(&self) -> Result<(), NoDesign> {
        let checked = self.information.balanced().and_then(|own| own.candidates.check_excitation());
        checked.map_err(|error| self.explain(error))
    }

    /// Expresses `error`, which is about blocks and rows of the information, in terms of the parameters.
    pub fn explain(&self, error: Error) -> NoDesign {
        let first_row = |block: usize| self.information.blocks().take(block).map(|(n, _)| n).sum::<usize>();
        match error {
            Error::Unexcited { block, direction } => {
                let size = |i: usize| direction.get(i).copied().unwrap_or(0.0).abs();
                let largest = (0..direction.len()).max_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap_or(0);
                let (degree, first) = self.degree(first_row(block) + largest);
                // In a common block, the direction's rows are those of all degrees of freedom.
                let offset = first - first_row(block);
                let own = |i: &usize| size(offset + *i);
                let most = (0..degree.parameters.len()).map(|i| own(&i)).fold(0.0, f64::max);
                // Of terms that are alike, the last one has been added to the others.
                let parameter =
                    (0..degree.parameters.len()).rev().find(|i| own(i) >= ALIKE * most).unwrap_or(0);
                NoDesign::Unexcited {
                    degree: degree.name.clone(),
                    parameter: degree.parameters[parameter].clone(),
                    regressor: degree.regressors[parameter].clone(),
                }
            }
            Error::SingularCovariance { block, row } => {
                let (degree, first) = self.degree(first_row(block) + row);
                let own = degree.parameters.get(first_row(block) + row - first).or(degree.parameters.last());
                NoDesign::Singular {
                    degree: degree.name.clone(),
                    parameter: own.cloned().unwrap_or_default(),
                }
            }
            other => NoDesign::Search(other),
        }
    }
}
