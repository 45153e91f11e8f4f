//! Designs of the paper's eleven maneuvers against numbers computed independently (`fixtures/oracle/oracle.json`: the
//! paper's own form log|det(T − S Z̄ᵀ)| by SLSQP), and the two facts that make one problem of the paper's two.

use design::{Candidates, Design, Evaluation, Objective, Options, Status, solve};
use proptest::prelude::*;
use serde_json::Value;

const ORACLE: &str = include_str!("../../../../fixtures/oracle/oracle.json");
const REMOVALS: [&str; 3] = ["complete", "batch", "none"];

/// Moments of one maneuver and degree of freedom: M = [[X̄, Ȳ], [Z̄ᵀ, 1]], p̃ × p̃, row-major.
#[derive(Clone, Debug)]
struct Lifted {
    n: usize,
    m: Vec<f64>,
}

impl Lifted {
    fn at(&self, i: usize, j: usize) -> f64 {
        self.m[i * self.n + j]
    }

    /// The additive information under the mean removal: M itself, X̄ − Ȳ Z̄ᵀ or X̄.
    fn information(&self, removal: &str) -> Vec<f64> {
        let p = self.n - 1;
        let mut entries = Vec::new();
        for i in 0..p {
            for j in 0..p {
                let mean = if removal == "batch" { self.at(i, p) * self.at(p, j) } else { 0.0 };
                entries.push(self.at(i, j) - mean);
            }
        }
        if removal == "complete" { self.m.clone() } else { entries }
    }
}

struct Oracle {
    whole: Value,
    names: Vec<String>,
    /// Per maneuver and degree of freedom.
    moments: Vec<Vec<Lifted>>,
}

impl Oracle {
    fn read() -> Self {
        let whole: Value = serde_json::from_str(ORACLE).unwrap();
        let maneuvers = whole["moments"].as_array().unwrap();
        let lifted = |degree: &Value| {
            let m: Vec<f64> = degree["M"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
            Lifted { n: degree["shape"][0].as_u64().unwrap() as usize, m }
        };
        let degrees = |maneuver: &Value| maneuver["degrees"].as_array().unwrap().iter().map(lifted).collect();
        let name = |maneuver: &Value| maneuver["name"].as_str().unwrap().to_owned();
        let names = maneuvers.iter().map(name).collect();
        let moments = maneuvers.iter().map(degrees).collect();
        Self { whole, names, moments }
    }

    fn candidates(&self, removal: &str) -> Candidates {
        let smaller = usize::from(removal != "complete");
        let mut candidates = Candidates::new(self.moments[0].iter().map(|m| m.n - smaller).collect());
        for degrees in &self.moments {
            let entries: Vec<f64> = degrees.iter().flat_map(|m| m.information(removal)).collect();
            candidates.push(&entries).unwrap();
        }
        candidates
    }

    /// A number of the design, or one per maneuver in order.
    fn number(&self, removal: &str, key: &str) -> f64 {
        self.whole["designs"][removal][key].as_f64().unwrap()
    }

    fn numbers(&self, removal: &str, key: &str) -> Vec<f64> {
        let map = &self.whole["designs"][removal][key];
        self.names.iter().map(|name| map[name].as_f64().unwrap()).collect()
    }
}

fn designs() -> Vec<(&'static str, Candidates, Design)> {
    let oracle = Oracle::read();
    let solved = |removal: &'static str| {
        let candidates = oracle.candidates(removal);
        let design = solve(&candidates, &Options::default()).unwrap();
        (removal, candidates, design)
    };
    REMOVALS.map(solved).into()
}

fn assert_all_close(found: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (q, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() <= tolerance, "{what} {q}: found {found}, expected {expected}");
    }
}

#[test]
fn oracle_shares_and_sensitivities_of_every_mean_removal() {
    let oracle = Oracle::read();
    for (removal, _, design) in designs() {
        assert_all_close(&design.shares, &oracle.numbers(removal, "shares"), 1e-6, removal);
        assert_all_close(&design.sensitivities, &oracle.numbers(removal, "sensitivities"), 1e-6, removal);
    }
}

#[test]
fn oracle_values_of_the_criterion() {
    let oracle = Oracle::read();
    for (removal, candidates, design) in designs() {
        let equal = vec![1.0 / candidates.len() as f64; candidates.len()];
        let at_equal = candidates.evaluate(&equal, &mut Evaluation::default()).unwrap();
        for (found, key) in [(design.log_det, "log_det"), (at_equal, "log_det_equal_shares")] {
            let expected = oracle.number(removal, key);
            let error = (found - expected).abs();
            assert!(error <= 1e-9 * expected.abs(), "{removal} {key}: found {found}, expected {expected}");
        }
    }
}

#[test]
fn oracle_gap_and_dimension() {
    let oracle = Oracle::read();
    for (removal, candidates, design) in designs() {
        let p = oracle.number(removal, "dimension");
        assert_eq!(candidates.dimension() as f64, p, "{removal}");
        assert!(design.gap <= 1e-10 * p, "{removal}: gap {}", design.gap);
        assert_eq!(design.status, Status::Stationary, "{removal}");
        let largest = design.sensitivities.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert!((design.gap - (largest - p)).abs() < 1e-12, "{removal}: gap {}", design.gap);
        assert_eq!(oracle.number(removal, "agreeing_starts"), oracle.number(removal, "starts"));
        for start in &design.starts {
            let error = (start.log_det - design.log_det).abs();
            assert!(error <= 1e-9 * design.log_det.abs(), "{removal}: {}", start.log_det);
        }
    }
}

