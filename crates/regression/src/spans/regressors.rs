use std::ops::Range;

use numerics::{Lane, Number, Numbers};
use pulp::{Simd, WithSimd};
use ship::model::{Factor, Model, Term};

use super::{Column, Difference, Modulus, Product, SPAN, Signal, Signals};
use crate::Batch;
use numerics::lanes::{parts, put};

/// The order in which the passes process the terms of a degree of freedom: first those with states, then those of inputs alone.
pub(super) struct Order {
    pub terms: Vec<usize>,
    /// The number of terms that are not the same in φ and in ζ: those with states, or all where instruments have other inputs.
    pub measured: usize,
}

impl Order {
    /// Of each degree of freedom of a batch.
    pub(super) fn of_batch<X>(batch: &Batch<X>) -> [Self; 3] {
        let is_same = std::ptr::eq(batch.exogenous, batch.instrument_exogenous);
        Self::of(batch.model).map(|order| match is_same {
            true => order,
            false => Self { measured: order.terms.len(), ..order },
        })
    }

    /// Of each degree of freedom.
    pub(super) fn of(model: &Model) -> [Self; 3] {
        model.degrees.each_ref().map(|degree| {
            let of_states = |i: &usize| degree.terms[*i].products().flatten().any(|f| f.variable < 3);
            let (mut terms, inputs): (Vec<_>, Vec<_>) = (0..degree.terms.len()).partition(of_states);
            let measured = terms.len();
            terms.extend(inputs);
            Self { terms, measured }
        })
    }
}

/// All terms of each degree of freedom.
pub(super) const ALL: [Range<usize>; 3] = [0..usize::MAX, 0..usize::MAX, 0..usize::MAX];

/// The column and the table of a signal.
#[derive(Clone, Copy)]
pub(super) enum ColumnPlace {
    State(usize),
    Input(usize),
    /// Among the signals computed span by span.
    Computed(usize),
    /// One.
    One,
}

/// Three signals at the samples of a span, row by row.
pub(super) type Table = Vec<Lane>;

/// Products of signals with their coefficients, and the index of their sum.
struct Sum {
    products: Vec<(f64, Vec<ColumnPlace>)>,
    computed: usize,
}

/// Terms of a model at the samples of a span, each as a product of two signals.
pub(super) struct Regressors<'a> {
    model: &'a Model,
    states: &'a [Lane],
    inputs: Numbers<'a>,
    /// Per degree of freedom and term its two factors.
    factors: [Vec<[ColumnPlace; 2]>; 3],
    /// The variables whose moduli are factors, and the indices of the moduli.
    moduli: Vec<(usize, ColumnPlace, usize)>,
    /// Terms with more than two factors or with others tied to them; their first products have no coefficients.
    sums: Vec<Sum>,
    /// For φ: per degree of freedom the known part of Δy, and the index of a Δy that cannot be read from the states.
    increments: Vec<Sum>,
    /// Per signal the table whose first column it is.
    computed: Vec<Table>,
    /// Likewise the inputs that are factors, if they cannot be read in place.
    copied: Vec<(usize, Table)>,
    /// The span: its first sample, whether all is read in place, and if not the states, zero beyond.
    k: usize,
    whole: bool,
    last: Table,
    /// Ones of such a span.
    ones: Table,
}

impl<'a> Regressors<'a> {
    /// φ of a batch, with the terms of each degree of freedom whose indices are in `terms`; and Δy.
    pub(super) fn phi<X: Number>(batch: &Batch<'a, X>, terms: [Range<usize>; 3]) -> Self {
        let mut regressors = Self::of(batch.model, batch.measured, X::numbers(batch.exogenous), terms);
        for degree in &batch.model.degrees {
            let known =
                degree.known.iter().map(|known| (known.coefficient, regressors.places(&known.factors)));
            let (products, computed) = (known.collect(), regressors.place());
            regressors.increments.push(Sum { products, computed });
        }
        regressors
    }

    /// ζ of a batch, likewise.
    pub(super) fn zeta(batch: &Batch<'a, Lane>, terms: [Range<usize>; 3]) -> Self {
        Self::of(batch.model, batch.instrument_states, Numbers::Lanes(batch.instrument_exogenous), terms)
    }

    fn of(model: &'a Model, states: &'a [Lane], inputs: Numbers<'a>, terms: [Range<usize>; 3]) -> Self {
        let mut regressors = Self {
            model,
            states,
            inputs,
            factors: Default::default(),
            moduli: Vec::new(),
            sums: Vec::new(),
            increments: Vec::new(),
            computed: Vec::new(),
            copied: Vec::new(),
            k: 0,
            whole: true,
            last: Table::new(),
            ones: Table::new(),
        };
        for (d, (order, range)) in Order::of(model).iter().zip(terms).enumerate() {
            for i in range.start..range.end.min(order.terms.len()) {
                let factors = regressors.term(&model.degrees[d].terms[order.terms[i]]);
                regressors.factors[d].push(factors);
            }
        }
        regressors
    }

