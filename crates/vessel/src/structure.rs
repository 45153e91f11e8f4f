//! Models whose terms are known when the program is compiled: what goes through them sample by sample keeps all in registers.
//! They give the same bits as [`Compiled`], which takes any model.

use crate::{Ambient, Arithmetic, Compiled, Factor, Model, Row};

/// The `P` terms of a degree of freedom in `V` variables; the first `M` depend on the vessel's state, the others do not.
pub trait Equation<const V: usize, const P: usize, const M: usize> {
    /// Their factors.
    const TERMS: [&'static [Factor]; P];

    /// φ at `variables`: u, v, r, then the inputs and measured disturbances.
    fn terms<X: Arithmetic>(variables: &[X; V]) -> [X; P];

    /// ∂(θᵀφ)/∂(u, v, r) at `variables`, of as many `parameters`. The slope of a modulus at zero is 0.
    fn slopes<X: Arithmetic>(variables: &[X; V], parameters: &[X]) -> [X; 3];
}

/// What is done with each degree of freedom of a structure.
pub trait Visit<const V: usize> {
    /// Degree of freedom `d`, whose parameters begin at `first`.
    fn equation<Q: Equation<V, P, M>, const P: usize, const M: usize>(&mut self, d: usize, first: usize);
}

/// A model of three equations and `P` parameters.
pub trait Structure<const V: usize, const P: usize>: Copy {
    /// Goes through surge, sway and yaw.
    fn visit(self, visit: &mut impl Visit<V>);
}

/// Terms as lists of variables by place: 0, 1, 2 for u, v, r, then the inputs; `(|0|)` is a modulus.
macro_rules! equation {
    ($(#[$doc:meta])* $name:ident, $v:literal, $p:literal, $m:literal: $([$($factor:tt)*]),+) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub struct $name;
        impl Equation<$v, $p, $m> for $name {
            const TERMS: [&'static [Factor]; $p] = [$(&[$(equation!(@factor $factor)),*]),+];
            #[inline(always)]
            fn terms<X: Arithmetic>(x: &[X; $v]) -> [X; $p] {
                [$(equation!(@product x, $($factor)*)),+]
            }
            #[inline(always)]
            fn slopes<X: Arithmetic>(x: &[X; $v], parameters: &[X]) -> [X; 3] {
                let (mut slopes, mut parameters) = ([X::ZERO; 3], parameters.iter());
                $(
                    if let Some(parameter) = parameters.next() {
                        equation!(@slopes x, slopes, *parameter, $($factor)*);
                    }
                )+
                slopes
            }
        }
    };
    (@factor (|$i:literal|)) => { Factor { variable: $i, modulus: true } };
    (@factor $i:literal) => { Factor { variable: $i, modulus: false } };
    (@value $x:ident, (|$i:literal|)) => { $x[$i].modulus() };
    (@value $x:ident, $i:literal) => { $x[$i] };
    (@place (|$i:literal|)) => { $i };
    (@place $i:literal) => { $i };
    (@inner $x:ident, $rest:expr, (|$i:literal|)) => { $rest * $x[$i].sign() };
    (@inner $x:ident, $rest:expr, $i:literal) => { $rest };
    // Inputs have no slope that is asked for.
    (@slope $x:ident, $slopes:ident, $parameter:expr, $rest:expr, $own:tt) => {
        if let Some(slope) = $slopes.get_mut(equation!(@place $own)) {
            *slope += $parameter * equation!(@inner $x, $rest, $own);
        }
    };
    (@slopes $x:ident, $slopes:ident, $parameter:expr,) => { let _ = $parameter; };
    (@slopes $x:ident, $slopes:ident, $parameter:expr, $one:tt) => {
        equation!(@slope $x, $slopes, $parameter, X::ONE, $one);
    };
    (@slopes $x:ident, $slopes:ident, $parameter:expr, $one:tt $two:tt) => {
        equation!(@slope $x, $slopes, $parameter, equation!(@value $x, $two), $one);
        equation!(@slope $x, $slopes, $parameter, equation!(@value $x, $one), $two);
    };
    (@product $x:ident,) => { X::ONE };
    (@product $x:ident, $first:tt $($next:tt)*) => { equation!(@value $x, $first) $(* equation!(@value $x, $next))* };
}

equation!(
    /// Surge of the model ship: u, u |u|, v r, τ₁.
    ModelShipSurge, 6, 4, 3: [0], [0 (|0|)], [1 2], [3]
);
equation!(
    /// Sway of the model ship: v, u r, τ₂.
    ModelShipSway, 6, 3, 2: [1], [0 2], [4]
);
equation!(
    /// Yaw of the model ship: r, u v, τ₃.
    ModelShipYaw, 6, 3, 2: [2], [0 1], [5]
);

/// The structure of the preset `ljungberg-model-ship`.
#[derive(Clone, Copy, Debug)]
pub struct ModelShip;

impl Structure<6, 10> for ModelShip {
    #[inline(always)]
    fn visit(self, visit: &mut impl Visit<6>) {
        visit.equation::<ModelShipSurge, 4, 3>(0, 0);
        visit.equation::<ModelShipSway, 3, 2>(1, 4);
        visit.equation::<ModelShipYaw, 3, 2>(2, 7);
    }
}

equation!(
    /// Surge with an intercept.
    ModelShipSurgeAndOne, 6, 5, 3: [0], [0 (|0|)], [1 2], [3], []
);
equation!(
    /// Sway with an intercept.
    ModelShipSwayAndOne, 6, 4, 2: [1], [0 2], [4], []
);
equation!(
    /// Yaw with an intercept.
    ModelShipYawAndOne, 6, 4, 2: [2], [0 1], [5], []
);

/// The structure of the preset with intercepts: see [`Model::with_intercepts`].
#[derive(Clone, Copy, Debug)]
pub struct ModelShipWithIntercepts;

impl Structure<6, 13> for ModelShipWithIntercepts {
    #[inline(always)]
    fn visit(self, visit: &mut impl Visit<6>) {
        visit.equation::<ModelShipSurgeAndOne, 5, 3>(0, 0);
        visit.equation::<ModelShipSwayAndOne, 4, 2>(1, 5);
        visit.equation::<ModelShipYawAndOne, 4, 2>(2, 9);
    }
}

impl Model {
    /// The structure of this model, where it is one that is known when the program is compiled.
    pub fn structure(&self) -> Option<ModelShip> {
        self.if_alike(ModelShip)
    }

    /// The structure of this model with intercepts, likewise.
    pub fn structure_with_intercepts(&self) -> Option<ModelShipWithIntercepts> {
        self.if_alike(ModelShipWithIntercepts)
    }

    fn if_alike<S: Structure<V, P>, const V: usize, const P: usize>(&self, structure: S) -> Option<S> {
        let mut same = Same { model: self, all: self.variables.len() == V };
        structure.visit(&mut same);
        same.all.then_some(structure)
    }
}

/// Whether the equations of a model are those of a structure.
struct Same<'m> {
    model: &'m Model,
    all: bool,
}

impl<const V: usize> Visit<V> for Same<'_> {
    fn equation<Q: Equation<V, P, M>, const P: usize, const M: usize>(&mut self, d: usize, _: usize) {
        let degree = &self.model.degrees[d];
        let alike = |(term, own): (&crate::Term, &&[Factor])| term.tied.is_empty() && term.factors == *own;
        self.all &= degree.terms.len() == P
            && degree.known.is_empty()
            && self.model.constant[d] == 0.0
            && degree.terms.iter().zip(&Q::TERMS).all(alike);
    }
}

/// What goes from sample to sample.
pub trait Step<X: Arithmetic> {
    /// One sample on: see [`Compiled::step`].
    fn step<E: Copy + Into<X>>(&mut self, state: [X; 3], exogenous: &[E], ambient: Ambient<X>) -> [X; 3];

