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

/// What a pass over a batch of either kind comes to, [`vectorized!`]. Passes of models whose structure is known and passes of any
/// model are compiled apart: together, they keep fewer numbers in registers.
macro_rules! over_batch {
    ($any:expr, |$batch:ident| $pass:expr) => {
        match $any {
            $crate::batch::AnyBatch::Lanes($batch) => vessel::vectorized!($pass),
            $crate::batch::AnyBatch::Shared($batch) => vessel::vectorized!($pass),
        }
    };
}
pub(crate) use over_batch;

impl<'a> AnyBatch<'a> {
    /// The model structure.
    pub(crate) fn model(&self) -> &'a Model {
        match self {
            Self::Lanes(batch) => batch.model,
            Self::Shared(batch) => batch.model,
        }
    }
}

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

    /// Evaluates φ at samples `k..k + count`, `count` ≤ [`SPAN`]; zero beyond.
    #[inline(always)]
    pub(crate) fn phi(&self, k: usize, count: usize, out: &mut Regressors<Lane>) {
        out.evaluate(self.model, self.measured, self.exogenous, X::lane, k, count);
    }

    /// Evaluates ζ at samples `k..k + count`, `count` ≤ [`SPAN`]; zero beyond.
    #[inline(always)]
    pub(crate) fn zeta(&self, k: usize, count: usize, out: &mut Regressors<X>) {
        out.evaluate(self.model, self.instrument_states, self.exogenous, std::convert::identity, k, count);
    }

    /// The measured states between which Δy lies at samples `k..k + count`, where nothing is to be subtracted from it and
    /// these are a whole span.
    #[inline(always)]
    pub(crate) fn between(&self, k: usize, count: usize, d: usize) -> Option<&[[Lane; 3]; SPAN + 1]> {
        let bare = self.model.constant[d] == 0.0 && self.model.degrees[d].known.is_empty();
        let rows = self.measured.as_chunks::<3>().0[k..].first_chunk();
        rows.filter(|_| bare && count == SPAN)
    }

    /// Δy of degree of freedom `d` less the model's constant and known terms at samples `k..k + count`; zero beyond. `phi` was
    /// evaluated there.
    #[inline(always)]
    pub(crate) fn increments(
        &self,
        k: usize,
        count: usize,
        d: usize,
        phi: &Regressors<Lane>,
        out: &mut Span<Lane>,
    ) {
        copy_state(&self.measured[3 * (k + 1)..], d, count, out);
        for (own, now) in out.iter_mut().zip(&phi.signals[d]) {
            *own = *own - *now;
        }
        let constant = self.model.constant[d];
        if constant != 0.0 {
            for increment in &mut out[..count] {
                *increment = *increment - Lane::splat(constant);
            }
        }
        for known in &self.model.degrees[d].known {
            let mut gained = [Lane::ZERO; SPAN];
            known.add(&phi.signals[..phi.variables], &mut gained);
            for (increment, gained) in out[..count].iter_mut().zip(gained) {
                *increment = *increment - gained;
            }
        }
    }
}

/// Copies state `i` of `count` samples, and zeros beyond: the terms of zeros are zeros. A whole span is a loop of fixed
/// length without conditions, so that each entry moves as one vector.
#[inline(always)]
fn copy_state<X: Number>(states: &[X], i: usize, count: usize, out: &mut Span<X>) {
    let rows = states.as_chunks::<3>().0;
    match rows.first_chunk::<SPAN>() {
        Some(rows) if count == SPAN => {
            for t in 0..SPAN {
                out[t] = rows[t][i];
            }
        }
        _ => {
            *out = [X::ZERO; SPAN];
            for (value, row) in out.iter_mut().zip(&rows[..count]) {
                *value = row[i];
            }
        }
    }
}

/// [`copy_state`] of a column.
#[inline(always)]
fn copy_column<X: Number, Y: Number>(
    column: &[X],
    stride: usize,
    count: usize,
    convert: impl Fn(X) -> Y,
    out: &mut Span<Y>,
) {
    if count == SPAN {
        for (t, value) in out.iter_mut().enumerate() {
            *value = convert(column[stride * t]);
        }
    } else {
        *out = [Y::ZERO; SPAN];
        for (value, entry) in out.iter_mut().zip(column.iter().step_by(stride)).take(count) {
            *value = convert(*entry);
        }
    }
}

/// Samples that are summed up before their sum is added to the others.
pub(crate) const BLOCK: usize = 8;
/// A signal at [`BLOCK`] samples.
pub(crate) type Block<X> = [X; BLOCK];

/// Samples at which the terms of any model are evaluated at once: several blocks, so that what is decided per term is
/// decided seldom, and few enough for the nearest cache.
pub(crate) const SPAN: usize = 4 * BLOCK;
/// A signal at [`SPAN`] samples.
pub(crate) type Span<X> = [X; SPAN];

