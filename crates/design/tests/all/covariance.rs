//! Criteria of the covariance: derivatives, scaling, certificates and designs known by theory.

use design::{
    Bounds, Candidates, Covariance, CovariancePoint, Criterion, Degree, Dictionary, Error, Norm, Objective,
    Options, Status, solve, solve_covariance, solve_covariance_among, solve_covariance_from, solve_within,
};

fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }
}

/// Information φζᵀ and meat matrices of `count` candidates; the last row of a block is a constant.
fn random(count: usize, seed: u64, dimensions: &[usize]) -> (Candidates, Candidates) {
    let mut uniform = uniform(seed);
    let (mut information, mut meat) =
        (Candidates::new(dimensions.to_vec()), Candidates::new(dimensions.to_vec()));
    for _ in 0..count {
        let (mut m, mut b) = (Vec::new(), Vec::new());
        for n in dimensions.iter().copied() {
            let (mut own_m, mut own_b) = (vec![0.0; n * n], vec![0.0; n * n]);
            let offset = uniform();
            let mut before = vec![0.0; n];
            for _ in 0..12 {
                let phi: Vec<f64> =
                    (0..n).map(|i| if i == n - 1 { 1.0 } else { uniform() + offset }).collect();
                let zeta: Vec<f64> =
                    (0..n).map(|i| if i == n - 1 { 1.0 } else { 0.8 * phi[i] + 0.1 * uniform() }).collect();
                let noise: Vec<f64> = zeta.iter().zip(&before).map(|(z, b)| b - 0.9 * z).collect();
                for k in 0..n * n {
                    own_m[k] += phi[k / n] * zeta[k % n] / 12.0;
                    own_b[k] += (noise[k / n] * noise[k % n] + 0.1 * zeta[k / n] * zeta[k % n]) / 12.0;
                }
                before = zeta;
            }
            m.extend(own_m);
            b.extend(own_b);
        }
        information.push(&m).unwrap();
        meat.push(&b).unwrap();
    }
    (information, meat)
}

/// Information about cubic polynomials at `count` points with spacing `apart`, from −1 on.
fn cubics(count: u32, apart: f64) -> Candidates {
    let mut information = Candidates::new(vec![4]);
    for i in 0..count {
        let x = -1.0 + apart * f64::from(i);
        let phi: Vec<f64> = (0..4).map(|p| x.powi(p)).collect();
        information.push(&(0..16).map(|k| phi[k / 4] * phi[k % 4]).collect::<Vec<_>>()).unwrap();
    }
    information
}

const DIMENSIONS: [usize; 3] = [5, 4, 4];

/// 1 for parameters, 0 for the intercept at the end of every block.
fn weights(dimensions: &[usize]) -> Vec<f64> {
    dimensions.iter().flat_map(|n| (0..*n).map(move |i| f64::from(u8::from(i + 1 < *n)))).collect()
}

const NORMS: [Norm; 2] = [Norm::LogDet, Norm::Trace];

#[test]
fn law_gradients_and_curvatures_are_those_of_finite_differences() {
    let (information, meat) = random(9, 3, &DIMENSIONS);
    let mut draw = uniform(8);
    let mut shares: Vec<f64> = (0..9).map(|_| draw() + 0.6).collect();
    let total: f64 = shares.iter().sum();
    shares.iter_mut().for_each(|w| *w /= total);
    for norm in NORMS {
        let c = Covariance::new(&information, &meat, &weights(&DIMENSIONS), norm).unwrap();
        let mut at = CovariancePoint::default();
        let value = c.evaluate(&shares, &mut at).unwrap();
        assert!((value - c.value(&shares, &mut CovariancePoint::default()).unwrap()).abs() < 1e-10);
        let members: Vec<usize> = (0..9).collect();
        let curvature = c.curvature(&members, &at);
        let mean: f64 = (0..9).map(|q| shares[q] * c.sensitivity(q, &at)).sum();
        assert!((mean - c.degree()).abs() < 1e-9 * c.degree(), "{norm:?}: {mean}");
        for q in 0..9 {
            let moved = |step: f64| {
                let mut moved = shares.clone();
                moved[q] += step;
                let mut there = CovariancePoint::default();
                let value = c.evaluate(&moved, &mut there).unwrap();
                (value, (0..9).map(|r| c.sensitivity(r, &there)).collect::<Vec<f64>>())
            };
            let step = 1e-6;
            let (up, down) = (moved(step), moved(-step));
            let (found, expected) = (c.sensitivity(q, &at), (up.0 - down.0) / (2.0 * step));
            assert!(
                (found - expected).abs() < 1e-6 * expected.abs().max(1.0),
                "{norm:?} {q}: {found} {expected}"
            );
            for r in 0..9 {
                let expected = -(up.1[r] - down.1[r]) / (2.0 * step);
                let found = curvature[q * 9 + r];
                let size = curvature.iter().fold(1.0f64, |a, b| a.max(b.abs()));
                assert!((found - expected).abs() < 2e-6 * size, "{norm:?} {q} {r}: {found} {expected}");
            }
        }
    }
}

