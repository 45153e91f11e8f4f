use numerics::statistics::log_chi_square_tail;
use numerics::{inverse, times};
use ship::engine::Streams;

use super::library::{CandidateEffect, Lifted};
use super::noise::{Noise, NoiseKind};
use super::problems::{Problems, TestedEstimate};
use super::verdict::{Absent, Criticism, LEVEL, Verdict, called};
use crate::predictor::{Linear, scaled_inverse};

/// A signal with less than this share of it left after projection cannot be told from the estimated unknowns.
const LEFT: f64 = 1e-7;

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Score {
    /// T = sᵀV⁻¹s over the errors' variance.
    pub statistic: f64,
    pub freedom: usize,
    /// log P(χ² ≥ T).
    pub log_p: f64,
    pub values: Vec<f64>,
    pub standard_errors: Vec<f64>,
}

/// Whitened errors and sensitivities of all runs, projected onto the complement of the estimated unknowns.
#[derive(Clone, Debug)]
pub(super) struct Projected {
    columns: usize,
    /// s = W⊥ᵀ w⊥ of every column.
    scores: Vec<f64>,
    /// V = W⊥ᵀ W⊥, columns × columns.
    covariance: Vec<f64>,
    /// The diagonal of WᵀW before projection.
    whole: Vec<f64>,
    /// Σ w⊥², and its degrees of freedom.
    pub squares: f64,
    pub freedom: f64,
}

impl Projected {
    /// From white `sums`, whose first `estimated` columns are estimated unknowns. `None` if these are singular.
    pub fn new(sums: &Linear, estimated: usize) -> Option<Self> {
        let (normal, gradient) = sums.weighted([1.0; 3]);
        let (all, p) = (gradient.len(), estimated);
        let known: Vec<f64> = (0..p * p).map(|k| normal[k / p * all + k % p]).collect();
        let inverted = scaled_inverse(&known, p).ok()?;
        let row = |i: usize| &normal[i * all..i * all + p];
        let solved: Vec<Vec<f64>> = (p..all).map(|i| times(&inverted, row(i))).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let columns = all - p;
        let covariance = (0..columns * columns).map(|k| {
            let (i, j) = (k / columns, k % columns);
            normal[(p + i) * all + p + j] - dot(&solved[i], row(p + j))
        });
        let explained = dot(&gradient[..p], &times(&inverted, &gradient[..p]));
        Some(Self {
            columns,
            scores: (0..columns).map(|i| gradient[p + i] - dot(&solved[i], &gradient[..p])).collect(),
            covariance: covariance.collect(),
            whole: (p..all).map(|i| normal[i * all + i]).collect(),
            squares: sums.squares.iter().sum::<f64>() - explained,
            freedom: (3.0 * sums.samples - p as f64).max(1.0),
        })
    }

    /// Variance of the white errors, 1 if the stated noise is right.
    pub fn variance(&self) -> f64 {
        self.squares / self.freedom
    }

    /// Correlation of the scores of unknowns, given by their columns.
    pub fn correlation(&self, unknowns: &[&[usize]]) -> Vec<f64> {
        let entry = |rows: &[usize], columns: &[usize]| -> f64 {
            let row = |a: &usize| columns.iter().map(|b| self.covariance[a * self.columns + b]).sum::<f64>();
            rows.iter().map(row).sum()
        };
        let size: Vec<f64> = unknowns.iter().map(|unknown| entry(unknown, unknown).max(0.0).sqrt()).collect();
        let all = || unknowns.iter().zip(&size);
        all().flat_map(|(a, s)| all().map(move |(b, t)| entry(a, b) / (s * t))).collect()
    }

    /// The test of these `unknowns`; `None` if they cannot be distinguished from the estimated ones.
    pub fn score(&self, unknowns: &[Vec<usize>]) -> Option<Score> {
        let q = unknowns.len();
        let sum = |of: &dyn Fn(usize) -> f64, columns: &[usize]| columns.iter().map(|c| of(*c)).sum::<f64>();
        let s: Vec<f64> = unknowns.iter().map(|columns| sum(&|c| self.scores[c], columns)).collect();
        let entry = |i: usize, j: usize| {
            let (rows, columns) = (&unknowns[i], &unknowns[j]);
            sum(&|a| sum(&|b| self.covariance[a * self.columns + b], columns), rows)
        };
        let v: Vec<f64> = (0..q * q).map(|k| entry(k / q, k % q)).collect();
        let whole = |i: usize| sum(&|c| self.whole[c], &unknowns[i]);
        if (0..q).any(|i| v[i * q + i].is_nan() || v[i * q + i] <= LEFT * whole(i)) {
            return None;
        }
        let (mut destroyed, mut inverted) = (v, vec![0.0; q * q]);
        inverse(q, &mut destroyed, &mut inverted)?;
        let values = times(&inverted, &s);
        let statistic = values.iter().zip(&s).map(|(x, s)| x * s).sum::<f64>() / self.variance();
        let error = |i: usize| (self.variance() * inverted[i * q + i]).max(0.0).sqrt();
        Some(Score {
            statistic,
            freedom: q,
            log_p: log_chi_square_tail(statistic, q),
            standard_errors: (0..q).map(error).collect(),
            values,
        })
    }
}

