use vessel::{LANES, Lane, check_diverged, simulate};

use super::{Lifted, Part};

/// An estimate that minimises the errors of free simulations.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputError {
    /// Lifted parameters.
    pub parameters: Vec<f64>,
    /// Their covariance, as many rows: H⁻¹ (Σ s sᵀ) H⁻¹ with the gradient s of each part, so that errors may be correlated
    /// in any way within a part. Zero for parameters held.
    pub covariance: Vec<f64>,
    /// Steps taken.
    pub steps: usize,
}

/// Most steps.
const STEPS: usize = 40;
/// A step that lowers the cost by less than this share is the last.
const ENOUGH: f64 = 1e-7;
/// Step of a difference quotient, as a share of the parameter's size.
const DIFFERENCE: f64 = 1e-5;

/// The sum of squared errors of free simulations over all parts, each from its first measured state.
struct Problem<'a> {
    lifted: &'a Lifted,
    parts: &'a [Part],
    exogenous: Vec<Vec<f64>>,
    weights: [f64; 3],
    /// Places of the parameters that are estimated, and the size of each.
    free: Vec<(usize, f64)>,
}

/// Gauss–Newton system JᵀJ x = Jᵀe over the free parameters, and the gradient of each part.
struct Linear {
    normal: Vec<f64>,
    right: Vec<f64>,
    gradients: Vec<Vec<f64>>,
}

/// Minimises Σ (e_d/std_d)² of free simulations over `parts` by Levenberg and Marquardt's method from `start` (lifted
/// parameters). `std`: of measured u, v, r. `sizes`: per lifted parameter the change that would matter; 0 holds it. `None`
/// where the start diverges or a number is not finite.
pub fn output_error(
    lifted: &Lifted,
    parts: &[Part],
    start: &[f64],
    std: [f64; 3],
    sizes: &[f64],
) -> Option<OutputError> {
    let problem = Problem {
        lifted,
        parts,
        exogenous: parts.iter().map(|part| lifted.exogenous(&part.exogenous, part.samples())).collect(),
        weights: std.map(|s| if s > 0.0 { 1.0 / s } else { 0.0 }),
        free: sizes.iter().copied().enumerate().filter(|(_, size)| *size > 0.0).collect(),
    };
    let mut parameters = start.to_vec();
    let mut cost = problem.costs(&[parameters.clone()])[0];
    let mut damping = 1e-3;
    let mut steps = 0;
    while cost.is_finite() && steps < STEPS {
        let linear = problem.linearized(&parameters)?;
        let dampings: Vec<f64> = (0..LANES as i32).map(|i| damping * 10f64.powi(i - 3)).collect();
        let tries: Vec<Vec<f64>> =
            dampings.iter().map(|l| problem.stepped(&parameters, &linear, *l)).collect();
        let costs = problem.costs(&tries);
        let best = (0..tries.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b]))?;
        if costs[best].is_nan() || costs[best] >= cost {
            break;
        }
        let gained = 1.0 - costs[best] / cost;
        (parameters, cost, damping) = (tries[best].clone(), costs[best], dampings[best].max(1e-12));
        steps += 1;
        if gained < ENOUGH {
            break;
        }
    }
    let covariance = cost.is_finite().then(|| problem.covariance(&parameters)).flatten()?;
    Some(OutputError { parameters, covariance, steps })
}

