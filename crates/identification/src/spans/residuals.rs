//! Residuals, and their products with each other.

use vessel::{Lane, Number};

use super::kept::{Kept, Zeta};
use super::regressors::{Picked, Regressors, SPAN, Span, measured};
use crate::Batch;
use crate::batch::{BLOCK, parts};
use crate::groups::{Constants, Groups};
use crate::lags::Lags;

/// Adds what the residuals of `theta` come to, one lane per parameter. `intercepts`: three per run and group.
#[inline(always)]
pub(crate) fn add_residuals<X: Number>(
    batch: &Batch<X>,
    kept: Option<&Kept<X>>,
    theta: &[Lane],
    intercepts: Groups,
    lags: &mut Lags,
) {
    let mut edges = [Lane::ZERO; 3];
    let mut intercepts = Constants::<SPAN>::new(intercepts, 3);
    let measured = measured(batch.model);
    let mut phi = Regressors::of(batch.model, measured.map(|measured| 0..measured));
    let mut inputs =
        Zeta::new(kept, batch, &(0..batch.samples()), measured.map(|measured| measured..usize::MAX));
    let mut left = [Lane::ZERO; SPAN];
    for (k, count) in parts::<SPAN>(0..batch.samples()) {
        batch.phi(k, count, &mut phi);
        let inputs = inputs.at(batch, k, count);
        let intercepts = intercepts.at(k);
        let mut first = 0;
        for d in 0..3 {
            let own = first..first + batch.model.degrees[d].terms.len();
            first = own.end;
            let middle = own.start + measured[d];
            let terms = Terms {
                measured: phi.terms().part(own.start..middle),
                inputs: inputs.part(middle..own.end),
                theta: &theta[own],
            };
            let (intercepts, residuals) = (&intercepts[d], Residuals { d, lags, edge: &mut edges[d] });
            match batch.between(k, count, d).filter(|_| terms.at_once()) {
                Some(rows) => residuals.subtract(
                    #[inline(always)]
                    |t| rows[t + 1][d] - rows[t][d] - intercepts[t],
                    terms,
                ),
                None => {
                    batch.increments(k, count, d, &phi, &mut left);
                    for (left, intercept) in left[..count].iter_mut().zip(intercepts) {
                        *left = *left - *intercept;
                    }
                    let terms = if terms.at_once() { terms } else { terms.subtract_all(&mut left) };
                    residuals.subtract(
                        #[inline(always)]
                        |t| left[t],
                        terms,
                    );
                }
            }
        }
    }
}

/// Where the residuals of a degree of freedom go.
struct Residuals<'a> {
    d: usize,
    lags: &'a mut Lags,
    /// The one before.
    edge: &'a mut Lane,
}

impl Residuals<'_> {
    /// Adds the residuals of a span: `y` less terms that are few enough.
    #[inline(always)]
    fn subtract<X: Number>(self, y: impl Fn(usize) -> Lane, terms: Terms<X>) {
        match (terms.measured.count(), terms.inputs.count()) {
            (1, 0) => self.add::<X, 1, 0>(y, terms),
            (1, _) => self.add::<X, 1, 1>(y, terms),
            (2, 0) => self.add::<X, 2, 0>(y, terms),
            (2, _) => self.add::<X, 2, 1>(y, terms),
            (3, 0) => self.add::<X, 3, 0>(y, terms),
            (3, _) => self.add::<X, 3, 1>(y, terms),
            (AT_ONCE, 0) => self.add::<X, AT_ONCE, 0>(y, terms),
            (AT_ONCE, _) => self.add::<X, AT_ONCE, 1>(y, terms),
            (_, 0) => self.add::<X, 0, 0>(y, terms),
            (_, _) => self.add::<X, 0, 1>(y, terms),
        }
    }

    /// [`Self::subtract`] of `C` terms and `I` of inputs alone.
    #[inline(always)]
    fn add<X: Number, const C: usize, const I: usize>(self, y: impl Fn(usize) -> Lane, terms: Terms<X>) {
        let (measured, inputs): ([_; C], [_; I]) = (terms.measured.some(0), terms.inputs.some(0));
        let (first, last) = (less::<C>(terms.theta), less::<I>(&terms.theta[C..]));
        for block in (0..SPAN).step_by(BLOCK) {
            self.lags.add(
                self.d,
                #[inline(always)]
                |t| {
                    let t = block + t;
                    remaining(remaining(y(t), &measured, &first, t), &inputs, &last, t)
                },
                self.edge,
            );
        }
    }
}

/// The terms of a degree of freedom in a span: those with measured states in them, then those of inputs alone.
#[derive(Clone, Copy)]
struct Terms<'a, X> {
    measured: Picked<'a, Lane>,
    inputs: Picked<'a, X>,
    /// Parameters of all.
    theta: &'a [Lane],
}

/// Terms with measured states that are subtracted at once: their parameters have a register each.
const AT_ONCE: usize = 4;

impl<X: Number> Terms<'_, X> {
    /// Whether all can be subtracted at once.
    #[inline(always)]
    fn at_once(&self) -> bool {
        self.measured.count() <= AT_ONCE && self.inputs.count() <= 1
    }

    /// Subtracts all with their parameters; what is left of them.
    #[inline(always)]
    fn subtract_all(self, left: &mut Span<Lane>) -> Self {
        let (of_measured, of_inputs) = self.theta.split_at(self.measured.count());
        subtract_each(left, self.measured, of_measured);
        subtract_each(left, self.inputs, of_inputs);
        Self { measured: self.measured.part(0..0), inputs: self.inputs.part(0..0), theta: &[] }
    }
}

/// Subtracts terms with their parameters, some at a time.
#[inline(always)]
fn subtract_each<X: Number>(left: &mut Span<Lane>, terms: Picked<X>, theta: &[Lane]) {
    let whole = theta.len() - theta.len() % AT_ONCE;
    for i in (0..whole).step_by(AT_ONCE) {
        subtract_some::<X, AT_ONCE>(left, terms.some(i), &theta[i..]);
    }
    for i in whole..theta.len() {
        subtract_some::<X, 1>(left, terms.some(i), &theta[i..]);
    }
}

#[inline(always)]
fn subtract_some<X: Number, const C: usize>(left: &mut Span<Lane>, terms: [&Span<X>; C], theta: &[Lane]) {
    let less = less(theta);
    for (t, left) in left.iter_mut().enumerate() {
        *left = remaining(*left, &terms, &less, t);
    }
}

/// The first `C` parameters, below zero.
#[inline(always)]
fn less<const C: usize>(theta: &[Lane]) -> [Lane; C] {
    let mut less = [Lane::ZERO; C];
    for (less, theta) in less.iter_mut().zip(theta) {
        *less = *less - *theta;
    }
    less
}

/// A residual at sample `t` less some terms.
#[inline(always)]
fn remaining<X: Number, const C: usize>(
    mut residual: Lane,
    terms: &[&Span<X>; C],
    less: &[Lane; C],
    t: usize,
) -> Lane {
    for i in 0..C {
        residual = terms[i][t].lane().fused(less[i], residual);
    }
    residual
}
