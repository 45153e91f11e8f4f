use argmin::core::{Executor, State as _};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::active_set::State;
use crate::{ActiveSetNewton, Candidates, Error, Evaluation, is_concave};

/// How to solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Relative Kiefer–Wolfowitz gap to stop at.
    pub tolerance: f64,
    /// Starts besides equal shares.
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

/// What is known of the shares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Globally optimal to the gap: the problem is concave.
    Optimal,
    /// First-order optimal to the gap; the problem is not concave, so another optimum may be better.
    Stationary,
    /// The gap was not reached.
    Stalled,
}

/// Where one start ended.
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

/// The best shares and what is known of them.
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
    /// Equal shares first, then the random starts. A start from a singular mixture is left out.
    pub starts: Vec<Start>,
}

/// Shares that maximise the D-criterion, from equal shares and from random starts.
///
/// # Errors
/// [`Error::Empty`]; [`Error::Unexcited`] where no mixture of the candidates is regular.
pub fn solve(candidates: &Candidates, options: &Options) -> Result<Design, Error> {
    let (scaled, offset) = candidates.scaled()?;
    check_excitation(&scaled)?;
    let concave = is_concave(candidates);
    let mut starts = Vec::new();
    for from in starting_points(scaled.len(), options) {
        if scaled.evaluate(&from, &mut Evaluation::default()).is_some() {
            starts.push(run(&scaled, from, options)?);
        }
    }
    let best = starts
        .iter()
        .max_by(|a, b| a.log_det.total_cmp(&b.log_det))
        .ok_or_else(|| Error::Solver("every start was singular".into()))?;
    let mut at = Evaluation::default();
    scaled.evaluate(&best.shares, &mut at);
    let sensitivities: Vec<f64> = (0..scaled.len()).map(|q| scaled.sensitivity(q, &at)).collect();
    let p = scaled.dimension() as f64;
    let gap = sensitivities.iter().copied().fold(f64::NEG_INFINITY, f64::max) - p;
    let status = match (gap <= options.tolerance * p, concave) {
        (false, _) => Status::Stalled,
        (true, true) => Status::Optimal,
        (true, false) => Status::Stationary,
    };
    let (shares, log_det) = (best.shares.clone(), best.log_det + offset);
    starts.iter_mut().for_each(|s| s.log_det += offset);
    Ok(Design { shares, log_det, sensitivities, gap, status, starts })
}

fn starting_points(count: usize, options: &Options) -> Vec<Vec<f64>> {
    let mut points = vec![vec![1.0 / count as f64; count]];
    for start in 0..options.random_starts {
        let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
        rng.set_stream(u64::from(start));
        // Exponential draws, normalised: uniform on the simplex.
        let mut draw = || -(((rng.next_u64() >> 11) as f64 + 0.5) * 2.0_f64.powi(-53)).ln();
        let shares: Vec<f64> = (0..count).map(|_| draw()).collect();
        let total: f64 = shares.iter().sum();
        points.push(shares.iter().map(|w| w / total).collect());
    }
    points
}

fn run(scaled: &Candidates, from: Vec<f64>, options: &Options) -> Result<Start, Error> {
    let failed = |e: argmin::core::Error| Error::Solver(e.to_string());
    let result = Executor::new(scaled, ActiveSetNewton::new(options.tolerance))
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

/// Refuses candidates whose equal mixture leaves a direction without excitation.
fn check_excitation(scaled: &Candidates) -> Result<(), Error> {
    let mut sum = Vec::new();
    scaled.sum(&vec![1.0 / scaled.len() as f64; scaled.len()], &mut sum);
    for (block, (n, range)) in scaled.blocks().enumerate() {
        // Rows belong to regressors: what no row combination reaches is a left singular direction.
        let own = &sum[range];
        if small_matrix::condition(n, own) < 1e9 {
            continue;
        }
        let transposed: Vec<f64> = (0..n * n).map(|k| own[(k % n) * n + k / n]).collect();
        let direction = match small_matrix::weakest(n, &transposed) {
            Some(found) if found.ratio > 1e-12 => continue,
            Some(found) => found.direction,
            None => vec![1.0; n],
        };
        return Err(Error::Unexcited { block, direction });
    }
    Ok(())
}

impl Design {
    /// D-efficiency of other shares against these: |det M(w)/det M(w*)|^(1/`parameters`), the fraction of the experiment
    /// time that these shares would need for the same information. 0 where a block is singular.
    pub fn efficiency(&self, candidates: &Candidates, shares: &[f64], parameters: usize) -> f64 {
        let Ok((scaled, offset)) = candidates.scaled() else { return 0.0 };
        self.efficiency_scaled(&scaled, offset, shares, parameters)
    }

    /// [`Design::efficiency`] of every candidate on its own.
    pub fn single_efficiencies(&self, candidates: &Candidates, parameters: usize) -> Vec<f64> {
        let Ok((scaled, offset)) = candidates.scaled() else { return vec![0.0; candidates.len()] };
        let mut alone = vec![0.0; candidates.len()];
        let mut single = |q: usize| {
            alone[q] = 1.0;
            let efficiency = self.efficiency_scaled(&scaled, offset, &alone, parameters);
            alone[q] = 0.0;
            efficiency
        };
        (0..scaled.len()).map(&mut single).collect()
    }

    fn efficiency_scaled(&self, scaled: &Candidates, offset: f64, shares: &[f64], parameters: usize) -> f64 {
        let mut sum = Vec::new();
        scaled.sum(shares, &mut sum);
        let mut log_det = offset;
        for (n, range) in scaled.blocks() {
            let block = &mut sum[range];
            if small_matrix::weakest(n, block).is_none_or(|w| w.ratio < 1e-12) {
                return 0.0;
            }
            match small_matrix::log_det(n, block) {
                Some(det) => log_det += det.log_abs,
                None => return 0.0,
            }
        }
        ((log_det - self.log_det) / parameters as f64).exp()
    }
}