/// All terms of each degree of freedom.
pub(crate) const ALL: [Range<usize>; 3] = [0..usize::MAX, 0..usize::MAX, 0..usize::MAX];

/// The variables at [`SPAN`] samples and the terms that are made of them. A term that is a variable is not copied.
pub(crate) struct Regressors<X> {
    /// Variables, then what of the terms is none.
    signals: Vec<Span<X>>,
    /// Of every term, the place of its signal.
    places: Vec<usize>,
    variables: usize,
    /// The inputs and measured disturbances that are evaluated; the others stay zero.
    exogenous: Vec<usize>,
    /// The terms that are evaluated: degree of freedom, place in it, place of the signal after the variables.
    products: Vec<[usize; 3]>,
}

impl<X: Number> Regressors<X> {
    pub(crate) fn new(model: &Model) -> Self {
        Self::of(model, ALL)
    }

    /// Those terms of each degree of freedom that are in `terms`, and the variables of its known terms.
    pub(crate) fn of(model: &Model, terms: [Range<usize>; 3]) -> Self {
        let variables = model.variables.len();
        let (mut places, mut products) = (Vec::new(), Vec::new());
        let mut used: Vec<usize> =
            model.known().flat_map(|(_, known)| &known.factors).map(|f| f.variable).collect();
        let mut next = variables;
        for (d, (degree, own)) in model.degrees.iter().zip(terms).enumerate() {
            for (i, term) in degree.terms.iter().enumerate() {
                let variable = variable_of(term);
                places.push(variable.unwrap_or(next));
                if own.contains(&i) {
                    used.extend(term.products().flatten().map(|f| f.variable));
                    products.extend(variable.is_none().then_some([d, i, next - variables]));
                }
                next += usize::from(variable.is_none());
            }
        }
        let exogenous = (3..variables).filter(|i| used.contains(i)).map(|i| i - 3).collect();
        Self { signals: vec![[X::ZERO; SPAN]; next], places, variables, exogenous, products }
    }

    /// All terms.
    #[inline(always)]
    pub(crate) fn terms(&self) -> Picked<'_, X> {
        Picked { signals: &self.signals, places: &self.places }
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
            copy_state(&states[3 * k..], i, count, variable);
        }
        let width = model.exogenous();
        for i in &self.exogenous {
            copy_column(&exogenous[width * k + i..], width, count, convert, &mut others[*i]);
        }
        for [d, i, place] in &self.products {
            let (term, out) = (&model.degrees[*d].terms[*i], &mut products[*place]);
            term.values(values, out);
            if term.is_constant() {
                out[count..].fill(X::ZERO);
            }
        }
    }
}

/// The variable that a term is.
fn variable_of(term: &Term) -> Option<usize> {
    match (term.factors.as_slice(), term.tied.is_empty()) {
        ([Factor { variable, modulus: false }], true) => Some(*variable),
        _ => None,
    }
}

/// Several signals at `N` samples, whole blocks of them.
pub(crate) trait Signals<Y, const N: usize>: Copy {
    /// How many.
    fn count(self) -> usize;
    /// One of them.
    fn signal(&self, i: usize) -> &[Y; N];
}

impl<Y, const N: usize> Signals<Y, N> for &[[Y; N]] {
    #[inline(always)]
    fn count(self) -> usize {
        self.len()
    }
    #[inline(always)]
    fn signal(&self, i: usize) -> &[Y; N] {
        &self[i]
    }
}

/// Signals among others.
#[derive(Clone, Copy)]
pub(crate) struct Picked<'a, X> {
    signals: &'a [Span<X>],
    places: &'a [usize],
}

impl<X> Picked<'_, X> {
    /// Those in `range`.
    #[inline(always)]
    pub(crate) fn part(self, range: Range<usize>) -> Self {
        Self { places: &self.places[range], ..self }
    }
}

/// ζ at all samples of a batch whose runs share it, evaluated once for all that share it.
pub(crate) struct Kept<X> {
    regressors: Regressors<X>,
    /// The signals of `regressors`, span after span.
    signals: Vec<Span<X>>,
}

impl Kept<f64> {
    /// Of a batch of any model whose runs share ζ.
    pub(crate) fn of(batch: AnyBatch) -> Option<Self> {
        let AnyBatch::Shared(batch) = batch else { return None };
        let (mut regressors, mut signals) = (Regressors::new(batch.model), Vec::new());
        vessel::vectorized!(for k in (0..batch.samples()).step_by(SPAN) {
            batch.zeta(k, SPAN.min(batch.samples() - k), &mut regressors);
            signals.extend_from_slice(&regressors.signals);
        });
        Some(Self { regressors, signals })
    }
}

/// Where ζ comes from.
pub(crate) enum Zeta<'k, X> {
    /// It was kept, of the batch's first sample and all after it.
    Kept(&'k Kept<X>),
    /// It is evaluated, span by span.
    Evaluated(Regressors<X>),
}

