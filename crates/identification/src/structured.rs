//! Passes over the samples of models whose structure is known when the program is compiled ([`vessel::Structure`]): terms and
//! sums of a block stay in registers. They give the same bits as those of [`crate::sums`] and [`crate::residual`].
//!
//! Loops count to a length that is known when they are compiled, and indices stand where iterators would read the same: so they are
//! unrolled, and what they add up has a register each.
#![allow(clippy::needless_range_loop)]

use vessel::{Equation, Lane, Number, Structure, Visit};

use crate::Batch;
use crate::batch::{BLOCK, Block};

/// Variables of a sample: its state, then inputs and measured disturbances.
#[inline(always)]
fn variables<X: Number, Y: Number, const V: usize>(
    state: [X; 3],
    exogenous: &[Y],
    convert: impl Fn(Y) -> X,
) -> [X; V] {
    let mut variables = [X::ZERO; V];
    variables[..3].copy_from_slice(&state);
    for (i, entry) in exogenous.iter().take(V - 3).enumerate() {
        variables[3 + i] = convert(*entry);
    }
    variables
}

/// The samples of a block, side by side: what was measured at each and after it, the instruments' states, the inputs.
struct Samples<'a, X> {
    measured: &'a [[Lane; 3]],
    instrument_states: &'a [[X; 3]],
    exogenous: &'a [X],
    width: usize,
}

impl<'a, X: Number> Samples<'a, X> {
    /// The `count` samples from `k` on.
    #[inline(always)]
    fn of(batch: &Batch<'a, X>, k: usize, count: usize) -> Self {
        let width = batch.model.exogenous();
        Self {
            measured: &batch.measured.as_chunks().0[k..=k + count],
            instrument_states: &batch.instrument_states.as_chunks().0[k..k + count],
            exogenous: &batch.exogenous[width * k..width * (k + count)],
            width,
        }
    }

    /// How many.
    #[inline(always)]
    fn count(&self) -> usize {
        self.instrument_states.len()
    }

    /// The inputs and measured disturbances of sample `t`.
    #[inline(always)]
    fn row(&self, t: usize) -> &[X] {
        &self.exogenous[self.width * t..self.width * (t + 1)]
    }

    /// φ of sample `t`.
    #[inline(always)]
    fn phi<Q: Equation<V, P, M>, const V: usize, const P: usize, const M: usize>(
        &self,
        t: usize,
    ) -> [Lane; P] {
        Q::terms(&variables(self.measured[t], self.row(t), X::lane))
    }

    /// ζ of sample `t`.
    #[inline(always)]
    fn zeta<Q: Equation<V, P, M>, const V: usize, const P: usize, const M: usize>(&self, t: usize) -> [X; P] {
        Q::terms(&variables(self.instrument_states[t], self.row(t), std::convert::identity))
    }
}

/// The sums of a degree of freedom: see [`crate::DegreeSums`].
pub(crate) struct Totals<'a> {
    pub a: &'a mut [Lane],
    pub b: &'a mut [Lane],
    pub instrument_squares: &'a mut [Lane],
    pub regressor_squares: &'a mut [Lane],
}

/// Adds everything of a block with measured terms or Δy in it to the sums.
struct Measured<'a, X> {
    samples: Samples<'a, X>,
    sums: [Totals<'a>; 3],
}

/// Adds the samples `k..k + count` to `sums`, those with measured terms or Δy in them.
#[inline(always)]
pub(crate) fn add_measured<X: Number, const V: usize, const P: usize>(
    structure: impl Structure<V, P>,
    batch: &Batch<X>,
    (k, count): (usize, usize),
    sums: [Totals; 3],
) {
    structure.visit(&mut Measured { samples: Samples::of(batch, k, count), sums });
}

impl<X: Number, const V: usize> Visit<V> for Measured<'_, X> {
    #[inline(always)]
    fn equation<Q: Equation<V, P, M>, const P: usize, const M: usize>(&mut self, d: usize, _: usize) {
        let mut a = [[Lane::ZERO; M]; P];
        let mut b = [Lane::ZERO; P];
        let (mut totals, mut squares, mut increments) = ([Lane::ZERO; M], [Lane::ZERO; M], Lane::ZERO);
        for t in 0..self.samples.count() {
            let phi = self.samples.phi::<Q, V, P, M>(t);
            let zeta = self.samples.zeta::<Q, V, P, M>(t);
            let increment = self.samples.measured[t + 1][d] - self.samples.measured[t][d];
            for i in 0..P {
                let z = zeta[i].lane();
                for j in 0..M {
                    a[i][j] = z.fused(phi[j], a[i][j]);
                }
                b[i] = increment.fused(z, b[i]);
            }
            for j in 0..M {
                totals[j] += phi[j];
                squares[j] = phi[j].fused(phi[j], squares[j]);
            }
            increments += increment;
        }
        let sums = &mut self.sums[d];
        for i in 0..P {
            add(&mut sums.a[i * (P + 1)..], &a[i]);
        }
        add(sums.b, &b);
        add(&mut sums.a[P * (P + 1)..], &totals);
        add(sums.regressor_squares, &squares);
        sums.b[P] += increments;
    }
}

/// Adds to the first sums; their number is known when this is compiled.
#[inline(always)]
fn add<const N: usize>(sums: &mut [Lane], own: &[Lane; N]) {
    if let Some(sums) = sums.first_chunk_mut::<N>() {
        for i in 0..N {
            sums[i] += own[i];
        }
    }
}

/// The residuals of a block, degree of freedom by degree of freedom.
struct Residuals<'a, X> {
    samples: Samples<'a, X>,
    theta: &'a [Lane],
    intercepts: &'a [Block<Lane>],
    residuals: &'a mut [Block<Lane>; 3],
}