/// With B proportional to a symmetric information the covariance is its inverse: D on either is the same problem.
#[test]
fn law_d_of_the_covariance_is_d_of_the_information_where_the_noise_is_white() {
    let information = cubics(21, 0.1);
    let c = Covariance::new(&information, &information, &[1.0; 4], Norm::LogDet).unwrap();
    assert!(c.is_concave());
    let (one, other) = (
        solve(&information, &Options::default()).unwrap(),
        solve_covariance(&c, &Bounds::default(), &Options::default()).unwrap(),
    );
    assert_eq!(other.status, Status::Optimal);
    assert!((one.log_det - other.log_det).abs() < 1e-9, "{} {}", one.log_det, other.log_det);
    for (a, b) in one.sensitivities.iter().zip(&other.sensitivities) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
}

/// Straight lines through −1, 0, 1: the A-optimal shares are half at each end.
#[test]
fn law_a_of_a_straight_line_takes_the_ends() {
    let mut information = Candidates::new(vec![2]);
    for x in [-1.0, -0.5, 0.0, 0.5, 1.0] {
        information.push(&[1.0, x, x, x * x]).unwrap();
    }
    let c = Covariance::new(&information, &information, &[1.0; 2], Norm::Trace).unwrap();
    let options = Options { tolerance: 1e-7, ..Options::default() };
    let design = solve_covariance(&c, &Bounds::default(), &options).unwrap();
    assert_eq!(design.status, Status::Optimal, "{design:?}");
    for end in [0, 4] {
        assert!((design.shares[end] - 0.5).abs() < 1e-6, "{:?}", design.shares);
    }
}

/// A concave criterion has one best value, from any start.
#[test]
fn law_a_search_from_other_shares_or_among_few_ends_at_the_same_value() {
    let information = cubics(201, 0.01);
    let options = Options { random_starts: 0, tolerance: 1e-8, ..Options::default() };
    let solved = |weights: [f64; 4]| {
        let c = Covariance::new(&information, &information, &weights, Norm::Trace).unwrap();
        let design = solve_covariance(&c, &Bounds::default(), &options).unwrap();
        (c, design)
    };
    let (c, best) = solved([1.0, 2.0, 3.0, 4.0]);
    let (_, other) = solved([4.0, 0.5, 1.0, 0.1]);
    let from = solve_covariance_from(&c, &other.shares, &options).unwrap();
    let among = solve_covariance_among(&c, 8, &options).unwrap();
    for own in [from, among] {
        assert_eq!(own.status, Status::Optimal);
        assert!((own.log_det - best.log_det).abs() < 1e-7, "{} {}", own.log_det, best.log_det);
    }
    assert!(matches!(solve_covariance_from(&c, &[1.0], &options), Err(Error::Shape { .. })));
    let one = [&[1.0][..], &[0.0; 200]].concat();
    assert!(matches!(solve_covariance_from(&c, &one, &options), Err(Error::Solver(_))));
}

#[test]
fn law_scaled_parameters_change_d_by_a_constant_and_no_shares() {
    let (information, meat) = random(12, 5, &DIMENSIONS);
    let rescale = |of: &Candidates, rows: bool| {
        let mut out = Candidates::new(DIMENSIONS.to_vec());
        for q in 0..of.len() {
            let mut entries = of.candidate(q).to_vec();
            for (n, range) in of.blocks() {
                for (k, e) in entries[range].iter_mut().enumerate() {
                    let row = if rows && k / n + 1 < n { 10f64.powi((k / n) as i32 * 3 - 4) } else { 1.0 };
                    *e *= row;
                }
            }
            out.push(&entries).unwrap();
        }
        out
    };
    let scaled = rescale(&information, true);
    let options = Options { random_starts: 1, ..Options::default() };
    let of = |m: &Candidates| {
        let c = Covariance::new(m, &meat, &weights(&DIMENSIONS), Norm::LogDet).unwrap();
        solve_covariance(&c, &Bounds::default(), &options).unwrap()
    };
    let (one, other) = (of(&information), of(&scaled));
    for (a, b) in one.shares.iter().zip(&other.shares) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
    // Each φ times 10^k makes its parameter 10^−k of what it was: variances fall by 10^2k.
    let exponent: i32 = DIMENSIONS.iter().map(|n| (0..*n as i32 - 1).map(|i| 3 * i - 4).sum::<i32>()).sum();
    let moved = 2.0 * f64::from(exponent) * 10f64.ln();
    assert!((other.log_det - one.log_det - moved).abs() < 1e-8, "{} {} {moved}", other.log_det, one.log_det);
}

