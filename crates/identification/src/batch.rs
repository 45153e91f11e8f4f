use vessel::{LANES, Lane, Model, Number, Numbers};

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
        let (mut now, mut next) = ([Lane::ZERO; BLOCK], [Lane::ZERO; BLOCK]);
        copy_column(&self.measured[3 * k + d..], 3, count, Lane::lane, &mut now);
        copy_column(&self.measured[3 * (k + 1) + d..], 3, count, Lane::lane, &mut next);
        for t in 0..BLOCK {
            next[t] = next[t] - now[t];
        }
        let constant = self.model.constant[d];
        if constant != 0.0 {
            for increment in &mut next[..count] {
                *increment = *increment - Lane::splat(constant);
            }
        }
        for known in &self.model.degrees[d].known {
            let mut gained = [Lane::ZERO; BLOCK];
            known.add(&phi.values, &mut gained);
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

/// The terms' values at [`BLOCK`] samples, and the variables that they were evaluated with.
pub(crate) struct Regressors<X> {
    values: Vec<Block<X>>,
    /// One per parameter.
    pub(crate) terms: Vec<Block<X>>,
}

impl<X: Number> Regressors<X> {
    pub(crate) fn new(model: &Model) -> Self {
        let zeros = |count| vec![[X::ZERO; BLOCK]; count];
        Self { values: zeros(model.variables.len()), terms: zeros(model.parameters()) }
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
        let (own, others) = self.values.split_at_mut(3);
        for (i, variable) in own.iter_mut().enumerate() {
            copy_column(&states[3 * k + i..], 3, count, std::convert::identity, variable);
        }
        let width = model.exogenous();
        for (i, variable) in others.iter_mut().enumerate() {
            copy_column(&exogenous[width * k + i..], width, count, convert, variable);
        }
        let terms = model.degrees.iter().flat_map(|d| &d.terms);
        for (term, out) in terms.zip(&mut self.terms) {
            term.values(&self.values, out);
            if term.is_constant() {
                out[count..].fill(X::ZERO);
            }
        }
    }
}

/// Adds Σ y of every signal y to its entry of `sums`.
#[inline(always)]
pub(crate) fn add_totals<Y: Number>(signals: &[Block<Y>], sums: &mut [Lane]) {
    accumulate(
        signals,
        sums,
        #[inline(always)]
        |_, y, sum| sum + y.lane(),
    );
}

/// Adds Σ y² of every signal y to its entry of `sums`.
#[inline(always)]
pub(crate) fn add_squares<Y: Number>(signals: &[Block<Y>], sums: &mut [Lane]) {
    accumulate(
        signals,
        sums,
        #[inline(always)]
        |_, y, sum| y.lane().fused(y.lane(), sum),
    );
}

/// Adds Σ x y of every signal y to its entry of `sums`.
#[inline(always)]
pub(crate) fn add_products<X: Number, Y: Number>(x: &Block<X>, signals: &[Block<Y>], sums: &mut [Lane]) {
    accumulate(
        signals,
        sums,
        #[inline(always)]
        |t, y, sum| x[t].lane().fused(y.lane(), sum),
    );
}

/// Adds to the entry of `sums` of every signal y what `f`(t, y(t), sum) makes of a sum, sample by sample; several signals at a time, so that no addition waits for
/// the one before it.
#[inline(always)]
pub(crate) fn accumulate<Y: Number>(
    signals: &[Block<Y>],
    sums: &mut [Lane],
    f: impl Fn(usize, Y, Lane) -> Lane + Copy,
) {
    let (fours, rest) = signals.as_chunks::<4>();
    let (of_fours, of_rest) = sums.split_at_mut(4 * fours.len());
    for (signals, sums) in fours.iter().zip(of_fours.as_chunks_mut().0) {
        add_sums(signals, sums, f);
    }
    match rest {
        [a, b, c] => add_sums(&[*a, *b, *c], &mut of_rest.as_chunks_mut::<3>().0[0], f),
        _ => {
            // No function that is handed to an iterator: it may be compiled on its own, for the oldest processor.
            for (y, sum) in rest.iter().zip(of_rest.as_chunks_mut().0) {
                add_sums(&[*y], sum, f);
            }
        }
    }
}

#[inline(always)]
fn add_sums<Y: Number, const N: usize>(
    signals: &[Block<Y>; N],
    sums: &mut [Lane; N],
    f: impl Fn(usize, Y, Lane) -> Lane,
) {
    let mut own = [0; N].map(|_| Lane::ZERO);
    for t in 0..BLOCK {
        for (own, signal) in own.iter_mut().zip(signals) {
            *own = f(t, signal[t], *own);
        }
    }
    for (sum, own) in sums.iter_mut().zip(own) {
        *sum += own;
    }
}
