use argmin::core::{Executor, State as _};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::active_set::{State, concentrate};
use crate::{ActiveSetNewton, Bounds, Candidates, Covariance, Error, Objective, is_concave};

/// Criteria that differ by less than this are the same: 1e-9 of the experiment's time.
const DIGITS: f64 = 1e-9;

/// A relative gap at which a search that rounding ends counts as done: a ten-thousandth of the experiment's time.
const ACCEPTED: f64 = 1e-4;

/// Options of the solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Relative Kiefer–Wolfowitz gap to stop at.
    pub tolerance: f64,
    /// Additional random starts, besides equal shares.
    pub random_starts: u32,
    /// Seed of the random starts.
    pub seed: u64,
    /// Limit on iterations per start.
    pub max_iterations: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self { tolerance: 1e-10, random_starts: 5, seed: 1, max_iterations: 500 }
    }
}

/// Whether the shares are proved optimal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Globally optimal to the gap: the problem is concave.
    Optimal,
    /// First-order optimal to the gap; the problem is not concave, so another optimum may be better.
    Stationary,
    /// The gap was not reached.
    Stalled,
}

impl Status {
    /// Whether the gap was `reached`, in a problem that is proved `concave`.
    pub(crate) fn of(reached: bool, concave: bool) -> Self {
        match (reached, concave) {
            (false, _) => Self::Stalled,
            (true, true) => Self::Optimal,
            (true, false) => Self::Stationary,
        }
    }
}

/// The result of one start.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Shares.
    pub shares: Vec<f64>,
    /// Value of the criterion.
    pub log_det: f64,
    /// max_q g_q / p − 1.
    pub relative_gap: f64,
    /// Iterations.
    pub iterations: u64,
}

/// The best shares and their certificate.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// Shares of the candidates; sum to 1.
    pub shares: Vec<f64>,
    /// Σ_b log|det M_b(w)|.
    pub log_det: f64,
    /// g_q of every candidate.
    pub sensitivities: Vec<f64>,
    /// max_q g_q − p.
    pub gap: f64,
    /// Optimal, stationary or stalled.
    pub status: Status,
    /// Equal shares first, then the random starts. A start from a singular mixture is omitted.
    pub starts: Vec<Start>,
}

/// Shares that maximise the D-criterion of the information matrix, from equal shares and from random starts.
///
/// # Errors
/// [`Error::Empty`]; [`Error::Unexcited`] if no mixture of the candidates is regular.
pub fn solve(candidates: &Candidates, options: &Options) -> Result<Design, Error> {
    solve_within(candidates, &Bounds::default(), options)
}

/// [`solve`] under upper bounds on the shares.
///
/// # Errors
/// As [`solve`]; [`Error::Shape`] if the number of bounds differs from that of candidates.
pub fn solve_within(candidates: &Candidates, bounds: &Bounds, options: &Options) -> Result<Design, Error> {
    let (scaled, offset) = candidates.scaled()?;
    scaled.check_excitation()?;
    let points = starting_points(scaled.len(), bounds, options)?;
    let mut design = from_points(&scaled, bounds, options, is_concave(candidates), points)?;
    design.log_det += offset;
    design.starts.iter_mut().for_each(|s| s.log_det += offset);
    Ok(design)
}

/// Shares that minimise a criterion of the covariance, under upper bounds. [`Design::log_det`] is minus the norm.
///
/// # Errors
/// As [`solve_within`].
pub fn solve_covariance(cost: &Covariance, bounds: &Bounds, options: &Options) -> Result<Design, Error> {
    let points = starting_points(cost.len(), bounds, options)?;
    from_points(cost, bounds, options, cost.is_concave(), points)
}

/// [`solve_covariance`] without bounds, from `shares`, such as those of a similar problem, instead of equal and random ones.
///
/// # Errors
/// As there; [`Error::Shape`] if the number of shares differs from that of candidates, [`Error::Solver`] if they are singular.
pub fn solve_covariance_from(cost: &Covariance, shares: &[f64], options: &Options) -> Result<Design, Error> {
    if shares.len() != cost.len() {
        return Err(Error::Shape { found: shares.len(), expected: cost.len() });
    }
    let (mut from, bounds) = (shares.to_vec(), Bounds::default());
    bounds.fill(&mut from);
    from_points(cost, &bounds, options, cost.is_concave(), vec![from])
}

/// [`solve_covariance`] without bounds, from equal shares reduced by multiplicative steps to about `support`
/// candidates: faster if the optimal support is small.
///
/// # Errors
/// As there.
pub fn solve_covariance_among(cost: &Covariance, support: usize, options: &Options) -> Result<Design, Error> {
    let count = cost.len();
    let mut shares = vec![1.0 / count as f64; count];
    concentrate(cost, &Bounds::default(), 2 * support, &mut shares);
    solve_covariance_from(cost, &shares, options)
}

/// An upper bound on the loss of a criterion of `value`, as a fraction of the experiment's time, against any shares
/// within the gap of `relaxed`.
pub(crate) fn loss(value: f64, relaxed: &Design, degree: f64) -> f64 {
    let gap = relaxed.gap.max(0.0);
    let above = if gap < 1.0 { -libm::log1p(-gap) } else { f64::INFINITY };
    1.0 - libm::exp((value - relaxed.log_det - above) / degree).min(1.0)
}

