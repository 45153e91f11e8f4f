use std::collections::BTreeMap;
use std::ops::Range;

use vessel::lanes::lane_of;
use vessel::{Degree, Lane, Model, Number, Term, vectorized};

use crate::batch::{
    ALL, AnyBatch, BLOCK, Kept, Picked, Regressors, SPAN, Signals, Span, Zeta, add_products, add_squares,
    add_totals, over_batch, some_of,
};
use crate::structured::Totals;
use crate::{Batch, structured};

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
pub struct DegreeSums<X = f64> {
    /// A = Σ ζ̃ φ̃ᵀ, p̃ × p̃, row-major. The last row holds Σ φ, the last column Σ ζ, the corner N.
    pub a: Vec<X>,
    /// b = Σ ζ̃ Δy, p̃.
    pub b: Vec<X>,
    /// Σ ζ_i², p.
    pub instrument_squares: Vec<X>,
    /// Σ φ_i², p.
    pub regressor_squares: Vec<X>,
    /// What is known of the parameters.
    pub known: Known,
}

/// What estimates from sums have to know of the parameters of a degree of freedom.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    /// Whether one of the terms is 1: then its parameter is the intercept, and no mean is removed.
    pub constant: bool,
    /// Within which estimates stay, by place; see [`vessel::Degree::bounds`].
    pub bounds: BTreeMap<usize, [f64; 2]>,
}

impl Known {
    /// Of `degree`.
    pub fn of(degree: &Degree) -> Self {
        Self { constant: degree.constant().is_some(), bounds: degree.bounds.clone() }
    }
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

impl<X: Number> DegreeSums<X> {
    /// Sums over no sample, of `p` parameters.
    pub(crate) fn zero(p: usize) -> Self {
        let zeros = |count: usize| vec![X::ZERO; count];
        Self {
            a: zeros((p + 1) * (p + 1)),
            b: zeros(p + 1),
            instrument_squares: zeros(p),
            regressor_squares: zeros(p),
            known: Known::default(),
        }
    }

    /// Sums over no sample, of the parameters of `degree`.
    pub(crate) fn of(degree: &Degree) -> Self {
        Self { known: Known::of(degree), ..Self::zero(degree.terms.len()) }
    }

    /// Number of parameters p.
    pub fn parameters(&self) -> usize {
        self.instrument_squares.len()
    }

    /// Adds a sample: ζ and φ of p entries, the 1 that lifts both, and Δy.
    #[inline(always)]
    pub(crate) fn add_sample(&mut self, zeta: &[X], phi: &[X], one: X, increment: X) {
        let p = zeta.len();
        for (i, z) in zeta.iter().enumerate() {
            self.add_row(i, *z, phi, one, increment);
        }
        self.add_row(p, one, phi, one, increment);
        for i in 0..p {
            self.instrument_squares[i] += zeta[i] * zeta[i];
            self.regressor_squares[i] += phi[i] * phi[i];
        }
    }

    /// Adds entry `i` of ζ̃ times φ̃ and Δy.
    #[inline(always)]
    fn add_row(&mut self, i: usize, z: X, phi: &[X], one: X, increment: X) {
        let p = phi.len();
        let row = &mut self.a[i * (p + 1)..(i + 1) * (p + 1)];
        for (sum, f) in row.iter_mut().zip(phi) {
            *sum += z * *f;
        }
        row[p] += z * one;
        self.b[i] += z * increment;
    }
}

impl DegreeSums<Lane> {
    #[inline(always)]
    fn totals(&mut self) -> Totals<'_> {
        let Self { a, b, instrument_squares, regressor_squares, .. } = self;
        Totals { a, b, instrument_squares, regressor_squares }
    }

    /// The sums of one lane.
    pub(crate) fn lane(&self, lane: usize) -> DegreeSums {
        DegreeSums {
            a: lane_of(&self.a, lane),
            b: lane_of(&self.b, lane),
            instrument_squares: lane_of(&self.instrument_squares, lane),
            regressor_squares: lane_of(&self.regressor_squares, lane),
            known: self.known.clone(),
        }
    }

