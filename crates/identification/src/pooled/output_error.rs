use vessel::lanes::SideBySide;
use vessel::{LANES, Lane, Model, RunView};

use super::Part;
use crate::predictor::{
    Ended, Linear, Recordings, Residuals, STEPS, Weighting, linearize, minimize, scaled_inverse,
};

/// An estimate that minimises the errors of free simulations.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputError {
    /// Of the model, in its order.
    pub parameters: Vec<f64>,
    /// Their covariance, as many rows: H⁻¹ (Σ s sᵀ) H⁻¹ with the gradient s of each part, so that errors may be correlated
    /// in any way within a part. Zero for parameters held.
    pub covariance: Vec<f64>,
    /// Steps tried.
    pub steps: usize,
    /// Whether the search ended at a minimum.
    pub converged: bool,
}

/// Minimises Σ (e_d/std_d)² of free simulations over `parts`, each from its first measured state, by Levenberg and
/// Marquardt's method from `start` (parameters of `model`). `std`: of measured u, v, r. `sizes`: per parameter the change
/// that would matter; 0 holds it. `None` where the start diverges or a parameter has no effect of its own.
pub fn output_error(
    model: &Model,
    parts: &[Part],
    start: &[f64],
    std: [f64; 3],
    sizes: &[f64],
) -> Option<OutputError> {
    let problem = Problem {
        model,
        groups: side_by_side(parts),
        held: start.to_vec(),
        free: (0..sizes.len()).filter(|i| sizes[*i] > 0.0).collect(),
    };
    let weights = std.map(|s| if s > 0.0 { s.powi(-2) } else { 0.0 });
    let from = problem.free.iter().map(|i| start[*i]).collect();
    let found = minimize(&problem, vec![Weighting::Fixed(weights)], vec![from], STEPS).pop()?;
    if !matches!(found.status, Ended::Converged | Ended::Stalled) {
        return None;
    }
    Some(OutputError {
        covariance: problem.covariance(&found.point, weights)?,
        parameters: problem.whole(&found.point),
        steps: found.steps,
        converged: found.status == Ended::Converged,
    })
}

/// One problem: the free simulations over all parts, [`LANES`] of them at a time.
struct Problem<'a> {
    model: &'a Model,
    groups: Vec<SideBySide>,
    held: Vec<f64>,
    free: Vec<usize>,
}

/// Parts of similar length side by side.
fn side_by_side(parts: &[Part]) -> Vec<SideBySide> {
    let mut order: Vec<RunView> = parts.iter().map(Part::view).collect();
    order.sort_by_key(|part| std::cmp::Reverse(part.samples()));
    order.chunks(LANES).map(SideBySide::of).collect()
}

impl Problem<'_> {
    /// All parameters of a point.
    fn whole(&self, point: &[f64]) -> Vec<f64> {
        let mut whole = self.held.clone();
        self.free.iter().zip(point).for_each(|(i, value)| whole[*i] = *value);
        whole
    }

    /// Part by part.
    fn linears(&self, point: &[f64]) -> Vec<Linear> {
        let whole = self.whole(point).into_iter().chain([0.0; 3]);
        let unknowns: Vec<Lane> = whole.map(Lane::splat).collect();
        let mut all = Vec::new();
        for group in &self.groups {
            let recordings = Recordings::of(self.model, group);
            let mut found = linearize::<3>(&recordings, &unknowns, &self.free, None, &[], false);
            found.truncate(group.runs);
            all.extend(found);
        }
        all
    }

    fn covariance(&self, point: &[f64], weights: [f64; 3]) -> Option<Vec<f64>> {
        let (p, all) = (self.free.len(), self.held.len());
        let parts = self.linears(point);
        let (normal, _) = total(&parts)?.weighted(weights);
        let inverse = scaled_inverse(&normal, p).ok()?;
        let mut out = vec![0.0; all * all];
        for part in &parts {
            let (_, gradient) = part.weighted(weights);
            let moved = numerics::times(&inverse, &gradient);
            for (row, a) in self.free.iter().zip(&moved) {
                for (column, b) in self.free.iter().zip(&moved) {
                    out[row * all + column] += a * b;
                }
            }
        }
        Some(out)
    }
}

fn total(parts: &[Linear]) -> Option<Linear> {
    let (first, others) = parts.split_first()?;
    let mut total = first.clone();
    others.iter().for_each(|part| total.add(part));
    Some(total)
}

impl Residuals for Problem<'_> {
    fn linearize(&self, points: &[Vec<f64>]) -> Vec<Linear> {
        points.iter().filter_map(|point| total(&self.linears(point))).collect()
    }
}
