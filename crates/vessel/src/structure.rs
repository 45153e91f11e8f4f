//! Models whose terms are known when the program is compiled: what goes through them sample by sample keeps all in registers.
//! They give the same bits as [`Compiled`], which takes any model.

use crate::{Ambient, Arithmetic, Compiled, Factor, Model};

/// The `P` terms of a degree of freedom in `V` variables; the first `M` depend on the vessel's state, the others do not.
pub trait Equation<const V: usize, const P: usize, const M: usize> {
    /// Their factors.
    const TERMS: [&'static [Factor]; P];

    /// φ at `variables`: u, v, r, then the inputs and measured disturbances.
    fn terms<X: Arithmetic>(variables: [X; V]) -> [X; P];
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
    ($(#[$doc:meta])* $name:ident, $v:literal, $p:literal, $m:literal: $([$($factor:tt)+]),+) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub struct $name;
        impl Equation<$v, $p, $m> for $name {
            const TERMS: [&'static [Factor]; $p] = [$(&[$(equation!(@factor $factor)),+]),+];
            #[inline(always)]
            fn terms<X: Arithmetic>(x: [X; $v]) -> [X; $p] {
                [$(equation!(@product x, $($factor)+)),+]
            }
        }
    };
    (@factor (|$i:literal|)) => { Factor { variable: $i, modulus: true } };
    (@factor $i:literal) => { Factor { variable: $i, modulus: false } };
    (@value $x:ident, (|$i:literal|)) => { $x[$i].modulus() };
    (@value $x:ident, $i:literal) => { $x[$i] };
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

impl Model {
    /// The structure of this model, where it is one that is known when the program is compiled.
    pub fn structure(&self) -> Option<ModelShip> {
        let mut same = Same { model: self, all: self.variables.len() == 6 };
        ModelShip.visit(&mut same);
        same.all.then_some(ModelShip)
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
pub trait Step<X> {
    /// One sample on: see [`Compiled::step`].
    fn step<E: Copy + Into<X>>(&mut self, state: [X; 3], exogenous: &[E], ambient: Ambient<X>) -> [X; 3];
}

impl<X: Arithmetic> Step<X> for Compiled<'_, X> {
    #[inline(always)]
    fn step<E: Copy + Into<X>>(&mut self, state: [X; 3], exogenous: &[E], ambient: Ambient<X>) -> [X; 3] {
        Compiled::step(self, state, exogenous, ambient)
    }
}

/// A structure with its parameters.
#[derive(Clone, Copy, Debug)]
pub struct Built<S, X, const V: usize, const P: usize> {
    structure: S,
    parameters: [X; P],
}

impl<S: Structure<V, P>, X: Arithmetic, const V: usize, const P: usize> Built<S, X, V, P> {
    /// `structure` with one number per parameter.
    pub fn new(structure: S, parameters: &[X]) -> Self {
        Self { structure, parameters: std::array::from_fn(|i| parameters[i]) }
    }
}

impl<S: Structure<V, P>, X: Arithmetic, const V: usize, const P: usize> Step<X> for Built<S, X, V, P> {
    #[inline(always)]
    fn step<E: Copy + Into<X>>(&mut self, state: [X; 3], exogenous: &[E], ambient: Ambient<X>) -> [X; 3] {
        let mut variables = [X::ZERO; V];
        variables[..3].copy_from_slice(&state);
        if let Some([along, across]) = ambient.current {
            variables[0] = state[0] - along;
            variables[1] = state[1] - across;
        }
        for i in 3..V {
            variables[i] = exogenous[i - 3].into();
        }
        let mut gained = Gained { variables, parameters: &self.parameters, sums: [X::ZERO; 3] };
        self.structure.visit(&mut gained);
        let [u, v, r] = gained.sums;
        let next = [state[0] + u, state[1] + v, state[2] + r];
        match ambient.force {
            Some(force) => [next[0] + force[0], next[1] + force[1], next[2] + force[2]],
            None => next,
        }
    }
}

/// θᵀφ of surge, sway and yaw.
struct Gained<'p, X, const V: usize> {
    variables: [X; V],
    parameters: &'p [X],
    sums: [X; 3],
}

impl<X: Arithmetic, const V: usize> Visit<V> for Gained<'_, X, V> {
    #[inline(always)]
    fn equation<Q: Equation<V, P, M>, const P: usize, const M: usize>(&mut self, d: usize, first: usize) {
        let terms = Q::terms(self.variables);
        for (parameter, term) in self.parameters[first..first + P].iter().zip(terms) {
            self.sums[d] += *parameter * term;
        }
    }
}

/// What `$body` makes of a model with its parameters as `$step`, a [`Step`]: compiled for its structure where this is known.
#[macro_export]
macro_rules! stepping {
    ($model:expr, $parameters:expr, |mut $step:ident| $body:expr) => {
        match $model.structure() {
            Some(structure) => {
                let mut $step = $crate::Built::new(structure, $parameters);
                $body
            }
            None => {
                let mut $step = $crate::Compiled::new($model, $parameters);
                $body
            }
        }
    };
}
