//! Whether recordings are of one ship: for every recording, whether its own parameters may be those of the others.

use super::found::Apart;
use super::problems::{Problems, State};
use crate::predictor::{Linear, scaled_inverse};
use numerics::distributions::log_chi_square_tail;
use numerics::{quadratic_of_inverse, times};

/// A recording contradicts the others if chance explains any of them with a smaller probability than this.
const LEVEL: f64 = 1e-4;
/// A parameter depends on the others if less than this share of its signal is independent of theirs.
const LEFT: f64 = 1e-6;

/// Recordings that contradict the others, the farthest first: they are removed one by one until the rest agree. At
/// most half of the recordings are named.
pub(super) fn apart(problems: &Problems, state: &State) -> Vec<Apart> {
    let mut left = recordings(problems, state);
    let mut out = Vec::new();
    let most = left.len() / 2;
    while left.len() > 2 && out.len() < most {
        let count = left.len() as f64;
        let Some((farthest, log_p)) = farthest(&left) else { break };
        let p_value = (count * libm::exp(log_p)).min(1.0);
        if p_value >= LEVEL {
            break;
        }
        out.push(Apart { recording: left.remove(farthest).0, p_value });
    }
    out
}

/// White errors of every recording, and their derivatives by the parameters.
fn recordings(problems: &Problems, state: &State) -> Vec<(String, Linear)> {
    let mut all: Vec<(String, Linear)> = Vec::new();
    for (run, found) in problems.by_run(state) {
        let name = problems.subject.names[run];
        match all.iter_mut().find(|(own, _)| own == name) {
            Some((_, sums)) => sums.add(&found),
            None => all.push((name.to_owned(), found)),
        }
    }
    all.retain(|(_, sums)| sums.finite());
    all
}

/// The recording that is least probable given the others, with the logarithm of its probability.
fn farthest(all: &[(String, Linear)]) -> Option<(usize, f64)> {
    let mut total = all.first()?.1.clone();
    all[1..].iter().for_each(|(_, sums)| total.add(sums));
    let (normal, gradient) = total.weighted([1.0; 3]);
    let p = gradient.len();
    let inverse = scaled_inverse(&normal, p).ok()?;
    let change = times(&inverse, &gradient);
    let explained: f64 = change.iter().zip(&gradient).map(|(a, b)| a * b).sum();
    let freedom = (3.0 * total.samples - p as f64).max(1.0);
    let variance = (total.squares.iter().sum::<f64>() - explained) / freedom;
    let tested = all.iter().enumerate().filter_map(|(i, (_, sums))| {
        let (own, scores) = sums.weighted([1.0; 3]);
        // Scores of the recording at the estimate from all recordings, and their covariance over the variance.
        let scores: Vec<f64> =
            scores.iter().zip(times(&own, &change)).map(|(s, explained)| s - explained).collect();
        let rows: Vec<f64> = own.chunks_exact(p).flat_map(|row| times(&inverse, row)).collect();
        let covariance: Vec<f64> = (0..p * p)
            .map(|k| {
                let (i, j) = (k / p, k % p);
                own[k] - numerics::dot(&rows[i * p..(i + 1) * p], &own[j * p..(j + 1) * p])
            })
            .collect();
        let whole: Vec<f64> = (0..p).map(|i| own[i * p + i]).collect();
        let (statistic, rank) = quadratic_of_inverse(covariance, scores, &whole, LEFT);
        (rank > 0).then(|| (i, log_chi_square_tail(statistic / variance, rank)))
    });
    tested.min_by(|a, b| a.1.total_cmp(&b.1))
}
