use argmin::core::{Error, IterState, KV, Problem, Solver, TerminationReason, TerminationStatus};
use serde::{Deserialize, Serialize};

use crate::{Candidates, Evaluation};

/// State of the solver as argmin keeps it: the shares as parameter, −log|det| as cost.
pub(crate) type State = IterState<Vec<f64>, (), (), (), (), f64>;

/// Maximises Σ_b log|det M_b(w)| over the simplex by Newton steps on the support and the candidates that are most worth
/// adding to it. An argmin [`Solver`]: its observers, checkpoints and limits apply.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ActiveSetNewton {
    /// Stop at this relative Kiefer–Wolfowitz gap.
    pub tolerance: f64,
    relative_gap: Option<f64>,
    stalled: bool,
}

/// Multiplicative steps before the support is cut to what Newton's method can handle.
const MULTIPLICATIVE_STEPS: usize = 40;
/// Candidates that may join the support in one iteration.
const JOINING: usize = 8;

impl ActiveSetNewton {
    /// Stops at a relative gap of `tolerance`.
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance, relative_gap: None, stalled: false }
    }

    /// max_q g_q / p − 1 at the last iterate.
    pub fn relative_gap(&self) -> Option<f64> {
        self.relative_gap
    }
}

impl Solver<&Candidates, State> for ActiveSetNewton {
    fn name(&self) -> &str {
        "active-set Newton on the simplex"
    }