    /// Takes one lane of `other`.
    fn take(&mut self, lane: usize, other: &Self) {
        for (own, other) in [
            (&mut self.a, &other.a),
            (&mut self.b, &other.b),
            (&mut self.instrument_squares, &other.instrument_squares),
            (&mut self.regressor_squares, &other.regressor_squares),
        ] {
            own.iter_mut().zip(other).for_each(|(own, other)| own[lane] = other[lane]);
        }
    }
}

impl<X: Number> DegreeSums<X> {
    /// Σζ/N; zero where there is no intercept.
    pub(crate) fn instrument_means(&self, centred: bool) -> impl Iterator<Item = X> {
        let (p, share) = (self.parameters(), self.share(centred));
        (0..p).map(move |i| share * self.a[i * (p + 1) + p])
    }

    /// (ΣΔy − Σφᵀθ)/N; zero where there is no intercept.
    pub(crate) fn intercept(&self, theta: &[X], centred: bool) -> X {
        self.share(centred) * self.residual(theta)
    }

    /// ΣΔy − Σφᵀθ.
    pub(crate) fn residual(&self, theta: &[X]) -> X {
        let p = self.parameters();
        let mut predicted = X::ZERO;
        theta.iter().zip(&self.a[p * (p + 1)..]).for_each(|(t, f)| predicted += *t * *f);
        self.b[p] - predicted
    }

    /// 1/N, what a sum counts in a mean; zero where no mean is removed.
    pub(crate) fn share(&self, centred: bool) -> X {
        let n = self.a.last().copied().unwrap_or(X::ZERO);
        if !centred || self.known.constant {
            return X::ZERO;
        }
        X::ONE.each(n, |one, n| if n > 0.0 { one / n } else { 0.0 })
    }
}

impl DegreeSums {
    /// Σφ and, last, ΣΔy.
    pub(crate) fn end(&self) -> impl Iterator<Item = f64> {
        let p = self.parameters();
        self.a[p * (p + 1)..].iter().take(p).chain(&self.b[p..]).copied()
    }
}

/// After how many terms of each degree of freedom all are made of inputs alone.
pub(crate) fn measured(model: &Model) -> [usize; 3] {
    let of_state = |term: &Term| term.products().flatten().any(|f| f.variable < 3);
    let last = |degree: &Degree| degree.terms.iter().rposition(of_state);
    model.degrees.each_ref().map(|degree| last(degree).map_or(0, |last| last + 1))
}

/// [`Sums`] of a batch over some samples, lane by lane.
#[derive(Clone)]
pub(crate) struct LaneSums {
    degrees: [DegreeSums<Lane>; 3],
    /// Per degree of freedom: what comes after so many terms is made of inputs alone, the same in φ and in ζ.
    measured: [usize; 3],
    range: Range<usize>,
}

impl LaneSums {
    /// What depends on the instruments alone, over samples `range`; zero elsewhere.
    pub(crate) fn of_instruments(batch: AnyBatch, range: Range<usize>) -> Self {
        let mut sums = Self::zero(batch.model(), range);
        match batch.model().structure() {
            Some(known) => over_batch!(batch, |batch| for block in sums.parts(BLOCK) {
                structured::add_instruments(known, &batch, block, sums.totals());
            }),
            None => over_batch!(batch, |batch| sums.add_instruments(&batch)),
        }
        sums
    }

    /// These sums of instruments with all the others. `kept` is ζ of all samples, where it was kept.
    pub(crate) fn with_measured(&self, batch: AnyBatch, kept: Option<&Kept<f64>>) -> Self {
        let mut sums = self.clone();
        if let Some(known) = batch.model().structure() {
            over_batch!(batch, |batch| for block in sums.parts(BLOCK) {
                structured::add_measured(known, &batch, block, sums.totals());
            });
            return sums;
        }
        match batch {
            AnyBatch::Lanes(batch) => vectorized!(sums.add_measured(&batch, None)),
            AnyBatch::Shared(batch) => vectorized!(sums.add_measured(&batch, kept)),
        }
        sums
    }

