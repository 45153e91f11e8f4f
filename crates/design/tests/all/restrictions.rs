//! Few candidates: bounds, and choices known by enumeration.

use design::{
    Bounds, Candidates, Covariance, CovariancePoint, Design, Norm, Objective, Options, select,
    solve_covariance,
};

fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }
}

/// White noise and as many rows as a line has: concave.
fn concave(count: usize, n: usize, seed: u64) -> Covariance {
    let mut draw = uniform(seed);
    let mut candidates = Candidates::new(vec![n]);
    for _ in 0..count {
        let mut f = vec![0.0; n * n];
        for _ in 0..3 {
            let row: Vec<f64> = (0..n).map(|_| draw()).collect();
            (0..n * n).for_each(|e| f[e] += row[e / n] * row[e % n]);
        }
        candidates.push(&f).unwrap();
    }
    Covariance::new(&candidates, &candidates, &vec![1.0; n], Norm::Trace).unwrap()
}

fn solved(c: &Covariance) -> Design {
    solve_covariance(c, &Bounds::default(), &Options { random_starts: 0, ..Options::default() }).unwrap()
}

#[test]
fn law_the_best_choice_of_few_is_the_best_of_all_choices() {
    let c = concave(8, 3, 7);
    let relaxed = solved(&c);
    let options = Options { tolerance: 1e-9, ..Options::default() };
    let found = select(&c, &relaxed, &Bounds::default(), 2, &options).unwrap();
    assert!(found.exhaustive);
    // Every pair, its shares on a grid.
    let mut best = f64::NEG_INFINITY;
    for a in 0..8 {
        for b in 0..a {
            for step in 1..400 {
                let mut shares = vec![0.0; 8];
                shares[a] = f64::from(step) / 400.0;
                shares[b] = 1.0 - shares[a];
                best =
                    best.max(c.value(&shares, &mut CovariancePoint::default()).unwrap_or(f64::NEG_INFINITY));
            }
        }
    }
    assert!(found.value >= best - 1e-12 && found.value < best + 1e-3, "{} {best}", found.value);
    let loss = found.loss_bound(&relaxed, 1.0);
    let own = 1.0 - (found.value - relaxed.log_det).exp();
    assert!(loss >= own - 1e-12 && loss < own + 1e-6, "{loss} {own}");
}

#[test]
fn restricted_shares_keep_their_restriction_and_cost_what_they_say() {
    let c = concave(60, 4, 21);
    let relaxed = solved(&c);
    let used = relaxed.shares.iter().filter(|w| **w > 0.0).count();
    assert!(used > 4, "{used}");
    let options = Options { tolerance: 1e-8, ..Options::default() };
    for most in [4, 5] {
        let found = select(&c, &relaxed, &Bounds::default(), most, &options).unwrap();
        let kept: Vec<f64> = found.shares.iter().copied().filter(|w| *w > 0.0).collect();
        assert!(kept.len() <= most, "{kept:?}");
        assert!((kept.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        let value = c.value(&found.shares, &mut CovariancePoint::default()).unwrap();
        assert!((value - found.value).abs() < 1e-9 && value <= relaxed.log_det + 1e-9);
        assert!(found.loss_bound(&relaxed, 1.0) < 0.5);
    }
}