    /// The same in place, in a current of surge and sway components in body axes.
    fn advance(&mut self, state: &mut [X; 3], exogenous: impl Row<X>, current: impl Fn(X::Place) -> [f64; 2]);
}

/// What is asked at points: see the functions of these names of [`Compiled`].
pub trait Look<X: Arithmetic>: Step<X> {
    /// Goes to a point.
    fn look<E: Copy + Into<X>>(&mut self, state: [X; 3], exogenous: &[E], current: Option<[X; 2]>);
    /// φ of parameter `i`.
    fn term(&self, i: usize) -> X;
    /// What surge, sway and yaw gain without parameters.
    fn known(&self) -> [X; 3];
    /// J with J\[d\]\[i\] = θ_dᵀ ∂φ_d/∂(state i).
    fn slopes(&mut self) -> [[X; 3]; 3];
    /// The state after `state`, which was looked at.
    fn next(&self, state: [X; 3], force: Option<[X; 3]>) -> [X; 3];
}

impl<X: Arithmetic> Step<X> for Compiled<'_, X> {
    #[inline(always)]
    fn step<E: Copy + Into<X>>(&mut self, state: [X; 3], exogenous: &[E], ambient: Ambient<X>) -> [X; 3] {
        Compiled::step(self, state, exogenous, ambient)
    }
    #[inline(always)]
    fn advance(
        &mut self,
        state: &mut [X; 3],
        exogenous: impl Row<X>,
        current: impl Fn(X::Place) -> [f64; 2],
    ) {
        Compiled::advance(self, state, exogenous, current);
    }
}