/// Candidates within this distance in −2 log p of the first may be what is missing too.
const CLOSE: f64 = 6.0;

pub(super) fn tested(lifted: &Lifted, draws: &Draws, projected: &Projected) -> (Vec<Absent>, Vec<String>) {
    let scored = lifted.candidates.iter().map(|candidate| (candidate, projected.score(&candidate.unknowns)));
    let (testable, hidden): (Vec<_>, Vec<_>) = scored.partition(|(_, score)| score.is_some());
    let testable: Vec<(&CandidateEffect, Score)> =
        testable.into_iter().filter_map(|(c, score)| Some((c, score?))).collect();
    let groups = testable.iter().map(|(c, score)| (c.unknowns.as_slice(), score)).collect::<Vec<_>>();
    let probabilities = draws.adjusted(projected, &groups);
    let most = testable.iter().map(|(_, score)| -2.0 * score.log_p).fold(0.0, f64::max);
    let all = testable.iter().zip(&probabilities);
    let mut all_absent: Vec<Absent> = all.map(|((c, score), p)| absent(c, score, *p, most)).collect();
    all_absent.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    (all_absent, hidden.into_iter().map(|(c, _)| called(&c.name, c.place())).collect())
}

/// The test of `candidate`, where `most` is the evidence of the likeliest.
fn absent(candidate: &CandidateEffect, score: &Score, p_value: f64, most: f64) -> Absent {
    let (values, errors) = (score.values.clone(), score.standard_errors.clone());
    Absent {
        kind: candidate.kind,
        name: candidate.name.clone(),
        degree: candidate.place().map(str::to_owned),
        unit: candidate.unit.clone(),
        candidate: most + 2.0 * score.log_p <= CLOSE,
        ..Absent::scored(values, errors, score.log_p, p_value)
    }
}

/// Twice the log-likelihood by which another kind may be ahead due to a missing term.
const TAKEN: f64 = 30.0;
const TESTS: f64 = 2.0;

/// The tests of every estimate under white noise if that is not the likeliest kind but plausible.
pub(super) fn under_white(
    problems: &Problems,
    lifted: &Lifted,
    draws: &Draws,
    states: &[TestedEstimate],
) -> Vec<Option<Vec<Absent>>> {
    let white = |state: &TestedEstimate| {
        let likeliest = state.noise.as_ref().filter(|noise| noise.guess.kind != NoiseKind::White)?;
        let guess = *likeliest.within(TAKEN).find(|guess| guess.kind == NoiseKind::White)?;
        Some(Noise { guess, ..likeliest.clone() })
    };
    let under =
        |state: &TestedEstimate| TestedEstimate { parameters: state.parameters.clone(), noise: white(state) };
    let white_states: Vec<TestedEstimate> = states.iter().map(under).collect();
    if white_states.iter().all(|state| state.noise.is_none()) {
        return vec![None; states.len()];
    }
    let (sums, _) = problems.look(lifted, &white_states);
    let each = sums.into_iter().zip(&white_states);
    each.map(|(sums, state)| Some(tested(lifted, draws, &Projected::new(&sums?, state.parameters.len())?).0))
        .collect()
}

/// Rejects a model by the tests under white noise if these are the stronger evidence; returns whether they are.
pub(super) fn reject_under_white(criticism: &mut Criticism, white: Option<Vec<Absent>>) -> bool {
    let Some(white) = white.and_then(|white| clearer_under_white(&criticism.absent, white)) else {
        return false;
    };
    (criticism.rejected, criticism.verdict) = (true, Verdict::Rejected);
    (criticism.p_value, criticism.absent) = (Some(least(&white)), white);
    true
}

