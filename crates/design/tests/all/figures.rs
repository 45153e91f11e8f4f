//! Designs for figures of merit, against an inverse and a search of their own.

use design::{
    AccuracyOf, Bounds, Candidates, Covariance, CovariancePoint, Criterion, Degree, Dictionary, Errors,
    FigureErrors, Norm, Objective, Options, Question, Wanted, WeightedFigure, solve_covariance,
};

/// What the criterion adds to figures.
const IDENTITY: f64 = 1e-5;

/// Parameters of 1 + q times the noise at the point `x[q]`: slope and curvature of a parabola with an intercept.
const PARAMETERS: [f64; 2] = [2.0, -0.5];

const POINTS: [f64; 4] = [-1.0, -0.3, 0.4, 1.0];

fn information(x: f64) -> [f64; 9] {
    let phi = [x, x * x, 1.0];
    std::array::from_fn(|k| phi[k / 3] * phi[k % 3])
}

/// A dictionary of points and its meat.
fn parabola() -> (Dictionary, Candidates) {
    let (mut own, mut meat) = (Candidates::new(vec![3]), Candidates::new(vec![3]));
    for (q, x) in POINTS.into_iter().enumerate() {
        own.push(&information(x)).unwrap();
        meat.push(&information(x).map(|entry| (1.0 + q as f64) * entry)).unwrap();
    }
    let degree = Degree {
        name: "surge".into(),
        regressors: vec!["x".into(), "x x".into()],
        parameters: vec!["slope".into(), "curvature".into()],
    };
    let maneuvers = POINTS.iter().map(|x| format!("{x}")).collect();
    (
        Dictionary {
            degrees: vec![degree],
            maneuvers,
            sample_rate_hz: 2.0,
            intercepts: true,
            information: own,
        },
        meat,
    )
}

fn product(a: &[f64; 9], b: &[f64; 9]) -> [f64; 9] {
    std::array::from_fn(|k| (0..3).map(|m| a[3 * (k / 3) + m] * b[3 * m + k % 3]).sum())
}

/// By cofactors; not a number where it is singular.
fn inverse(m: &[f64; 9]) -> [f64; 9] {
    let minor = |i: usize, j: usize| {
        let of = |a: usize, b: usize| m[3 * ((i + a) % 3) + (j + b) % 3];
        of(1, 1) * of(2, 2) - of(1, 2) * of(2, 1)
    };
    let det: f64 = (0..3).map(|j| m[j] * minor(0, j)).sum();
    let det = if det.abs() < 1e-9 { f64::NAN } else { det };
    std::array::from_fn(|k| minor(k % 3, k / 3) / det)
}

/// Variance of the figure with these slopes after a sample at `shares`, and of each parameter.
fn variances(shares: &[f64], slopes: &[f64]) -> [f64; 3] {
    let (mut a, mut b) = ([0.0; 9], [0.0; 9]);
    for (q, x) in POINTS.into_iter().enumerate() {
        for (k, entry) in information(x).into_iter().enumerate() {
            a[k] += shares[q] * entry;
            b[k] += (1.0 + q as f64) * shares[q] * entry;
        }
    }
    let inverse = inverse(&a);
    let c = product(&product(&inverse, &b), &inverse);
    let figure = (0..4).map(|k| slopes[k / 2] * c[3 * (k / 2) + k % 2] * slopes[k % 2]).sum();
    [figure, c[0], c[4]]
}

fn criterion(shares: &[f64], figure: &WeightedFigure) -> f64 {
    let [own, slope, curvature] = variances(shares, &figure.slopes);
    let relative = slope / PARAMETERS[0].powi(2) + curvature / PARAMETERS[1].powi(2);
    own / figure.value.powi(2) + IDENTITY * relative
}

/// The least criterion over the shares of a grid, then over ever smaller steps around the best.
fn searched(figure: &WeightedFigure) -> (f64, Vec<f64>) {
    let steps = 20;
    let mut best = (f64::INFINITY, vec![0.25; 4]);
    for k in 0..(steps + 1usize).pow(3) {
        let counts = [k % (steps + 1), k / (steps + 1) % (steps + 1), k / (steps + 1).pow(2)];
        let rest = steps as f64 - counts.iter().sum::<usize>() as f64;
        if rest >= 0.0 {
            let shares: Vec<f64> =
                counts.iter().map(|n| *n as f64).chain([rest]).map(|n| n / steps as f64).collect();
            let value = criterion(&shares, figure);
            if value.is_finite() && value < best.0 {
                best = (value, shares);
            }
        }
    }
    let mut step = 0.5 / steps as f64;
    while step > 1e-9 {
        let from = best.clone();
        for (i, j) in (0..16).map(|k| (k / 4, k % 4)).filter(|(i, j)| i != j) {
            let mut shares = from.1.clone();
            let moved = step.min(shares[i]);
            shares[i] -= moved;
            shares[j] += moved;
            let value = criterion(&shares, figure);
            if value < best.0 {
                best = (value, shares);
            }
        }
        step = if best.0 < from.0 { step } else { 0.5 * step };
    }
    best
}

fn solved(dictionary: &Dictionary, criterion: &Criterion) -> Vec<f64> {
    let design = criterion.solve(&Bounds::default(), &Options::default());
    design.map_err(|e| dictionary.explain(e)).unwrap().shares
}

