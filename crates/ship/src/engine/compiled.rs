use std::ops::Range;

use crate::model::{Factor, Model, RateChange, Term};
use numerics::Row;

use super::force_step::{Point, Stepping};
use crate::engine::products::{
    Curve, Derivatives, ONE, Products, Slope, first_coefficient, note, place, put_state,
};

/// A model with its parameters, compiled to products of two places each, so that a step has no branches. Places hold one, every
/// variable, its modulus, its sign, and the leading products of terms with more than two factors. Terms that are tied to each
/// other are summed in a place of their own. `X` is a [`numerics::Lane`] for lanes of runs, or `f64` for a single one.
///
/// [`Self::look`] sets a point; values there are computed on request. Derivatives are compiled on first use,
/// so that callers who only need values do not pay for them.
///
/// A model that is made of forces has no terms: its increments are a step of Runge and Kutta's method with held inputs.
#[derive(Clone, Debug)]
pub struct Compiled<'m, X: Stepping> {
    model: &'m Model,
    variables: usize,
    /// The known ones come last.
    parameters: Vec<X>,
    moduli: Vec<usize>,
    products: Products,
    terms: Vec<[usize; 2]>,
    /// By its place, the products of each sum of tied terms.
    tied: Vec<(usize, Vec<[usize; 2]>)>,
    sums: [Vec<Weighted<X>>; 3],
    constant: [X; 3],
    by_state: Option<Derivatives<Slope>>,
    by_exogenous: Option<Derivatives<Slope>>,
    twice: Option<Derivatives<Curve>>,
    places: Vec<X>,
    /// In place of terms.
    moving: Option<Box<X::Moving<'m>>>,
    /// Of the current at the point that was set \[m/s\]; only where forces move the ship.
    current: [X; 2],
    /// Where a sample is not one step of the terms.
    paced: Option<Box<Paced<X>>>,
}

/// A sample that is several steps of the terms, or a part of one.
#[derive(Clone, Debug)]
struct Paced<X> {
    /// Those of the states after one, two, … steps.
    weights: Vec<f64>,
    /// The increments from the point that was set.
    gained: [X; 3],
}

/// The disturbances of a vessel during a sample; none by default.
#[derive(Clone, Copy, Debug)]
pub struct Ambient<X> {
    /// Velocity of the water in body axes: surge and sway \[m/s\].
    pub current: Option<[X; 2]>,
    /// Added to u, v \[m/s\] and r \[rad/s\] by the end of the sample.
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

/// Places under construction.
struct Places {
    variables: usize,
    moduli: Vec<usize>,
    products: Products,
    tied: Vec<(usize, Vec<[usize; 2]>)>,
    coefficients: Range<usize>,
    sums: Range<usize>,
}

impl Places {
    fn new(model: &Model) -> Self {
        let terms = || model.degrees.iter().flat_map(|degree| &degree.terms);
        let first = first_coefficient(model);
        let coefficients = first..first + terms().map(|term| term.tied.len()).sum::<usize>();
        let sums = coefficients.end..coefficients.end + terms().filter(|term| !term.tied.is_empty()).count();
        let products = Products::after(sums.end);
        let variables = model.variables.len();
        Self { variables, moduli: Vec::new(), products, tied: Vec::new(), coefficients, sums }
    }

    /// Two places whose product is that of `factors` and the coefficient at `coefficient`.
    fn product(&mut self, factors: &[Factor], coefficient: Option<usize>) -> [usize; 2] {
        let used = factors.iter().filter(|factor| factor.modulus);
        used.for_each(|factor| note(&mut self.moduli, factor.variable));
        let own_places = factors.iter().map(|factor| place(*factor, self.variables));
        self.products.pair(own_places.chain(coefficient))
    }

    /// Two places whose product is `term`.
    fn term(&mut self, term: &Term) -> [usize; 2] {
        let product = self.product(&term.factors, None);
        if term.tied.is_empty() {
            return product;
        }
        let mut parts = vec![product];
        for tied in &term.tied {
            let coefficient = self.coefficients.next();
            parts.push(self.product(&tied.factors, coefficient));
        }
        let place = self.sums.next().unwrap_or_default();
        self.tied.push((place, parts));
        [place, ONE]
    }
}

/// The order in which terms are summed, regardless of their order in the model, so that more models share a
/// shape: states, products, inputs and measured disturbances, then the constant.
fn kind([one, two]: [usize; 2], variables: usize) -> u8 {
    match (one, two) {
        (ONE, ONE) => 3,
        (..=3, ONE) => 0,
        (_, ONE) if one <= variables => 2,
        _ => 1,
    }
}

/// The point of these variables, states first.
#[inline(always)]
fn point<X: Stepping>(variables: &[X], current: [X; 2]) -> Point<'_, X> {
    let relative = [variables[0], variables[1], variables[2]];
    Point { relative, exogenous: &variables[3..], current }
}

