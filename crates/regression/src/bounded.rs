//! Normal equations whose solution stays within bounds.
//!
//! The solution is that of the box-constrained linear complementarity problem: every parameter either solves its own
//! equation, or lies at a bound that the solution of its equation is beyond. With the regressors as instruments this
//! is the least-squares estimate within the bounds. With other instruments nothing is minimised: parameters at a
//! bound are fixed, and their equations left out.

use std::collections::BTreeMap;

use numerics::times;

/// Maximum number of pivots; a problem with a unique solution takes far fewer.
const FLIPS: usize = 1000;
/// Share of an equation's terms below which its residual is rounding.
const ROUNDING: f64 = 1e-12;

/// Whether a parameter is free or fixed at a bound.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Free,
    Held(f64),
}

/// Normal equations A θ = b and bounds of θ.
pub struct Equations<'a> {
    /// A: p × p, row-major.
    pub a: &'a [f64],
    /// b: p entries.
    pub b: &'a [f64],
    /// Lower and upper bound by the index of the parameter, infinite at open ends; the other parameters are not
    /// bounded.
    pub bounds: &'a BTreeMap<usize, [f64; 2]>,
}

/// Estimates θ and the gain within the bounds, starting from the unbounded solution `theta`. Parameters are fixed and
/// freed one by one, the first violation first: Murty's method, which terminates if the solution is unique.
///
/// `theta` has p entries. The gain is p × p, row-major: empty if `theta` is the solution, else 0 in the rows and
/// columns of fixed parameters. `solve` is called with the indices of n parameters and their n right-hand sides. It
/// returns their values and the n × n inverse of their block of A, or the position among them of one that is not
/// excited.
///
/// # Errors
/// The index of a parameter that is not excited, or of a bounded one if no solution is found.
pub fn bounded(
    equations: &Equations,
    mut theta: Vec<f64>,
    solve: impl Fn(&[usize], Vec<f64>) -> Result<(Vec<f64>, Vec<f64>), usize>,
) -> Result<(Vec<f64>, Vec<f64>), usize> {
    let p = theta.len();
    let mut places = vec![Place::Free; p];
    let mut gain = Vec::new();
    for _ in 0..FLIPS {
        let flip = equations.bounds.iter().find_map(|(i, bounds)| {
            let next = wanted(equations, &theta, places[*i], *i, *bounds);
            (next != places[*i]).then_some((*i, next))
        });
        let Some((i, next)) = flip else { return Ok((theta, gain)) };
        places[i] = next;
        (theta, gain) = solved(equations, &places, &solve)?;
    }
    equations.bounds.keys().next().map_or(Err(0), |i| Err(*i))
}

/// The state that parameter `i` should have: a free one beyond a bound is fixed there, a fixed one is freed if its
/// equation points inside.
fn wanted(equations: &Equations, theta: &[f64], place: Place, i: usize, [low, high]: [f64; 2]) -> Place {
    match place {
        Place::Free if theta[i] < low => Place::Held(low),
        Place::Free if theta[i] > high => Place::Held(high),
        Place::Free => Place::Free,
        Place::Held(at) => {
            let (pull, rounding) = pull(equations, theta, i);
            let back = if at == low { pull > rounding } else { pull < -rounding };
            if back { Place::Free } else { place }
        }
    }
}

/// The residual b − Aθ of equation `i`, and the part of it that is rounding.
fn pull(equations: &Equations, theta: &[f64], i: usize) -> (f64, f64) {
    let p = theta.len();
    let terms = equations.a[i * p..(i + 1) * p].iter().zip(theta).map(|(a, t)| a * t);
    let sizes: f64 = terms.clone().map(f64::abs).sum::<f64>() + equations.b[i].abs();
    (equations.b[i] - terms.sum::<f64>(), ROUNDING * sizes)
}

/// θ and the gain with some parameters fixed.
fn solved(
    equations: &Equations,
    places: &[Place],
    solve: impl Fn(&[usize], Vec<f64>) -> Result<(Vec<f64>, Vec<f64>), usize>,
) -> Result<(Vec<f64>, Vec<f64>), usize> {
    let p = places.len();
    let free: Vec<usize> = (0..p).filter(|i| places[*i] == Place::Free).collect();
    let held = |i: usize| if let Place::Held(at) = places[i] { at } else { 0.0 };
    let mut theta: Vec<f64> = (0..p).map(held).collect();
    let mut gain = vec![0.0; p * p];
    if free.is_empty() {
        return Ok((theta, gain));
    }
    let known = times(equations.a, &theta);
    let rest = free.iter().map(|i| equations.b[*i] - known[*i]).collect();
    let (found, inverse) = solve(&free, rest).map_err(|i| free[i])?;
    for (k, (i, value)) in free.iter().zip(found).enumerate() {
        theta[*i] = value;
        free.iter().enumerate().for_each(|(l, j)| gain[i * p + j] = inverse[k * free.len() + l]);
    }
    Ok((theta, gain))
}

/// The number of nonzero rows of a p × p gain, given by its entries: parameters that are estimated and not fixed.
pub(crate) fn estimated(p: usize, gain: impl Fn(usize) -> f64) -> usize {
    (0..p).filter(|row| (row * p..(row + 1) * p).any(|k| gain(k) != 0.0)).count()
}