/// The tests under white noise of a model whose `likeliest` noise is another, if they reject it and are the stronger
/// evidence. Their probabilities are doubled, since two tests are made; `None` if they are not.
pub fn clearer_under_white(likeliest: &[Absent], mut white: Vec<Absent>) -> Option<Vec<Absent>> {
    white.iter_mut().for_each(|absent| absent.p_value = (TESTS * absent.p_value).min(1.0));
    Some(white).filter(|white| least(white) < least(likeliest).min(LEVEL))
}

fn least(absents: &[Absent]) -> f64 {
    absents.iter().map(|absent| absent.p_value).fold(1.0, f64::min)
}

const DRAWS: usize = 2000;
/// A score is a mixture of others if less than this share of its pivot is left.
const DEPENDENT: f64 = 1e-9;
const SEED: u64 = 1;

pub(super) struct Draws {
    width: usize,
    normals: Vec<f64>,
}

impl Draws {
    /// For up to `width` unknowns.
    pub fn new(width: usize) -> Self {
        let mut normals = vec![0.0; (width * DRAWS).next_multiple_of(2)];
        Streams::new(SEED, "criticism").normals(0, 0, &mut normals);
        Self { width, normals }
    }

    /// Per candidate, the probability that any has so improbable a score: by joint draws, since tests overlap, and
    /// beyond all draws by Bonferroni's factor.
    pub fn adjusted(&self, projected: &Projected, groups: &[(&[Vec<usize>], &Score)]) -> Vec<f64> {
        let least = self.least(projected, groups);
        let among = |score: &Score| {
            let fewer = least.partition_point(|log_p| *log_p <= score.log_p);
            let product = groups.len() as f64 * libm::exp(score.log_p);
            ((fewer + 1) as f64 / (DRAWS + 1) as f64).min(product).min(1.0)
        };
        groups.iter().map(|(_, score)| among(score)).collect()
    }

    /// The least logarithm of a probability of every draw, in ascending order.
    fn least(&self, projected: &Projected, groups: &[(&[Vec<usize>], &Score)]) -> Vec<f64> {
        let unknowns = groups.iter().flat_map(|(group, _)| group.iter().map(Vec::as_slice));
        let unknowns: Vec<&[usize]> = unknowns.collect();
        let n = unknowns.len();
        let correlation = projected.correlation(&unknowns);
        let (factor, forms) = (lower(n, &correlation), forms(n, &correlation, groups));
        let freedom = groups.iter().map(|(_, score)| score.freedom).max().unwrap_or(0);
        let least = |z: &[f64]| {
            let x: Vec<f64> = (0..n).map(|i| numerics::dot(&factor[i * n..=i * n + i], &z[..=i])).collect();
            let mut most = vec![0.0_f64; freedom + 1];
            for (first, inverse, q) in &forms {
                let statistic = numerics::quadratic(&x[*first..first + q], inverse);
                most[*q] = most[*q].max(statistic);
            }
            let tail = |(q, x): (usize, &f64)| if *x > 0.0 { log_chi_square_tail(*x, q) } else { 0.0 };
            most.iter().enumerate().map(tail).fold(0.0, f64::min)
        };
        let mut all: Vec<f64> = self.normals.chunks_exact(self.width.max(1)).take(DRAWS).map(least).collect();
        all.sort_by(f64::total_cmp);
        all
    }
}

/// Per group its first unknown, the inverse correlation of its unknowns, and their number.
fn forms(n: usize, correlation: &[f64], groups: &[(&[Vec<usize>], &Score)]) -> Vec<(usize, Vec<f64>, usize)> {
    let mut first = 0;
    let form = |(group, _): &(&[Vec<usize>], &Score)| {
        let (from, q) = (first, group.len());
        first += q;
        let mut block: Vec<f64> =
            (0..q * q).map(|k| correlation[(from + k / q) * n + from + k % q]).collect();
        let mut inverted = vec![0.0; q * q];
        numerics::inverse(q, &mut block, &mut inverted)?;
        Some((from, inverted, q))
    };
    groups.iter().filter_map(form).collect()
}

/// L with L Lᵀ = `a`, n × n, which may be singular.
fn lower(n: usize, a: &[f64]) -> Vec<f64> {
    let mut l = vec![0.0; n * n];
    for j in 0..n {
        let left = a[j * n + j] - (0..j).map(|k| l[j * n + k] * l[j * n + k]).sum::<f64>();
        if left <= DEPENDENT {
            continue;
        }
        l[j * n + j] = left.sqrt();
        for i in j + 1..n {
            let rest = a[i * n + j] - (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum::<f64>();
            l[i * n + j] = rest / l[j * n + j];
        }
    }
    l
}