impl<'m, X: Stepping> Compiled<'m, X> {
    /// `model` with one number per parameter.
    pub fn new(model: &'m Model, parameters: &[X]) -> Self {
        let variables = model.variables.len();
        let mut places = Places::new(model);
        let terms: Vec<[usize; 2]> =
            model.degrees.iter().flat_map(|degree| &degree.terms).map(|term| places.term(term)).collect();
        let known: Vec<(usize, [usize; 2])> =
            model.known().map(|(d, known)| (d, places.product(&known.factors, None))).collect();
        let mut all = parameters.to_vec();
        all.extend(model.known().map(|(_, known)| X::from(known.coefficient)));
        let mut first = 0;
        let moving = model.forces.as_ref().map(|forces| Box::new(X::moving(forces, parameters)));
        let mut sums = model.degrees.each_ref().map(|degree| {
            let range = first..first + degree.terms.len();
            first = range.end;
            let mut sum: Vec<_> =
                range.map(|i| Weighted { parameter: parameters[i], places: terms[i] }).collect();
            sum.sort_by_key(|term| kind(term.places, variables));
            sum
        });
        for ((d, places), parameter) in known.into_iter().zip(&all[parameters.len()..]) {
            sums[d].push(Weighted { parameter: *parameter, places });
        }
        let Places { moduli, products, tied, .. } = places;
        let mut places = vec![X::ONE; products.first + products.pairs.len()];
        let tied_terms = model.degrees.iter().flat_map(|degree| &degree.terms).flat_map(|term| &term.tied);
        for (place, tied) in places[first_coefficient(model)..].iter_mut().zip(tied_terms) {
            *place = X::from(tied.coefficient);
        }
        Self {
            model,
            variables,
            parameters: all,
            moduli,
            products,
            terms,
            tied,
            sums,
            constant: model.constant.map(X::from),
            by_state: None,
            by_exogenous: None,
            twice: None,
            places,
            moving,
            current: [X::ZERO; 2],
            paced: (model.pace != RateChange::Own)
                .then(|| Box::new(Paced { weights: model.pace.weights(), gained: [X::ZERO; 3] })),
        }
    }

    /// Sets the state (u, v over ground \[m/s\], r \[rad/s\]) and one number per input and measured
    /// disturbance, in a current of surge and sway components in body axes \[m/s\].
    #[inline(always)]
    pub fn look<E: Copy + Into<X>>(&mut self, state: [X; 3], exogenous: &[E], current: Option<[X; 2]>) {
        let Self { variables, places, .. } = self;
        places[1..4].copy_from_slice(&state);
        if let Some([along, across]) = current {
            places[1] = state[0] - along;
            places[2] = state[1] - across;
        }
        if self.moving.is_some() {
            self.current = current.unwrap_or([X::ZERO; 2]);
        }
        for (place, value) in places[4..=*variables].iter_mut().zip(exogenous) {
            *place = (*value).into();
        }
        self.evaluate();
        if self.paced.is_some() {
            self.pace();
        }
    }

    /// Computes the increments of a sample that is not one step, by Σ w_j (x_j − x_0) over the states x_j after j steps.
    #[inline(never)]
    fn pace(&mut self) {
        let Some(mut paced) = self.paced.take() else { return };
        let start = [self.places[1], self.places[2], self.places[3]];
        let (mut state, mut gained) = (start, [X::ZERO; 3]);
        for (j, weight) in paced.weights.iter().enumerate() {
            if j > 0 {
                self.set_state(state);
            }
            let step = [self.increment(0), self.increment(1), self.increment(2)];
            for d in 0..3 {
                state[d] += step[d];
                gained[d] += (state[d] - start[d]) * X::from(*weight);
            }
        }
        self.set_state(start);
        paced.gained = gained;
        self.paced = Some(paced);
    }

    /// Sets the state through the water at the point.
    fn set_state(&mut self, state: [X; 3]) {
        self.places[1..4].copy_from_slice(&state);
        self.evaluate();
    }