    /// Nothing but the number of samples.
    fn zero(model: &Model, range: Range<usize>) -> Self {
        let measured = measured(model);
        let mut degrees = model.degrees.each_ref().map(DegreeSums::of);
        let count = Lane::splat(range.len() as f64);
        degrees.iter_mut().flat_map(|own| own.a.last_mut()).for_each(|corner| *corner = count);
        Self { degrees, measured, range }
    }

    /// The sums of one lane.
    pub(crate) fn lane(&self, lane: usize) -> Sums {
        let degrees = self.degrees.iter().map(|own| own.lane(lane)).collect();
        Sums { samples: self.range.len() as u64, degrees }
    }

    /// The sums of all lanes, where all have the same samples.
    pub(crate) fn whole(self) -> [DegreeSums<Lane>; 3] {
        self.degrees
    }

    /// These sums in one lane of `degrees`, which hold those of others in other lanes.
    pub(crate) fn put(&self, lane: usize, degrees: &mut [DegreeSums<Lane>; 3]) {
        degrees.iter_mut().zip(&self.degrees).for_each(|(own, other)| own.take(lane, other));
    }

    /// Samples, so many at a time: (first, count).
    fn parts(&self, of: usize) -> impl Iterator<Item = (usize, usize)> + use<> {
        let end = self.range.end;
        self.range.clone().step_by(of).map(move |k| (k, of.min(end - k)))
    }

    /// Per degree of freedom: its place among the parameters, how many terms are measured, and the sums.
    #[inline(always)]
    fn degrees(&mut self) -> impl Iterator<Item = (Range<usize>, usize, &mut DegreeSums<Lane>)> {
        let mut first = 0;
        self.degrees.iter_mut().zip(self.measured).map(move |(sums, measured)| {
            let own = first..first + sums.parameters();
            first = own.end;
            (own, measured, sums)
        })
    }

    #[inline(always)]
    fn totals(&mut self) -> [Totals<'_>; 3] {
        let [u, v, r] = &mut self.degrees;
        [u.totals(), v.totals(), r.totals()]
    }

    /// Adds Σζ, Σζ² and everything with terms of inputs alone.
    #[inline(always)]
    fn add_instruments<X: Number>(&mut self, batch: &Batch<X>) {
        let mut zeta = Regressors::new(batch.model);
        for (k, count) in self.parts(SPAN) {
            batch.zeta(k, count, &mut zeta);
            for (own, measured, sums) in self.degrees() {
                let p = own.len();
                let inputs = zeta.terms().part(own.start + measured..own.end);
                let zeta = zeta.terms().part(own);
                for (i, row) in sums.a.chunks_exact_mut(p + 1).take(p).enumerate() {
                    let z = zeta.signal(i);
                    add_totals(std::slice::from_ref(z), &mut row[p..]);
                    add_products(z, inputs, &mut row[measured..p]);
                }
                add_totals(inputs, &mut sums.a[p * (p + 1) + measured..]);
                add_squares(zeta, &mut sums.instrument_squares);
                add_squares(inputs, &mut sums.regressor_squares[measured..]);
            }
        }
    }

    /// Adds everything with measured terms or Δy in it.
    #[inline(always)]
    fn add_measured<X: Number>(&mut self, batch: &Batch<X>, kept: Option<&Kept<X>>) {
        let mut phi = Regressors::of(batch.model, self.measured.map(|measured| 0..measured));
        let mut zeta = Zeta::new(kept, self.range.start, batch.model, ALL);
        let mut columns = [0, 1, 2].map(|d: usize| Columns::new(self.measured[d], &self.degrees[d]));
        let mut increments = [Lane::ZERO; SPAN];
        for (k, count) in self.parts(SPAN) {
            batch.phi(k, count, &mut phi);
            let zeta = zeta.at(batch, k, count);
            for (d, (own, measured, _)) in self.degrees().enumerate() {
                let regressors = phi.terms().part(own.start..own.start + measured);
                let zeta = zeta.part(own);
                let columns = &mut columns[d];
                for i in 0..measured {
                    let regressor = regressors.signal(i);
                    columns.add(
                        i,
                        zeta,
                        #[inline(always)]
                        |t| regressor[t],
                    );
                }
                if let Some(rows) = batch.between(k, count, d) {
                    columns.add(
                        measured,
                        zeta,
                        #[inline(always)]
                        |t| rows[t + 1][d] - rows[t][d],
                    );
                } else {
                    batch.increments(k, count, d, &phi, &mut increments);
                    columns.add(
                        measured,
                        zeta,
                        #[inline(always)]
                        |t| increments[t],
                    );
                }
            }
        }
        self.degrees.iter_mut().zip(columns).for_each(|(sums, columns)| columns.put(sums));
    }
}