#[test]
fn law_the_design_for_a_figure_is_that_of_a_search_and_knows_it_better_than_the_d_optimal_one() {
    let (dictionary, meat) = parabola();
    let d = Criterion::of_covariance(&dictionary, &meat, vec![1.0; 2], Norm::LogDet).unwrap();
    let d_optimal = solved(&dictionary, &d);
    let mut ratios = Vec::new();
    for slopes in [[1.0, 0.0], [0.0, 3.0], [1.0, 1.4], [-0.6, 2.0]] {
        let figure = WeightedFigure { value: 0.7, slopes: slopes.to_vec(), weight: 1.0 };
        let own =
            Criterion::of_figures(&dictionary, &meat, std::slice::from_ref(&figure), &PARAMETERS).unwrap();
        let shares = solved(&dictionary, &own);
        let (least, _) = searched(&figure);
        let found = criterion(&shares, &figure);
        assert!((found - least).abs() < 1e-6 * least, "{slopes:?}: {found} {least}");
        let value = own.value(&shares).unwrap();
        assert!(((-value).exp() - found).abs() < 1e-9 * found, "{slopes:?}: {value} {found}");
        let errors = FigureErrors::new(&dictionary, &meat, &[slopes.to_vec()]).unwrap();
        let at = |shares: &[f64]| errors.at(shares, 100.0).unwrap()[0];
        let [expected, ..] = variances(&shares, &slopes);
        assert!((at(&shares) - (expected / 100.0).sqrt()).abs() < 1e-9 * at(&shares));
        ratios.push(at(&shares) / at(&d_optimal));
    }
    assert!(
        ratios.iter().all(|ratio| *ratio < 0.99) && ratios.iter().any(|ratio| *ratio < 0.85),
        "{ratios:?}"
    );
}

#[test]
fn law_the_unit_of_a_figure_drops_out_and_its_weight_does_not() {
    let (dictionary, meat) = parabola();
    let shares = |figures: &[(f64, f64)]| {
        let one = |(k, (unit, weight)): (usize, &(f64, f64))| {
            let slopes = [[1.0, 0.2], [0.1, 2.0]][k].map(|slope| unit * slope).to_vec();
            WeightedFigure { value: 0.7 * unit, slopes, weight: *weight }
        };
        let figures: Vec<WeightedFigure> = figures.iter().enumerate().map(one).collect();
        solved(&dictionary, &Criterion::of_figures(&dictionary, &meat, &figures, &PARAMETERS).unwrap())
    };
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    let both = shares(&[(1.0, 1.0), (1.0, 1.0)]);
    assert!(apart(&both, &shares(&[(57.3, 1.0), (0.01, 1.0)])) < 1e-6);
    assert!(apart(&both, &shares(&[(1.0, 1.0), (1.0, 0.0)])) > 0.01);
    assert!(apart(&shares(&[(1.0, 1.0)]), &shares(&[(1.0, 1.0), (1.0, 0.0)])) < 1e-6);
}

/// Variances are those of the functions that single parameters are; blocks count as uncorrelated.
#[test]
fn law_functions_of_single_parameters_are_their_variances() {
    let mut own = Candidates::new(vec![2, 1]);
    own.push(&[1.0, 0.3, 0.3, 2.0, 0.5]).unwrap();
    own.push(&[2.0, -0.4, -0.4, 1.0, 1.5]).unwrap();
    let meat = own.clone();
    let weights = [2.0, 0.5, 3.0];
    let rows: Vec<Vec<f64>> = weights
        .iter()
        .enumerate()
        .map(|(i, w): (usize, &f64)| (0..3).map(|j| if i == j { w.sqrt() } else { 0.0 }).collect())
        .collect();
    let by_row = Covariance::new(&own, &meat, &weights, Norm::Trace).unwrap();
    let by_function = Covariance::of_functions(&own, &meat, &rows).unwrap();
    let shares = [0.3, 0.7];
    let value = |c: &Covariance| c.value(&shares, &mut CovariancePoint::default()).unwrap();
    assert!((value(&by_row) - value(&by_function)).abs() < 1e-12);
    let one = by_row.variances(&shares).unwrap();
    let functions = by_row.variances_of(&shares, &rows).unwrap();
    assert!((0..3).all(|i| (weights[i] * one[i] - functions[i]).abs() < 1e-12));
    let solve = |c: &Covariance| solve_covariance(c, &Bounds::default(), &Options::default()).unwrap().shares;
    assert!(solve(&by_row).iter().zip(solve(&by_function)).all(|(a, b)| (a - b).abs() < 1e-6));
    assert!(Covariance::of_functions(&own, &meat, &[vec![1.0; 2]]).is_err());
    assert!(Covariance::of_functions(&own, &meat, &[vec![1.0, f64::NAN, 0.0]]).is_err());
}

#[test]
fn law_the_time_for_a_figure_falls_as_the_square_of_its_error() {
    let (dictionary, meat) = parabola();
    let slopes = vec![1.0, 1.4];
    let figure = WeightedFigure { value: 0.7, slopes: slopes.clone(), weight: 1.0 };
    let criterion = Criterion::of_figures(&dictionary, &meat, &[figure], &PARAMETERS).unwrap();
    let Criterion::Covariance(own) = &criterion else { panic!() };
    let samples = |error: f64| {
        let wanted = Wanted { accuracy: 1.0, of: AccuracyOf::Figures, longest_s: 1e6 };
        let question = Question {
            dictionary: &dictionary,
            lengths: &[20.0; 4],
            criterion: &criterion,
            errors: Errors::of_figures(&dictionary, own, &[(slopes.clone(), error)]),
            wanted,
            stock: None,
        };
        let shortest = question.shortest(&Options::default()).unwrap();
        let [variance, ..] = variances(&shortest.design.shares, &slopes);
        assert!((shortest.samples - variance / (error * error)).abs() <= 1.0);
        shortest.samples
    };
    let (one, other) = (samples(0.02), samples(0.01));
    assert!((other / one - 4.0).abs() < 0.01, "{one} {other}");
}
