use std::ops::Range;

use vessel::{Lane, Number, Term};

use crate::Batch;
use crate::batch::{AnyBatch, BLOCK, Regressors, accumulate};

/// Sums over regression pairs of all degrees of freedom. The sums of two pieces of data add to those of both.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sums {
    /// Number of pairs N.
    pub samples: u64,
    /// Surge, sway, yaw.
    pub degrees: Vec<DegreeSums>,
}

/// Sums of one degree of freedom with p parameters; p̃ = p + 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DegreeSums {
    /// A = Σ ζ̃ φ̃ᵀ, p̃ × p̃, row-major. The last row holds Σ φ, the last column Σ ζ, the corner N.
    pub a: Vec<f64>,
    /// b = Σ ζ̃ Δy, p̃.
    pub b: Vec<f64>,
    /// Σ ζ_i², p.
    pub instrument_squares: Vec<f64>,
    /// Σ φ_i², p.
    pub regressor_squares: Vec<f64>,
}

impl Sums {
    /// The sums of all `parts` together.
    pub fn total<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut whole = Self::default();
        parts.into_iter().for_each(|part| whole.merge(part));
        whole
    }

    /// Adds the sums of further data.
    pub fn merge(&mut self, other: &Self) {
        if self.degrees.is_empty() {
            self.clone_from(other);
            return;
        }
        self.samples += other.samples;
        for (own, other) in self.degrees.iter_mut().zip(&other.degrees) {
            add(&mut own.a, &other.a);
            add(&mut own.b, &other.b);
            add(&mut own.instrument_squares, &other.instrument_squares);
            add(&mut own.regressor_squares, &other.regressor_squares);
        }
    }
}

fn add(own: &mut [f64], other: &[f64]) {
    own.iter_mut().zip(other).for_each(|(a, b)| *a += b);
}

impl DegreeSums {
    /// Number of parameters p.
    pub fn parameters(&self) -> usize {
        self.instrument_squares.len()
    }

    /// Σζ/N; zero where there is no intercept.
    pub(crate) fn instrument_means(&self, centred: bool) -> impl Iterator<Item = f64> {
        let (p, share) = (self.parameters(), self.share(centred));
        (0..p).map(move |i| share * self.a[i * (p + 1) + p])
    }

    /// (ΣΔy − Σφᵀθ)/N; zero where there is no intercept.
    pub(crate) fn intercept(&self, theta: &[f64], centred: bool) -> f64 {
        let p = self.parameters();
        let predicted: f64 = theta.iter().zip(&self.a[p * (p + 1)..]).map(|(t, f)| t * f).sum();
        self.share(centred) * (self.b[p] - predicted)
    }

    /// 1/N, what a sum counts in a mean; zero where no mean is removed.
    pub(crate) fn share(&self, centred: bool) -> f64 {
        let n = self.a.last().copied().unwrap_or(0.0);
        if centred && n > 0.0 { 1.0 / n } else { 0.0 }
    }
}

/// [`Sums`] of a batch over some samples, lane by lane, laid out one degree of freedom after the other: a, b, squares of
/// ζ and of φ.
#[derive(Clone)]
pub(crate) struct LaneSums {
    entries: Vec<Lane>,
    parameters: [usize; 3],
    /// Per degree of freedom: what comes after so many terms is made of inputs alone, the same in φ and in ζ.
    measured: [usize; 3],
    range: Range<usize>,
}

impl LaneSums {
    /// What depends on the instruments alone, over samples `range`; zero elsewhere.
    pub(crate) fn of_instruments<X: Number>(batch: &Batch<X>, range: Range<usize>) -> Self {
        let parameters = [0, 1, 2].map(|d: usize| batch.model.degrees[d].terms.len());
        let size = parameters.into_iter().map(entries).sum();
        let measured = [0, 1, 2].map(|d: usize| {
            let of_state = |term: &Term| term.factors.iter().any(|f| f.variable < 3);
            batch.model.degrees[d].terms.iter().rposition(of_state).map_or(0, |last| last + 1)
        });
        let mut sums = Self { entries: vec![Lane::ZERO; size], parameters, measured, range };
        sums.add_instruments(batch.any());
        sums
    }

    fn add_instruments(&mut self, batch: AnyBatch) {
        match &batch {
            AnyBatch::Lanes(batch) => pulp::Arch::new().dispatch(AddInstruments { sums: self, batch }),
            AnyBatch::Shared(batch) => pulp::Arch::new().dispatch(AddInstruments { sums: self, batch }),
        }
    }

    /// These sums of instruments with all the others.
    pub(crate) fn with_measured<X: Number>(&self, batch: &Batch<X>) -> Self {
        let mut sums = self.clone();
        sums.add_measured(batch.any());
        sums
    }

    fn add_measured(&mut self, batch: AnyBatch) {
        match &batch {
            AnyBatch::Lanes(batch) => pulp::Arch::new().dispatch(AddMeasured { sums: self, batch }),
            AnyBatch::Shared(batch) => pulp::Arch::new().dispatch(AddMeasured { sums: self, batch }),
        }
    }