impl<X: Arithmetic> Look<X> for Compiled<'_, X> {
    #[inline(always)]
    fn look<E: Copy + Into<X>>(&mut self, state: [X; 3], exogenous: &[E], current: Option<[X; 2]>) {
        Compiled::look(self, state, exogenous, current);
    }
    #[inline(always)]
    fn term(&self, i: usize) -> X {
        Compiled::term(self, i)
    }
    #[inline(always)]
    fn known(&self) -> [X; 3] {
        Compiled::known(self)
    }
    #[inline(always)]
    fn slopes(&mut self) -> [[X; 3]; 3] {
        Compiled::slopes(self)
    }
    #[inline(always)]
    fn next(&self, state: [X; 3], force: Option<[X; 3]>) -> [X; 3] {
        Compiled::next(self, state, force)
    }
}

/// A structure with its parameters, and the point that was looked at.
#[derive(Clone, Copy, Debug)]
pub struct Built<S, X, const V: usize, const P: usize> {
    structure: S,
    parameters: [X; P],
    variables: [X; V],
    terms: [X; P],
}

impl<S: Structure<V, P>, X: Arithmetic, const V: usize, const P: usize> Built<S, X, V, P> {
    /// `structure` with one number per parameter.
    pub fn new(structure: S, parameters: &[X]) -> Self {
        let parameters = std::array::from_fn(|i| parameters[i]);
        Self { structure, parameters, variables: [X::ZERO; V], terms: [X::ZERO; P] }
    }
}

impl<S: Structure<V, P>, X: Arithmetic, const V: usize, const P: usize> Step<X> for Built<S, X, V, P> {
    #[inline(always)]
    fn step<E: Copy + Into<X>>(&mut self, state: [X; 3], exogenous: &[E], ambient: Ambient<X>) -> [X; 3] {
        // Nothing is kept of a point that is only passed through: all stays in registers.
        let mut gained = GainedAt {
            variables: variables(state, exogenous, ambient.current),
            parameters: &self.parameters,
            sums: [X::ZERO; 3],
        };
        self.structure.visit(&mut gained);
        moved(state, gained.sums, ambient.force)
    }
    #[inline(always)]
    fn advance(
        &mut self,
        state: &mut [X; 3],
        exogenous: impl Row<X>,
        current: impl Fn(X::Place) -> [f64; 2],
    ) {
        let Self { structure, parameters, .. } = self;
        let exogenous = exogenous.up_to(V - 3);
        X::change(
            state,
            #[inline(always)]
            |place, own| {
                let ([u, v, r], [along, across]) = (own, current(place));
                let mut variables = [0.0; V];
                variables[..3].copy_from_slice(&[u - along, v - across, r]);
                for (i, variable) in variables[3..].iter_mut().enumerate() {
                    *variable = exogenous.entry(i, place);
                }
                let mut now = [0.0; P];
                for i in 0..P {
                    now[i] = parameters[i].at(place);
                }
                let mut gained = GainedAt { variables, parameters: &now, sums: [0.0; 3] };
                structure.visit(&mut gained);
                moved(own, gained.sums, None)
            },
        );
    }
}

/// u, v, r through the water, then inputs and measured disturbances.
#[inline(always)]
fn variables<X: Arithmetic, E: Copy + Into<X>, const V: usize>(
    state: [X; 3],
    exogenous: &[E],
    current: Option<[X; 2]>,
) -> [X; V] {
    let mut variables = [X::ZERO; V];
    fill(&mut variables, state, exogenous, current);
    variables
}