    /// Two signals whose product is a term.
    fn term(&mut self, term: &Term) -> [ColumnPlace; 2] {
        let factors = self.places(&term.factors);
        match factors[..] {
            [] if term.tied.is_empty() => [ColumnPlace::One; 2],
            [one] if term.tied.is_empty() => [one, ColumnPlace::One],
            [one, two] if term.tied.is_empty() => [one, two],
            _ => {
                let tied = term.tied.iter().map(|tied| (tied.coefficient, self.places(&tied.factors)));
                let products = [(1.0, factors)].into_iter().chain(tied).collect();
                let computed = self.place();
                self.sums.push(Sum { products, computed });
                [ColumnPlace::Computed(computed), ColumnPlace::One]
            }
        }
    }

    /// Allocates an index for a computed signal.
    fn place(&mut self) -> usize {
        self.computed.push(Table::new());
        self.computed.len() - 1
    }

    fn places(&mut self, factors: &[Factor]) -> Vec<ColumnPlace> {
        factors.iter().map(|factor| self.factor(*factor)).collect()
    }

    fn factor(&mut self, Factor { variable, modulus }: Factor) -> ColumnPlace {
        if !modulus {
            return self.variable(variable);
        }
        let known = self.moduli.iter().find(|(of, ..)| *of == variable).map(|(.., computed)| *computed);
        ColumnPlace::Computed(known.unwrap_or_else(|| {
            let (place, computed) = (self.variable(variable), self.place());
            self.moduli.push((variable, place, computed));
            computed
        }))
    }

    fn variable(&mut self, variable: usize) -> ColumnPlace {
        if variable < 3 {
            return ColumnPlace::State(variable);
        }
        let input = variable - 3;
        let known = self.copied.iter().position(|(of, _)| *of == input);
        ColumnPlace::Input(known.unwrap_or_else(|| {
            self.copied.push((input, Table::new()));
            self.copied.len() - 1
        }))
    }

    /// Moves to samples `k..k + count`, `count` ≤ [`SPAN`]; all is zero beyond, and only the last span is shorter.
    #[inline(always)]
    pub(super) fn go_to(&mut self, k: usize, count: usize) {
        (self.k, self.whole) = (k, count == SPAN);
        if !self.whole {
            self.last = self.states[3 * k..3 * (k + count)].to_vec();
            self.ones = vec![Lane::ONE; 3 * count];
            self.last.resize(3 * SPAN, Lane::ZERO);
            self.ones.resize(3 * SPAN, Lane::ZERO);
        }
        self.copy_inputs(count);
        for i in 0..self.moduli.len() {
            let (_, place, computed) = self.moduli[i];
            self.compute(computed, |regressors, out| fill(Modulus(regressors.column(place)), out));
        }
        for i in 0..self.sums.len() {
            self.compute(self.sums[i].computed, |regressors, out| {
                let [(_, first), tied @ ..] = &regressors.sums[i].products[..] else { return };
                regressors.multiply(first, out);
                regressors.add(tied, out);
            });
        }
        for d in 0..self.increments.len() {
            if !self.read_increments(d) {
                self.compute(self.increments[d].computed, |regressors, out| {
                    regressors.increase(d, count, out)
                });
            }
        }
    }