    /// The sums of one lane.
    pub(crate) fn lane(&self, lane: usize) -> Sums {
        let mut start = 0;
        let degree = |p: &usize| {
            let own: Vec<f64> = self.entries[start..start + entries(*p)].iter().map(|e| e[lane]).collect();
            start += entries(*p);
            let lifted = p + 1;
            let (a, rest) = own.split_at(lifted * lifted);
            let (b, squares) = rest.split_at(lifted);
            let mut a = a.to_vec();
            a[lifted * lifted - 1] = self.range.len() as f64;
            let (zeta, phi) = squares.split_at(*p);
            DegreeSums {
                a,
                b: b.to_vec(),
                instrument_squares: zeta.to_vec(),
                regressor_squares: phi.to_vec(),
            }
        };
        Sums { samples: self.range.len() as u64, degrees: self.parameters.iter().map(degree).collect() }
    }

    /// Samples in blocks: (first, count).
    fn blocks(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let end = self.range.end;
        self.range.clone().step_by(BLOCK).map(move |k| (k, BLOCK.min(end - k)))
    }

    /// Per degree of freedom: its place among the parameters, how many terms are measured, and a, b, the squares of ζ and
    /// of φ.
    #[inline(always)]
    fn degrees(&mut self) -> impl Iterator<Item = (Range<usize>, usize, [&mut [Lane]; 4])> {
        let (mut rest, mut first) = (&mut self.entries[..], 0);
        self.parameters.iter().zip(self.measured).map(move |(p, measured)| {
            let (a, after) = std::mem::take(&mut rest).split_at_mut((p + 1) * (p + 1));
            let (b, after) = after.split_at_mut(p + 1);
            let (zeta, after) = after.split_at_mut(*p);
            let (phi, after) = after.split_at_mut(*p);
            (rest, first) = (after, first + p);
            (first - p..first, measured, [a, b, zeta, phi])
        })
    }
}

fn entries(p: usize) -> usize {
    (p + 1) * (p + 1) + (p + 1) + 2 * p
}

/// Σζ, Σζ² and everything with terms of inputs alone; compiled for every instruction set that pulp picks from.
struct AddInstruments<'a, X> {
    sums: &'a mut LaneSums,
    batch: &'a Batch<'a, X>,
}

impl<X: Number> pulp::WithSimd for AddInstruments<'_, X> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let mut zeta = Regressors::new(self.batch.model);
        for (k, count) in self.sums.blocks() {
            self.batch.zeta(k, count, &mut zeta);
            for (own, measured, [a, _, squares, phi_squares]) in self.sums.degrees() {
                let lifted = own.len() + 1;
                let zeta = &zeta.terms[own];
                for (z, row) in zeta.iter().zip(a.chunks_exact_mut(lifted)) {
                    accumulate(
                        std::slice::from_ref(z),
                        &mut row[lifted - 1..],
                        #[inline(always)]
                        |_, z| z.lane(),
                    );
                    accumulate(
                        &zeta[measured..],
                        &mut row[measured..lifted - 1],
                        #[inline(always)]
                        |t, other| (other * z[t]).lane(),
                    );
                }
                accumulate(
                    &zeta[measured..],
                    &mut a[lifted * (lifted - 1) + measured..],
                    #[inline(always)]
                    |_, z| z.lane(),
                );
                for (squares, first) in [(squares, 0), (phi_squares, measured)] {
                    accumulate(
                        &zeta[first..],
                        &mut squares[first..],
                        #[inline(always)]
                        |_, z| (z * z).lane(),
                    );
                }
            }
        }
    }
}

/// Everything with measured terms or Δy in it; compiled for every instruction set that pulp picks from.
struct AddMeasured<'a, X> {
    sums: &'a mut LaneSums,
    batch: &'a Batch<'a, X>,
}

impl<X: Number> pulp::WithSimd for AddMeasured<'_, X> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let (mut phi, mut zeta) = (Regressors::new(self.batch.model), Regressors::new(self.batch.model));
        for (k, count) in self.sums.blocks() {
            self.batch.phi(k, count, &mut phi);
            self.batch.zeta(k, count, &mut zeta);
            for (d, (own, measured, [a, b, _, squares])) in self.sums.degrees().enumerate() {
                let increments = self.batch.increments(k, count, d);
                let (zeta, p) = (&zeta.terms[own.clone()], own.len());
                let phi = &phi.terms[own][..measured];
                for (z, row) in zeta.iter().zip(a.chunks_exact_mut(p + 1)) {
                    accumulate(
                        phi,
                        row,
                        #[inline(always)]
                        |t, f| f * z[t].lane(),
                    );
                }
                accumulate(
                    zeta,
                    b,
                    #[inline(always)]
                    |t, z| z.lane() * increments[t],
                );
                accumulate(
                    phi,
                    &mut a[p * (p + 1)..],
                    #[inline(always)]
                    |_, f| f,
                );
                accumulate(
                    phi,
                    squares,
                    #[inline(always)]
                    |_, f| f * f,
                );
                accumulate(
                    &[increments],
                    &mut b[p..],
                    #[inline(always)]
                    |_, y| y,
                );
            }
        }
    }
}
