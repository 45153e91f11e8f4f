//! Standard errors of a search's unknowns, and their covariance.

use ship::model::ParameterLayout;

/// Standard errors of all unknowns.
#[derive(Clone, Debug)]
pub(crate) struct Errors {
    /// One per unknown.
    pub each: Vec<f64>,
    /// The covariance of the unknowns, as many rows, row-major; none where errors are the largest of several.
    pub covariance: Option<Vec<f64>>,
    /// Whether they are approximate, since errors follow no known kind of noise.
    pub approximate: bool,
}

impl Errors {
    /// Those on the diagonal of `covariance`.
    pub fn of(covariance: Vec<f64>) -> Self {
        Self { each: roots(&covariance), covariance: Some(covariance), approximate: false }
    }

    /// The larger of both, unknown by unknown, which no covariance belongs to.
    pub fn largest(self, other: Self) -> Self {
        let each = self.each.into_iter().zip(other.each).map(|(a, b)| a.max(b)).collect();
        Self { each, covariance: None, approximate: self.approximate || other.approximate }
    }

    /// With every error times `factor`.
    pub fn times(self, factor: f64) -> Self {
        let each = self.each.into_iter().map(|error| factor * error).collect();
        Self { each, covariance: self.covariance.map(|covariance| scaled(covariance, factor)), ..self }
    }
}

/// `covariance`, if every error is multiplied by `factor`.
pub(crate) fn scaled(mut covariance: Vec<f64>, factor: f64) -> Vec<f64> {
    covariance.iter_mut().for_each(|entry| *entry *= factor * factor);
    covariance
}

/// The part of `covariance`, of a model's parameters, intercepts and perhaps further unknowns, that the terms' parameters
/// have.
pub(crate) fn of_terms(layout: ParameterLayout, covariance: &[f64]) -> Vec<f64> {
    let all = covariance.len().isqrt();
    let numbers: Vec<usize> = (0..layout.parameters()).collect();
    let places = layout.theta(&numbers);
    places.iter().flat_map(|i| places.iter().map(move |j| covariance[i * all + j])).collect()
}

/// `covariance` without the rows and columns of parameters that are held: those whose standard error is 0.
pub(crate) fn held(mut covariance: Vec<f64>, standard_errors: &[f64]) -> Vec<f64> {
    let p = standard_errors.len();
    for (i, _) in standard_errors.iter().enumerate().filter(|(_, error)| **error == 0.0) {
        for j in 0..p {
            covariance[i * p + j] = 0.0;
            covariance[j * p + i] = 0.0;
        }
    }
    covariance
}

/// Roots of a diagonal.
pub(crate) fn roots(covariance: &[f64]) -> Vec<f64> {
    let p = covariance.len().isqrt();
    covariance.iter().step_by(p + 1).map(|variance| variance.sqrt()).collect()
}
