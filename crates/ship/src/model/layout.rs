use std::ops::Range;

use crate::model::{Model, Term};

/// The order of a model's parameters: those of surge, sway and yaw, each followed by that degree of freedom's
/// intercept if the model has intercepts ([`Model::with_intercepts`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterLayout {
    /// Terms of surge, sway and yaw, without intercepts.
    terms: [usize; 3],
    /// Which of them have an intercept.
    intercepts: [bool; 3],
    /// Which of them have the term 1 instead.
    constants: [bool; 3],
}

impl Model {
    /// The same model with the constant 1 as one more term of every degree of freedom that has none; its
    /// parameter is the intercept, the state's constant increment per sample beyond the known one.
    pub fn with_intercepts(&self) -> Self {
        let mut model = self.clone();
        for degree in model.degrees.iter_mut().filter(|degree| degree.constant().is_none()) {
            degree.parameters.push("intercept".to_owned());
            degree.terms.push(Term::constant());
            degree.intercept = true;
        }
        model
    }

    /// The order of its parameters.
    pub fn layout(&self) -> ParameterLayout {
        if self.forces.is_some() {
            // Parameters of forces belong to no one degree of freedom; they are in order, and no intercepts are among them.
            let terms = [self.parameters(), 0, 0];
            return ParameterLayout { terms, intercepts: [false; 3], constants: [true; 3] };
        }
        ParameterLayout {
            terms: self.degrees.each_ref().map(|degree| degree.terms.len() - usize::from(degree.intercept)),
            intercepts: self.degrees.each_ref().map(|degree| degree.intercept),
            constants: self.degrees.each_ref().map(|degree| !degree.intercept && degree.constant().is_some()),
        }
    }
}

impl ParameterLayout {
    /// The same with intercepts, where there is no term 1.
    pub fn with_intercepts(self) -> Self {
        Self { intercepts: self.constants.map(|constant| !constant), ..self }
    }

    /// Whether there are intercepts.
    pub fn has_intercepts(self) -> bool {
        self.intercepts.contains(&true)
    }

    /// Number of parameters, including intercepts.
    pub fn parameters(self) -> usize {
        self.degree(2).end
    }

    /// Indices of the parameters of degree of freedom `d` that belong to terms.
    pub fn terms(self, d: usize) -> Range<usize> {
        let before = self.intercepts[..d].iter().filter(|intercept| **intercept).count();
        let first = self.terms[..d].iter().sum::<usize>() + before;
        first..first + self.terms[d]
    }

    /// Indices of all parameters of degree of freedom `d`; its intercept is the last.
    pub fn degree(self, d: usize) -> Range<usize> {
        let terms = self.terms(d);
        terms.start..terms.end + usize::from(self.intercepts[d])
    }

    /// The degree of freedom of every parameter.
    pub fn degrees(self) -> impl Iterator<Item = usize> {
        (0..3).flat_map(move |d| self.degree(d).map(move |_| d))
    }

    /// Whether every parameter is an intercept.
    pub fn are_intercepts(self) -> impl Iterator<Item = bool> {
        (0..3).flat_map(move |d| self.degree(d).map(move |i| i == self.terms(d).end))
    }

    /// Parameters in this order from those of the terms (surge, sway, yaw) and the `intercepts`, which are
    /// ignored if there are none.
    pub fn woven(self, theta: &[f64], intercepts: [f64; 3]) -> Vec<f64> {
        let mut theta = theta.iter();
        let mut next = |(intercept, d): (bool, usize)| match intercept {
            true => Some(intercepts[d]),
            false => theta.next().copied(),
        };
        self.are_intercepts().zip(self.degrees()).map_while(&mut next).collect()
    }

    /// The terms' parameters alone: surge, sway, yaw.
    pub fn theta<T: Copy>(self, parameters: &[T]) -> Vec<T> {
        let all = parameters.iter().zip(self.are_intercepts());
        all.filter_map(|(parameter, intercept)| (!intercept).then_some(*parameter)).collect()
    }

    /// The intercepts alone; zero where there are none.
    pub fn intercepts(self, parameters: &[f64]) -> [f64; 3] {
        [0, 1, 2].map(|d: usize| if self.intercepts[d] { parameters[self.terms(d).end] } else { 0.0 })
    }
}
