//! Rounds of minimisation, with updates of the multipliers between them.

use numerics::bounded::minimise;
use numerics::{Watch, iterate};

use super::criterion::{Forward, TraceCriterion};
use super::lagrangian::{Lagrangian, SignalLimits};
use super::signal::Signal;

/// The effort and resolution of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Samples between the knots of a correction; 1 corrects every sample.
    pub knot: usize,
    /// Maximum number of iterations, of all rounds.
    pub iterations: usize,
}

/// Refined inputs.
#[derive(Clone, Debug)]
pub struct Refined {
    /// N × inputs.
    pub inputs: Vec<f64>,
    /// The experiment at the start.
    pub before: Forward,
    /// The refined one; as at the start if nothing better was found within the limits.
    pub after: Forward,
    /// Number of iterations.
    pub iterations: usize,
    /// Number of simulations.
    pub evaluations: usize,
    /// Whether the search converged: a round gained less than one in ten thousand.
    pub settled: bool,
}

/// Maximum iterations of a round; few iterations are shared among rounds, since the cost of violations has to grow.
const ROUND: usize = 60;
const ROUNDS: usize = 12;
/// Cost of a violation in the first round, its growth by round, and its greatest.
const WEIGHTS: [f64; 3] = [3.0, 2.0, 3e3];
/// Margin of the search below limits of motion and rates, as a part of them.
pub const MARGIN: f64 = 5e-4;
/// A gain below this, in a round, ends the search.
const GAIN: f64 = 1e-4;

/// Minimises `criterion` from inputs `start`, N × inputs, within `limits`, which `start` must keep, those of rates by
/// more than [`MARGIN`]: a correction is linear between knots, so that it slows no input that rises and falls between two. The
/// result keeps the limits. `None` if the criterion is not defined at the start. `watch` may end it with the best so far.
pub fn refine(
    criterion: &TraceCriterion,
    start: &[f64],
    limits: &SignalLimits,
    effort: &Effort,
    watch: &Watch,
) -> Option<Refined> {
    let signal = Signal::new(start, &limits.inputs, effort.knot);
    let [low, high] = signal.bounds();
    let mut x = vec![0.0; low.len()];
    let states = 3 * (start.len() / limits.inputs.len().max(1) + 1);
    let mut lagrangian = Lagrangian {
        criterion,
        signal,
        limits,
        margin: MARGIN,
        weight: WEIGHTS[0],
        multipliers: vec![0.0; states + start.len().saturating_sub(limits.inputs.len())],
        best: None,
        evaluations: 0,
    };
    let before = lagrangian.run(&x)?;
    lagrangian.best = Some((before.value, x.clone()));
    let (mut iterations, mut settled) = (0, false);
    iterate("augmented Lagrangian", effort.iterations, &Watch::default(), || {
        let known = lagrangian.best.as_ref().map_or(f64::INFINITY, |(value, _)| *value);
        let round = ROUND.min(effort.iterations.div_ceil(ROUNDS)).min(effort.iterations - iterations);
        iterations += minimise(&mut lagrangian, &mut x, [&low, &high], round, watch).max(1);
        let violation = lagrangian.update(&x)?;
        let now = lagrangian.best.as_ref().map_or(f64::INFINITY, |(value, _)| *value);
        let heaviest = lagrangian.weight >= WEIGHTS[2];
        settled = heaviest && violation < MARGIN && known - now < GAIN * now;
        lagrangian.weight = (WEIGHTS[1] * lagrangian.weight).min(WEIGHTS[2]);
        (iterations < effort.iterations && !settled && !watch.ended()).then_some(())
    });
    let best = lagrangian.best.take().map_or(x, |(_, x)| x);
    let after = lagrangian.run(&best)?;
    let inputs = lagrangian.signal.inputs(&best);
    Some(Refined { inputs, before, after, iterations, evaluations: lagrangian.evaluations, settled })
}
