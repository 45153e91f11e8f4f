use std::collections::BTreeMap;

use numerics::lanes::lane_of;
use numerics::{LANES, Lane, Number, times};

use crate::DegreeSums;

/// The excitation of one degree of freedom of one run: the normal matrix Σ ζᶜφᵀ, each row and column divided by the
/// root sum of squares of its centred instrument and regressor, so that its entries are correlations.
#[derive(Clone, Debug, PartialEq)]
pub struct Excitation {
    /// Largest over smallest singular value; infinite if a direction is not excited.
    pub condition: f64,
    /// Index, within the degree of freedom, of the parameter that dominates the weakest direction.
    pub weakest: usize,
}

/// A direction of the parameter space that a run does not excite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Direction {
    /// 0 surge, 1 sway, 2 yaw.
    pub degree: usize,
    /// Index, within the degree of freedom, of the parameter that dominates the direction.
    pub parameter: usize,
}

/// Condition number of the scaled normal matrix from which a direction counts as not excited.
const SINGULAR: f64 = 1e10;
/// A centred sum of squares below this share of the raw one is rounding: the signal is constant.
const CONSTANT: f64 = 1e-12;

/// Pivot of the scaled normal matrix below which rows are exchanged: it is at most 1 if instruments and regressors are the same.
const SMALL: f64 = 1e-3;

/// Solutions of one degree of freedom of [`LANES`] runs.
pub(crate) struct SolvedLanes {
    pub theta: Vec<Lane>,
    /// A⁻¹, p × p; rows and columns of parameters at a bound zero.
    pub inverse: Vec<Lane>,
    /// In lanes without a solution a parameter that is not excited.
    pub unexcited: [Option<usize>; LANES],
}

/// The normal equations of one degree of freedom, centred per group of samples, of one run or of several in lanes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Normal<X = f64> {
    /// Σ ζᶜφᵀ, p × p.
    pub a: Vec<X>,
    /// Σ ζᶜΔy, p.
    pub b: Vec<X>,
    /// Root sums of squares of the centred instruments, 0 for constant ones.
    pub zeta: Vec<X>,
    /// The same of the regressors.
    pub phi: Vec<X>,
    /// The bounds of the solution, by index.
    pub bounds: BTreeMap<usize, [f64; 2]>,
}

/// Normal equations while they are accumulated, group by group.
#[derive(Clone, Debug, Default)]
pub(crate) struct NormalSums<X = f64> {
    /// With sums of squares instead of their roots.
    normal: Normal<X>,
    /// Sums of squares of instruments and regressors that are not centred.
    plain_zeta: Vec<X>,
    plain_phi: Vec<X>,
}

impl<X: Number> NormalSums<X> {
    /// Adds a group that shares an intercept, if it is `centred`.
    pub(crate) fn add(&mut self, sums: &DegreeSums<X>, centred: bool) {
        let p = sums.parameters();
        if self.normal.b.len() != p {
            let normal = Normal { bounds: sums.known.bounds.clone(), ..Normal::zero(p) };
            *self = Self { normal, plain_zeta: vec![X::ZERO; p], plain_phi: vec![X::ZERO; p] };
        }
        self.normal.add(sums, centred);
        for i in 0..p {
            self.plain_zeta[i] += sums.instrument_squares[i];
            self.plain_phi[i] += sums.regressor_squares[i];
        }
    }

    /// The equations of all groups.
    pub(crate) fn finish(self) -> Normal<X> {
        let Self { mut normal, plain_zeta, plain_phi } = self;
        let size = |centred: f64, plain: f64| if centred > CONSTANT * plain { centred.sqrt() } else { 0.0 };
        for i in 0..plain_zeta.len() {
            normal.zeta[i] = normal.zeta[i].each(plain_zeta[i], size);
            normal.phi[i] = normal.phi[i].each(plain_phi[i], size);
        }
        normal
    }
}

