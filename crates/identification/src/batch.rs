use std::ops::Range;

use vessel::{Factor, LANES, Lane, Model, Number, Numbers, Term};

/// [`LANES`] runs of N samples side by side. All row-major. What the runs share (`X` = `f64`) is one number per entry
/// instead of a lane; the results are the same bits.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a, X = Lane> {
    /// The model structure.
    pub model: &'a Model,
    /// Measured states u, v \[m/s\], r \[rad/s\]: (N+1) × 3.
    pub measured: &'a [Lane],
    /// States that the instruments are formed with: (N+1) × 3. Of a nominal simulation for instrumental variables, the
    /// measured ones themselves for least squares.
    pub instrument_states: &'a [X],
    /// Inputs and measured disturbances: N × exogenous.
    pub exogenous: &'a [X],
    /// Per run, the first sample of each segment, ascending from 0.
    pub segments: [&'a [usize]; LANES],
}

/// A batch by what its runs share: passes over one are compiled here, not in every crate and test that calls them.
#[derive(Clone, Copy, Debug)]
pub(crate) enum AnyBatch<'a> {
    Lanes(Batch<'a, Lane>),
    Shared(Batch<'a, f64>),
}

/// What a pass over a batch of either kind comes to, [`vectorized!`].
macro_rules! over_batch {
    ($any:expr, |$batch:ident| $pass:expr) => {
        match $any {
            $crate::batch::AnyBatch::Lanes($batch) => vessel::vectorized!($pass),
            $crate::batch::AnyBatch::Shared($batch) => vessel::vectorized!($pass),
        }
    };
}
pub(crate) use over_batch;

impl<'a, X: Number> Batch<'a, X> {
    /// The same batch, `X` told.
    pub(crate) fn any(&self) -> AnyBatch<'a> {
        let Self { model, measured, segments, .. } = *self;
        match (X::numbers(self.instrument_states), X::numbers(self.exogenous)) {
            (Numbers::Lanes(instrument_states), Numbers::Lanes(exogenous)) => {
                AnyBatch::Lanes(Batch { model, measured, instrument_states, exogenous, segments })
            }
            (Numbers::Shared(instrument_states), Numbers::Shared(exogenous)) => {
                AnyBatch::Shared(Batch { model, measured, instrument_states, exogenous, segments })
            }
            _ => unreachable!("both are made of X"),
        }
    }
}

impl<X: Number> Batch<'_, X> {
    /// Number of regression pairs N.
    pub fn samples(&self) -> usize {
        self.measured.len() / 3 - 1
    }

    /// Evaluates φ at samples `k..k + count`, `count` ≤ [`BLOCK`]; zero beyond.
    #[inline(always)]
    pub(crate) fn phi(&self, k: usize, count: usize, out: &mut Regressors<Lane>) {
        out.evaluate(self.model, self.measured, self.exogenous, X::lane, k, count);
    }

    /// Evaluates ζ at samples `k..k + count`, `count` ≤ [`BLOCK`]; zero beyond.
    #[inline(always)]
    pub(crate) fn zeta(&self, k: usize, count: usize, out: &mut Regressors<X>) {
        out.evaluate(self.model, self.instrument_states, self.exogenous, std::convert::identity, k, count);
    }

    /// Δy of degree of freedom `d` less the model's constant and known terms at samples `k..k + count`; zero beyond. `phi` was
    /// evaluated there.
    #[inline(always)]
    pub(crate) fn increments(&self, k: usize, count: usize, d: usize, phi: &Regressors<Lane>) -> Block<Lane> {
        let mut next = [Lane::ZERO; BLOCK];
        copy_column(&self.measured[3 * (k + 1) + d..], 3, count, Lane::lane, &mut next);
        for (next, now) in next.iter_mut().zip(&phi.signals[d]) {
            *next = *next - *now;
        }
        let constant = self.model.constant[d];
        if constant != 0.0 {
            for increment in &mut next[..count] {
                *increment = *increment - Lane::splat(constant);
            }
        }
        for known in &self.model.degrees[d].known {
            let mut gained = [Lane::ZERO; BLOCK];
            known.add(&phi.signals[..phi.variables], &mut gained);
            for (increment, gained) in next[..count].iter_mut().zip(gained) {
                *increment = *increment - gained;
            }
        }
        next
    }
}

/// Copies `count` entries of a column into a block, and zeros beyond: the terms of zeros are zeros. A whole block is a loop
/// of fixed length without conditions, so that each entry moves as one vector.
#[inline(always)]
fn copy_column<X: Number, Y: Number>(
    column: &[X],
    stride: usize,
    count: usize,
    convert: impl Fn(X) -> Y,
    out: &mut Block<Y>,
) {
    if count == BLOCK {
        for (t, value) in out.iter_mut().enumerate() {
            *value = convert(column[stride * t]);
        }
    } else {
        *out = [Y::ZERO; BLOCK];
        for (value, entry) in out.iter_mut().zip(column.iter().step_by(stride)).take(count) {
            *value = convert(*entry);
        }
    }
}