    /// Derivatives of the increments of a sample that is not one step, by the states and, if `all`, by the exogenous variables.
    fn paced_gradients(&mut self, all: bool, out: &mut [[X; 3]]) {
        let Some(paced) = self.paced.take() else { return };
        let start = [self.places[1], self.places[2], self.places[3]];
        let mut state = start;
        let mut step = vec![[X::ZERO; 3]; out.len()];
        // Of the state so far, by every variable.
        let mut so_far = step.clone();
        (0..3).for_each(|d| so_far[d][d] = X::ONE);
        out.fill([X::ZERO; 3]);
        for weight in &paced.weights {
            self.own_gradients(if all { &[true, false] } else { &[true] }, &mut step);
            let gained = [self.increment(0), self.increment(1), self.increment(2)];
            for (i, row) in so_far.iter_mut().enumerate() {
                let before = *row;
                for d in 0..3 {
                    let direct = if i < 3 { X::ZERO } else { step[i][d] };
                    row[d] +=
                        direct + before[0] * step[0][d] + before[1] * step[1][d] + before[2] * step[2][d];
                    let less = if i == d { X::ONE } else { X::ZERO };
                    out[i][d] += (row[d] - less) * X::from(*weight);
                }
            }
            (0..3).for_each(|d| state[d] += gained[d]);
            self.set_state(state);
        }
        self.set_state(start);
        self.paced = Some(paced);
    }

    /// Computes the places that follow from the variables.
    #[inline(always)]
    fn evaluate(&mut self) {
        let Self { variables, moduli, products, tied, places, .. } = self;
        for variable in moduli {
            places[1 + *variables + *variable] = places[1 + *variable].modulus();
        }
        products.evaluate(places);
        for (place, parts) in tied {
            let sum = parts.iter().fold(X::ZERO, |sum, [one, two]| sum + places[*one] * places[*two]);
            places[*place] = sum;
        }
    }

    /// φ of parameter `i` of a model of terms.
    #[inline(always)]
    pub fn term(&self, i: usize) -> X {
        let [one, two] = self.terms[i];
        self.places[one] * self.places[two]
    }

    /// The increments of surge, sway and yaw without parameters: the model's constant, and its known terms.
    #[inline(always)]
    pub fn known(&self) -> [X; 3] {
        let mut sums = self.constant;
        for (d, sum) in sums.iter_mut().enumerate() {
            for Weighted { parameter, places: [one, two] } in
                &self.sums[d][self.model.degrees[d].terms.len()..]
            {
                *sum += *parameter * (self.places[*one] * self.places[*two]);
            }
        }
        sums
    }

    /// θᵀφ of surge, sway and yaw, plus the increments without parameters.
    #[inline(always)]
    pub fn increments(&self) -> [X; 3] {
        if let Some(moving) = &self.moving {
            return X::increments(moving, self.point(self.current));
        }
        if let Some(paced) = &self.paced {
            return paced.gained;
        }
        [self.increment(0), self.increment(1), self.increment(2)]
    }

