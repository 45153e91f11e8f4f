//! Whole segments: counts n_q with Σ n_q = n and n_q ≤ a_q whose mixture is best.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::certificate::largest;
use crate::{Design, Error, Objective};

/// Options of the search for counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CountOptions {
    /// All counts are tried if there are no more than this.
    pub exhaustive: u64,
    /// Additional starts of the exchange, besides the apportioned shares.
    pub random_starts: u32,
    /// Seed of the random starts.
    pub seed: u64,
}

impl Default for CountOptions {
    fn default() -> Self {
        Self { exhaustive: 10_000_000, random_starts: 5, seed: 1 }
    }
}

/// How counts, or choices of candidates, were found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// All were tried: none is better.
    Exhaustive,
    /// No exchange of one segment or candidate for another improves them (among the most promising where there are many).
    Exchange,
}

/// The best counts found.
#[derive(Clone, Debug, PartialEq)]
pub struct Counted {
    /// Segments of every candidate.
    pub counts: Vec<u64>,
    /// Φ of their shares n_q/n.
    pub value: f64,
    /// How they were found.
    pub method: Method,
    /// Number of counts that were tried.
    pub tried: u64,
    /// Φ of the apportioned shares; minus infinity if that is not defined.
    pub apportioned: f64,
}

/// Counts of `total` segments, at most `limits[q]` of candidate `q`, that maximise `objective`; `shares` are the
/// relaxed problem's.
///
/// # Errors
/// [`Error::Infeasible`] if the limits sum to less than `total`; [`Error::Shape`]; [`Error::Solver`] if the criterion
/// is undefined for all counts that were tried.
pub fn count_segments<O: Objective>(
    objective: &O,
    shares: &[f64],
    total: u64,
    limits: Option<&[u64]>,
    options: &CountOptions,
) -> Result<Counted, Error> {
    let limits: Vec<u64> = match limits {
        Some(limits) => limits.iter().map(|a| (*a).min(total)).collect(),
        None => vec![total; objective.len()],
    };
    if limits.len() != objective.len() || shares.len() != objective.len() {
        return Err(Error::Shape { found: limits.len().min(shares.len()), expected: objective.len() });
    }
    let capacity: u128 = limits.iter().map(|a| u128::from(*a)).sum();
    if total == 0 || capacity < u128::from(total) {
        return Err(Error::Infeasible { total: capacity as f64 / total as f64 });
    }
    let mut search = Search { objective, total, limits, at: O::Point::default(), tried: 0 };
    let start = search.apportioned(shares);
    let apportioned = search.value(&start);
    let exhaustive = shares.len() <= MOST_WALKED && search.compositions() <= options.exhaustive as f64;
    let best = if exhaustive { search.all() } else { search.exchanges(start, options) };
    let (value, counts) = best
        .filter(|(value, _)| value.is_finite())
        .ok_or_else(|| Error::Solver("every count was singular".into()))?;
    let method = if exhaustive { Method::Exhaustive } else { Method::Exchange };
    Ok(Counted { counts, value, method, tried: search.tried, apportioned })
}

impl Counted {
    /// An upper bound on the loss of these counts, as a fraction of the experiment's time, against any shares within the gap of
    /// `design`, the relaxed problem's: proved if that is proved global. `degree`: the criterion's gain per log of time.
    pub fn loss_bound(&self, design: &Design, degree: f64) -> f64 {
        crate::design::loss(self.value, design, degree)
    }
}

/// Maximum number of incoming candidates of an exchange.
const INCOMING: usize = 256;

/// Maximum number of candidates of the exhaustive search, which recurses once per candidate.
const MOST_WALKED: usize = 1000;

struct Search<'a, O: Objective> {
    objective: &'a O,
    total: u64,
    limits: Vec<u64>,
    at: O::Point,
    tried: u64,
}

