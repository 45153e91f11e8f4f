//! The search for least squares against known minima.

use std::convert::Infallible;

use numerics::Watch;
use numerics::least_squares::{Ended, Ending, Expansion, Linearization, Minimum, Residuals, huber, minimize};

const ENDING: Ending = Ending { steps: 100, enough: 1e-7, damping: 1e-3 };

/// Errors and their derivatives, row by row; and the knee of each error's Huber function.
struct Errors<F> {
    of: F,
    knee: f64,
    has_costs: bool,
    bounds: Vec<[f64; 2]>,
}

impl<F: Fn(usize, &[f64]) -> Vec<(f64, Vec<f64>)>> Errors<F> {
    fn new(of: F) -> Self {
        Self { of, knee: f64::INFINITY, has_costs: false, bounds: Vec::new() }
    }

    fn expansion(&self, asked: &Linearization) -> Expansion {
        let n = asked.point.len();
        let mut sums = Expansion { cost: 0.0, unit: 1.0, normal: vec![0.0; n * n], gradient: vec![0.0; n] };
        for (error, slopes) in (self.of)(asked.problem, &asked.point) {
            let [cost, weight] = huber(error.abs(), self.knee);
            sums.cost += cost;
            for i in 0..n {
                sums.gradient[i] -= weight * error * slopes[i];
                (0..n).for_each(|j| sums.normal[i * n + j] += weight * slopes[i] * slopes[j]);
            }
        }
        sums
    }

    fn minima(mut self, starts: &[Vec<f64>]) -> Vec<Minimum<()>> {
        let Ok(minima) = minimize(&mut self, starts.to_vec(), ENDING, &Watch::default());
        minima
    }
}

impl<F: Fn(usize, &[f64]) -> Vec<(f64, Vec<f64>)>> Residuals for Errors<F> {
    fn linearize(&mut self, asked: &[Linearization]) -> Result<Vec<(Expansion, ())>, Infallible> {
        Ok(asked.iter().map(|asked| (self.expansion(asked), ())).collect())
    }

    fn has_costs(&self) -> bool {
        self.has_costs
    }

    fn cost(&mut self, trial: &Linearization) -> f64 {
        self.expansion(trial).cost
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        self.bounds.clone()
    }
}

/// Rosenbrock's valley with its minimum at (a, a²), a = 1 + the problem, and an error that stays.
fn rosenbrock(problem: usize, x: &[f64]) -> Vec<(f64, Vec<f64>)> {
    let a = 1.0 + problem as f64;
    vec![
        (10.0 * (x[1] - x[0] * x[0]), vec![-20.0 * x[0], 10.0]),
        (a - x[0], vec![-1.0, 0.0]),
        (0.5, vec![0.0; 2]),
    ]
}

#[test]
fn law_known_minima_are_reached_side_by_side_with_costs_or_without() {
    for has_costs in [false, true] {
        let problem = Errors { has_costs, ..Errors::new(rosenbrock) };
        let minima = problem.minima(&[vec![-1.2, 1.0], vec![0.0, 0.0], vec![9.0, -5.0]]);
        for (minimum, a) in minima.iter().zip([1.0, 2.0, 3.0]) {
            assert_eq!(minimum.status, Ended::Converged, "{minimum:?}");
            let [x, y] = [minimum.point[0], minimum.point[1]];
            assert!((x - a).abs() < 1e-6 && (y - a * a).abs() < 1e-5, "{has_costs} {x} {y}");
        }
    }
}

#[test]
fn law_an_unknown_is_held_at_the_bound_beyond_which_the_cost_falls() {
    for has_costs in [false, true] {
        let bounds = vec![[-2.0, 0.5], [-2.0, 2.0]];
        let minimum =
            Errors { has_costs, bounds, ..Errors::new(rosenbrock) }.minima(&[vec![-1.2, 1.0]]).remove(0);
        // At x = 1/2 the best y is 1/4.
        assert_eq!((minimum.status, &minimum.held[..]), (Ended::Converged, &[0][..]));
        assert!(minimum.point[0] == 0.5 && (minimum.point[1] - 0.25).abs() < 1e-7, "{:?}", minimum.point);
        assert_eq!(minimum.inverse(vec![4.0, 1.0, 1.0, 2.0]), Ok(vec![0.0, 0.0, 0.0, 0.5]));
    }
}

#[test]
fn oracle_hubers_location_is_where_clipped_errors_cancel() {
    let data = [0.1, 0.3, -0.2, 0.05, 7.0, -0.4, 0.2, 30.0];
    let knee = 0.25;
    let pull = |x: f64| data.iter().map(|d| (x - d).clamp(-knee, knee)).sum::<f64>();
    let (mut low, mut high) = (-1.0, 31.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if pull(middle) < 0.0 { low = middle } else { high = middle }
    }
    for has_costs in [false, true] {
        let location = |_: usize, x: &[f64]| data.iter().map(|d| (x[0] - d, vec![1.0])).collect();
        let found = Errors { knee, has_costs, ..Errors::new(location) }.minima(&[vec![5.0]]).remove(0);
        assert!((found.point[0] - low).abs() < 1e-6, "{found:?} {low}");
    }
}

#[test]
fn law_an_unknown_without_effect_is_named_and_a_prior_makes_it_regular() {
    let sum = |_: usize, x: &[f64]| {
        vec![(x[0] + 2.0 * x[1] - 3.0, vec![1.0, 2.0, 0.0]), (x[0], vec![1.0, 0.0, 0.0])]
    };
    let named = Errors::new(sum).minima(&[vec![1.0; 3]]).remove(0);
    assert_eq!(named.status, Ended::Singular(2));
    let mut expansion = Errors::new(sum).expansion(&Linearization { problem: 0, point: vec![0.0; 3] });
    (0..3).for_each(|i| expansion.add_prior(i, -1.0, 0.5));
    assert_eq!((expansion.cost, expansion.gradient), (9.0 + 1.5, vec![3.5, 6.5, 0.5]));
    assert_eq!(expansion.normal, [2.5, 2.0, 0.0, 2.0, 4.5, 0.0, 0.0, 0.0, 0.5]);
    let nowhere = |_: usize, _: &[f64]| vec![(f64::NAN, vec![1.0])];
    assert_eq!(Errors::new(nowhere).minima(&[vec![0.0]])[0].status, Ended::Diverged);
}