impl<X: Number> Normal<X> {
    /// From the sums of the groups that share an intercept; `centred` says whether there is an intercept.
    pub(crate) fn new<'a>(groups: impl Iterator<Item = &'a DegreeSums<X>>, centred: bool) -> Self
    where
        X: 'a,
    {
        let none = Normal {
            a: Vec::new(),
            b: Vec::new(),
            zeta: Vec::new(),
            phi: Vec::new(),
            bounds: BTreeMap::new(),
        };
        let mut sums = NormalSums { normal: none, plain_zeta: Vec::new(), plain_phi: Vec::new() };
        groups.for_each(|group| sums.add(group, centred));
        sums.finish()
    }

    fn zero(p: usize) -> Self {
        let zeros = |count: usize| vec![X::ZERO; count];
        Self { a: zeros(p * p), b: zeros(p), zeta: zeros(p), phi: zeros(p), bounds: BTreeMap::new() }
    }

    fn add(&mut self, sums: &DegreeSums<X>, centred: bool) {
        let p = self.b.len();
        let lifted = p + 1;
        let (sum_zeta, sum_phi) = (|i: usize| sums.a[i * lifted + p], |j: usize| sums.a[p * lifted + j]);
        let share = sums.share(centred);
        for i in 0..p {
            for j in 0..p {
                self.a[i * p + j] += sums.a[i * lifted + j] - share * sum_zeta(i) * sum_phi(j);
            }
            self.b[i] += sums.b[i] - share * sum_zeta(i) * sums.b[p];
            self.zeta[i] += sums.instrument_squares[i] - share * sum_zeta(i) * sum_zeta(i);
            self.phi[i] += sums.regressor_squares[i] - share * sum_phi(i) * sum_phi(i);
        }
    }
}

impl Normal<Lane> {
    /// The equations of one lane.
    pub(crate) fn lane(&self, lane: usize) -> Normal {
        let Self { a, b, zeta, phi, bounds } = self;
        let [a, b, zeta, phi] = [a, b, zeta, phi].map(|lanes| lane_of(lanes, lane));
        Normal { a, b, zeta, phi, bounds: bounds.clone() }
    }

    /// θ and A⁻¹ of every lane, or the index of a parameter that is not excited. Lanes that would delay their
    /// neighbours are solved by themselves: nearly singular equations, estimates at a bound.
    pub(crate) fn solve_lanes(&self) -> SolvedLanes {
        let (mut solved, regular) = numerics::vectorized!(self.in_order());
        for lane in 0..LANES {
            let open =
                |(i, [low, high]): (&usize, &[f64; 2])| (*low..=*high).contains(&solved.theta[*i][lane]);
            if regular[lane] > 0.0 && self.bounds.iter().all(open) {
                continue;
            }
            match self.lane(lane).solve() {
                Ok((theta, inverse)) => {
                    solved.theta.iter_mut().zip(theta).for_each(|(lanes, entry)| lanes[lane] = entry);
                    solved.inverse.iter_mut().zip(inverse).for_each(|(lanes, entry)| lanes[lane] = entry);
                }
                Err(parameter) => solved.unexcited[lane] = Some(parameter),
            }
        }
        solved
    }

    /// Solves all lanes without bounds and without row exchanges, and returns a positive number for lanes that are
    /// far from singular.
    #[inline(always)]
    fn in_order(&self) -> (SolvedLanes, Lane) {
        let p = self.b.len();
        let mut scaled: Vec<Lane> =
            (0..p * p).map(|k| self.a[k] / (self.zeta[k / p] * self.phi[k % p])).collect();
        let mut inverse = scaled.clone();
        let before = moduli(&scaled);
        numerics::inverse_in_order(p, &mut scaled, &mut inverse);
        // The spectral norm of a matrix is at most the sum of its moduli.
        let condition = before * moduli(&inverse);
        let far = |condition: f64, _| if condition <= SINGULAR { 1.0 } else { 0.0 };
        let regular = (0..p).fold(condition.each(condition, far), |regular, i| {
            regular
                .each(scaled[i * (p + 1)], |regular, pivot| if pivot.abs() >= SMALL { regular } else { 0.0 })
        });
        let mut theta = vec![Lane::ZERO; p];
        for (k, entry) in inverse.iter_mut().enumerate() {
            *entry = *entry / (self.phi[k / p] * self.zeta[k % p]);
            theta[k / p] += *entry * self.b[k % p];
        }
        let finite = |regular: f64, theta: f64| if theta.is_finite() { regular } else { 0.0 };
        let regular = theta.iter().fold(regular, |regular, theta| regular.each(*theta, finite));
        (SolvedLanes { theta, inverse, unexcited: [None; LANES] }, regular)
    }
}

