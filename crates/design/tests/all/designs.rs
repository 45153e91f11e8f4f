//! Designs whose answer is known by theory.

use argmin::core::{Executor, IterState, State as _};
use design::{ActiveSetNewton, Candidates, Error, Options, Start, Status, is_concave, solve};
use proptest::prelude::*;

/// φφᵀ of polynomial regression of `degree` at points between −1 and 1.
fn polynomial(degree: usize, points: &[f64]) -> Candidates {
    let n = degree + 1;
    let mut candidates = Candidates::new(vec![n]);
    for x in points {
        let phi: Vec<f64> = (0..n).map(|i| x.powi(i as i32)).collect();
        let outer: Vec<f64> = (0..n * n).map(|k| phi[k / n] * phi[k % n]).collect();
        candidates.push(&outer).unwrap();
    }
    candidates
}

fn grid(count: usize) -> Vec<f64> {
    (0..count).map(|i| -1.0 + 2.0 * i as f64 / (count - 1) as f64).collect()
}

/// Guest 1958: the D-optimal points of cubic regression on [−1, 1] are ±1 and ±1/√5, a quarter each.
#[test]
fn law_polynomial_designs_sit_on_the_legendre_points() {
    let mut points = grid(41);
    points.extend([-(0.2_f64.sqrt()), 0.2_f64.sqrt()]);
    let design = solve(&polynomial(3, &points), &Options::default()).unwrap();
    assert_eq!(design.status, Status::Optimal);
    for q in [0, 40, 41, 42] {
        assert!((design.shares[q] - 0.25).abs() < 1e-7, "{}: {}", points[q], design.shares[q]);
    }
    assert!(design.gap <= 1e-10 * 4.0);
}

#[test]
fn law_every_start_of_a_concave_problem_reaches_the_same_value() {
    let design =
        solve(&polynomial(2, &grid(21)), &Options { random_starts: 8, ..Options::default() }).unwrap();
    assert_eq!(design.starts.len(), 9);
    for start in &design.starts {
        assert!((start.log_det - design.log_det).abs() < 1e-9 * design.log_det.abs().max(1.0));
    }
    for (q, x) in [(0, -1.0), (10, 0.0), (20, 1.0)] {
        assert!((design.shares[q] - 1.0 / 3.0).abs() < 1e-7, "{x}");
    }
}