    /// The inputs, if they are read in place.
    #[inline(always)]
    fn read_inputs(&self) -> Option<&'a [Lane]> {
        match self.inputs {
            Numbers::Lanes(inputs) if self.whole && self.model.exogenous() == 3 => Some(inputs),
            _ => None,
        }
    }

    #[inline(always)]
    fn copy_inputs(&mut self, count: usize) {
        if self.read_inputs().is_some() {
            return;
        }
        let width = self.model.exogenous();
        for (i, table) in &mut self.copied {
            table.resize(3 * SPAN, Lane::ZERO);
            let first = width * self.k + *i;
            let rows = table.chunks_exact_mut(3).take(count).enumerate();
            match self.inputs {
                Numbers::Lanes(inputs) => rows.for_each(|(t, row)| row[0] = inputs[first + width * t]),
                Numbers::Shared(inputs) => {
                    rows.for_each(|(t, row)| row[0] = Lane::splat(inputs[first + width * t]));
                }
            }
            table[3 * count..].fill(Lane::ZERO);
        }
    }

    /// Computes a signal with `f`.
    #[inline(always)]
    fn compute(&mut self, computed: usize, f: impl Fn(&Self, &mut Table)) {
        let mut out = std::mem::take(&mut self.computed[computed]);
        out.resize(3 * SPAN, Lane::ZERO);
        f(self, &mut out);
        self.computed[computed] = out;
    }

    /// The product of some signals.
    #[inline(always)]
    fn multiply(&self, factors: &[ColumnPlace], out: &mut Table) {
        let first = |i: usize| self.column(factors.get(i).copied().unwrap_or(ColumnPlace::One));
        fill(Product([first(0), first(1)]), out);
        for factor in factors.iter().skip(2) {
            let column = self.column(*factor);
            (0..SPAN).for_each(|t| out[3 * t] = out[3 * t] * column.entry(t));
        }
    }

    /// Adds products with their coefficients.
    #[inline(always)]
    fn add(&self, products: &[(f64, Vec<ColumnPlace>)], out: &mut Table) {
        let mut product = vec![Lane::ZERO; 3 * SPAN];
        for (coefficient, factors) in products {
            self.multiply(factors, &mut product);
            (0..SPAN).for_each(|t| out[3 * t] += Lane::splat(*coefficient) * product[3 * t]);
        }
    }

    /// Δy less the model's constant and known terms.
    #[inline(always)]
    fn increase(&self, d: usize, count: usize, out: &mut Table) {
        let rows = self.states.as_chunks::<3>().0;
        let constant = Lane::splat(self.model.constant[d]);
        for t in 0..count {
            out[3 * t] = rows[self.k + t + 1][d] - rows[self.k + t][d];
            out[3 * t] = out[3 * t] - constant;
        }
        for known in &self.increments[d].products {
            let mut gained = vec![Lane::ZERO; 3 * SPAN];
            self.add(std::slice::from_ref(known), &mut gained);
            (0..count).for_each(|t| out[3 * t] = out[3 * t] - gained[3 * t]);
        }
        out[3 * count..].fill(Lane::ZERO);
    }

    #[inline(always)]
    fn column(&self, place: ColumnPlace) -> Column<'_> {
        let entries = match place {
            ColumnPlace::State(i) if self.whole => &self.states[3 * self.k + i..],
            ColumnPlace::State(i) => &self.last[i..],
            ColumnPlace::Input(i) => match self.read_inputs() {
                Some(inputs) => &inputs[3 * self.k + self.copied[i].0..],
                None => &self.copied[i].1,
            },
            ColumnPlace::Computed(i) => &self.computed[i],
            ColumnPlace::One if self.whole => return Column::ONE,
            ColumnPlace::One => &self.ones,
        };
        Column::of(entries)
    }

    /// Whether Δy is read from the states.
    #[inline(always)]
    fn read_increments(&self, d: usize) -> bool {
        self.whole && self.model.constant[d] == 0.0 && self.increments[d].products.is_empty()
    }

    /// Δy of degree of freedom `d` less the model's constant and known terms.
    #[inline(always)]
    pub(super) fn increments(&self, d: usize) -> Difference<'_> {
        if self.read_increments(d) {
            let after = &self.states[3 * (self.k + 1) + d..];
            Difference([Column::of(after), self.column(ColumnPlace::State(d))])
        } else {
            Difference([self.column(ColumnPlace::Computed(self.increments[d].computed)), Column::ZERO])
        }
    }

    /// The terms of degree of freedom `d`.
    #[inline(always)]
    pub(super) fn terms(&self, d: usize) -> Products<'_> {
        Products { table: self, factors: &self.factors[d] }
    }
}

/// Terms as products of two signals.
#[derive(Clone, Copy)]
pub(super) struct Products<'s> {
    table: &'s Regressors<'s>,
    factors: &'s [[ColumnPlace; 2]],
}

impl<'s> Signals for Products<'s> {
    type One = Product<'s>;
    const ZERO: Self::One = Product([Column::ZERO; 2]);

    #[inline(always)]
    fn count(self) -> usize {
        self.factors.len()
    }

    #[inline(always)]
    fn one(self, i: usize) -> Product<'s> {
        let [one, two] = self.factors[i];
        Product([self.table.column(one), self.table.column(two)])
    }

    #[inline(always)]
    fn part(self, range: Range<usize>) -> Self {
        Self { factors: &self.factors[range], ..self }
    }
}

/// Writes a signal into the first column of a table.
#[inline(always)]
pub(super) fn fill(signal: impl Signal, out: &mut Table) {
    numerics::dispatch(Fill { signal, out });
}

struct Fill<'a, T> {
    signal: T,
    out: &'a mut Table,
}

impl<T: Signal> WithSimd for Fill<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { signal, out } = self;
        for at in 0..parts::<S>() {
            for (t, row) in out.as_chunks_mut::<3>().0.iter_mut().take(SPAN).enumerate() {
                put::<S>(&mut row[0], at, signal.at(simd, t, at));
            }
        }
    }
}