/// Samples that are evaluated at once.
pub(crate) const BLOCK: usize = 8;
/// A signal at [`BLOCK`] samples.
pub(crate) type Block<X> = [X; BLOCK];

/// The variables at [`BLOCK`] samples and the terms that are made of them. A term that is a variable is not copied.
pub(crate) struct Regressors<X> {
    /// Variables, then what of the terms is none.
    signals: Vec<Block<X>>,
    /// Of every term, the place of its signal.
    places: Vec<usize>,
    variables: usize,
    /// Of every signal, whether it is evaluated; the others stay zero.
    wanted: Vec<bool>,
}

impl<X: Number> Regressors<X> {
    pub(crate) fn new(model: &Model) -> Self {
        Self::of(model, [usize::MAX; 3])
    }

    /// The first `terms` terms of each degree of freedom, and the variables of its known terms.
    pub(crate) fn of(model: &Model, terms: [usize; 3]) -> Self {
        let variables = model.variables.len();
        let mut next = variables;
        let place = |term: &Term| match (term.factors.as_slice(), term.tied.is_empty()) {
            ([Factor { variable, modulus: false }], true) => *variable,
            _ => {
                next += 1;
                next - 1
            }
        };
        let places: Vec<usize> = model.degrees.iter().flat_map(|d| &d.terms).map(place).collect();
        let mut wanted = vec![false; next];
        model.known().flat_map(|(_, known)| &known.factors).for_each(|f| wanted[f.variable] = true);
        let all = model
            .degrees
            .iter()
            .zip(terms)
            .flat_map(|(d, own)| d.terms.iter().enumerate().map(move |(i, t)| (t, i < own)));
        for ((term, _), place) in all.zip(&places).filter(|((_, own), _)| *own) {
            wanted[*place] = true;
            term.products().flatten().for_each(|f| wanted[f.variable] = true);
        }
        Self { signals: vec![[X::ZERO; BLOCK]; next], places, variables, wanted }
    }

    /// The terms in `range`.
    #[inline(always)]
    pub(crate) fn terms(&self, range: Range<usize>) -> Picked<'_, X> {
        Picked { signals: &self.signals, places: &self.places[range] }
    }

    #[inline(always)]
    fn evaluate<E: Number>(
        &mut self,
        model: &Model,
        states: &[X],
        exogenous: &[E],
        convert: impl Fn(E) -> X + Copy,
        k: usize,
        count: usize,
    ) {
        let (values, products) = self.signals.split_at_mut(self.variables);
        let (own, others) = values.split_at_mut(3);
        for (i, variable) in own.iter_mut().enumerate() {
            copy_column(&states[3 * k + i..], 3, count, std::convert::identity, variable);
        }
        let width = model.exogenous();
        for (i, variable) in others.iter_mut().enumerate().filter(|(i, _)| self.wanted[3 + i]) {
            copy_column(&exogenous[width * k + i..], width, count, convert, variable);
        }
        let mut places = self.places.iter();
        for degree in &model.degrees {
            for (term, place) in degree.terms.iter().zip(&mut places) {
                let product = place.checked_sub(self.variables).filter(|_| self.wanted[*place]);
                let Some(out) = product.and_then(|i| products.get_mut(i)) else { continue };
                term.values(values, out);
                if term.is_constant() {
                    out[count..].fill(X::ZERO);
                }
            }
        }
    }
}

/// Several signals at [`BLOCK`] samples.
pub(crate) trait Signals<Y>: Copy {
    /// How many.
    fn count(self) -> usize;
    /// One of them.
    fn signal(&self, i: usize) -> &Block<Y>;
}

impl<Y> Signals<Y> for &[Block<Y>] {
    #[inline(always)]
    fn count(self) -> usize {
        self.len()
    }
    #[inline(always)]
    fn signal(&self, i: usize) -> &Block<Y> {
        &self[i]
    }
}

/// Signals among others.
#[derive(Clone, Copy)]
pub(crate) struct Picked<'a, X> {
    signals: &'a [Block<X>],
    places: &'a [usize],
}

impl<X: Copy> Signals<X> for Picked<'_, X> {
    #[inline(always)]
    fn count(self) -> usize {
        self.places.len()
    }
    #[inline(always)]
    fn signal(&self, i: usize) -> &Block<X> {
        &self.signals[self.places[i]]
    }
}

/// Adds Σ y of every signal y to its entry of `sums`.
#[inline(always)]
pub(crate) fn add_totals<Y: Number>(signals: impl Signals<Y>, sums: &mut [Lane]) {
    accumulate(
        signals,
        sums,
        #[inline(always)]
        |_, y, sum| sum + y.lane(),
    );
}

