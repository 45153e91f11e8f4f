//! Several models at once, and few candidates: derivatives, bounds and choices known by enumeration.

use design::{
    Bounds, Candidates, Covariance, CovariancePoint, Design, Norm, Objective, Options, Over, Restriction,
    Robust, RobustPoint, Status, select, solve_covariance, solve_robust,
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
    Covariance::new(&candidates, &candidates, &vec![1.0; n], Norm::PowerMean(1.0)).unwrap()
}

fn solved(c: &Covariance) -> Design {
    solve_covariance(c, &Bounds::default(), &Options { random_starts: 0, ..Options::default() }).unwrap()
}

#[test]
fn law_gradients_and_curvatures_over_models_are_those_of_finite_differences() {
    let models = || (0..3).map(|m| concave(6, 3, 10 + m)).collect::<Vec<_>>();
    let shares = [0.1, 0.2, 0.15, 0.25, 0.2, 0.1];
    for over in [Over::Mean, Over::Worst(3.0), Over::Worst(40.0)] {
        let robust = Robust::new(models(), over).unwrap();
        let mut at = RobustPoint::default();
        robust.evaluate(&shares, &mut at).unwrap();
        let members: Vec<usize> = (0..6).collect();
        let curvature = robust.curvature(&members, &at);
        let mean: f64 = (0..6).map(|q| shares[q] * robust.sensitivity(q, &at)).sum();
        assert!((mean - robust.degree()).abs() < 1e-9);
        for q in 0..6 {
            let moved = |step: f64| {
                let mut moved = shares.to_vec();
                moved[q] += step;
                let mut there = RobustPoint::default();
                let value = robust.evaluate(&moved, &mut there).unwrap();
                (value, (0..6).map(|r| robust.sensitivity(r, &there)).collect::<Vec<f64>>())
            };
            let (up, down) = (moved(1e-6), moved(-1e-6));
            let slope = (up.0 - down.0) / 2e-6;
            assert!((slope - robust.sensitivity(q, &at)).abs() < 1e-6 * slope.abs().max(1.0), "{over:?} {q}");
            for r in 0..6 {
                let second = -(up.1[r] - down.1[r]) / 2e-6;
                let found = curvature[q * 6 + r];
                assert!(
                    (found - second).abs() < 1e-5 * second.abs().max(1.0),
                    "{over:?} {q} {r}: {found} {second}"
                );
            }
        }
    }
}

#[test]
fn law_the_worst_model_is_better_off_than_in_any_other_design() {
    let models: Vec<Covariance> = (0..4).map(|m| concave(9, 3, 30 + m)).collect();
    let worst = |shares: &[f64]| {
        let of = |m: &Covariance| m.value(shares, &mut CovariancePoint::default()).unwrap();
        models.iter().map(of).fold(f64::INFINITY, f64::min)
    };
    let robust = Robust::new(models.clone(), Over::Worst(1e5)).unwrap();
    let options = Options { tolerance: 1e-7, random_starts: 0, ..Options::default() };
    let design = solve_robust(&robust, &Bounds::default(), &options).unwrap();
    assert_eq!(design.status, Status::Optimal, "{}", design.gap);
    let own = worst(&design.shares);
    assert!(design.log_det >= own - 1e-9 && design.log_det <= own + robust.excess() + 1e-9);
    for m in &models {
        assert!(worst(&solved(m).shares) <= own + 1e-6);
    }
    let mean = Robust::new(models.clone(), Over::Mean).unwrap();
    let design = solve_robust(&mean, &Bounds::default(), &options).unwrap();
    assert!(worst(&design.shares) <= own + 1e-6);
}

#[test]
fn law_the_best_choice_of_few_is_the_best_of_all_choices() {
    let c = concave(8, 3, 7);
    let relaxed = solved(&c);
    let options = Options { tolerance: 1e-9, ..Options::default() };
    let restriction = Restriction { most: 2, least: 0.0 };
    let found = select(&c, &relaxed, &Bounds::default(), &restriction, &options).unwrap();
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
    for (most, least) in [(4, 0.0), (60, 0.15), (5, 0.12)] {
        let found = select(&c, &relaxed, &Bounds::default(), &Restriction { most, least }, &options).unwrap();
        let kept: Vec<f64> = found.shares.iter().copied().filter(|w| *w > 0.0).collect();
        assert!(kept.len() <= most && kept.iter().all(|w| *w >= least - 1e-9), "{kept:?}");
        assert!((kept.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        let value = c.value(&found.shares, &mut CovariancePoint::default()).unwrap();
        assert!((value - found.value).abs() < 1e-9 && value <= relaxed.log_det + 1e-9);
        assert!(found.loss_bound(&relaxed, 1.0) < 0.5);
    }
}
