use argmin::core::{Error, IterState, KV, Problem, Solver, TerminationReason, TerminationStatus};
use serde::{Deserialize, Serialize};

use crate::Evaluation;
use crate::candidates::Objective;
use crate::certificate::{Bounds, largest};

/// State of the solver as argmin keeps it: the shares as parameter, −log|det| as cost.
pub(crate) type State = IterState<Vec<f64>, (), (), (), (), f64>;

/// Maximises an [`Objective`] over the simplex, or the part of it below upper bounds, by Newton steps on the support
/// and the candidates with the largest gain. An argmin [`Solver`]: its observers, checkpoints and limits apply. `P`
/// is the objective's workspace at an evaluated point.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ActiveSetNewton<P = Evaluation> {
    /// Stop at this relative gap.
    pub tolerance: f64,
    bounds: Bounds,
    relative_gap: Option<f64>,
    stalled: bool,
    /// Iterations since the criterion grew by more than rounding.
    idle: u32,
    /// The last iterate.
    #[serde(skip)]
    last: Option<Evaluated<P>>,
}

/// Multiplicative steps before the support is cut to what Newton's method can handle.
const MULTIPLICATIVE_STEPS: usize = 40;
/// Iterations without growth after which rounding alone moves the shares.
const IDLE: u32 = 60;
/// Growth of the criterion that may be rounding, as a part of its value.
const ROUNDING: f64 = 1e-14;
/// Candidates that may join the support in one iteration.
const JOINING: usize = 8;

impl<P> ActiveSetNewton<P> {
    /// Stops at a relative gap of `tolerance`.
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance, bounds: Bounds::default(), relative_gap: None, stalled: false, idle: 0, last: None }
    }

    /// The same within `bounds`. The shares that it starts from must lie within them.
    pub fn within(self, bounds: Bounds) -> Self {
        Self { bounds, ..self }
    }

    /// The gap over the objective's degree at the last iterate.
    pub fn relative_gap(&self) -> Option<f64> {
        self.relative_gap
    }
}

impl<O: Objective> Solver<&O, State> for ActiveSetNewton<O::Point> {
    fn name(&self) -> &str {
        "active-set Newton on the simplex"
    }

    fn init(&mut self, problem: &mut Problem<&O>, mut state: State) -> Result<(State, Option<KV>), Error> {
        let mut shares = state.take_param().unwrap_or_default();
        let objective = *problem.problem.as_ref().ok_or_else(|| Error::msg("no problem"))?;
        concentrate(objective, &self.bounds, 2 * objective.size() + 16, &mut shares);
        let start = Evaluated::of(objective, shares).ok_or_else(|| Error::msg("singular start"))?;
        Ok((self.arrive(start, objective, state), None))
    }

    fn next_iter(&mut self, task: &mut Problem<&O>, mut state: State) -> Result<(State, Option<KV>), Error> {
        let shares = state.take_param().ok_or_else(|| Error::msg("no shares"))?;
        let objective = *task.problem.as_ref().ok_or_else(|| Error::msg("no problem"))?;
        // After a checkpoint the iterate may be another one.
        let last = self.last.take().filter(|last| last.shares == shares);
        let last = last.or_else(|| Evaluated::of(objective, shares.clone()));
        let step = task.problem("evaluations", |objective| {
            Ok(last.and_then(|last| improve(*objective, &self.bounds, &last, self.tolerance)))
        })?;
        Ok(match step {
            Some(next) => {
                let growth = next.value + state.cost;
                let is_idle = growth <= ROUNDING * next.value.abs().max(1.0);
                self.idle = if is_idle { self.idle + 1 } else { 0 };
                self.stalled = self.idle >= IDLE;
                (self.arrive(next, objective, state), None)
            }
            None => {
                self.stalled = true;
                let cost = state.cost;
                (state.param(shares).cost(cost), None)
            }
        })
    }

    fn terminate(&mut self, _state: &State) -> TerminationStatus {
        let reason = match self.relative_gap {
            Some(gap) if gap <= self.tolerance => TerminationReason::SolverConverged,
            _ if self.stalled => TerminationReason::SolverExit("no step improves the criterion".into()),
            _ => return TerminationStatus::NotTerminated,
        };
        TerminationStatus::Terminated(reason)
    }
}

