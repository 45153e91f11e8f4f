//! Newton's method for a few equations, plain and damped.

/// Most steps; damped ones may be short.
const STEPS: usize = 50;
const DAMPED_STEPS: usize = 200;

/// Relative change of the unknowns at which they count as solved.
const SOLVED: f64 = 1e-13;

/// The unknowns that solve the equations from `unknowns` on, by full steps. `linearised` gives rows \[Jacobian | −residual\].
/// Whether they do.
pub(crate) fn plain(unknowns: &mut [f64], mut linearised: impl FnMut(&[f64]) -> Vec<Vec<f64>>) -> bool {
    for _ in 0..STEPS {
        let Some(step) = solve(&linearised(unknowns)) else {
            return false;
        };
        let mut change: f64 = 0.0;
        for (x, dx) in unknowns.iter_mut().zip(&step) {
            change = change.max(dx.abs() / (x.abs() + 1e-9));
            *x += dx;
        }
        if !unknowns.iter().all(|x| x.is_finite()) {
            return false;
        }
        if change < SOLVED {
            return true;
        }
    }
    false
}

/// The same with steps that are halved until the next one, of the same Jacobian, is shorter: it then does not matter in which
/// units the equations are. `scales`: magnitudes of the unknowns.
///
/// The test is the natural one of Deuflhard, Newton Methods for Nonlinear Problems, 2011, section 3.3.
pub(crate) fn damped(
    unknowns: &mut [f64],
    scales: &[f64],
    mut linearised: impl FnMut(&[f64]) -> Vec<Vec<f64>>,
) -> bool {
    let mut rows = linearised(unknowns);
    // Nothing is to be done at rest, where no step is determined either.
    if rows.iter().all(|row| row.last() == Some(&0.0)) {
        return true;
    }
    let mut before = f64::INFINITY;
    for _ in 0..DAMPED_STEPS {
        let Some(step) = solve(&rows) else { return false };
        let length = length(&step, unknowns, scales);
        // What is left is rounding: the equations cannot be solved better.
        let rounding = length < 1e-8 && length >= 0.5 * before;
        if length < SOLVED || rounding {
            unknowns.iter_mut().zip(&step).for_each(|(x, dx)| *x += dx);
            return true;
        }
        let Some((next, after)) = shortened(unknowns, scales, (&step, length), &rows, &mut linearised) else {
            return false;
        };
        unknowns.copy_from_slice(&next);
        (rows, before) = (after, length);
    }
    false
}

/// As far along `step`, of such a length, as the next step of the same Jacobian gets shorter: the unknowns there, with their
/// rows.
fn shortened(
    unknowns: &[f64],
    scales: &[f64],
    (step, whole): (&[f64], f64),
    rows: &[Vec<f64>],
    linearised: &mut impl FnMut(&[f64]) -> Vec<Vec<f64>>,
) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
    let mut share = 1.0;
    while share > 1e-6 {
        let next: Vec<f64> = unknowns.iter().zip(step).map(|(x, dx)| x + share * dx).collect();
        let after = linearised(&next);
        let mixed: Vec<Vec<f64>> = rows
            .iter()
            .zip(&after)
            .map(|(row, after)| row[..row.len() - 1].iter().chain(after.last()).copied().collect())
            .collect();
        let shorter =
            solve(&mixed).is_some_and(|left| length(&left, unknowns, scales) <= (1.0 - share / 4.0) * whole);
        if shorter || whole < 1e-8 {
            return Some((next, after));
        }
        share *= 0.5;
    }
    None
}

/// The largest relative change that `step` makes.
fn length(step: &[f64], unknowns: &[f64], scales: &[f64]) -> f64 {
    let all = step.iter().zip(unknowns).zip(scales);
    all.fold(0.0, |most: f64, ((dx, x), scale)| most.max(dx.abs() / (x.abs() + 1e-3 * scale)))
}

/// Solves rows \[a | b\], each scaled to a largest coefficient of 1; `None` where they are singular.
fn solve(rows: &[Vec<f64>]) -> Option<Vec<f64>> {
    let n = rows.len();
    let mut a = Vec::with_capacity(n * n);
    let mut b = Vec::with_capacity(n);
    for row in rows {
        let scale = row[..n].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        a.extend(row[..n].iter().map(|x| x / scale));
        b.push(row[n] / scale);
    }
    numerics::solve(n, &mut a, &mut b).map(|_| b).filter(|b| b.iter().all(|x| x.is_finite()))
}