    /// The point that was set, in this current.
    #[inline(always)]
    fn point(&self, current: [X; 2]) -> Point<'_, X> {
        point(&self.places[1..=self.variables], current)
    }

    #[inline(always)]
    fn increment(&self, d: usize) -> X {
        let mut sum = self.constant[d];
        for Weighted { parameter, places: [one, two] } in &self.sums[d] {
            sum += *parameter * (self.places[*one] * self.places[*two]);
        }
        sum
    }

    /// The state after `state`, which was set, under a force as in [`Ambient`].
    #[inline(always)]
    pub fn next(&self, state: [X; 3], force: Option<[X; 3]>) -> [X; 3] {
        let [u, v, r] = self.increments();
        let next = [state[0] + u, state[1] + v, state[2] + r];
        match force {
            Some(force) => [next[0] + force[0], next[1] + force[1], next[2] + force[2]],
            None => next,
        }
    }

    /// Advances by one sample: x(k+1) = x(k) + θᵀφ(x(k) − x_c(k), exogenous(k)) + f(k).
    #[inline(always)]
    pub fn step<E: Copy + Into<X>>(&mut self, state: [X; 3], exogenous: &[E], ambient: Ambient<X>) -> [X; 3] {
        self.look(state, exogenous, ambient.current);
        self.next(state, ambient.force)
    }

    /// [`Self::step`] in place, in a current.
    #[inline(always)]
    pub fn advance(
        &mut self,
        state: &mut [X; 3],
        exogenous: impl Row<X>,
        current: impl Fn(X::Place) -> [f64; 2],
    ) {
        let Self { variables, places, .. } = self;
        put_state(places, state, current);
        let exogenous = exogenous.up_to(*variables - 3);
        for (i, entry) in places[4..=*variables].iter_mut().enumerate() {
            *entry = X::of(|place| exogenous.entry(i, place));
        }
        if let Some(moving) = &self.moving {
            let current = [state[0] - self.places[1], state[1] - self.places[2]];
            let gained = X::increments(moving, self.point(current));
            (0..3).for_each(|d| state[d] += gained[d]);
            return;
        }
        self.evaluate();
        if self.paced.is_some() {
            self.pace();
            let gained = self.increments();
            (0..3).for_each(|d| state[d] += gained[d]);
            return;
        }
        // Each sum is finished before the next begins: three at once need more registers than processors have.
        state[0] += self.increment(0);
        state[1] += self.increment(1);
        state[2] += self.increment(2);
    }

    /// J with J\[d\]\[i\] = θ_dᵀ ∂φ_d/∂(state i). The slope of a modulus at zero is 0, here and below.
    #[inline(always)]
    pub fn slopes(&mut self) -> [[X; 3]; 3] {
        if let Some(moving) = &mut self.moving {
            let mut by_state = [[X::ZERO; 3]; 3];
            X::gradients(moving, point(&self.places[1..=self.variables], self.current), 0..3, &mut by_state);
            return [0, 1, 2].map(|d: usize| by_state.map(|row| row[d]));
        }
        if self.paced.is_some() {
            let mut by_state = [[X::ZERO; 3]; 3];
            self.paced_gradients(false, &mut by_state);
            return [0, 1, 2].map(|d: usize| by_state.map(|row| row[d]));
        }
        let Self { model, variables, parameters, by_state, places, .. } = self;
        let derivatives = by_state.get_or_insert_with(|| Derivatives::once(model, places, true));
        derivatives.evaluate(*variables, places);
        let mut slopes = [[X::ZERO; 3]; 3];
        for Slope { parameter, degree, variable, places: [one, two] } in &derivatives.parts {
            slopes[*degree][*variable] += parameters[*parameter] * (places[*one] * places[*two]);
        }
        slopes
    }

    /// Transposed products, over parameters and then known terms: Σ_p `terms`\[p\] ∂φ_p/∂z + Σ_d Σ_i
    /// `slopes`\[d\]\[i\] ∂J\[d\]\[i\]/∂z for every variable z, that is the derivative by z of a quantity
    /// with these derivatives by the terms and by J.
    #[inline(always)]
    pub fn pull_back(&mut self, terms: &[X], slopes: &[[X; 3]; 3], out: &mut [X]) {
        let Self { model, parameters, by_state, by_exogenous, twice, places, .. } = self;
        let variables = model.variables.len();
        out.fill(X::ZERO);
        for (part, states) in [(by_state, true), (by_exogenous, false)] {
            let derivatives = part.get_or_insert_with(|| Derivatives::once(model, places, states));
            derivatives.evaluate(variables, places);
            for Slope { parameter, variable, places: [one, two], .. } in &derivatives.parts {
                out[*variable] += terms[*parameter] * (places[*one] * places[*two]);
            }
        }
        let curves = twice.get_or_insert_with(|| Derivatives::twice(model, places));
        curves.evaluate(variables, places);
        for Curve { parameter, degree, state, variable, places: [one, two] } in &curves.parts {
            let weight = slopes[*degree][*state] * parameters[*parameter];
            out[*variable] += weight * (places[*one] * places[*two]);
        }
    }

    /// ∂(θ_dᵀφ_d)/∂z for every variable z: variables × 3.
    pub fn gradients(&mut self, out: &mut [[X; 3]]) {
        self.gradients_by(&[true, false], out);
    }

    /// [`Self::gradients`] of the exogenous variables; those of the states are zero.
    pub fn exogenous_gradients(&mut self, out: &mut [[X; 3]]) {
        self.gradients_by(&[false], out);
    }

    /// By the states or by the exogenous variables.
    fn gradients_by(&mut self, which: &[bool], out: &mut [[X; 3]]) {
        if let Some(moving) = &mut self.moving {
            out.fill([X::ZERO; 3]);
            let first = if which.contains(&true) { 0 } else { 3 };
            let here = point(&self.places[1..=self.variables], self.current);
            return X::gradients(moving, here, first..self.variables, out);
        }
        if self.paced.is_some() {
            self.paced_gradients(true, out);
            if !which.contains(&true) {
                out[..3].fill([X::ZERO; 3]);
            }
            return;
        }
        self.own_gradients(which, out);
    }

    /// [`Self::gradients_by`] of one step of the terms.
    fn own_gradients(&mut self, which: &[bool], out: &mut [[X; 3]]) {
        let Self { model, parameters, by_state, by_exogenous, places, .. } = self;
        out.fill([X::ZERO; 3]);
        for states in which {
            let part = if *states { &mut *by_state } else { &mut *by_exogenous };
            let derivatives = part.get_or_insert_with(|| Derivatives::once(model, places, *states));
            derivatives.evaluate(model.variables.len(), places);
            for Slope { parameter, degree, variable, places: [one, two] } in &derivatives.parts {
                out[*variable][*degree] += parameters[*parameter] * (places[*one] * places[*two]);
            }
        }
    }
}