/// The same in place.
#[inline(always)]
fn fill<X: Arithmetic, E: Copy + Into<X>, const V: usize>(
    variables: &mut [X; V],
    state: [X; 3],
    exogenous: &[E],
    current: Option<[X; 2]>,
) {
    let [u, v, r] = state;
    (variables[0], variables[1]) = match current {
        Some([along, across]) => (u - along, v - across),
        None => (u, v),
    };
    variables[2] = r;
    let exogenous = &exogenous[..V - 3];
    for i in 3..V {
        variables[i] = exogenous[i - 3].into();
    }
}

#[inline(always)]
fn moved<X: Arithmetic>(state: [X; 3], [u, v, r]: [X; 3], force: Option<[X; 3]>) -> [X; 3] {
    let next = [state[0] + u, state[1] + v, state[2] + r];
    match force {
        Some(force) => [next[0] + force[0], next[1] + force[1], next[2] + force[2]],
        None => next,
    }
}

impl<S: Structure<V, P>, X: Arithmetic, const V: usize, const P: usize> Look<X> for Built<S, X, V, P> {
    #[inline(always)]
    fn look<E: Copy + Into<X>>(&mut self, state: [X; 3], exogenous: &[E], current: Option<[X; 2]>) {
        fill(&mut self.variables, state, exogenous, current);
        let Self { structure, variables, terms, .. } = self;
        structure.visit(&mut Terms { variables, terms });
    }
    #[inline(always)]
    fn term(&self, i: usize) -> X {
        self.terms[i]
    }
    #[inline(always)]
    fn known(&self) -> [X; 3] {
        [X::ZERO; 3]
    }
    #[inline(always)]
    fn slopes(&mut self) -> [[X; 3]; 3] {
        let Self { structure, parameters, variables, .. } = self;
        let mut slopes = Slopes { variables, parameters, slopes: [[X::ZERO; 3]; 3] };
        structure.visit(&mut slopes);
        slopes.slopes
    }
    #[inline(always)]
    fn next(&self, state: [X; 3], force: Option<[X; 3]>) -> [X; 3] {
        let mut gained = Gained { terms: &self.terms, parameters: &self.parameters, sums: [X::ZERO; 3] };
        self.structure.visit(&mut gained);
        moved(state, gained.sums, force)
    }
}

/// φ of all parameters.
struct Terms<'t, X, const V: usize> {
    variables: &'t [X; V],
    terms: &'t mut [X],
}

impl<X: Arithmetic, const V: usize> Visit<V> for Terms<'_, X, V> {
    #[inline(always)]
    fn equation<Q: Equation<V, P, M>, const P: usize, const M: usize>(&mut self, _: usize, first: usize) {
        if let Some(terms) = self.terms[first..].first_chunk_mut::<P>() {
            *terms = Q::terms(self.variables);
        }
    }
}

/// θᵀφ of surge, sway and yaw.
struct Gained<'p, X> {
    terms: &'p [X],
    parameters: &'p [X],
    sums: [X; 3],
}

impl<X: Arithmetic, const V: usize> Visit<V> for Gained<'_, X> {
    #[inline(always)]
    fn equation<Q: Equation<V, P, M>, const P: usize, const M: usize>(&mut self, d: usize, first: usize) {
        for (parameter, term) in self.parameters[first..first + P].iter().zip(&self.terms[first..]) {
            self.sums[d] += *parameter * *term;
        }
    }
}

/// The same at a point.
struct GainedAt<'p, X, const V: usize> {
    variables: [X; V],
    parameters: &'p [X],
    sums: [X; 3],
}

impl<X: Arithmetic, const V: usize> Visit<V> for GainedAt<'_, X, V> {
    #[inline(always)]
    fn equation<Q: Equation<V, P, M>, const P: usize, const M: usize>(&mut self, d: usize, first: usize) {
        let terms = Q::terms(&self.variables);
        for (parameter, term) in self.parameters[first..first + P].iter().zip(terms) {
            self.sums[d] += *parameter * term;
        }
    }
}

/// ∂(θᵀφ)/∂(u, v, r) of surge, sway and yaw.
struct Slopes<'p, X, const V: usize> {
    variables: &'p [X; V],
    parameters: &'p [X],
    slopes: [[X; 3]; 3],
}

impl<X: Arithmetic, const V: usize> Visit<V> for Slopes<'_, X, V> {
    #[inline(always)]
    fn equation<Q: Equation<V, P, M>, const P: usize, const M: usize>(&mut self, d: usize, first: usize) {
        self.slopes[d] = Q::slopes(self.variables, &self.parameters[first..first + P]);
    }
}