    fn init(
        &mut self,
        problem: &mut Problem<&Candidates>,
        mut state: State,
    ) -> Result<(State, Option<KV>), Error> {
        let mut shares = state.take_param().unwrap_or_default();
        let candidates = *problem.problem.as_ref().ok_or_else(|| Error::msg("no problem"))?;
        concentrate(candidates, &mut shares);
        let mut at = Evaluation::default();
        let log_det = candidates.evaluate(&shares, &mut at).ok_or_else(|| Error::msg("singular start"))?;
        self.relative_gap = Some(relative_gap(candidates, &at));
        Ok((state.param(shares).cost(-log_det), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<&Candidates>,
        mut state: State,
    ) -> Result<(State, Option<KV>), Error> {
        let shares = state.take_param().ok_or_else(|| Error::msg("no shares"))?;
        let step =
            problem.problem("evaluations", |candidates| Ok(improve(candidates, &shares, self.tolerance)))?;
        Ok(match step {
            Some(Step { shares, log_det, relative_gap }) => {
                self.relative_gap = Some(relative_gap);
                (state.param(shares).cost(-log_det), None)
            }
            None => {
                self.stalled = true;
                let cost = state.cost;
                (state.param(shares).cost(cost), None)
            }
        })
    }

    fn terminate(&mut self, _state: &State) -> TerminationStatus {
        match self.relative_gap {
            Some(gap) if gap <= self.tolerance => {
                TerminationStatus::Terminated(TerminationReason::SolverConverged)
            }
            _ if self.stalled => TerminationStatus::Terminated(TerminationReason::SolverExit(
                "no step improves the criterion".into(),
            )),
            _ => TerminationStatus::NotTerminated,
        }
    }
}

/// max_q g_q / p − 1.
pub(crate) fn relative_gap(candidates: &Candidates, at: &Evaluation) -> f64 {
    let largest =
        (0..candidates.len()).map(|q| candidates.sensitivity(q, at)).fold(f64::NEG_INFINITY, f64::max);
    largest / candidates.dimension() as f64 - 1.0
}

/// Cuts a support that is far larger than an optimal one can be: multiplicative steps w_q ← w_q g_q / p, then the
/// largest shares.
fn concentrate(candidates: &Candidates, shares: &mut [f64]) {
    let most = 2 * candidates.size() + 16;
    if shares.iter().filter(|w| **w > 0.0).count() <= most {
        return;
    }
    let mut at = Evaluation::default();
    for _ in 0..MULTIPLICATIVE_STEPS {
        if candidates.evaluate(shares, &mut at).is_none() {
            return;
        }
        for (q, share) in shares.iter_mut().enumerate() {
            *share *= candidates.sensitivity(q, &at).max(0.0);
        }
        normalize(shares);
    }
    let mut order: Vec<usize> = (0..shares.len()).collect();
    order.sort_by(|a, b| shares[*b].total_cmp(&shares[*a]).then(a.cmp(b)));
    order[most / 2..].iter().for_each(|q| shares[*q] = 0.0);
    normalize(shares);
}

fn normalize(shares: &mut [f64]) {
    let total: f64 = shares.iter().sum();
    shares.iter_mut().for_each(|w| *w /= total);
}

struct Step {
    shares: Vec<f64>,
    log_det: f64,
    relative_gap: f64,
}

/// One iteration: who takes part, in which direction, how far.
fn improve(candidates: &Candidates, shares: &[f64], tolerance: f64) -> Option<Step> {
    let mut at = Evaluation::default();
    let before = candidates.evaluate(shares, &mut at)?;
    let sensitivities: Vec<f64> = (0..candidates.len()).map(|q| candidates.sensitivity(q, &at)).collect();
    let members = members(shares, &sensitivities, candidates.dimension() as f64, tolerance);
    let curvature = curvature(candidates, &members, &at);
    let local: Vec<f64> = members.iter().map(|q| shares[*q]).collect();
    let gradient: Vec<f64> = members.iter().map(|q| sensitivities[*q]).collect();
    let direction = ascent(&local, &gradient, &curvature)?;
    let slope: f64 = direction.iter().zip(&gradient).map(|(d, g)| d * g).sum();
    let mut length = 1.0;
    for _ in 0..40 {
        let mut trial = shares.to_vec();
        for ((q, w), d) in members.iter().zip(&local).zip(&direction) {
            trial[*q] = (w + length * d).max(0.0);
        }
        normalize(&mut trial);
        let enough = before + 1e-4 * length * slope - 1e-14 * before.abs().max(1.0);
        if let Some(log_det) = candidates.evaluate(&trial, &mut at).filter(|value| *value >= enough) {
            return Some(Step { shares: trial, log_det, relative_gap: relative_gap(candidates, &at) });
        }
        length *= 0.5;
    }
    None
}

/// The support and the candidates whose sensitivity exceeds p most.
fn members(shares: &[f64], sensitivities: &[f64], p: f64, tolerance: f64) -> Vec<usize> {
    let mut joining: Vec<usize> = (0..shares.len())
        .filter(|q| shares[*q] == 0.0 && sensitivities[*q] > p * (1.0 + 0.1 * tolerance))
        .collect();
    joining.sort_by(|a, b| sensitivities[*b].total_cmp(&sensitivities[*a]).then(a.cmp(b)));
    joining.truncate(JOINING);
    let mut members: Vec<usize> = (0..shares.len()).filter(|q| shares[*q] > 0.0).chain(joining).collect();
    members.sort_unstable();
    members
}

/// −∂²/∂w_q∂w_r Σ_b log|det M_b| = Σ_b tr(M⁻¹ M_q M⁻¹ M_r), members × members.
fn curvature(candidates: &Candidates, members: &[usize], at: &Evaluation) -> Vec<f64> {
    let size = candidates.size();
    let (mut products, mut transposed) = (vec![0.0; members.len() * size], vec![0.0; members.len() * size]);
    for (m, q) in members.iter().enumerate() {
        let entries = candidates.candidate(*q);
        for (n, range) in candidates.blocks() {
            let inverse_t = &at.inverse_transposed[range.clone()];
            let matrix = &entries[range.clone()];
            for i in 0..n {
                for j in 0..n {
                    let product: f64 = (0..n).map(|k| inverse_t[k * n + i] * matrix[k * n + j]).sum();
                    products[m * size + range.start + i * n + j] = product;
                    transposed[m * size + range.start + j * n + i] = product;
                }
            }
        }
    }
    let mut curvature = vec![0.0; members.len() * members.len()];
    for (q, row) in products.chunks_exact(size).enumerate() {
        for (r, column) in transposed.chunks_exact(size).enumerate() {
            curvature[q * members.len() + r] = row.iter().zip(column).map(|(a, b)| a * b).sum();
        }
    }
    curvature
}

/// Direction d that maximises gᵀd − ½ dᵀCd with Σd = 0 and w + d ≥ 0, by a primal active-set method; regularised until it
/// ascends.
fn ascent(shares: &[f64], gradient: &[f64], curvature: &[f64]) -> Option<Vec<f64>> {
    let k = shares.len();
    let scale = (0..k).map(|i| curvature[i * k + i].abs()).fold(0.0, f64::max);
    let mut damping = 1e-13 * scale;
    for _ in 0..20 {
        let direction = quadratic_step(shares, gradient, curvature, damping);
        let slope: f64 = direction.iter().zip(gradient).map(|(d, g)| d * g).sum();
        if slope > 0.0 && slope.is_finite() {
            return Some(direction);
        }
        damping = (damping * 30.0).max(1e-10 * scale);
    }
    None
}

fn quadratic_step(shares: &[f64], gradient: &[f64], curvature: &[f64], damping: f64) -> Vec<f64> {
    let k = shares.len();
    let mut moved = vec![0.0; k];
    let mut free: Vec<usize> = (0..k).collect();
    for _ in 0..2 * k + 8 {
        let Some(step) = equality_step(&free, &moved, gradient, curvature, damping) else { return moved };
        let room =
            |i: usize, d: f64| if d < 0.0 { (shares[free[i]] + moved[free[i]]) / -d } else { f64::INFINITY };
        let limits: Vec<f64> = step.iter().enumerate().map(|(i, d)| room(i, *d)).collect();
        let length = limits.iter().copied().fold(1.0, f64::min).max(0.0);
        for (i, d) in free.iter().zip(&step) {
            moved[*i] += length * d;
        }
        if length >= 1.0 {
            return moved;
        }
        let mut kept = Vec::with_capacity(free.len());
        for (i, limit) in free.iter().zip(&limits) {
            if *limit <= length {
                moved[*i] = -shares[*i];
            } else {
                kept.push(*i);
            }
        }
        free = kept;
        if free.len() < 2 {
            return moved;
        }
    }
    moved
}

/// Newton step on the free members: (C + damping) d + ν = g − C moved, Σd = 0.
fn equality_step(
    free: &[usize],
    moved: &[f64],
    gradient: &[f64],
    curvature: &[f64],
    damping: f64,
) -> Option<Vec<f64>> {
    let (k, n) = (moved.len(), free.len() + 1);
    let mut matrix = vec![0.0; n * n];
    let mut rhs = vec![0.0; n];
    for (i, q) in free.iter().enumerate() {
        for (j, r) in free.iter().enumerate() {
            matrix[i * n + j] = curvature[q * k + r];
        }
        matrix[i * n + i] += damping;
        matrix[i * n + n - 1] = 1.0;
        matrix[(n - 1) * n + i] = 1.0;
        rhs[i] = gradient[*q] - (0..k).map(|r| curvature[q * k + r] * moved[r]).sum::<f64>();
    }
    small_matrix::solve(n, &mut matrix, &mut rhs)?;
    rhs.pop();
    Some(rhs)
}
