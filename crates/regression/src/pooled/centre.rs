use std::sync::Arc;

use crate::bounded::estimated;
use crate::{MeanRemoval, Sums};

/// The means that are subtracted from instruments and regressors of each part: over all parts, over the part, or
/// none.
#[derive(Clone, Debug)]
pub struct Centring {
    removal: MeanRemoval,
    parts: AllMeans,
}

/// The means of every part, or of all together.
pub(super) type AllMeans = Arc<Vec<[Means; 3]>>;

/// Means of one degree of freedom.
#[derive(Clone, Debug, Default)]
pub(super) struct Means {
    zeta: Vec<f64>,
    phi: Vec<f64>,
    target: f64,
    /// Whether a term 1 is the intercept.
    constant: bool,
    /// Whether some parameters are bounded.
    bounded: bool,
}

impl Centring {
    /// From the means of every part, or of all together.
    pub(super) fn of(removal: MeanRemoval, parts: AllMeans) -> Self {
        Self { removal, parts }
    }

    /// Number of unknowns of degree of freedom `d`: intercepts, and those of `p` parameters that are not at a bound,
    /// by the `gain` of their estimate.
    pub(super) fn unknowns(&self, d: usize, gain: &[f64], p: usize) -> usize {
        let is = |of: fn(&Means) -> bool| self.parts.first().is_some_and(|means| of(&means[d]));
        let parameters = if is(|means| means.bounded) { estimated(p, |k| gain[k]) } else { p };
        let none = self.removal == MeanRemoval::None || is(|means| means.constant);
        parameters + if none { 0 } else { self.parts.len() }
    }

    fn at(&self, part: usize, d: usize) -> &Means {
        let group = if self.removal == MeanRemoval::Batch { part } else { 0 };
        &self.parts[group][d]
    }

    /// `row` of the instruments of part `part` without their means.
    pub fn zeta(&self, part: usize, d: usize, row: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.extend(row.iter().zip(&self.at(part, d).zeta).map(|(z, mean)| z - mean));
    }

    /// `row` of the regressors of part `part` without their means.
    pub fn phi(&self, part: usize, d: usize, row: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.extend(row.iter().zip(&self.at(part, d).phi).map(|(f, mean)| f - mean));
    }

    /// The intercept that goes with `theta` in part `part`: mean of Δy − φᵀθ.
    pub fn intercept(&self, part: usize, d: usize, theta: &[f64]) -> f64 {
        let means = self.at(part, d);
        means.target - means.phi.iter().zip(theta).map(|(f, t)| f * t).sum::<f64>()
    }
}

impl Means {
    /// Of surge, sway and yaw in `sums`; of instruments and regressors 0 where they are not `removed`.
    pub(super) fn of(sums: &Sums, removed: bool) -> [Self; 3] {
        [0, 1, 2].map(|d| {
            let degree = &sums.degrees[d];
            let removed = removed && sums.samples > 0 && !degree.known.constant;
            let share = if removed { 1.0 / sums.samples as f64 } else { 0.0 };
            let (p, lifted) = (degree.parameters(), degree.parameters() + 1);
            Self {
                zeta: (0..p).map(|i| share * degree.a[i * lifted + p]).collect(),
                phi: (0..p).map(|i| share * degree.a[p * lifted + i]).collect(),
                target: share * degree.b[p],
                constant: degree.known.constant,
                bounded: !degree.known.bounds.is_empty(),
            }
        })
    }
}