impl<'k, X: Number> Zeta<'k, X> {
    /// ζ from sample `first` on, those in `terms` of each degree of freedom.
    pub(crate) fn new(
        kept: Option<&'k Kept<X>>,
        first: usize,
        model: &Model,
        terms: [Range<usize>; 3],
    ) -> Self {
        match kept.filter(|_| first.is_multiple_of(SPAN)) {
            Some(kept) => Self::Kept(kept),
            None => Self::Evaluated(Regressors::of(model, terms)),
        }
    }

    /// Its terms at samples `k..k + count`, `count` ≤ [`SPAN`]. What is beyond is finite, and zero after
    /// the batch's last.
    #[inline(always)]
    pub(crate) fn at(&mut self, batch: &Batch<X>, k: usize, count: usize) -> Picked<'_, X> {
        match self {
            Self::Kept(Kept { regressors, signals }) => {
                let width = regressors.signals.len();
                let signals = &signals[k / SPAN * width..][..width];
                Picked { signals, places: &regressors.places }
            }
            Self::Evaluated(regressors) => {
                batch.zeta(k, count, regressors);
                regressors.terms()
            }
        }
    }
}

impl<X: Copy> Signals<X, SPAN> for Picked<'_, X> {
    #[inline(always)]
    fn count(self) -> usize {
        self.places.len()
    }
    #[inline(always)]
    fn signal(&self, i: usize) -> &Span<X> {
        &self.signals[self.places[i]]
    }
}

/// `C` signals from `first` on.
#[inline(always)]
pub(crate) fn some_of<Y, const N: usize, const C: usize>(
    signals: &impl Signals<Y, N>,
    first: usize,
) -> [&[Y; N]; C] {
    std::array::from_fn(
        #[inline(always)]
        |i| signals.signal(first + i),
    )
}

/// Adds Σ y of every signal y to its entry of `sums`.
#[inline(always)]
pub(crate) fn add_totals<Y: Number, const N: usize>(signals: impl Signals<Y, N>, sums: &mut [Lane]) {
    accumulate(
        signals,
        sums,
        #[inline(always)]
        |_, y, sum| sum + y.lane(),
    );
}

/// Adds Σ y² of every signal y to its entry of `sums`.
#[inline(always)]
pub(crate) fn add_squares<Y: Number, const N: usize>(signals: impl Signals<Y, N>, sums: &mut [Lane]) {
    accumulate(
        signals,
        sums,
        #[inline(always)]
        |_, y, sum| y.lane().fused(y.lane(), sum),
    );
}

/// Adds Σ x y of every signal y to its entry of `sums`.
#[inline(always)]
pub(crate) fn add_products<X: Number, Y: Number, const N: usize>(
    x: &[X; N],
    signals: impl Signals<Y, N>,
    sums: &mut [Lane],
) {
    accumulate(
        signals,
        sums,
        #[inline(always)]
        |t, y, sum| x[t].lane().fused(y.lane(), sum),
    );
}

/// Adds to the entry of `sums` of every signal y what `f`(t, y(t), sum) makes of a sum, sample by sample, block by block;
/// several signals at a time, so that no addition waits for the one before it.
#[inline(always)]
pub(crate) fn accumulate<Y: Number, const N: usize>(
    signals: impl Signals<Y, N>,
    sums: &mut [Lane],
    f: impl Fn(usize, Y, Lane) -> Lane + Copy,
) {
    let count = signals.count();
    let whole = count - count % 4;
    for first in (0..whole).step_by(4) {
        add_sums::<Y, N, 4>(&signals, first, sums, f);
    }
    match count % 4 {
        3 => add_sums::<Y, N, 3>(&signals, whole, sums, f),
        2 => add_sums::<Y, N, 2>(&signals, whole, sums, f),
        1 => add_sums::<Y, N, 1>(&signals, whole, sums, f),
        _ => {}
    }
}

/// [`accumulate`] of `C` signals from `first` on.
#[allow(clippy::needless_range_loop)] // What iterators make of arrays is not always inlined, and then has no vectors.
#[inline(always)]
fn add_sums<Y: Number, const N: usize, const C: usize>(
    signals: &impl Signals<Y, N>,
    first: usize,
    sums: &mut [Lane],
    f: impl Fn(usize, Y, Lane) -> Lane,
) {
    let some: [_; C] = some_of(signals, first);
    let mut totals = [Lane::ZERO; C];
    totals.copy_from_slice(&sums[first..first + C]);
    for block in (0..N).step_by(BLOCK) {
        let mut own = [Lane::ZERO; C];
        for t in block..block + BLOCK {
            for i in 0..C {
                own[i] = f(t, some[i][t], own[i]);
            }
        }
        for i in 0..C {
            totals[i] += own[i];
        }
    }
    sums[first..first + C].copy_from_slice(&totals);
}