/// Adds Σ y² of every signal y to its entry of `sums`.
#[inline(always)]
pub(crate) fn add_squares<Y: Number>(signals: impl Signals<Y>, sums: &mut [Lane]) {
    accumulate(
        signals,
        sums,
        #[inline(always)]
        |_, y, sum| y.lane().fused(y.lane(), sum),
    );
}

/// Adds Σ x y of every signal y to its entry of `sums`.
#[inline(always)]
pub(crate) fn add_products<X: Number, Y: Number>(x: &Block<X>, signals: impl Signals<Y>, sums: &mut [Lane]) {
    accumulate(
        signals,
        sums,
        #[inline(always)]
        |t, y, sum| x[t].lane().fused(y.lane(), sum),
    );
}

/// Adds Σ x y of every signal x and every signal y to `sums`: a row of `width` for each x. Tiles of them stay in
/// registers, so that a number that was loaded is used several times.
#[inline(always)]
pub(crate) fn add_outer<X: Number, Y: Number>(
    x: &impl Signals<X>,
    y: &impl Signals<Y>,
    width: usize,
    sums: &mut [Lane],
) {
    let (rows, columns) = (x.count(), y.count());
    for row in (0..rows).step_by(2) {
        for column in (0..columns).step_by(3) {
            let at = [row, column];
            match (rows - row > 1, columns - column) {
                (true, 1) => add_tile::<X, Y, 2, 1>(x, y, at, width, sums),
                (true, 2) => add_tile::<X, Y, 2, 2>(x, y, at, width, sums),
                (true, _) => add_tile::<X, Y, 2, 3>(x, y, at, width, sums),
                (false, 1) => add_tile::<X, Y, 1, 1>(x, y, at, width, sums),
                (false, 2) => add_tile::<X, Y, 1, 2>(x, y, at, width, sums),
                (false, _) => add_tile::<X, Y, 1, 3>(x, y, at, width, sums),
            }
        }
    }
}

/// A tile of [`add_outer`]: `R` rows and `C` columns from a place on.
#[inline(always)]
fn add_tile<X: Number, Y: Number, const R: usize, const C: usize>(
    x: &impl Signals<X>,
    y: &impl Signals<Y>,
    [row, column]: [usize; 2],
    width: usize,
    sums: &mut [Lane],
) {
    let mut rows = [x.signal(row); R];
    for (i, signal) in rows.iter_mut().enumerate() {
        *signal = x.signal(row + i);
    }
    let mut columns = [y.signal(column); C];
    for (i, signal) in columns.iter_mut().enumerate() {
        *signal = y.signal(column + i);
    }
    let mut own = [[Lane::ZERO; C]; R];
    for t in 0..BLOCK {
        for (own, x) in own.iter_mut().zip(rows) {
            for (own, y) in own.iter_mut().zip(columns) {
                *own = x[t].lane().fused(y[t].lane(), *own);
            }
        }
    }
    for (i, own) in own.iter().enumerate() {
        let first = (row + i) * width + column;
        for (sum, own) in sums[first..first + C].iter_mut().zip(own) {
            *sum += *own;
        }
    }
}

/// Adds to the entry of `sums` of every signal y what `f`(t, y(t), sum) makes of a sum, sample by sample; several signals at a time, so that no addition waits for
/// the one before it.
#[inline(always)]
pub(crate) fn accumulate<Y: Number>(
    signals: impl Signals<Y>,
    sums: &mut [Lane],
    f: impl Fn(usize, Y, Lane) -> Lane + Copy,
) {
    let count = signals.count();
    let whole = count - count % 4;
    for first in (0..whole).step_by(4) {
        add_sums::<Y, 4>(&signals, first, sums, f);
    }
    match count % 4 {
        3 => add_sums::<Y, 3>(&signals, whole, sums, f),
        2 => add_sums::<Y, 2>(&signals, whole, sums, f),
        1 => add_sums::<Y, 1>(&signals, whole, sums, f),
        _ => {}
    }
}

/// [`accumulate`] of `N` signals from `first` on.
#[inline(always)]
fn add_sums<Y: Number, const N: usize>(
    signals: &impl Signals<Y>,
    first: usize,
    sums: &mut [Lane],
    f: impl Fn(usize, Y, Lane) -> Lane,
) {
    let mut signal = [signals.signal(first); N];
    for (i, signal) in signal.iter_mut().enumerate() {
        *signal = signals.signal(first + i);
    }
    let mut own = [Lane::ZERO; N];
    for t in 0..BLOCK {
        for (own, signal) in own.iter_mut().zip(signal) {
            *own = f(t, signal[t], *own);
        }
    }
    for (sum, own) in sums[first..first + N].iter_mut().zip(own) {
        *sum += own;
    }
}