impl<O: Objective> Search<'_, O> {
    fn shares(&self, counts: &[u64]) -> Vec<f64> {
        counts.iter().map(|n| *n as f64 / self.total as f64).collect()
    }

    fn value(&mut self, counts: &[u64]) -> f64 {
        let shares = self.shares(counts);
        self.value_of(&shares)
    }

    fn value_of(&mut self, shares: &[f64]) -> f64 {
        self.tried += 1;
        let value = self.objective.value(shares, &mut self.at);
        value.filter(|v| v.is_finite()).unwrap_or(f64::NEG_INFINITY)
    }

    /// The apportioned shares, cut to the limits; the rest is added to the candidates that lack most.
    fn apportioned(&self, shares: &[f64]) -> Vec<u64> {
        let mut counts = apportion(shares, self.total);
        counts.iter_mut().zip(&self.limits).for_each(|(n, a)| *n = (*n).min(*a));
        let mut left = self.total - counts.iter().sum::<u64>();
        while left > 0 {
            let lack = |q: &usize| (counts[*q] as f64 + 1.0) / shares[*q].max(1e-12);
            let open = (0..counts.len()).filter(|q| counts[*q] < self.limits[*q]);
            let Some(q) = open.min_by(|a, b| lack(a).total_cmp(&lack(b))) else { break };
            counts[q] += 1;
            left -= 1;
        }
        counts
    }

    /// The number of possible counts.
    fn compositions(&self) -> f64 {
        // This many are too many in any case.
        if self.total > 100_000 {
            return if self.limits.len() == 1 { 1.0 } else { f64::INFINITY };
        }
        let n = self.total as usize;
        let mut ways = vec![0.0_f64; n + 1];
        ways[0] = 1.0;
        for limit in &self.limits {
            let limit = *limit as usize;
            let mut next = vec![0.0; n + 1];
            let mut window = 0.0;
            for sum in 0..=n {
                window += ways[sum];
                if sum > limit {
                    window -= ways[sum - limit - 1];
                }
                next[sum] = window;
            }
            ways = next;
            if ways[n] > 1e15 {
                break;
            }
        }
        ways[n].max(1.0)
    }

    /// The best of all counts, the lexicographically first among equals.
    fn all(&mut self) -> Option<(f64, Vec<u64>)> {
        // The sum of the limits of the candidates from q on.
        let mut capacity: Vec<u64> = vec![0; self.limits.len() + 1];
        for q in (0..self.limits.len()).rev() {
            capacity[q] = capacity[q + 1].saturating_add(self.limits[q]);
        }
        let mut walk =
            Walk { counts: vec![0; self.limits.len()], shares: vec![0.0; self.limits.len()], best: None };
        self.descend(0, self.total, &capacity, &mut walk);
        walk.best
    }

    fn descend(&mut self, q: usize, left: u64, capacity: &[u64], walk: &mut Walk) {
        let set = |walk: &mut Walk, n: u64, total: u64| {
            walk.counts[q] = n;
            walk.shares[q] = n as f64 / total as f64;
        };
        if q + 1 == self.limits.len() {
            set(walk, left, self.total);
            let value = self.value_of(&walk.shares);
            if walk.best.as_ref().is_none_or(|(best, _)| value > *best) {
                walk.best = Some((value, walk.counts.clone()));
            }
            return;
        }
        for n in left.saturating_sub(capacity[q + 1])..=left.min(self.limits[q]) {
            set(walk, n, self.total);
            self.descend(q + 1, left - n, capacity, walk);
        }
    }

    /// The best result of exchanges from the apportioned shares and from random counts.
    fn exchanges(&mut self, start: Vec<u64>, options: &CountOptions) -> Option<(f64, Vec<u64>)> {
        let mut best: Option<(f64, Vec<u64>)> = None;
        for number in 0..=options.random_starts {
            let mut counts = start.clone();
            if number > 0 {
                let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
                rng.set_stream(u64::from(number));
                self.shake(&mut counts, &mut rng);
            }
            let exchanged = self.exchange(counts);
            if best.as_ref().is_none_or(|(value, _)| exchanged.0 > *value) {
                best = Some(exchanged);
            }
        }
        best
    }

    /// Moves about a third of the segments to random candidates.
    fn shake(&self, counts: &mut [u64], rng: &mut ChaCha8Rng) {
        let mut pick = |places: &[usize]| places[(rng.next_u64() % places.len().max(1) as u64) as usize];
        for _ in 0..(self.total / 3).clamp(1, 1000) {
            let used: Vec<usize> = (0..counts.len()).filter(|q| counts[*q] > 0).collect();
            let from = pick(&used);
            let open: Vec<usize> =
                (0..counts.len()).filter(|q| *q != from && counts[*q] < self.limits[*q]).collect();
            if open.is_empty() {
                return;
            }
            let to = pick(&open);
            counts[from] -= 1;
            counts[to] += 1;
        }
    }

    /// Best exchanges of one segment for another until none improves.
    fn exchange(&mut self, mut counts: Vec<u64>) -> (f64, Vec<u64>) {
        let mut value = self.value(&counts);
        let mut shares = self.shares(&counts);
        let one = 1.0 / self.total as f64;
        loop {
            let mut best: Option<(f64, usize, usize)> = None;
            for to in self.incoming(&counts) {
                for from in (0..counts.len()).filter(|q| counts[*q] > 0 && *q != to) {
                    let kept = (shares[from], shares[to]);
                    shares[from] = (counts[from] - 1) as f64 * one;
                    shares[to] = (counts[to] + 1) as f64 * one;
                    let better = self.value_of(&shares);
                    (shares[from], shares[to]) = kept;
                    if best.is_none_or(|(value, ..)| better > value) {
                        best = Some((better, from, to));
                    }
                }
            }
            match best {
                Some((better, from, to))
                    if better > value + 1e-12 * value.abs().max(1.0)
                        || value.is_infinite() && better.is_finite() =>
                {
                    counts[from] -= 1;
                    counts[to] += 1;
                    (shares[from], shares[to]) = (counts[from] as f64 * one, counts[to] as f64 * one);
                    value = better;
                }
                _ => return (value, counts),
            }
        }
    }

    /// Candidates below their limits, the most sensitive ones if there are many.
    fn incoming(&mut self, counts: &[u64]) -> Vec<usize> {
        let mut open: Vec<usize> = (0..counts.len()).filter(|q| counts[*q] < self.limits[*q]).collect();
        if open.len() <= INCOMING {
            return open;
        }
        let shares = self.shares(counts);
        if self.objective.evaluate(&shares, &mut self.at).is_some() {
            return largest(open, &self.objective.sensitivities(&self.at), INCOMING);
        }
        open.truncate(INCOMING);
        open
    }
}

