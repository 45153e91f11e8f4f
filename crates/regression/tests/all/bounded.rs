//! Normal equations with bounds.

use numerics::times;
use regression::{Equations, bounded};

/// A that is not symmetric, as with instruments.
const A: [f64; 9] = [1.0, 0.3, -0.2, 0.2, 1.0, 0.4, 0.1, -0.3, 1.0];
const THETA: [f64; 3] = [0.5, -1.0, 2.0];

fn solve(free: &[usize], mut b: Vec<f64>) -> Result<(Vec<f64>, Vec<f64>), usize> {
    let n = free.len();
    let a: Vec<f64> = free.iter().flat_map(|i| free.iter().map(move |j| A[3 * i + j])).collect();
    let mut inverse = vec![0.0; n * n];
    numerics::inverse(n, &mut a.clone(), &mut inverse).ok_or(0_usize)?;
    b = times(&inverse, &b);
    Ok((b, inverse))
}

#[test]
fn law_a_parameter_solves_its_equation_or_lies_at_a_bound_that_it_is_pulled_beyond() {
    let far = f64::INFINITY;
    let some = [
        vec![(0, [0.0, 0.2])],
        vec![(0, [0.7, far]), (2, [-far, 1.5])],
        vec![(1, [-0.5, 3.0]), (2, [3.0, 4.0])],
    ];
    // All about the solution: some parameters are fixed at first and freed later.
    let lowest =
        |code: usize, i: usize| THETA[i] + [-2.0, -0.8, -0.45, -0.1, 0.3][code / 5_usize.pow(i as u32) % 5];
    let boxes = (0..125).map(|code| (0..3).map(|i| (i, [lowest(code, i), lowest(code, i) + 0.5])).collect());
    for bounds in some.into_iter().chain(boxes) {
        let (b, bounds) = (times(&A, &THETA), bounds.into_iter().collect());
        let equations = Equations { a: &A, b: &b, bounds: &bounds };
        let (theta, gain) = bounded(&equations, THETA.to_vec(), solve).unwrap();
        let solved = times(&A, &theta);
        for i in 0..3 {
            let pull = b[i] - solved[i];
            let [low, high] = bounds.get(&i).copied().unwrap_or([-far, far]);
            assert!((low..=high).contains(&theta[i]), "{bounds:?} {theta:?}");
            let at = theta[i] == low && pull <= 0.0 || theta[i] == high && pull >= 0.0;
            assert!(at || pull.abs() < 1e-12, "{bounds:?} {theta:?} {i} {pull}");
            // There is no gain where the bounds hold from the start.
            let fixed = gain.get(3 * i..3 * i + 3).is_some_and(|row| row == [0.0; 3]);
            assert_eq!(at, fixed, "{bounds:?} {theta:?}");
        }
    }
}
