use std::ops::Range;

use numerics::{quadratic, times};
use rayon::prelude::*;
use vessel::lanes::SideBySide;
use vessel::{LANES, Lane, Model};

use super::{Part, Parts};
use crate::predictor::{
    Asked, Ended, Linear, Minimum, Recordings, Residuals, STEPS, Weighting, linearize, minimize,
};

/// An estimate that minimises the errors of free simulations.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputError {
    /// Of the model, in its order.
    pub parameters: Vec<f64>,
    /// Their covariance, as many rows: (G − 1)/G Σ δ δᵀ with the change δ of the estimate where one of the G parts is left out,
    /// to first order (jackknife), so that errors may be correlated in any way within a part, and few parts do not make it
    /// too small. Zero for parameters held, and for those at a bound.
    pub covariance: Vec<f64>,
    /// Per parameter, how many parts would tell as much of it if all told alike; 0 for what is held.
    pub telling: Vec<f64>,
    /// Steps tried.
    pub steps: usize,
    /// Whether the search ended at a minimum.
    pub converged: bool,
}

impl OutputError {
    /// The covariance of the parameters at `places`, as many rows.
    pub(super) fn covariance_of(&self, places: Range<usize>) -> Vec<f64> {
        let all = self.parameters.len();
        let pairs = places.clone().flat_map(|i| places.clone().map(move |j| (i, j)));
        pairs.map(|(i, j)| self.covariance[i * all + j]).collect()
    }
}

/// Minimises Σ (e_d/std_d)² of free simulations over `parts`, each from its first measured state, by Levenberg and
/// Marquardt's method from `start` (parameters of `model`). `std`: of measured u, v, r. `sizes`: per parameter the change
/// that would matter; 0 holds it. `None` where the start diverges or a parameter has no effect of its own.
///
/// # Errors
/// Parts that cannot be read, all of which every step of the search looks at.
pub fn output_error<P: Parts>(
    model: &Model,
    parts: &P,
    start: &[f64],
    std: [f64; 3],
    sizes: &[f64],
) -> Result<Option<OutputError>, P::Error> {
    let free = (0..sizes.len()).filter(|i| sizes[*i] > 0.0).collect();
    let mut problem = Problem { model, parts, order: by_length(parts), held: start.to_vec(), free };
    let weights = std.map(|s| if s > 0.0 { s.powi(-2) } else { 0.0 });
    let from = problem.free.iter().map(|i| start[*i]).collect();
    let found = minimize(&mut problem, vec![Weighting::Fixed(weights)], vec![from], STEPS)?.pop();
    let Some(found) = found.filter(|found| matches!(found.status, Ended::Converged | Ended::Stalled)) else {
        return Ok(None);
    };
    Ok(problem.spread(&found, weights)?.map(|(covariance, telling)| OutputError {
        covariance,
        telling,
        parameters: problem.whole(&found.point),
        steps: found.steps,
        converged: found.status == Ended::Converged,
    }))
}

/// One problem: the free simulations over all parts, [`LANES`] of them at a time.
struct Problem<'a, P> {
    model: &'a Model,
    parts: &'a P,
    /// Places of the parts: those of similar length are simulated side by side.
    order: Vec<usize>,
    held: Vec<f64>,
    free: Vec<usize>,
}

/// The longest first.
fn by_length(parts: &impl Parts) -> Vec<usize> {
    let mut order: Vec<usize> = (0..parts.count()).collect();
    order.sort_by_key(|i| std::cmp::Reverse(parts.samples(*i)));
    order
}

impl<P: Parts> Problem<'_, P> {
    /// All parameters of a point.
    fn whole(&self, point: &[f64]) -> Vec<f64> {
        let mut whole = self.held.clone();
        self.free.iter().zip(point).for_each(|(i, value)| whole[*i] = *value);
        whole
    }

    /// Calls `look` with every part linearised, in order.
    fn each(&self, point: &[f64], mut look: impl FnMut(&Linear)) -> Result<(), P::Error> {
        let whole = self.whole(point).into_iter().chain([0.0; 3]);
        let unknowns: Vec<Lane> = whole.map(Lane::splat).collect();
        let together = LANES * rayon::current_num_threads();
        let mut waiting: Vec<Part> = Vec::with_capacity(together);
        self.parts.at(&self.order, |part| {
            waiting.push(Part::new("", "", part.run));
            if waiting.len() == together {
                self.linears(&waiting, &unknowns).iter().for_each(&mut look);
                waiting.clear();
            }
        })?;
        self.linears(&waiting, &unknowns).iter().for_each(look);
        Ok(())
    }

    /// Parts linearised, [`LANES`] of them by a thread.
    fn linears(&self, parts: &[Part], unknowns: &[Lane]) -> Vec<Linear> {
        let linear = |parts: &[Part]| {
            let group = SideBySide::of(&parts.iter().map(Part::view).collect::<Vec<_>>());
            let recordings = Recordings::of(self.model, &group);
            let mut found = linearize::<3>(&recordings, unknowns, &self.free, None, &[], false);
            found.truncate(group.runs);
            found
        };
        parts.par_chunks(LANES).flat_map_iter(linear).collect()
    }

    /// The covariance of all parameters, and how many parts tell of each.
    fn spread(&self, found: &Minimum, weights: [f64; 3]) -> Result<Option<Spread>, P::Error> {
        let Ok(inverse) = found.inverse(weights) else { return Ok(None) };
        let (all, free, parts) = (self.held.len(), self.free.len(), self.parts.count() as f64);
        let (mut covariance, mut told) = (vec![0.0; all * all], vec![[0.0; 2]; all]);
        self.each(&found.point, |part| {
            let (normal, gradient) = part.weighted(weights);
            // Without a part that alone determines a parameter there is no estimate: it counts as one that tells little.
            let moved = found.without(part, weights).unwrap_or_else(|_| times(&inverse, &gradient));
            for (i, (row, a)) in self.free.iter().zip(&moved).enumerate() {
                for (column, b) in self.free.iter().zip(&moved) {
                    covariance[row * all + column] += (parts - 1.0) / parts * a * b;
                }
                let share = quadratic(&inverse[i * free..(i + 1) * free], &normal);
                told[*row] = [told[*row][0] + share, told[*row][1] + share * share];
            }
        })?;
        let alike = |[sum, squares]: [f64; 2]| if squares > 0.0 { sum * sum / squares } else { 0.0 };
        Ok(Some((covariance, told.into_iter().map(alike).collect())))
    }
}

/// [`OutputError::covariance`] and [`OutputError::telling`].
type Spread = (Vec<f64>, Vec<f64>);

impl<P: Parts> Residuals for Problem<'_, P> {
    type Error = P::Error;

    fn linearize(&mut self, asked: &[Asked]) -> Result<Vec<Linear>, P::Error> {
        let mut totals = Vec::new();
        for Asked { point, .. } in asked {
            let mut total: Option<Linear> = None;
            self.each(point, |part| match &mut total {
                Some(total) => total.add(part),
                None => total = Some(part.clone()),
            })?;
            totals.extend(total);
        }
        Ok(totals)
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        let all = self.model.bounds();
        all.map_or(Vec::new(), |all| self.free.iter().map(|i| all[*i]).collect())
    }
}