struct Walk {
    counts: Vec<u64>,
    shares: Vec<f64>,
    best: Option<(f64, Vec<u64>)>,
}

/// Rounds `shares` (sum 1) to whole numbers that sum to `total` by the efficient apportionment of Pukelsheim & Rieder
/// 1992: every positive share gets at least one if `total` suffices.
pub fn apportion(shares: &[f64], total: u64) -> Vec<u64> {
    let support = shares.iter().filter(|w| **w > 0.0).count() as f64;
    let multiplier = (total as f64 - support / 2.0).max(0.0);
    let mut counts: Vec<u64> = shares.iter().map(|w| (multiplier * w).ceil() as u64).collect();
    let used = || (0..shares.len()).filter(|q| shares[*q] > 0.0);
    let mut sum: u64 = counts.iter().sum();
    while sum > total {
        let surplus = |q: &usize| ((counts[*q] - 1) as f64 / shares[*q], -shares[*q]);
        let Some(most) = used().filter(|q| counts[*q] > 0).max_by(|a, b| compare(surplus(a), surplus(b)))
        else {
            break;
        };
        counts[most] -= 1;
        sum -= 1;
    }
    while sum < total {
        let lack = |q: &usize| (counts[*q] as f64 / shares[*q], -shares[*q]);
        let Some(least) = used().min_by(|a, b| compare(lack(a), lack(b))) else { break };
        counts[least] += 1;
        sum += 1;
    }
    counts
}

fn compare(a: (f64, f64), b: (f64, f64)) -> std::cmp::Ordering {
    a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
}