#[test]
fn law_sensitivities_average_to_the_dimension_and_none_exceeds_it() {
    let candidates = polynomial(4, &grid(101));
    let design = solve(&candidates, &Options::default()).unwrap();
    let mean: f64 = design.shares.iter().zip(&design.sensitivities).map(|(w, g)| w * g).sum();
    assert!((mean - 5.0).abs() < 1e-9);
    assert!(design.sensitivities.iter().all(|g| *g <= 5.0 * (1.0 + 1e-9)));
    assert!((design.shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
}

/// At scale: ten thousand candidates of dimension 13 in three blocks, not symmetric.
#[test]
fn law_ten_thousand_candidates_reach_the_gap() {
    let candidates = random_candidates(10_000, 7);
    let design =
        solve(&candidates, &Options { random_starts: 1, tolerance: 1e-8, ..Options::default() }).unwrap();
    assert!(design.gap <= 1e-8 * 13.0, "gap {}", design.gap);
    assert_eq!(design.status, Status::Stationary);
}

/// φ̃ζ̃ᵀ averaged over a few draws, with ζ a distorted φ, as simulated instruments are.
fn random_candidates(count: usize, seed: u64) -> Candidates {
    let mut state = seed;
    let mut uniform = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let mut candidates = Candidates::new(vec![5, 4, 4]);
    for _ in 0..count {
        let mut entries = Vec::new();
        for n in [5, 4, 4] {
            let mut block = vec![0.0; n * n];
            let offset = uniform();
            for _ in 0..12 {
                let phi: Vec<f64> =
                    (0..n).map(|i| if i == n - 1 { 1.0 } else { uniform() + offset }).collect();
                let zeta: Vec<f64> =
                    (0..n).map(|i| if i == n - 1 { 1.0 } else { 0.8 * phi[i] + 0.1 * uniform() }).collect();
                block.iter_mut().enumerate().for_each(|(k, m)| *m += phi[k / n] * zeta[k % n] / 12.0);
            }
            entries.extend(block);
        }
        candidates.push(&entries).unwrap();
    }
    candidates
}

#[test]
fn a_direction_without_excitation_is_named() {
    let mut candidates = Candidates::new(vec![2, 2]);
    candidates.push(&[1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]).unwrap();
    assert_eq!(
        solve(&candidates, &Options::default()),
        Err(Error::Unexcited { block: 1, direction: vec![0.0, 1.0] })
    );
    // Rows that are excited, but always in the same combination.
    let mut collinear = Candidates::new(vec![2]);
    collinear.push(&[1.0, 2.0, 2.0, 4.0]).unwrap();
    collinear.push(&[2.0, 4.0, 4.0, 8.0]).unwrap();
    assert!(matches!(solve(&collinear, &Options::default()), Err(Error::Unexcited { block: 0, .. })));
    assert_eq!(solve(&Candidates::new(vec![2]), &Options::default()), Err(Error::Empty));
    assert!(candidates.push(&[1.0]).is_err() && candidates.push(&[f64::NAN; 8]).is_err());
}

#[test]
fn concavity_is_seen_through_row_scaling_and_denied_without_symmetry() {
    let mut scaled = Candidates::new(vec![2]);
    scaled.push(&[2.0, 1.0, 0.5, 1.0]).unwrap();
    scaled.push(&[4.0, -1.0, -0.5, 1.0]).unwrap();
    assert!(is_concave(&scaled));
    scaled.push(&[4.0, -1.0, 0.5, 1.0]).unwrap();
    assert!(!is_concave(&scaled));
    let mut indefinite = Candidates::new(vec![2]);
    indefinite.push(&[1.0, 2.0, 2.0, 1.0]).unwrap();
    assert!(!is_concave(&indefinite));
}

#[test]
fn law_an_efficiency_is_the_share_of_time_that_is_needed() {
    let candidates = polynomial(1, &[-1.0, 1.0]);
    let design = solve(&candidates, &Options::default()).unwrap();
    assert!((design.efficiency(&candidates, &[0.5, 0.5], 2) - 1.0).abs() < 1e-12);
    // det at shares (w, 1 − w) is 4 w (1 − w).
    assert!((design.efficiency(&candidates, &[0.9, 0.1], 2) - (4.0 * 0.09_f64).sqrt()).abs() < 1e-12);
    assert_eq!(design.efficiency(&candidates, &[1.0, 0.0], 2), 0.0);
    assert_eq!(design.single_efficiencies(&candidates, 2), vec![0.0, 0.0]);
}

/// argmin's limits apply, and a saved solver continues where it stopped.
#[test]
fn a_saved_solver_resumes() {
    type Held = IterState<Vec<f64>, (), (), (), (), f64>;
    let candidates = random_candidates(40, 3);
    let start = vec![1.0 / 40.0; 40];
    let run = |solver: ActiveSetNewton, from: Vec<f64>, limit: u64| {
        Executor::new(&candidates, solver)
            .configure(|s: Held| s.param(from).max_iters(limit))
            .timer(false)
            .run()
            .unwrap()
    };
    let whole = run(ActiveSetNewton::new(1e-10), start.clone(), 200);
    let part = run(ActiveSetNewton::new(1e-10), start, 2);
    let saved = serde_json::to_string(&part.solver).unwrap();
    let shares = part.state.param.unwrap();
    let rest = run(serde_json::from_str(&saved).unwrap(), shares, 200);
    assert_eq!(whole.state.get_iter(), 2 + rest.state.get_iter());
    assert!((whole.state.cost - rest.state.cost).abs() < 1e-12);
}

proptest! {
    #[test]
    fn law_rescaled_rows_and_columns_change_neither_shares_nor_sensitivities(factors in prop::collection::vec(1e-3f64..1e3, 26)) {
        let candidates = random_candidates(12, 5);
        let mut rescaled = Candidates::new(vec![5, 4, 4]);
        for q in 0..candidates.len() {
            let mut entries = candidates.candidate(q).to_vec();
            let mut row = 0;
            for (n, range) in candidates.blocks() {
                for (k, entry) in entries[range].iter_mut().enumerate() {
                    *entry *= factors[row + k / n] * factors[13 + row + k % n];
                }
                row += n;
            }
            rescaled.push(&entries).unwrap();
        }
        let options = Options { random_starts: 0, ..Options::default() };
        let (one, other) = (solve(&candidates, &options).unwrap(), solve(&rescaled, &options).unwrap());
        for (a, b) in one.shares.iter().zip(&other.shares) {
            prop_assert!((a - b).abs() < 1e-6, "{a} {b}");
        }
        for (a, b) in one.sensitivities.iter().zip(&other.sensitivities) {
            prop_assert!((a - b).abs() < 1e-6 * 13.0, "{a} {b}");
        }
    }
}

#[test]
fn a_start_that_stalled_wins_by_more_than_digits_alone() {
    let start =
        |log_det: f64, relative_gap: f64| Start { shares: vec![], log_det, relative_gap, iterations: 1 };
    let won = |of: &[Start]| Start::best(of, 1e-10).map(|own| (own.log_det, own.relative_gap));
    let (converged, near, far) = (start(5.0, 1e-11), start(5.0 + 1e-11, 1e-7), start(5.1, 1e-7));
    assert_eq!(won(&[near.clone(), converged.clone()]), Some((5.0, 1e-11)));
    assert_eq!(won(&[converged.clone(), start(4.0, 1e-12)]), Some((5.0, 1e-11)));
    assert_eq!(won(&[converged, far.clone(), near]), Some((5.1, 1e-7)));
    assert_eq!(won(&[far]), Some((5.1, 1e-7)));
    assert_eq!(won(&[]), None);
}