/// Residuals at the samples `k..k + count`; what is beyond stays.
#[inline(always)]
pub(crate) fn residuals<X: Number, const V: usize, const P: usize>(
    structure: impl Structure<V, P>,
    batch: &Batch<X>,
    (k, count): (usize, usize),
    theta: &[Lane],
    intercepts: &[Block<Lane>],
    residuals: &mut [Block<Lane>; 3],
) {
    let samples = Samples::of(batch, k, count);
    structure.visit(&mut Residuals { samples, theta, intercepts, residuals });
}

impl<X: Number, const V: usize> Visit<V> for Residuals<'_, X> {
    #[inline(always)]
    fn equation<Q: Equation<V, P, M>, const P: usize, const M: usize>(&mut self, d: usize, first: usize) {
        let mut less = [Lane::ZERO; P];
        for i in 0..P {
            less[i] = Lane::ZERO - self.theta[first + i];
        }
        for t in 0..self.samples.count().min(BLOCK) {
            let phi = self.samples.phi::<Q, V, P, M>(t);
            let increment = self.samples.measured[t + 1][d] - self.samples.measured[t][d];
            let mut residual = increment - self.intercepts[d][t];
            for i in 0..P {
                residual = phi[i].fused(less[i], residual);
            }
            self.residuals[d][t] = residual;
        }
    }
}

/// Adds Σζ, Σζ² and everything with terms of inputs alone to the sums.
struct Unmeasured<'a, X> {
    samples: Samples<'a, X>,
    sums: [Totals<'a>; 3],
}

/// Adds the samples `k..k + count` to `sums`, what of them depends on the instruments alone.
#[inline(always)]
pub(crate) fn add_instruments<X: Number, const V: usize, const P: usize>(
    structure: impl Structure<V, P>,
    batch: &Batch<X>,
    (k, count): (usize, usize),
    sums: [Totals; 3],
) {
    structure.visit(&mut Unmeasured { samples: Samples::of(batch, k, count), sums });
}

impl<X: Number, const V: usize> Visit<V> for Unmeasured<'_, X> {
    #[inline(always)]
    fn equation<Q: Equation<V, P, M>, const P: usize, const M: usize>(&mut self, d: usize, _: usize) {
        let mut products = [[Lane::ZERO; P]; P];
        let (mut totals, mut squares) = ([Lane::ZERO; P], [Lane::ZERO; P]);
        for t in 0..self.samples.count() {
            let zeta = self.samples.zeta::<Q, V, P, M>(t);
            for i in 0..P {
                let z = zeta[i].lane();
                totals[i] += z;
                squares[i] = z.fused(z, squares[i]);
                for j in M..P {
                    products[i][j] = z.fused(zeta[j].lane(), products[i][j]);
                }
            }
        }
        let sums = &mut self.sums[d];
        for i in 0..P {
            for j in M..P {
                sums.a[i * (P + 1) + j] += products[i][j];
            }
            sums.a[i * (P + 1) + P] += totals[i];
        }
        for j in M..P {
            sums.a[P * (P + 1) + j] += totals[j];
            sums.regressor_squares[j] += squares[j];
        }
        add(sums.instrument_squares, &squares);
    }
}

/// Adds products of centred instruments to Σ ζᶜζᶜᵀ and, of neighbours, to Σ (ζᶜ(k−1) ζᶜ(k)ᵀ + its transpose).
struct Products<'a, X> {
    samples: Samples<'a, X>,
    means: &'a [Block<Lane>],
    /// The centred instruments of the sample before the block.
    edges: &'a mut [Lane],
    squares: &'a mut [Lane],
    neighbours: &'a mut [Lane],
    /// How many entries of the triangles are done.
    place: usize,
}

/// Adds the samples `k..k + count` to the upper triangles `squares` and `neighbours`; `edges` came before them.
#[inline(always)]
pub(crate) fn add_squares<X: Number, const V: usize, const P: usize>(
    structure: impl Structure<V, P>,
    batch: &Batch<X>,
    (k, count): (usize, usize),
    means: &[Block<Lane>],
    edges: &mut [Lane],
    [squares, neighbours]: [&mut [Lane]; 2],
) {
    let samples = Samples::of(batch, k, count);
    structure.visit(&mut Products { samples, means, edges, squares, neighbours, place: 0 });
}

impl<X: Number, const V: usize> Visit<V> for Products<'_, X> {
    #[inline(always)]
    fn equation<Q: Equation<V, P, M>, const P: usize, const M: usize>(&mut self, _: usize, first: usize) {
        let (mut squares, mut followed) = ([[Lane::ZERO; P]; P], [[Lane::ZERO; P]; P]);
        let mut before = [Lane::ZERO; P];
        before.copy_from_slice(&self.edges[first..first + P]);
        for t in 0..self.samples.count().min(BLOCK) {
            let zeta = self.samples.zeta::<Q, V, P, M>(t);
            let mut now = [Lane::ZERO; P];
            for i in 0..P {
                now[i] = zeta[i].lane() - self.means[first + i][t];
            }
            for i in 0..P {
                for j in 0..P {
                    if j >= i {
                        squares[i][j] = now[i].fused(now[j], squares[i][j]);
                    }
                    followed[i][j] = before[i].fused(now[j], followed[i][j]);
                }
            }
            before = now;
        }
        self.edges[first..first + P].copy_from_slice(&before);
        for i in 0..P {
            for j in 0..P {
                if j >= i {
                    self.squares[self.place] += squares[i][j];
                    self.neighbours[self.place] += followed[i][j];
                    self.neighbours[self.place] += followed[j][i];
                    self.place += 1;
                }
            }
        }
    }
}