pub(crate) fn from_points<O: Objective>(
    objective: &O,
    bounds: &Bounds,
    options: &Options,
    concave: bool,
    points: Vec<Vec<f64>>,
) -> Result<Design, Error> {
    let mut starts = Vec::new();
    for from in points {
        if objective.evaluate(&from, &mut O::Point::default()).is_some() {
            starts.push(run(objective, bounds, from, options)?);
        }
    }
    let best = Start::best(&starts, options.tolerance)
        .ok_or_else(|| Error::Solver("every start was singular".into()))?;
    let mut at = O::Point::default();
    objective.evaluate(&best.shares, &mut at);
    let sensitivities = objective.sensitivities(&at);
    let p = objective.degree();
    let gap = bounds.gap(&sensitivities, &best.shares, p);
    let status = Status::of(gap <= options.tolerance.max(ACCEPTED) * p, concave);
    let (shares, log_det) = (best.shares.clone(), best.log_det);
    Ok(Design { shares, log_det, sensitivities, gap, status, starts })
}

/// Equal and random shares, projected into the bounds.
fn starting_points(count: usize, bounds: &Bounds, options: &Options) -> Result<Vec<Vec<f64>>, Error> {
    if let Some(given) = bounds.count().filter(|given| *given != count) {
        return Err(Error::Shape { found: given, expected: count });
    }
    let mut points = vec![vec![1.0 / count as f64; count]];
    for start in 0..options.random_starts {
        let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
        rng.set_stream(u64::from(start));
        // Exponential draws, normalised: uniform on the simplex.
        let mut draw = || -libm::log(((rng.next_u64() >> 11) as f64 + 0.5) * 2.0_f64.powi(-53));
        let shares: Vec<f64> = (0..count).map(|_| draw()).collect();
        let total: f64 = shares.iter().sum();
        points.push(shares.iter().map(|w| w / total).collect());
    }
    for point in points.iter_mut().filter(|_| bounds.bind()) {
        bounds.fill(point);
    }
    Ok(points)
}

fn run<O: Objective>(goal: &O, bounds: &Bounds, from: Vec<f64>, options: &Options) -> Result<Start, Error> {
    let failed = |e: argmin::core::Error| Error::Solver(e.to_string());
    let result = Executor::new(goal, ActiveSetNewton::new(options.tolerance).within(bounds.clone()))
        .configure(|state: State| state.param(from).max_iters(options.max_iterations))
        .timer(false)
        .run()
        .map_err(failed)?;
    let relative_gap = result.solver.relative_gap().unwrap_or(f64::INFINITY);
    let iterations = result.state.get_iter();
    let mut state = result.state;
    let shares = state.take_param().ok_or_else(|| Error::Solver("no shares".into()))?;
    Ok(Start { log_det: -state.cost, shares, relative_gap, iterations })
}

/// `of` the shares that are all on one candidate, for each of `count` candidates.
pub(crate) fn alone(count: usize, of: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    let mut shares = vec![0.0; count];
    let mut single = |q: usize| {
        shares[q] = 1.0;
        let design = of(&shares);
        shares[q] = 0.0;
        design
    };
    (0..count).map(&mut single).collect()
}

impl Start {
    /// The best of `starts` that reached a relative gap of `tolerance`; or one that did not, if it is better by more than
    /// 1e-9 or none did. `None` without starts.
    pub fn best(starts: &[Self], tolerance: f64) -> Option<&Self> {
        let highest = |a: &&Self, b: &&Self| a.log_det.total_cmp(&b.log_det);
        let best = starts.iter().max_by(highest)?;
        let converged = starts.iter().filter(|start| start.relative_gap <= tolerance).max_by(highest);
        Some(converged.filter(|design| design.log_det > best.log_det - DIGITS).unwrap_or(best))
    }
}

impl Design {
    /// Whether another start reached the same value.
    pub fn agrees(&self, start: &Start) -> bool {
        (self.log_det - start.log_det).abs() <= 1e-8 * self.log_det.abs().max(1.0)
    }

    /// D-efficiency of other shares against these: |det M(w)/det M(w*)|^(1/`parameters`), the fraction of the
    /// experiment time that these shares would need for the same information. 0 if a block is singular.
    pub fn efficiency(&self, candidates: &Candidates, shares: &[f64], parameters: usize) -> f64 {
        let Ok((scaled, offset)) = candidates.scaled() else { return 0.0 };
        self.efficiency_scaled(&scaled, offset, shares, parameters)
    }

    /// [`Design::efficiency`] of every candidate on its own.
    pub fn single_efficiencies(&self, candidates: &Candidates, parameters: usize) -> Vec<f64> {
        let Ok((scaled, offset)) = candidates.scaled() else { return vec![0.0; candidates.len()] };
        alone(scaled.len(), |shares| self.efficiency_scaled(&scaled, offset, shares, parameters))
    }

    fn efficiency_scaled(&self, scaled: &Candidates, offset: f64, shares: &[f64], parameters: usize) -> f64 {
        let mut sum = Vec::new();
        scaled.sum(shares, &mut sum);
        let mut log_det = offset;
        for (n, range) in scaled.blocks() {
            let block = &mut sum[range];
            if numerics::weakest(n, block).is_none_or(|w| w.ratio < 1e-12) {
                return 0.0;
            }
            match numerics::log_det(n, block) {
                Some(det) => log_det += det.log_abs,
                None => return 0.0,
            }
        }
        libm::exp((log_det - self.log_det) / parameters as f64)
    }
}
