use crate::{Factor, Model, Number, Term};

/// A model with its parameters, compiled to products of two places each, so that a step decides nothing. Places hold one,
/// every variable, its modulus, its sign, and the leading products of whatever has more than two factors. `X` is a
/// [`crate::Lane`] for runs side by side, or `f64` for a single one.
///
/// [`Self::look`] goes to a point; what is asked there is computed then. Derivatives are compiled when first asked for:
/// who wants values alone pays for nothing else.
#[derive(Clone, Debug)]
pub struct Compiled<'m, X> {
    model: &'m Model,
    variables: usize,
    parameters: Vec<X>,
    moduli: Vec<usize>,
    products: Products,
    terms: Vec<[usize; 2]>,
    sums: [Vec<Weighted<X>>; 3],
    by_state: Option<Derivatives<Slope>>,
    by_exogenous: Option<Derivatives<Slope>>,
    twice: Option<Derivatives<Curve>>,
    places: Vec<X>,
}

/// What acts on a vessel during a sample besides its inputs; nothing by default.
#[derive(Clone, Copy, Debug)]
pub struct Ambient<X> {
    /// Velocity of the water in body axes: surge and sway \[m/s\].
    pub current: Option<[X; 2]>,
    /// What is added to u, v \[m/s\] and r \[rad/s\] by the end of the sample.
    pub force: Option<[X; 3]>,
}

impl<X> Default for Ambient<X> {
    fn default() -> Self {
        Self { current: None, force: None }
    }
}

/// A parameter and the two places of its term.
#[derive(Clone, Copy, Debug)]
struct Weighted<X> {
    parameter: X,
    places: [usize; 2],
}

/// A part of the derivative of one parameter's term by `variable`, by the product rule.
#[derive(Clone, Copy, Debug)]
struct Slope {
    parameter: usize,
    degree: usize,
    variable: usize,
    places: [usize; 2],
}

/// A part of the derivative of one parameter's term by `state` and by `variable`.
#[derive(Clone, Copy, Debug)]
struct Curve {
    parameter: usize,
    degree: usize,
    state: usize,
    variable: usize,
    places: [usize; 2],
}

/// The place that holds one.
const ONE: usize = 0;

/// Products of two places each, which stand after one another from place `first` on.
#[derive(Clone, Debug)]
struct Products {
    first: usize,
    pairs: Vec<[usize; 2]>,
}

impl Products {
    fn after(first: usize) -> Self {
        Self { first, pairs: Vec::new() }
    }

    /// Two places whose product is that of all of `places`.
    fn pair(&mut self, places: impl Iterator<Item = usize>) -> [usize; 2] {
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
    fn evaluate<X: Number>(&self, places: &mut [X]) {
        for (i, [one, two]) in self.pairs.iter().enumerate() {
            places[self.first + i] = places[*one] * places[*two];
        }
    }
}

/// Parts of derivatives, with the products and signs that they take.
#[derive(Clone, Debug)]
struct Derivatives<T> {
    signs: Vec<usize>,
    products: Products,
    parts: Vec<T>,
}

impl<T> Derivatives<T> {
    /// Calls `add` with every term (its parameter and its degree of freedom), and makes room for the products.
    #[cold]
    #[inline(never)]
    fn new<X: Number>(
        model: &Model,
        places: &mut Vec<X>,
        mut add: impl FnMut(&mut Self, usize, usize, &Term),
    ) -> Self {
        let products = Products::after(places.len());
        let mut own = Self { signs: Vec::new(), products, parts: Vec::new() };
        let mut parameter = 0;
        for (degree, terms) in model.degrees.iter().map(|d| &d.terms).enumerate() {
            for term in terms {
                add(&mut own, parameter, degree, term);
                parameter += 1;
            }
        }
        places.resize(places.len() + own.products.pairs.len(), X::ONE);
        own
    }