/// Σ |entry|.
#[inline(always)]
fn moduli(entries: &[Lane]) -> Lane {
    let mut sum = Lane::ZERO;
    for entry in entries {
        sum += entry.abs();
    }
    sum
}

impl Normal {
    /// θ within its bounds and A⁻¹ (p × p; rows and columns of parameters at a bound zero), or the index of a parameter that is
    /// not excited.
    pub(crate) fn solve(&self) -> Result<(Vec<f64>, Vec<f64>), usize> {
        let open = self.unbounded()?;
        let within = |(i, [low, high]): (&usize, &[f64; 2])| (*low..=*high).contains(&open.0[*i]);
        if self.bounds.iter().all(within) {
            return Ok(open);
        }
        let equations = Equations { a: &self.a, b: &self.b, bounds: &self.bounds };
        bounded(&equations, open.0, |free, b| self.part(free, b).unbounded())
    }

    /// The equations of some parameters with other right-hand sides.
    fn part(&self, parameters: &[usize], b: Vec<f64>) -> Self {
        let p = self.b.len();
        let of = |all: &[f64]| parameters.iter().map(|i| all[*i]).collect();
        let row = |i: &usize| parameters.iter().map(|j| self.a[i * p + j]).collect::<Vec<_>>();
        let a = parameters.iter().flat_map(row).collect();
        Self { a, b, zeta: of(&self.zeta), phi: of(&self.phi), bounds: BTreeMap::new() }
    }

    /// The same without bounds.
    fn unbounded(&self) -> Result<(Vec<f64>, Vec<f64>), usize> {
        let p = self.b.len();
        let mut scaled = self.scaled()?;
        let mut inverse = vec![0.0; p * p];
        let norm = numerics::one_norm(p, &scaled);
        let regular = numerics::inverse(p, &mut scaled, &mut inverse).is_some();
        if !regular || numerics::one_norm(p, &inverse) * norm > SINGULAR {
            return Err(self.excitation().weakest);
        }
        inverse.iter_mut().enumerate().for_each(|(k, entry)| *entry /= self.phi[k / p] * self.zeta[k % p]);
        let theta = times(&inverse, &self.b);
        if theta.iter().all(|t| t.is_finite()) { Ok((theta, inverse)) } else { Err(0) }
    }

    /// Condition number and weakest direction, by singular values.
    pub(crate) fn excitation(&self) -> Excitation {
        let p = self.b.len();
        let scaled = match self.scaled() {
            Ok(scaled) => scaled,
            Err(weakest) => return Excitation { condition: f64::INFINITY, weakest },
        };
        match numerics::weakest(p, &scaled) {
            Some(weakest) => Excitation {
                condition: if weakest.ratio * SINGULAR < 1.0 { f64::INFINITY } else { 1.0 / weakest.ratio },
                weakest: weakest.dominant(p),
            },
            None => Excitation { condition: f64::INFINITY, weakest: 0 },
        }
    }

    /// The matrix of correlations; zeros if an instrument or regressor never varies.
    pub(crate) fn regular_scaled(&self) -> Vec<f64> {
        let p = self.b.len();
        let entry = |k: usize| {
            let size = self.zeta[k / p] * self.phi[k % p];
            if size > 0.0 { self.a[k] / size } else { 0.0 }
        };
        (0..p * p).map(entry).collect()
    }

    /// The matrix of correlations, or the index of a parameter whose instrument or regressor never varies.
    fn scaled(&self) -> Result<Vec<f64>, usize> {
        let p = self.b.len();
        match (0..p).find(|i| !(self.zeta[*i] > 0.0 && self.phi[*i] > 0.0)) {
            Some(constant) => Err(constant),
            None => Ok((0..p * p).map(|k| self.a[k] / (self.zeta[k / p] * self.phi[k % p])).collect()),
        }
    }
}