/// log|det A| by elimination with full pivoting of a matrix whose rows and columns are scaled first.
fn log_abs_det(n: usize, a: &[f64]) -> f64 {
    let mut a = a.to_vec();
    let mut log = 0.0;
    for along in [1, n, 1, n] {
        let across = if along == 1 { n } else { 1 };
        for line in 0..n {
            let size = (0..n).map(|k| a[line * across + k * along].abs()).fold(0.0, f64::max);
            (0..n).for_each(|k| a[line * across + k * along] /= size);
            log += size.ln();
        }
    }
    let mut rows: Vec<Vec<f64>> = a.chunks(n).map(<[f64]>::to_vec).collect();
    while let Some((i, j)) = pivot(&rows) {
        let top = rows.swap_remove(i);
        log += top[j].abs().ln();
        for row in &mut rows {
            let factor = row[j] / top[j];
            row.iter_mut().zip(&top).for_each(|(x, t)| *x -= factor * t);
            row.swap_remove(j);
        }
    }
    log
}

fn pivot(rows: &[Vec<f64>]) -> Option<(usize, usize)> {
    let places = (0..rows.len()).flat_map(|i| (0..rows.len()).map(move |j| (i, j)));
    places.max_by(|a, b| rows[a.0][a.1].abs().total_cmp(&rows[b.0][b.1].abs()))
}

/// The paper's form for one degree of freedom: T = Σ w_q X̄_q, S = Σ w_q Ȳ_q, Z̄ = Σ w_q Z̄_q, T − S Z̄ᵀ.
fn paper_form(moments: &[&Lifted], shares: &[f64]) -> Vec<f64> {
    let p = moments[0].n - 1;
    let (mut t, mut s, mut z) = (vec![0.0; p * p], vec![0.0; p], vec![0.0; p]);
    for (m, share) in moments.iter().zip(shares) {
        for i in 0..p {
            s[i] += share * m.at(i, p);
            z[i] += share * m.at(p, i);
            for j in 0..p {
                t[i * p + j] += share * m.at(i, j);
            }
        }
    }
    (0..p * p).map(|k| t[k] - s[k / p] * z[k % p]).collect()
}

fn normalized(weights: &[f64]) -> Vec<f64> {
    let total: f64 = weights.iter().sum();
    weights.iter().map(|w| w / total).collect()
}

fn weights() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(0.02f64..1.0, 11)
}

proptest! {
    /// Σ_b log|det M_b(w)| one dimension up is the paper's Σ_b log|det(T_b − S_b Z̄_bᵀ)|.
    #[test]
    fn law_the_zero_mean_problem_is_the_ordinary_one_one_dimension_up(weights in weights()) {
        let (oracle, shares) = (Oracle::read(), normalized(&weights));
        let found = oracle.candidates("complete").evaluate(&shares, &mut Evaluation::default()).unwrap();
        let degree = |d: usize| {
            let moments: Vec<&Lifted> = oracle.moments.iter().map(|degrees| &degrees[d]).collect();
            log_abs_det(moments[0].n - 1, &paper_form(&moments, &shares))
        };
        let expected: f64 = (0..3).map(degree).sum();
        prop_assert!((found - expected).abs() <= 1e-10 * expected.abs().max(1.0), "{} {}", found, expected);
    }

    /// g_q is the derivative of the criterion with respect to w_q, and Σ w_q g_q = p.
    #[test]
    fn law_sensitivities_are_the_gradient_of_the_criterion(weights in weights()) {
        let (oracle, shares) = (Oracle::read(), normalized(&weights));
        for removal in REMOVALS {
            let candidates = oracle.candidates(removal);
            let mut at = Evaluation::default();
            candidates.evaluate(&shares, &mut at).unwrap();
            let sensitivities: Vec<f64> = (0..shares.len()).map(|q| candidates.sensitivity(q, &at)).collect();
            let p = candidates.dimension() as f64;
            let mean: f64 = sensitivities.iter().zip(&shares).map(|(g, w)| g * w).sum();
            prop_assert!((mean - p).abs() <= 1e-9 * p, "{}: {} {}", removal, mean, p);
            for (q, found) in sensitivities.iter().enumerate() {
                let expected = slope(&candidates, &shares, q);
                let error = (found - expected).abs();
                prop_assert!(error <= 1e-6 * expected.abs().max(1.0), "{} {}: {} {}", removal, q, found, expected);
            }
        }
    }
}

/// Derivative of the criterion with respect to share q by central differences of fourth order.
fn slope(candidates: &Candidates, shares: &[f64], q: usize) -> f64 {
    let step = 2e-3 * shares[q];
    let at = |steps: f64| {
        let mut moved = shares.to_vec();
        moved[q] += steps * step;
        candidates.evaluate(&moved, &mut Evaluation::default()).unwrap()
    };
    (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * step)
}