#[test]
fn law_the_certificate_holds_under_bounds() {
    let (information, meat) = random(40, 11, &DIMENSIONS);
    let bounds = Bounds::new(&[0.06; 40]).unwrap();
    let c = |norm| Covariance::new(&information, &meat, &weights(&DIMENSIONS), norm).unwrap();
    let options = Options { tolerance: 1e-9, ..Options::default() };
    let designs = [
        (solve_within(&information, &bounds, &options).unwrap(), 13.0),
        (solve_covariance(&c(Norm::LogDet), &bounds, &options).unwrap(), 10.0),
        (solve_covariance(&c(Norm::Trace), &bounds, &options).unwrap(), 1.0),
    ];
    for (design, p) in designs {
        assert_eq!(design.status, Status::Stationary, "{}", design.gap);
        assert!((design.shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let mean: f64 = design.shares.iter().zip(&design.sensitivities).map(|(w, g)| w * g).sum();
        assert!((mean - p).abs() < 1e-8 * p);
        let between: Vec<f64> = (0..40)
            .filter(|q| design.shares[*q] > 0.0 && design.shares[*q] < 0.06)
            .map(|q| design.sensitivities[q])
            .collect();
        let level = between[0];
        for (q, w) in design.shares.iter().enumerate() {
            let g = design.sensitivities[q];
            assert!(*w <= 0.06 && *w >= 0.0);
            if *w == 0.0 {
                assert!(g <= level + 1e-6 * p, "{q}: {g} {level}");
            } else if *w == 0.06 {
                assert!(g >= level - 1e-6 * p, "{q}: {g} {level}");
            } else {
                assert!((g - level).abs() < 1e-6 * p, "{q}: {g} {level}");
            }
        }
    }
}

#[test]
fn law_bounds_that_do_not_bind_change_nothing() {
    let (information, _) = random(30, 2, &DIMENSIONS);
    let free = solve(&information, &Options::default()).unwrap();
    let loose = solve_within(&information, &Bounds::new(&[0.99; 30]).unwrap(), &Options::default()).unwrap();
    for (a, b) in free.shares.iter().zip(&loose.shares) {
        assert!((a - b).abs() < 1e-7, "{a} {b}");
    }
    assert_eq!(Bounds::new(&[1.0; 30]).unwrap(), Bounds::default());
    assert!(matches!(Bounds::new(&[0.1; 3]), Err(Error::Infeasible { .. })));
    assert!(matches!(Bounds::new(&[0.9, f64::NAN]), Err(Error::Bound { candidate: 1, .. })));
}

#[test]
fn law_ten_thousand_candidates_reach_the_gap_of_covariance_criteria() {
    let (information, meat) = random(10_000, 7, &DIMENSIONS);
    for norm in NORMS {
        let begun = std::time::Instant::now();
        let c = Covariance::new(&information, &meat, &weights(&DIMENSIONS), norm).unwrap();
        let options = Options { random_starts: 1, tolerance: 1e-6, ..Options::default() };
        let design = solve_covariance(&c, &Bounds::default(), &options).unwrap();
        println!(
            "{norm:?}: {:?} gap {:e} iterations {:?}",
            begun.elapsed(),
            design.gap,
            design.starts.iter().map(|s| (s.iterations, s.log_det)).collect::<Vec<_>>()
        );
        assert_eq!(design.status, Status::Stationary, "{norm:?} {}", design.gap);
    }
}

#[test]
fn a_singular_covariance_names_its_row() {
    let mut information = Candidates::new(vec![2]);
    information.push(&[1.0, 0.2, 0.1, 1.0]).unwrap();
    let mut meat = Candidates::new(vec![2]);
    meat.push(&[1.0, 0.0, 0.0, 0.0]).unwrap();
    let of = |norm| Covariance::new(&information, &meat, &[1.0, 1.0], norm);
    assert!(matches!(of(Norm::LogDet), Err(Error::SingularCovariance { block: 0, .. })));
    assert!(of(Norm::Trace).is_ok());
    let mut still = Candidates::new(vec![2]);
    still.push(&[0.0; 4]).unwrap();
    for norm in NORMS {
        assert!(matches!(
            Covariance::new(&information, &still, &[1.0, 1.0], norm),
            Err(Error::SingularCovariance { .. })
        ));
    }
    assert!(matches!(
        Covariance::new(&information, &meat, &[1.0, -1.0], Norm::LogDet),
        Err(Error::Weight { row: 1, .. })
    ));
}

/// D-optimality does not depend on the basis of polynomials: powers, whose information is nearly singular, lead to
/// the same shares and the same certificate as Legendre polynomials.
#[test]
fn law_an_ill_conditioned_basis_changes_no_shares() {
    let points = 41;
    let solved = |basis: &dyn Fn(f64) -> Vec<f64>| {
        let (mut information, mut meat) = (Candidates::new(vec![5]), Candidates::new(vec![5]));
        for i in 0..points {
            let row = basis(2.0 * f64::from(i) / f64::from(points - 1) - 1.0);
            let square: Vec<f64> = row.iter().flat_map(|a| row.iter().map(move |b| a * b)).collect();
            information.push(&square).unwrap();
            meat.push(&square).unwrap();
        }
        let c = Covariance::new(&information, &meat, &[1.0; 5], Norm::LogDet).unwrap();
        let options = Options { tolerance: 1e-6, ..Options::default() };
        solve_covariance(&c, &Bounds::default(), &options).unwrap()
    };
    let legendre = solved(&|x| {
        let mut all = vec![1.0, x];
        for k in 2..5_i32 {
            let (n, before, last) = (f64::from(k), all[all.len() - 2], all[all.len() - 1]);
            all.push(((2.0 * n - 1.0) * x * last - (n - 1.0) * before) / n);
        }
        all
    });
    let powers = solved(&|x| (0..5).map(|k| (2.0 + x).powi(k)).collect());
    for design in [&legendre, &powers] {
        assert_eq!(design.status, Status::Optimal, "{:e}", design.gap);
    }
    for (a, b) in legendre.shares.iter().zip(&powers.shares) {
        assert!((a - b).abs() < 2e-3, "{:?} {:?}", legendre.shares, powers.shares);
    }
}

#[test]
fn law_predicted_errors_add_up_to_the_norm_and_fall_with_the_samples() {
    let (information, meat) = random(9, 3, &DIMENSIONS);
    let names = |n: usize| (0..n).map(|i| format!("p{i}")).collect::<Vec<_>>();
    let degree = |n: usize| Degree { name: "surge".into(), regressors: names(n), parameters: names(n - 1) };
    let dictionary = Dictionary {
        degrees: DIMENSIONS.map(degree).into(),
        maneuvers: names(9),
        sample_rate_hz: 1.0,
        intercepts: true,
        information,
    };
    let (shares, p) = ([1.0 / 9.0; 9], dictionary.parameters());
    let weights: Vec<f64> = (1..=p).map(|k| k as f64).collect();
    let is_near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9 * b.abs(), "{a} {b}");
    for norm in NORMS {
        let built = Criterion::of_covariance(&dictionary, &meat, weights.clone(), norm).unwrap();
        let Criterion::Covariance(own) = built else { panic!("no criterion of the covariance") };
        let [once, often] = [1.0, 400.0].map(|n| own.predicted(&dictionary, &shares, n).unwrap());
        assert_eq!((once.standard_errors.len(), often.standard_errors.len()), (p, p));
        once.standard_errors.iter().zip(&often.standard_errors).for_each(|(a, b)| is_near(*a, 20.0 * b));
        let summed = |errors: &[f64]| weights.iter().zip(errors).map(|(w, e)| w * e * e).sum::<f64>();
        match norm {
            Norm::Trace => {
                [&once, &often].into_iter().for_each(|own| is_near(own.value, summed(&own.standard_errors)));
            }
            Norm::LogDet => is_near(once.value - often.value, p as f64 * 400f64.ln()),
        }
    }
    let known = Criterion::Information(dictionary.information.clone()).value(&shares).unwrap();
    is_near(dictionary.information.log_det(&shares).unwrap(), known);
}
