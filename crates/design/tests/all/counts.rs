//! Exact counts.

use design::{
    Bounds, Candidates, CountOptions, Counted, Error, Method, Options, apportion, count_segments, solve,
    solve_within,
};

fn polynomial(degree: usize, points: &[f64]) -> Candidates {
    let n = degree + 1;
    let mut candidates = Candidates::new(vec![n]);
    for x in points {
        let phi: Vec<f64> = (0..n).map(|i| x.powi(i as i32)).collect();
        candidates.push(&(0..n * n).map(|k| phi[k / n] * phi[k % n]).collect::<Vec<_>>()).unwrap();
    }
    candidates
}

fn grid(count: usize) -> Vec<f64> {
    (0..count).map(|i| -1.0 + 2.0 * i as f64 / (count - 1) as f64).collect()
}

fn counted(candidates: &Candidates, total: u64, limits: Option<&[u64]>, exhaustive: u64) -> Counted {
    let bounds = match limits {
        Some(limits) => {
            Bounds::new(&limits.iter().map(|a| *a as f64 / total as f64).collect::<Vec<_>>()).unwrap()
        }
        None => Bounds::default(),
    };
    let design = solve_within(candidates, &bounds, &Options::default()).unwrap();
    let options = CountOptions { exhaustive, ..CountOptions::default() };
    count_segments(candidates, &design.shares, total, limits, &options).unwrap()
}

#[test]
fn law_a_multiple_of_the_support_gets_the_optimal_design_itself() {
    let found = counted(&polynomial(2, &grid(9)), 6, None, 10_000_000);
    assert_eq!(found.counts, [2, 0, 0, 0, 2, 0, 0, 0, 2]);
    assert_eq!((found.method, found.tried), (Method::Exhaustive, 3003 + 1));
    let design = solve(&polynomial(2, &grid(9)), &Options::default()).unwrap();
    assert!(found.loss_bound(&design, 3.0) < 1e-9);
}

#[test]
fn law_exchange_finds_what_the_exhaustive_search_proves_best() {
    for (degree, points, total) in [(2, 7, 5), (3, 6, 7), (2, 7, 8), (3, 7, 5)] {
        let candidates = polynomial(degree, &grid(points));
        let (all, some) =
            (counted(&candidates, total, None, 10_000_000), counted(&candidates, total, None, 0));
        assert_eq!((all.method, some.method), (Method::Exhaustive, Method::Exchange));
        assert!((all.value - some.value).abs() < 1e-10, "{degree} {points} {total}: {all:?} {some:?}");
        assert!(all.value >= all.apportioned - 1e-12);
    }
}

#[test]
fn law_limits_are_kept_and_the_bound_covers_every_count() {
    let candidates = polynomial(2, &grid(7));
    let limits = [1, 1, 2, 0, 2, 3, 1];
    for exhaustive in [0, 10_000_000] {
        let found = counted(&candidates, 6, Some(&limits), exhaustive);
        assert_eq!(found.counts.iter().sum::<u64>(), 6);
        assert!(found.counts.iter().zip(&limits).all(|(n, a)| n <= a), "{:?}", found.counts);
    }
    let upper: Vec<f64> = limits.iter().map(|a| *a as f64 / 6.0).collect();
    let design = solve_within(&candidates, &Bounds::new(&upper).unwrap(), &Options::default()).unwrap();
    let found = counted(&candidates, 6, Some(&limits), 10_000_000);
    let loss = found.loss_bound(&design, 3.0);
    assert!((0.0..0.2).contains(&loss) && found.value <= design.log_det + design.gap.max(0.0), "{loss}");
}

#[test]
fn many_segments_of_many_candidates_are_exchanged() {
    let candidates = polynomial(4, &grid(500));
    let found = counted(&candidates, 23, None, 10_000_000);
    assert_eq!(found.method, Method::Exchange);
    let design = solve(&candidates, &Options::default()).unwrap();
    assert!(found.loss_bound(&design, 5.0) < 0.02, "{}", found.loss_bound(&design, 5.0));
    assert!(found.value >= found.apportioned);
    assert_eq!(apportion(&design.shares, 23).iter().sum::<u64>(), 23);
}

#[test]
fn limits_below_the_total_are_refused() {
    let candidates = polynomial(1, &grid(2));
    let of = |total, limits: Option<&[u64]>| {
        count_segments(&candidates, &[0.5, 0.5], total, limits, &CountOptions::default())
    };
    assert!(matches!(of(5, Some(&[2, 2])), Err(Error::Infeasible { .. })));
    assert!(matches!(of(0, None), Err(Error::Infeasible { .. })));
    assert!(matches!(of(1, None), Err(Error::Solver(_))));
    assert!(matches!(of(2, Some(&[2])), Err(Error::Shape { .. })));
}
