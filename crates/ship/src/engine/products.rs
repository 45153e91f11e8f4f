//! Terms and parts of their derivatives as products of two places each.

use crate::model::{Factor, Model};
use numerics::Arithmetic;

/// A part of the derivative of one parameter's term by `variable`, by the product rule.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slope {
    pub parameter: usize,
    pub degree: usize,
    pub variable: usize,
    pub places: [usize; 2],
}

/// A part of the derivative of one parameter's term by `state` and by `variable`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Curve {
    pub parameter: usize,
    pub degree: usize,
    pub state: usize,
    pub variable: usize,
    pub places: [usize; 2],
}

/// The place that holds one.
pub(crate) const ONE: usize = 0;

/// Sets the places of u, v relative to the water, which moves with `current`, and of r.
#[inline(always)]
pub(crate) fn put_state<X: Arithmetic>(
    places: &mut [X],
    state: &[X; 3],
    current: impl Fn(X::Place) -> [f64; 2],
) {
    places[1] = state[0] - X::of(|place| current(place)[0]);
    places[2] = state[1] - X::of(|place| current(place)[1]);
    places[3] = state[2];
}

/// Products of two places each, in consecutive places from `first` on.
#[derive(Clone, Debug)]
pub(crate) struct Products {
    pub first: usize,
    pub pairs: Vec<[usize; 2]>,
}

impl Products {
    pub fn after(first: usize) -> Self {
        Self { first, pairs: Vec::new() }
    }

    /// Two places whose product is that of all of `places`.
    pub fn pair(&mut self, places: impl Iterator<Item = usize>) -> [usize; 2] {
        let mut pair = [ONE, ONE];
        for (i, place) in places.enumerate() {
            if i > 1 {
                let leading = self.first + self.pairs.len();
                self.pairs.push(pair);
                pair = [leading, ONE];
            }
            pair[i.min(1)] = place;
        }
        pair
    }

    #[inline(always)]
    pub fn evaluate<X: Arithmetic>(&self, places: &mut [X]) {
        for (i, [one, two]) in self.pairs.iter().enumerate() {
            places[self.first + i] = places[*one] * places[*two];
        }
    }
}

/// Parts of derivatives, with their products and signs.
#[derive(Clone, Debug)]
pub(crate) struct Derivatives<T> {
    signs: Vec<usize>,
    products: Products,
    pub parts: Vec<T>,
}

impl<T> Derivatives<T> {
    /// Calls `add` with every product (its parameter, its degree of freedom, the place of its coefficient),
    /// and reserves the places it needs. Known terms count as parameters after all others.
    #[cold]
    #[inline(never)]
    fn new<X: Arithmetic>(
        model: &Model,
        places: &mut Vec<X>,
        mut add: impl FnMut(&mut Self, usize, usize, AsWritten),
    ) -> Self {
        let products = Products::after(places.len());
        let mut all = Self { signs: Vec::new(), products, parts: Vec::new() };
        let (mut parameter, mut coefficients) = (0, first_coefficient(model)..);
        for (degree, terms) in model.degrees.iter().map(|d| &d.terms).enumerate() {
            for term in terms {
                add(&mut all, parameter, degree, (&term.factors, None));
                for (tied, coefficient) in term.tied.iter().zip(&mut coefficients) {
                    add(&mut all, parameter, degree, (&tied.factors, Some(coefficient)));
                }
                parameter += 1;
            }
        }
        for (i, (degree, known)) in model.known().enumerate() {
            add(&mut all, parameter + i, degree, (&known.factors, None));
        }
        places.resize(places.len() + all.products.pairs.len(), X::ONE);
        all
    }

    /// Two places whose product is `term` without its factors `dropped`, times the inner derivatives of these.
    fn rest(&mut self, model: &Model, (factors, coefficient): AsWritten, dropped: &[usize]) -> [usize; 2] {
        let variables = model.variables.len();
        let moduli = || dropped.iter().map(|i| factors[*i]).filter(|factor| factor.modulus);
        moduli().for_each(|factor| note(&mut self.signs, factor.variable));
        let kept = factors.iter().enumerate().filter(|(i, _)| !dropped.contains(i));
        let signs = moduli().map(|factor| 1 + 2 * variables + factor.variable);
        let all = kept.map(|(_, factor)| place(*factor, variables)).chain(signs);
        self.products.pair(all.chain(coefficient))
    }

    #[inline(always)]
    pub fn evaluate<X: Arithmetic>(&self, variables: usize, places: &mut [X]) {
        for variable in &self.signs {
            places[1 + 2 * variables + variable] = places[1 + variable].sign();
        }
        self.products.evaluate(places);
    }
}

impl Derivatives<Slope> {
    /// By those variables that are states, or by the others.
    pub fn once<X: Arithmetic>(model: &Model, places: &mut Vec<X>, states: bool) -> Self {
        Self::new(model, places, |derivatives, parameter, degree, term| {
            for (i, Factor { variable, .. }) in term.0.iter().enumerate() {
                if (*variable < 3) == states {
                    let places = derivatives.rest(model, term, &[i]);
                    derivatives.parts.push(Slope { parameter, degree, variable: *variable, places });
                }
            }
        })
    }
}

impl Derivatives<Curve> {
    /// By a state and by any variable.
    pub fn twice<X: Arithmetic>(model: &Model, places: &mut Vec<X>) -> Self {
        Self::new(model, places, |derivatives, parameter, degree, term| {
            for (i, Factor { variable: state, .. }) in term.0.iter().enumerate() {
                for (j, Factor { variable, .. }) in term.0.iter().enumerate() {
                    if *state < 3 && i != j {
                        let places = derivatives.rest(model, term, &[i, j]);
                        derivatives.parts.push(Curve {
                            parameter,
                            degree,
                            state: *state,
                            variable: *variable,
                            places,
                        });
                    }
                }
            }
        })
    }
}

/// The factors of a product, and the place of its coefficient, if it has one.
type AsWritten<'a> = (&'a [Factor], Option<usize>);

/// The place of the first coefficient of tied terms: after one, the variables, their moduli and signs.
pub(crate) fn first_coefficient(model: &Model) -> usize {
    1 + 3 * model.variables.len()
}

pub(crate) fn place(factor: Factor, variables: usize) -> usize {
    1 + factor.variable + if factor.modulus { variables } else { 0 }
}

pub(crate) fn note(variables: &mut Vec<usize>, variable: usize) {
    if !variables.contains(&variable) {
        variables.push(variable);
    }
}
