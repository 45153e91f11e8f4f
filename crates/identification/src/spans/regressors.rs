use std::ops::Range;

use vessel::{Factor, Lane, Model, Number, Term};

use crate::Batch;
use crate::batch::BLOCK;

/// Samples at which terms are evaluated at once: several blocks, so that what is decided per term is decided seldom, and few
/// enough for the nearest cache.
pub(super) const SPAN: usize = 4 * BLOCK;
/// A signal at [`SPAN`] samples.
pub(super) type Span<X> = [X; SPAN];

/// After how many terms of each degree of freedom all are made of inputs alone: those are the same in φ and in ζ.
pub(super) fn measured(model: &Model) -> [usize; 3] {
    let of_state = |term: &Term| term.products().flatten().any(|f| f.variable < 3);
    model.degrees.each_ref().map(|degree| degree.terms.iter().rposition(of_state).map_or(0, |last| last + 1))
}

/// All terms of each degree of freedom.
pub(super) const ALL: [Range<usize>; 3] = [0..usize::MAX, 0..usize::MAX, 0..usize::MAX];

/// The variables at [`SPAN`] samples and the terms that are made of them. A term that is a variable is not copied.
pub(super) struct Regressors<X> {
    /// Variables, then what of the terms is none.
    pub signals: Vec<Span<X>>,
    /// Of every term, the place of its signal.
    pub places: Vec<usize>,
    variables: usize,
    /// The variables that are evaluated, u, v, r and then the others; what is not stays zero.
    states: Vec<usize>,
    exogenous: Vec<usize>,
    /// The terms that are evaluated: degree of freedom, place in it, place of the signal after the variables.
    products: Vec<[usize; 3]>,
}

impl<X: Number> Regressors<X> {
    /// Those terms of each degree of freedom that are in `terms`, and the variables of its known terms.
    pub(super) fn of(model: &Model, terms: [Range<usize>; 3]) -> Self {
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
        let of = |range: Range<usize>| range.filter(|i| used.contains(i));
        let (states, exogenous) = (of(0..3).collect(), of(3..variables).map(|i| i - 3).collect());
        Self { signals: vec![[X::ZERO; SPAN]; next], places, variables, states, exogenous, products }
    }

    /// All terms.
    #[inline(always)]
    pub(super) fn terms(&self) -> Picked<'_, X> {
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
        for i in &self.states {
            copy_state(&states[3 * k..], *i, count, &mut own[*i]);
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

impl<X: Number> Batch<'_, X> {
    /// Evaluates φ at samples `k..k + count`, `count` ≤ [`SPAN`]; zero beyond.
    #[inline(always)]
    pub(super) fn phi(&self, k: usize, count: usize, out: &mut Regressors<Lane>) {
        out.evaluate(self.model, self.measured, self.exogenous, X::lane, k, count);
    }

    /// Evaluates ζ at samples `k..k + count`, `count` ≤ [`SPAN`]; zero beyond.
    #[inline(always)]
    pub(super) fn zeta(&self, k: usize, count: usize, out: &mut Regressors<X>) {
        out.evaluate(self.model, self.instrument_states, self.exogenous, std::convert::identity, k, count);
    }

    /// The measured states between which Δy lies at samples `k..k + count`, where nothing is to be subtracted from it and
    /// these are a whole span.
    #[inline(always)]
    pub(super) fn between(&self, k: usize, count: usize, d: usize) -> Option<&[[Lane; 3]; SPAN + 1]> {
        let bare = self.model.constant[d] == 0.0 && self.model.degrees[d].known.is_empty();
        let rows = self.measured.as_chunks::<3>().0[k..].first_chunk();
        rows.filter(|_| bare && count == SPAN)
    }

    /// Δy of degree of freedom `d` less the model's constant and known terms at samples `k..k + count`; zero beyond. `phi` was
    /// evaluated there.
    #[inline(always)]
    pub(super) fn increments(
        &self,
        k: usize,
        count: usize,
        d: usize,
        phi: &Regressors<Lane>,
        out: &mut Span<Lane>,
    ) {
        let mut before = [Lane::ZERO; SPAN];
        copy_state(&self.measured[3 * k..], d, count, &mut before);
        copy_state(&self.measured[3 * (k + 1)..], d, count, out);
        for (own, before) in out.iter_mut().zip(before) {
            *own = *own - before;
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

/// The variable that a term is.
fn variable_of(term: &Term) -> Option<usize> {
    match (term.factors.as_slice(), term.tied.is_empty()) {
        ([Factor { variable, modulus: false }], true) => Some(*variable),
        _ => None,
    }
}

/// Signals among others.
#[derive(Clone, Copy)]
pub(super) struct Picked<'a, X> {
    pub signals: &'a [Span<X>],
    pub places: &'a [usize],
}

impl<X> Picked<'_, X> {
    /// How many.
    #[inline(always)]
    pub(super) fn count(self) -> usize {
        self.places.len()
    }

    /// One of them.
    #[inline(always)]
    pub(super) fn signal(&self, i: usize) -> &Span<X> {
        &self.signals[self.places[i]]
    }

    /// `C` of them, from `first` on.
    #[inline(always)]
    pub(super) fn some<const C: usize>(&self, first: usize) -> [&Span<X>; C] {
        std::array::from_fn(
            #[inline(always)]
            |i| self.signal(first + i),
        )
    }

    /// Those in `range`.
    #[inline(always)]
    pub(super) fn part(self, range: Range<usize>) -> Self {
        Self { places: &self.places[range], ..self }
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