    /// Two places whose product is `term` without its factors `dropped`, times the inner derivatives of these.
    fn rest(&mut self, model: &Model, term: &Term, dropped: &[usize]) -> [usize; 2] {
        let variables = model.variables.len();
        let moduli = || dropped.iter().map(|i| term.factors[*i]).filter(|factor| factor.modulus);
        moduli().for_each(|factor| note(&mut self.signs, factor.variable));
        let kept = term.factors.iter().enumerate().filter(|(i, _)| !dropped.contains(i));
        let signs = moduli().map(|factor| 1 + 2 * variables + factor.variable);
        self.products.pair(kept.map(|(_, factor)| place(*factor, variables)).chain(signs))
    }

    #[inline(always)]
    fn evaluate<X: Number>(&self, variables: usize, places: &mut [X]) {
        for variable in &self.signs {
            places[1 + 2 * variables + variable] = places[1 + variable].sign();
        }
        self.products.evaluate(places);
    }
}

impl Derivatives<Slope> {
    /// By those variables that are states, or by the others.
    fn once<X: Number>(model: &Model, places: &mut Vec<X>, states: bool) -> Self {
        Self::new(model, places, |own, parameter, degree, term| {
            for (i, Factor { variable, .. }) in term.factors.iter().enumerate() {
                if (*variable < 3) == states {
                    let places = own.rest(model, term, &[i]);
                    own.parts.push(Slope { parameter, degree, variable: *variable, places });
                }
            }
        })
    }
}

impl Derivatives<Curve> {
    /// By a state and by any variable.
    fn twice<X: Number>(model: &Model, places: &mut Vec<X>) -> Self {
        Self::new(model, places, |own, parameter, degree, term| {
            for (i, Factor { variable: state, .. }) in term.factors.iter().enumerate() {
                for (j, Factor { variable, .. }) in term.factors.iter().enumerate() {
                    if *state < 3 && i != j {
                        let places = own.rest(model, term, &[i, j]);
                        own.parts.push(Curve {
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

fn place(factor: Factor, variables: usize) -> usize {
    1 + factor.variable + if factor.modulus { variables } else { 0 }
}

fn note(variables: &mut Vec<usize>, variable: usize) {
    if !variables.contains(&variable) {
        variables.push(variable);
    }
}

impl<'m, X: Number> Compiled<'m, X> {
    /// `model` with one number per parameter.
    pub fn new(model: &'m Model, parameters: &[X]) -> Self {
        let variables = model.variables.len();
        let mut products = Products::after(1 + 3 * variables);
        let (mut moduli, mut terms) = (Vec::new(), Vec::with_capacity(parameters.len()));
        let sums = model.degrees.each_ref().map(|degree| {
            let first = terms.len();
            for term in &degree.terms {
                let used = term.factors.iter().filter(|factor| factor.modulus);
                used.for_each(|factor| note(&mut moduli, factor.variable));
                terms.push(products.pair(term.factors.iter().map(|factor| place(*factor, variables))));
            }
            let weighted = |i: usize| Weighted { parameter: parameters[i], places: terms[i] };
            (first..terms.len()).map(weighted).collect()
        });
        let places = vec![X::ONE; products.first + products.pairs.len()];
        let parameters = parameters.to_vec();
        let (by_state, by_exogenous, twice) = (None, None, None);
        Self {
            model,
            variables,
            parameters,
            moduli,
            products,
            terms,
            sums,
            by_state,
            by_exogenous,
            twice,
            places,
        }
    }

    /// The model.
    pub fn model(&self) -> &'m Model {
        self.model
    }

    /// Goes to a state (u, v over ground \[m/s\], r \[rad/s\]) and one number per input and measured disturbance, in a
    /// current of surge and sway components in body axes \[m/s\].
    #[inline(always)]
    pub fn look<E: Copy + Into<X>>(&mut self, state: [X; 3], exogenous: &[E], current: Option<[X; 2]>) {
        let Self { variables, moduli, products, places, .. } = self;
        places[1..4].copy_from_slice(&state);
        if let Some([along, across]) = current {
            places[1] = state[0] - along;
            places[2] = state[1] - across;
        }
        for (place, value) in places[4..=*variables].iter_mut().zip(exogenous) {
            *place = (*value).into();
        }
        for variable in moduli {
            places[1 + *variables + *variable] = places[1 + *variable].modulus();
        }
        products.evaluate(places);
    }

    /// φ of parameter `i`.
    #[inline(always)]
    pub fn term(&self, i: usize) -> X {
        let [one, two] = self.terms[i];
        self.places[one] * self.places[two]
    }

    /// θᵀφ of surge, sway and yaw.
    #[inline(always)]
    pub fn increments(&self) -> [X; 3] {
        let mut sums = [X::ZERO; 3];
        for (sum, terms) in sums.iter_mut().zip(&self.sums) {
            for Weighted { parameter, places: [one, two] } in terms {
                *sum += *parameter * (self.places[*one] * self.places[*two]);
            }
        }
        sums
    }

    /// The state after `state`, which was looked at, under a force as in [`Ambient`].
    #[inline(always)]
    pub fn next(&self, state: [X; 3], force: Option<[X; 3]>) -> [X; 3] {
        let [u, v, r] = self.increments();
        let next = [state[0] + u, state[1] + v, state[2] + r];
        match force {
            Some(force) => [next[0] + force[0], next[1] + force[1], next[2] + force[2]],
            None => next,
        }
    }

    /// One sample on: x(k+1) = x(k) + θᵀφ(x(k) − x_c(k), exogenous(k)) + f(k).
    #[inline(always)]
    pub fn step<E: Copy + Into<X>>(&mut self, state: [X; 3], exogenous: &[E], ambient: Ambient<X>) -> [X; 3] {
        self.look(state, exogenous, ambient.current);
        self.next(state, ambient.force)
    }

    /// J with J\[d\]\[i\] = θ_dᵀ ∂φ_d/∂(state i). The slope of a modulus at zero is 0, here and below.
    #[inline(always)]
    pub fn slopes(&mut self) -> [[X; 3]; 3] {
        let Self { model, variables, parameters, by_state, places, .. } = self;
        let own = by_state.get_or_insert_with(|| Derivatives::once(model, places, true));
        own.evaluate(*variables, places);
        let mut slopes = [[X::ZERO; 3]; 3];
        for Slope { parameter, degree, variable, places: [one, two] } in &own.parts {
            slopes[*degree][*variable] += parameters[*parameter] * (places[*one] * places[*two]);
        }
        slopes
    }

    /// Transposed products: Σ_p `terms`\[p\] ∂φ_p/∂z + Σ_d Σ_i `slopes`\[d\]\[i\] ∂J\[d\]\[i\]/∂z for every variable z, that is the
    /// slope by z of whatever has these slopes by the terms and by J.
    #[inline(always)]
    pub fn pull_back(&mut self, terms: &[X], slopes: &[[X; 3]; 3], out: &mut [X]) {
        let Self { model, parameters, by_state, by_exogenous, twice, places, .. } = self;
        let variables = model.variables.len();
        out.fill(X::ZERO);
        for (own, states) in [(by_state, true), (by_exogenous, false)] {
            let own = own.get_or_insert_with(|| Derivatives::once(model, places, states));
            own.evaluate(variables, places);
            for Slope { parameter, variable, places: [one, two], .. } in &own.parts {
                out[*variable] += terms[*parameter] * (places[*one] * places[*two]);
            }
        }
        let own = twice.get_or_insert_with(|| Derivatives::twice(model, places));
        own.evaluate(variables, places);
        for Curve { parameter, degree, state, variable, places: [one, two] } in &own.parts {
            let weight = slopes[*degree][*state] * parameters[*parameter];
            out[*variable] += weight * (places[*one] * places[*two]);
        }
    }

    /// ∂(θ_dᵀφ_d)/∂z for every variable z: variables × 3.
    pub fn gradients(&mut self, out: &mut [[X; 3]]) {
        let Self { model, parameters, by_state, by_exogenous, places, .. } = self;
        out.fill([X::ZERO; 3]);
        for (own, states) in [(by_state, true), (by_exogenous, false)] {
            let own = own.get_or_insert_with(|| Derivatives::once(model, places, states));
            own.evaluate(model.variables.len(), places);
            for Slope { parameter, degree, variable, places: [one, two] } in &own.parts {
                out[*variable][*degree] += parameters[*parameter] * (places[*one] * places[*two]);
            }
        }
    }
}