impl<P> ActiveSetNewton<P> {
    /// The state at the iterate `next`.
    fn arrive(&mut self, next: Evaluated<P>, objective: &impl Objective, state: State) -> State {
        let degree = objective.degree();
        self.relative_gap = Some(self.bounds.gap(&next.sensitivities, &next.shares, degree) / degree);
        let state = state.param(next.shares.clone()).cost(-next.value);
        self.last = Some(next);
        state
    }
}

/// Shares with the objective evaluated there.
#[derive(Clone, Debug)]
struct Evaluated<P> {
    shares: Vec<f64>,
    at: P,
    value: f64,
    sensitivities: Vec<f64>,
}

impl<P: Default> Evaluated<P> {
    fn of<O: Objective<Point = P>>(objective: &O, shares: Vec<f64>) -> Option<Self> {
        let mut at = P::default();
        let value = objective.evaluate(&shares, &mut at)?;
        let sensitivities = objective.sensitivities(&at);
        Some(Self { shares, at, value, sensitivities })
    }
}

/// Reduces a support of more than `most`, which is far larger than an optimal one: multiplicative steps w_q ← w_q
/// g_q^κ, then the largest shares, half as many as `most`. The point is kept if the cut would make it singular.
pub(crate) fn concentrate<O: Objective>(objective: &O, bounds: &Bounds, most: usize, shares: &mut Vec<f64>) {
    if shares.iter().filter(|w| **w > 0.0).count() <= most {
        return;
    }
    let mut at = O::Point::default();
    let mut weights = shares.clone();
    for _ in 0..MULTIPLICATIVE_STEPS {
        if objective.evaluate(&weights, &mut at).is_none() {
            return;
        }
        for (q, weight) in weights.iter_mut().enumerate() {
            *weight *= libm::pow(objective.sensitivity(q, &at).max(0.0), objective.exponent());
        }
        if !bounds.fill(&mut weights) {
            return;
        }
    }
    bounds.keep_largest(&mut weights, most / 2);
    if objective.evaluate(&weights, &mut at).is_some() {
        *shares = weights;
    }
}

/// One iteration: selects members, a direction and a step length.
fn improve<O: Objective>(
    objective: &O,
    bounds: &Bounds,
    Evaluated { shares, at, value: before, sensitivities }: &Evaluated<O::Point>,
    tolerance: f64,
) -> Option<Evaluated<O::Point>> {
    let members = members(bounds, shares, sensitivities, objective.degree(), tolerance);
    let quadratic = Quadratic {
        shares: members.iter().map(|q| shares[*q]).collect(),
        upper: members.iter().map(|q| bounds.upper(*q)).collect(),
        gradient: members.iter().map(|q| sensitivities[*q]).collect(),
        curvature: objective.curvature(&members, at),
    };
    let direction = quadratic.ascent()?;
    let slope = quadratic.slope(&direction);
    let mut length = 1.0;
    let mut at = O::Point::default();
    for _ in 0..40 {
        let mut trial = shares.clone();
        for ((q, w), d) in members.iter().zip(&quadratic.shares).zip(&direction) {
            trial[*q] = (w + length * d).max(0.0);
        }
        bounds.repair(&mut trial);
        let enough = before + 1e-4 * length * slope - ROUNDING * before.abs().max(1.0);
        if let Some(value) = objective.evaluate(&trial, &mut at).filter(|value| *value >= enough) {
            let sensitivities = objective.sensitivities(&at);
            return Some(Evaluated { shares: trial, at, value, sensitivities });
        }
        length *= 0.5;
    }
    None
}