// Normal equations whose solution stays within bounds.
//
// The solution is that of the box-constrained linear complementarity problem: every parameter either solves its own
// equation, or lies at a bound that the solution of its equation is beyond. With the regressors as instruments this
// is the least-squares estimate within the bounds. With other instruments nothing is minimised: parameters at a
// bound are fixed, and their equations left out.

/// Maximum number of pivots; a problem with a unique solution takes far fewer.
const FLIPS: usize = 1000;
/// Share of an equation's terms below which its residual is rounding.
const ROUNDING: f64 = 1e-12;

/// Whether a parameter is free or fixed at a bound.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Hold {
    Free,
    Held(f64),
}

/// Normal equations A θ = b and bounds of θ.
pub struct Equations<'a> {
    /// A: p × p, row-major.
    pub a: &'a [f64],
    /// b: p entries.
    pub b: &'a [f64],
    /// Lower and upper bound by the index of the parameter, infinite at open ends; the other parameters are not bounded.
    pub bounds: &'a BTreeMap<usize, [f64; 2]>,
}

/// Estimates θ and the gain within the bounds, starting from the unbounded solution `theta`. Parameters are fixed and
/// freed one by one, the first violation first: Murty's method, which terminates if the solution is unique.
///
/// `theta` has p entries. The gain is p × p, row-major: empty if `theta` is the solution, else 0 in the rows and columns of fixed
/// parameters. `solve` is called with the indices of n parameters and their n right-hand sides. It returns their values and the n
/// × n inverse of their block of A, or the position among them of one that is not excited.
///
/// # Errors
/// The index of a parameter that is not excited, or of a bounded one if no solution is found.
pub fn bounded(
    equations: &Equations,
    mut theta: Vec<f64>,
    solve: impl Fn(&[usize], Vec<f64>) -> Result<(Vec<f64>, Vec<f64>), usize>,
) -> Result<(Vec<f64>, Vec<f64>), usize> {
    let p = theta.len();
    let mut places = vec![Hold::Free; p];
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
fn wanted(equations: &Equations, theta: &[f64], place: Hold, i: usize, [low, high]: [f64; 2]) -> Hold {
    match place {
        Hold::Free if theta[i] < low => Hold::Held(low),
        Hold::Free if theta[i] > high => Hold::Held(high),
        Hold::Free => Hold::Free,
        Hold::Held(at) => {
            let (pull, rounding) = pull(equations, theta, i);
            let back = if at == low { pull > rounding } else { pull < -rounding };
            if back { Hold::Free } else { place }
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
    places: &[Hold],
    solve: impl Fn(&[usize], Vec<f64>) -> Result<(Vec<f64>, Vec<f64>), usize>,
) -> Result<(Vec<f64>, Vec<f64>), usize> {
    let p = places.len();
    let free: Vec<usize> = (0..p).filter(|i| places[*i] == Hold::Free).collect();
    let held = |i: usize| if let Hold::Held(at) = places[i] { at } else { 0.0 };
    let mut theta: Vec<f64> = (0..p).map(held).collect();
    let mut gain = vec![0.0; p * p];
    if free.is_empty() {
        return Ok((theta, gain));
    }
    let known = times(equations.a, &theta);
    let rest = free.iter().map(|i| equations.b[*i] - known[*i]).collect();
    let (values, inverse) = solve(&free, rest).map_err(|i| free[i])?;
    for (k, (i, value)) in free.iter().zip(values).enumerate() {
        theta[*i] = value;
        free.iter().enumerate().for_each(|(l, j)| gain[i * p + j] = inverse[k * free.len() + l]);
    }
    Ok((theta, gain))
}

/// The number of nonzero rows of a p × p gain, given by its entries: parameters that are estimated and not fixed.
pub(crate) fn estimated(p: usize, gain: impl Fn(usize) -> f64) -> usize {
    (0..p).filter(|row| (row * p..(row + 1) * p).any(|k| gain(k) != 0.0)).count()
}
