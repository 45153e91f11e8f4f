//! A step of a model that is made of forces. All of it is compiled here, for one number and for a lane, and not again in
//! every crate that steps models.

use std::array::from_fn;
use std::fmt::Debug;
use std::ops::Range;

use numerics::{Arithmetic, Lane, Wide, vectorized};

use crate::forces::{Body, Dual, Forces, Real};
use crate::model::ForceModel;

/// Unknowns by which derivatives are computed at once.
const AT_ONCE: usize = 4;

/// A number type that models are stepped with.
pub trait Stepping: Arithmetic {
    /// A ship that forces move, with parameters of this type.
    type Moving<'m>: Clone + Debug + Send + Sync;

    /// The ship with these parameters.
    fn moving<'m>(moved: &'m ForceModel, parameters: &[Self]) -> Self::Moving<'m>;

    /// By how much u, v and r change in a sample at `point`.
    fn increments(moving: &Self::Moving<'_>, point: Point<Self>) -> [Self; 3];

    /// Derivatives of the increments by `variables`, states first: a row each, into these rows of `out`.
    fn gradients(
        moving: &mut Self::Moving<'_>,
        point: Point<Self>,
        variables: Range<usize>,
        out: &mut [[Self; 3]],
    );
}

/// Where a step begins.
#[derive(Clone, Copy, Debug)]
pub struct Point<'a, X> {
    /// u, v \[m/s\] relative to the water, r \[rad/s\].
    pub relative: [X; 3],
    /// Inputs, measured disturbances and derived channels, held during the sample.
    pub exogenous: &'a [X],
    /// Surge and sway components of the current \[m/s\].
    pub current: [X; 2],
}

/// A ship with numbers, and with their derivatives from their first use on.
#[derive(Clone, Debug)]
pub struct Moving<'m, X> {
    forces: &'m Forces,
    sample_s: f64,
    parameters: Vec<X>,
    body: Body<'m, X>,
    with_slopes: Option<Body<'m, Dual<X, AT_ONCE>>>,
}

impl<'m, X: Real> Moving<'m, X> {
    fn new(moved: &'m ForceModel, parameters: &[X]) -> Self {
        let (forces, parameters) = (&moved.forces, parameters.to_vec());
        let body = forces.body(&parameters);
        Self { forces, sample_s: moved.sample_s, parameters, body, with_slopes: None }
    }

    #[inline(always)]
    fn gradients(&mut self, point: Point<X>, variables: Range<usize>, out: &mut [[X; 3]]) {
        let Self { forces, sample_s, parameters, with_slopes, .. } = self;
        let body = with_slopes.get_or_insert_with(|| {
            let constants: Vec<_> = parameters.iter().map(|parameter| Dual::constant(*parameter)).collect();
            forces.body(&constants)
        });
        for first in variables.clone().step_by(AT_ONCE) {
            let unknown = |value: X, i: usize| Dual::<X, AT_ONCE>::unknown(value, i.wrapping_sub(first));
            let relative = [0, 1, 2].map(|d: usize| unknown(point.relative[d], d));
            let row = point.exogenous.iter().enumerate().map(|(i, value)| unknown(*value, 3 + i));
            let (exogenous, current) = (row.collect::<Vec<_>>(), point.current.map(Dual::constant));
            let changes = increments(body, Point { relative, exogenous: &exogenous, current }, *sample_s);
            for (i, row) in out[first..variables.end].iter_mut().take(AT_ONCE).enumerate() {
                *row = changes.map(|dual| dual.tangents[i]);
            }
        }
    }
}

/// The step through the water, and what the current adds.
#[inline(always)]
fn increments<X: Real>(body: &Body<X>, point: Point<X>, sample_s: f64) -> [X; 3] {
    body.changes_in_current(point.relative, point.exogenous, point.current, sample_s)
}

impl Stepping for f64 {
    type Moving<'m> = Moving<'m, Self>;

    fn moving<'m>(moved: &'m ForceModel, parameters: &[Self]) -> Moving<'m, Self> {
        Moving::new(moved, parameters)
    }

    fn increments(moving: &Moving<Self>, point: Point<Self>) -> [Self; 3] {
        increments(&moving.body, point, moving.sample_s)
    }

    fn gradients(
        moving: &mut Moving<Self>,
        point: Point<Self>,
        variables: Range<usize>,
        out: &mut [[Self; 3]],
    ) {
        moving.gradients(point, variables, out);
    }
}

impl Stepping for Lane {
    type Moving<'m> = Moving<'m, Self>;

    fn moving<'m>(moved: &'m ForceModel, parameters: &[Self]) -> Moving<'m, Self> {
        Moving::new(moved, parameters)
    }

    fn increments(moving: &Moving<Self>, point: Point<Self>) -> [Self; 3] {
        vectorized!(increments(&moving.body, point, moving.sample_s))
    }

    fn gradients(
        moving: &mut Moving<Self>,
        point: Point<Self>,
        variables: Range<usize>,
        out: &mut [[Self; 3]],
    ) {
        moving.gradients(point, variables, out);
    }
}

/// Lane by lane.
impl<const G: usize> Stepping for Wide<G> {
    type Moving<'m> = Vec<Moving<'m, Lane>>;

    fn moving<'m>(moved: &'m ForceModel, parameters: &[Self]) -> Vec<Moving<'m, Lane>> {
        let of = |group: usize| parameters.iter().map(|wide| wide.0[group]).collect::<Vec<Lane>>();
        (0..G).map(|group| Lane::moving(moved, &of(group))).collect()
    }

    fn increments(moving: &Vec<Moving<Lane>>, point: Point<Self>) -> [Self; 3] {
        let mut out = [Self::ZERO; 3];
        for (group, lane) in moving.iter().enumerate() {
            let exogenous: Vec<Lane> = point.exogenous.iter().map(|wide| wide.0[group]).collect();
            let changes = Lane::increments(lane, in_group(&point, &exogenous, group));
            (0..3).for_each(|d| out[d].0[group] = changes[d]);
        }
        out
    }

    fn gradients(
        moving: &mut Vec<Moving<Lane>>,
        point: Point<Self>,
        variables: Range<usize>,
        out: &mut [[Self; 3]],
    ) {
        for (group, lane) in moving.iter_mut().enumerate() {
            let exogenous: Vec<Lane> = point.exogenous.iter().map(|wide| wide.0[group]).collect();
            let mut slopes = vec![[Lane::ZERO; 3]; out.len()];
            Lane::gradients(lane, in_group(&point, &exogenous, group), variables.clone(), &mut slopes);
            for variable in variables.clone() {
                (0..3).for_each(|d| out[variable][d].0[group] = slopes[variable][d]);
            }
        }
    }
}

/// A point of one group of lanes.
fn in_group<'a, const G: usize>(
    point: &Point<Wide<G>>,
    exogenous: &'a [Lane],
    group: usize,
) -> Point<'a, Lane> {
    Point {
        relative: from_fn(|d| point.relative[d].0[group]),
        exogenous,
        current: from_fn(|d| point.current[d].0[group]),
    }
}
