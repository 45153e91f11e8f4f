use std::ops::Range;

use crate::{Degree, Model, Term};

/// In which order a model's parameters stand: those of surge, sway and yaw, each followed by that degree of freedom's
/// intercept where the model has intercepts ([`Model::with_intercepts`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterLayout {
    /// Terms of surge, sway and yaw, intercepts left out.
    terms: [usize; 3],
    intercepts: bool,
}

impl Model {
    /// The same model with the constant 1 as one more term of every degree of freedom; its parameter is the intercept, what
    /// the state gains in a sample whatever the vessel does, beyond the constant that is known.
    pub fn with_intercepts(&self) -> Self {
        let mut model = self.clone();
        for degree in &mut model.degrees {
            degree.parameters.push("intercept".to_owned());
            degree.terms.push(Term::constant());
        }
        model
    }

    /// The order of its parameters.
    pub fn layout(&self) -> ParameterLayout {
        let intercepts = self.degrees.iter().all(|degree| degree.terms.last().is_some_and(Term::is_constant));
        let terms = |degree: &Degree| degree.terms.len() - usize::from(intercepts);
        ParameterLayout { terms: self.degrees.each_ref().map(terms), intercepts }
    }
}

impl ParameterLayout {
    /// The same with intercepts.
    pub fn with_intercepts(self) -> Self {
        Self { intercepts: true, ..self }
    }

    /// Whether there are intercepts.
    pub fn has_intercepts(self) -> bool {
        self.intercepts
    }

    /// Number of parameters, intercepts among them.
    pub fn parameters(self) -> usize {
        self.degree(2).end
    }

    /// Places of the parameters of degree of freedom `d` that belong to terms.
    pub fn terms(self, d: usize) -> Range<usize> {
        let first = self.terms[..d].iter().sum::<usize>() + if self.intercepts { d } else { 0 };
        first..first + self.terms[d]
    }

    /// Places of all parameters of degree of freedom `d`; its intercept is the last.
    pub fn degree(self, d: usize) -> Range<usize> {
        let terms = self.terms(d);
        terms.start..terms.end + usize::from(self.intercepts)
    }

    /// The degree of freedom of every parameter.
    pub fn degrees(self) -> impl Iterator<Item = usize> {
        (0..3).flat_map(move |d| self.degree(d).map(move |_| d))
    }

    /// Whether every parameter is an intercept.
    pub fn are_intercepts(self) -> impl Iterator<Item = bool> {
        (0..3).flat_map(move |d| self.degree(d).map(move |i| i == self.terms(d).end))
    }

    /// Parameters in this order from those of the terms (surge, sway, yaw); `intercepts` count where there are any.
    pub fn woven(self, theta: &[f64], intercepts: [f64; 3]) -> Vec<f64> {
        let (mut theta, mut intercepts) = (theta.iter(), intercepts.into_iter());
        let mut next = |intercept: bool| match intercept {
            true => intercepts.next(),
            false => theta.next().copied(),
        };
        self.are_intercepts().map_while(&mut next).collect()
    }

    /// The terms' parameters alone: surge, sway, yaw.
    pub fn theta<T: Copy>(self, parameters: &[T]) -> Vec<T> {
        let all = parameters.iter().zip(self.are_intercepts());
        all.filter_map(|(parameter, intercept)| (!intercept).then_some(*parameter)).collect()
    }

    /// The intercepts alone; zero where there are none.
    pub fn intercepts(self, parameters: &[f64]) -> [f64; 3] {
        [0, 1, 2].map(|d| if self.intercepts { parameters[self.terms(d).end] } else { 0.0 })
    }
}
