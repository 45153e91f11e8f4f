//! Models of a common shape: loops count to lengths that are known when the program is compiled.

use crate::products::{ONE, put_state};
use crate::{Ambient, Arithmetic, Compiled, Row, Step};

/// How many places there are; a mask of indices.
const PLACES: usize = 64;

/// A [`Compiled`] model each of whose degrees of freedom adds up at most `L` places, then at most `P` products of two places,
/// then at most `I` inputs or measured disturbances. What a degree of freedom has less of is filled with terms that add
/// zero. It gives the same bits: no sum is −0, for each starts from a constant that is not.
#[derive(Clone, Debug)]
pub struct Shaped<X, const L: usize, const P: usize, const I: usize> {
    exogenous: usize,
    /// Inputs and measured disturbances that products are made of: those have places.
    placed: Vec<usize>,
    /// Per modulus its variable's place and its own.
    moduli: Vec<[usize; 2]>,
    /// Per leading product its two places and its own.
    products: Vec<[usize; 3]>,
    constant: [X; 3],
    linear: [[(X, usize); L]; 3],
    pairs: [[(X, [usize; 2]); P]; 3],
    inputs: [[(X, usize); I]; 3],
    places: Box<[X; PLACES]>,
}

impl<X: Arithmetic, const L: usize, const P: usize, const I: usize> Shaped<X, L, P, I> {
    /// `model`, where it has this shape and two thirds of its terms: with fewer, it is faster as it is.
    pub fn new(model: &Compiled<X>) -> Option<Self> {
        let parts = model.parts()?;
        let exogenous = parts.variables - 3;
        let input =
            |[one, two]: [usize; 2]| (two == ONE && (4..=parts.variables).contains(&one)).then(|| one - 4);
        let mut own = Self {
            exogenous,
            placed: Vec::new(),
            moduli: parts.moduli,
            products: parts.products,
            constant: parts.constant,
            linear: [[(X::ZERO, ONE); L]; 3],
            pairs: [[(X::ZERO, [ONE; 2]); P]; 3],
            inputs: [[(X::ZERO, 0); I]; 3],
            places: Box::new([X::ONE; PLACES]),
        };
        let mut used: Vec<usize> = own.moduli.iter().map(|[variable, _]| *variable).collect();
        used.extend(own.products.iter().flat_map(|[one, two, _]| [*one, *two]));
        let terms: usize = parts.sums.iter().map(Vec::len).sum();
        if parts.places > PLACES || exogenous == 0 || terms < 2 * (L + P + I) {
            return None;
        }
        for (d, terms) in parts.sums.iter().enumerate() {
            let last = terms.iter().rev().take(I).take_while(|(_, places)| input(*places).is_some()).count();
            let (terms, inputs) = terms.split_at(terms.len() - last);
            let first = terms.iter().take(L).take_while(|(_, [_, two])| *two == ONE).count();
            let (linear, pairs) = terms.split_at(first);
            if pairs.len() > P {
                return None;
            }
            for (own, (parameter, [one, _])) in own.linear[d].iter_mut().zip(linear) {
                *own = (*parameter, *one);
            }
            for (own, pair) in own.pairs[d].iter_mut().zip(pairs) {
                *own = *pair;
            }
            for (own, (parameter, places)) in own.inputs[d].iter_mut().zip(inputs) {
                *own = (*parameter, input(*places)?);
            }
            used.extend(terms.iter().flat_map(|(_, places)| *places));
        }
        own.placed = (0..exogenous).filter(|i| used.contains(&(4 + i))).collect();
        Some(own)
    }

    /// Adds to `state` what it gains; u, v, r through the water have their places.
    #[inline(always)]
    fn gain(&mut self, state: &mut [X; 3], exogenous: impl Fn(usize) -> X) {
        let Self { placed, moduli, products, places, .. } = self;
        for i in placed.iter() {
            places[(4 + i) % PLACES] = exogenous(*i);
        }
        for [variable, own] in moduli.iter() {
            places[own % PLACES] = places[variable % PLACES].modulus();
        }
        for [one, two, own] in products.iter() {
            places[own % PLACES] = places[one % PLACES] * places[two % PLACES];
        }
        // Three calls, and no loop, so that the state can stay in registers.
        state[0] += self.sum(0, &exogenous);
        state[1] += self.sum(1, &exogenous);
        state[2] += self.sum(2, &exogenous);
    }

    /// What degree of freedom `d` gains.
    #[allow(clippy::needless_range_loop)] // Loops over indices are unrolled.
    #[inline(always)]
    fn sum(&self, d: usize, exogenous: impl Fn(usize) -> X) -> X {
        let Self { constant, linear, pairs, inputs, places, .. } = self;
        let mut sum = constant[d];
        for i in 0..L {
            let (parameter, place) = &linear[d][i];
            sum += *parameter * places[place % PLACES];
        }
        for i in 0..P {
            let (parameter, [one, two]) = &pairs[d][i];
            sum += *parameter * (places[one % PLACES] * places[two % PLACES]);
        }
        for i in 0..I {
            let (parameter, input) = &inputs[d][i];
            sum += *parameter * exogenous(*input);
        }
        sum
    }
}

impl<X: Arithmetic, const L: usize, const P: usize, const I: usize> Step<X> for Shaped<X, L, P, I> {
    #[inline(always)]
    fn step<E: Copy + Into<X>>(&mut self, state: [X; 3], exogenous: &[E], ambient: Ambient<X>) -> [X; 3] {
        let [along, across] = ambient.current.unwrap_or([X::ZERO; 2]);
        self.places[1..4].copy_from_slice(&[state[0] - along, state[1] - across, state[2]]);
        let mut state = state;
        self.gain(
            &mut state,
            #[inline(always)]
            |i| exogenous[i].into(),
        );
        if let Some(force) = ambient.force {
            state.iter_mut().zip(force).for_each(|(state, force)| *state += force);
        }
        state
    }

    #[inline(always)]
    fn advance(
        &mut self,
        state: &mut [X; 3],
        exogenous: impl Row<X>,
        current: impl Fn(X::Place) -> [f64; 2],
    ) {
        put_state(&mut *self.places, state, current);
        let exogenous = exogenous.up_to(self.exogenous);
        self.gain(
            state,
            #[inline(always)]
            |i| {
                X::of(
                    #[inline(always)]
                    |place| exogenous.entry(i, place),
                )
            },
        );
    }
}
