use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
        let checked = self.information.balanced().and_then(|balanced| balanced.candidates.check_excitation());
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
                let part = |i: &usize| size(offset + *i);
                let most = (0..degree.parameters.len()).map(|i| part(&i)).fold(0.0, f64::max);
                // Of terms that are alike, the last one has been added to the others.
                let place = (0..degree.parameters.len()).rev().find(|i| part(i) >= ALIKE * most).unwrap_or(0);
                NoDesign::Unexcited {
                    degree: degree.name.clone(),
                    parameter: degree.parameters[place].clone(),
                    regressor: degree.regressors[place].clone(),
                }
            }
            Error::SingularCovariance { block, row } => {
                let (degree, first) = self.degree(first_row(block) + row);
                let name = degree.parameters.get(first_row(block) + row - first).or(degree.parameters.last());
                let (degree, parameter) = (degree.name.clone(), name.cloned().unwrap_or_default());
                NoDesign::Singular { degree, parameter }
            }
            other => NoDesign::Search(other),
        }
    }
}

/// Which relative standard error is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AccuracyOf {
    /// The root of the sum of the squared relative standard errors.
    Overall,
    /// The largest standard error of a figure of merit over the wanted one.
    Figures,
}

impl fmt::Display for AccuracyOf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Overall => "root of the sum of squared relative standard errors",
            Self::Figures => "largest standard error of a figure over the wanted one",
        })
    }
}

/// The accuracy that is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// The standard error, relative to the parameters or to those that are wanted of figures.
    pub accuracy: f64,
    /// Which one.
    pub of: AccuracyOf,
    /// The longest experiment \[s\].
    pub longest_s: f64,
}

/// An accuracy that the longest experiment does not reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfReach {
    /// What was wanted.
    pub wanted: Wanted,
    /// How long that takes; infinite if no time is enough \[s\].
    pub needed_s: f64,
    /// What the longest experiment reaches.
    pub best: f64,
}

impl fmt::Display for OutOfReach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { wanted, needed_s, best } = self;
        write!(f, "found {} ({}), ", wanted.accuracy, wanted.of)?;
        match needed_s.is_finite() {
            true => write!(f, "which takes {needed_s:.1} s")?,
            false => f.write_str("which no time gives")?,
        }
        write!(f, ", expected one that {} s can reach: the best is {best:.4}", wanted.longest_s)
    }
}

/// Why the available maneuvers are not enough for an experiment.
#[derive(Clone, Copy, Debug, thiserror::Error, PartialEq)]
pub enum Scarce {
    /// Segments are limited, and the experiment has none.
    #[error("whole segments are limited, but the experiment has none")]
    NoSegments,
    /// Seconds are limited, and the length of the experiment is not known.
    #[error("seconds are limited, but the length of the experiment is not known")]
    NoLength,
    /// All maneuvers together do not fill the experiment.
    #[error("what is available fills {share} of the experiment")]
    Time {
        /// The share of the experiment that they fill, below 1.
        share: f64,
    },
    /// All maneuvers together have too few whole segments.
    #[error("{found} of {expected} whole segments are available")]
    Segments {
        /// Whole segments that are available.
        found: u128,
        /// Whole segments of the experiment.
        expected: u64,
    },
}

/// Why there is no design.
#[derive(Clone, Debug, thiserror::Error, PartialEq)]
pub enum NoDesign {
    /// A direction of the parameters that no maneuver excites.
    #[error("no maneuver excites `{parameter}` ({degree}) apart from the other parameters")]
    Unexcited {
        /// Degree of freedom.
        degree: String,
        /// The dominant parameter of the direction.
        parameter: String,
        /// The regressor of that parameter.
        regressor: String,
    },
    /// A singular covariance: the disturbances do not affect a parameter.
    #[error("the covariance gives `{parameter}` ({degree}) no variance of its own")]
    Singular {
        /// Degree of freedom.
        degree: String,
        /// The parameter.
        parameter: String,
    },
    /// Not enough of the maneuvers is available.
    #[error(transparent)]
    Scarce(#[from] Scarce),
    /// A standard error that the longest experiment cannot reach.
    #[error("{0}")]
    OutOfReach(OutOfReach),
    /// The problem or its search, without a parameter to name.
    #[error(transparent)]
    Search(Error),
}