/// Sums of one degree of freedom with measured terms or Δy in them: a column for each of these, then one for Δy.
struct Columns {
    /// Of a signal y: Σ ζ y, p of them, Σ y and Σ y².
    sums: Vec<Lane>,
    height: usize,
}

/// Instruments that are multiplied at once: their sums have a register each.
const AT_ONCE: usize = 4;

impl Columns {
    fn new(measured: usize, sums: &DegreeSums<Lane>) -> Self {
        let height = sums.parameters() + 2;
        Self { sums: vec![Lane::ZERO; (measured + 1) * height], height }
    }

    /// Adds the sums of a signal to its column.
    #[inline(always)]
    fn add<X: Number>(&mut self, column: usize, zeta: Picked<X>, y: impl Fn(usize) -> Lane + Copy) {
        let sums = &mut self.sums[column * self.height..(column + 1) * self.height];
        let mut done = 0;
        while zeta.count() - done > AT_ONCE {
            add_rows::<X, AT_ONCE, false>(some_of(&zeta, done), y, &mut sums[done..]);
            done += AT_ONCE;
        }
        let sums = &mut sums[done..];
        match zeta.count() - done {
            0 => add_rows::<X, 0, true>(some_of(&zeta, done), y, sums),
            1 => add_rows::<X, 1, true>(some_of(&zeta, done), y, sums),
            2 => add_rows::<X, 2, true>(some_of(&zeta, done), y, sums),
            3 => add_rows::<X, 3, true>(some_of(&zeta, done), y, sums),
            _ => add_rows::<X, AT_ONCE, true>(some_of(&zeta, done), y, sums),
        }
    }

    /// Puts the sums where they belong.
    fn put(&self, own: &mut DegreeSums<Lane>) {
        let p = own.parameters();
        let columns = self.sums.chunks_exact(self.height);
        let measured = columns.len() - 1;
        for (j, column) in columns.enumerate() {
            if j < measured {
                (0..=p).for_each(|i| own.a[i * (p + 1) + j] = column[i]);
                own.regressor_squares[j] = column[p + 1];
            } else {
                own.b.copy_from_slice(&column[..=p]);
            }
        }
    }
}

/// Adds Σ ζ y of `R` instruments to the first sums; `LAST` ones are followed by Σ y and Σ y².
#[allow(clippy::needless_range_loop)] // What iterators make of arrays is not always inlined, and then has no vectors.
#[inline(always)]
fn add_rows<X: Number, const R: usize, const LAST: bool>(
    zeta: [&Span<X>; R],
    y: impl Fn(usize) -> Lane,
    sums: &mut [Lane],
) {
    let (sums, more) = sums.split_at_mut(R);
    let mut whole = [Lane::ZERO; R];
    whole.copy_from_slice(sums);
    let mut ends = [Lane::ZERO; 2];
    if LAST {
        ends.copy_from_slice(more);
    }
    for block in (0..SPAN).step_by(BLOCK) {
        let (mut own, mut total, mut square) = ([Lane::ZERO; R], Lane::ZERO, Lane::ZERO);
        for t in block..block + BLOCK {
            let y = y(t);
            for i in 0..R {
                own[i] = zeta[i][t].lane().fused(y, own[i]);
            }
            if LAST {
                total += y;
                square = y.fused(y, square);
            }
        }
        for i in 0..R {
            whole[i] += own[i];
        }
        ends[0] += total;
        ends[1] += square;
    }
    sums.copy_from_slice(&whole);
    if LAST {
        more.copy_from_slice(&ends);
    }
}