/// The shares between their bounds, and those at a bound with the largest gain from leaving it: `JOINING` of either kind.
fn members(bounds: &Bounds, shares: &[f64], sensitivities: &[f64], p: f64, tolerance: f64) -> Vec<usize> {
    let full = |q: usize| shares[q] > 0.0 && shares[q] >= bounds.upper(q);
    let level = bounds.level(sensitivities, shares, p);
    let margin = 0.1 * tolerance * p;
    let empty = |q: &usize| shares[*q] == 0.0 && bounds.upper(*q) > 0.0 && sensitivities[*q] > level + margin;
    let joining = largest((0..shares.len()).filter(empty), sensitivities, JOINING);
    let mut leaving: Vec<usize> =
        (0..shares.len()).filter(|q| full(*q) && sensitivities[*q] < level - margin).collect();
    leaving.sort_by(|a, b| sensitivities[*a].total_cmp(&sensitivities[*b]).then(a.cmp(b)));
    leaving.truncate(JOINING);
    let between = (0..shares.len()).filter(|q| shares[*q] > 0.0 && !full(*q));
    let mut members: Vec<usize> = between.chain(joining).chain(leaving).collect();
    members.sort_unstable();
    members
}

/// The model gᵀd − ½ dᵀCd of the members' change d, with Σd = 0 and 0 ≤ w + d ≤ upper.
struct Quadratic {
    shares: Vec<f64>,
    upper: Vec<f64>,
    gradient: Vec<f64>,
    curvature: Vec<f64>,
}

impl Quadratic {
    fn slope(&self, direction: &[f64]) -> f64 {
        direction.iter().zip(&self.gradient).map(|(d, g)| d * g).sum()
    }

    /// A direction that maximises the model by a primal active-set method; regularised until it is one of ascent.
    fn ascent(&self) -> Option<Vec<f64>> {
        let k = self.shares.len();
        let scale = (0..k).map(|i| self.curvature[i * k + i].abs()).fold(0.0, f64::max);
        let mut damping = 1e-13 * scale;
        for _ in 0..20 {
            let direction = self.step(damping);
            let slope = self.slope(&direction);
            if slope > 0.0 && slope.is_finite() {
                return Some(direction);
            }
            damping = (damping * 30.0).max(1e-10 * scale);
        }
        None
    }

    fn step(&self, damping: f64) -> Vec<f64> {
        let k = self.shares.len();
        let mut moved = vec![0.0; k];
        let mut free: Vec<usize> = (0..k).collect();
        for _ in 0..2 * k + 8 {
            let Some(step) = self.equality_step(&free, &moved, damping) else { return moved };
            let longest = |i: usize, d: f64| {
                let q = free[i];
                if d < 0.0 {
                    (self.shares[q] + moved[q]) / -d
                } else if d > 0.0 {
                    (self.upper[q] - self.shares[q] - moved[q]) / d
                } else {
                    f64::INFINITY
                }
            };
            let limits: Vec<f64> = step.iter().enumerate().map(|(i, d)| longest(i, *d)).collect();
            let length = limits.iter().copied().fold(1.0, f64::min).max(0.0);
            for (i, d) in free.iter().zip(&step) {
                moved[*i] += length * d;
            }
            if length >= 1.0 {
                return moved;
            }
            let mut kept = Vec::with_capacity(free.len());
            for ((i, limit), d) in free.iter().zip(&limits).zip(&step) {
                if *limit <= length {
                    moved[*i] = if *d < 0.0 { -self.shares[*i] } else { self.upper[*i] - self.shares[*i] };
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
    fn equality_step(&self, free: &[usize], moved: &[f64], damping: f64) -> Option<Vec<f64>> {
        let (k, n) = (moved.len(), free.len() + 1);
        let mut matrix = vec![0.0; n * n];
        let mut rhs = vec![0.0; n];
        for (i, q) in free.iter().enumerate() {
            for (j, r) in free.iter().enumerate() {
                matrix[i * n + j] = self.curvature[q * k + r];
            }
            matrix[i * n + i] += damping;
            matrix[i * n + n - 1] = 1.0;
            matrix[(n - 1) * n + i] = 1.0;
            rhs[i] = self.gradient[*q] - (0..k).map(|r| self.curvature[q * k + r] * moved[r]).sum::<f64>();
        }
        numerics::solve(n, &mut matrix, &mut rhs)?;
        rhs.pop();
        Some(rhs)
    }
}