impl Problem<'_> {
    fn states(&self, models: &[Lane], part: usize) -> Vec<Lane> {
        let mut states = vec![Lane::ZERO; self.parts[part].measured.len()];
        let initial = self.parts[part].initial().map(Lane::splat);
        simulate(&self.lifted.model, models, initial, &self.exogenous[part], &[], &mut states);
        states
    }

    /// Costs of up to [`LANES`] models; infinite where one diverges.
    fn costs(&self, models: &[Vec<f64>]) -> Vec<f64> {
        let lanes = side_by_side(models);
        let mut totals = vec![0.0; models.len()];
        for (i, part) in self.parts.iter().enumerate() {
            let states = self.states(&lanes, i);
            for (lane, total) in totals.iter_mut().enumerate() {
                if check_diverged(states.iter().map(|s| s[lane])).is_some() {
                    *total = f64::INFINITY;
                    continue;
                }
                for (k, (state, measured)) in states.iter().zip(&part.measured).enumerate() {
                    let error = self.weights[k % 3] * (measured - state[lane]);
                    *total += error * error;
                }
            }
        }
        totals
    }

    fn linearized(&self, parameters: &[f64]) -> Option<Linear> {
        let p = self.free.len();
        let mut linear = Linear { normal: vec![0.0; p * p], right: vec![0.0; p], gradients: Vec::new() };
        let shifted = |(place, size): &(usize, f64)| {
            let mut moved = parameters.to_vec();
            moved[*place] += DIFFERENCE * size;
            moved
        };
        let moved: Vec<Vec<f64>> =
            [parameters.to_vec()].into_iter().chain(self.free.iter().map(shifted)).collect();
        let groups: Vec<Vec<Lane>> = moved.chunks(LANES).map(side_by_side).collect();
        for (i, part) in self.parts.iter().enumerate() {
            let states: Vec<Vec<Lane>> = groups.iter().map(|models| self.states(models, i)).collect();
            let at = |model: usize, k: usize| states[model / LANES][k][model % LANES];
            let mut gradient = vec![0.0; p];
            let mut row = vec![0.0; p];
            for (k, measured) in part.measured.iter().enumerate().skip(3) {
                let weight = self.weights[k % 3];
                let base = at(0, k);
                for (j, (_, size)) in self.free.iter().enumerate() {
                    row[j] = weight * (at(j + 1, k) - base) / (DIFFERENCE * size);
                }
                let error = weight * (measured - base);
                for a in 0..p {
                    gradient[a] += row[a] * error;
                    for b in a..p {
                        linear.normal[a * p + b] += row[a] * row[b];
                    }
                }
            }
            linear.right.iter_mut().zip(&gradient).for_each(|(r, g)| *r += g);
            linear.gradients.push(gradient);
        }
        for a in 0..p {
            for b in 0..a {
                linear.normal[a * p + b] = linear.normal[b * p + a];
            }
        }
        linear.normal.iter().all(|x| x.is_finite()).then_some(linear)
    }

    /// The parameters after a step damped by `damping`.
    fn stepped(&self, parameters: &[f64], linear: &Linear, damping: f64) -> Vec<f64> {
        let p = self.free.len();
        let mut normal = linear.normal.clone();
        (0..p).for_each(|i| normal[i * p + i] *= 1.0 + damping);
        let mut step = linear.right.clone();
        let mut moved = parameters.to_vec();
        if small_matrix::solve(p, &mut normal, &mut step).is_some() {
            self.free.iter().zip(step).for_each(|((place, _), step)| moved[*place] += step);
        }
        moved
    }

    fn covariance(&self, parameters: &[f64]) -> Option<Vec<f64>> {
        let (p, all) = (self.free.len(), parameters.len());
        let mut linear = self.linearized(parameters)?;
        let mut inverse = vec![0.0; p * p];
        small_matrix::inverse(p, &mut linear.normal, &mut inverse)?;
        let mut out = vec![0.0; all * all];
        for gradient in &linear.gradients {
            let moved: Vec<f64> =
                (0..p).map(|i| (0..p).map(|j| inverse[i * p + j] * gradient[j]).sum()).collect();
            for (i, (row, _)) in self.free.iter().enumerate() {
                for (j, (column, _)) in self.free.iter().enumerate() {
                    out[row * all + column] += moved[i] * moved[j];
                }
            }
        }
        Some(out)
    }
}

/// Up to [`LANES`] models, one per lane; unused lanes repeat the first.
fn side_by_side(models: &[Vec<f64>]) -> Vec<Lane> {
    let model = |lane: usize| models.get(lane).unwrap_or(&models[0]);
    (0..models[0].len()).map(|i| Lane(std::array::from_fn(|lane| model(lane)[i]))).collect()
}
