use crate::model::{DegreeOfFreedom, Factor, Model, Product, Term};

/// A parameter that is not estimated on its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Constrained {
    /// Its degree of freedom.
    pub degree: DegreeOfFreedom,
    /// Its index among the parameters of this degree of freedom, as written.
    pub place: usize,
    /// Its name.
    pub name: String,
    /// Its term.
    pub term: Term,
    /// How its value is determined.
    pub constraint: Constraint,
}

/// How the value of a constrained parameter is determined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Constraint {
    /// It is known.
    Fixed(f64),
    /// It is another parameter times a factor.
    Tied {
        /// The other parameter's index in the model.
        to: usize,
        /// The factor.
        factor: f64,
    },
}

/// A parameter as written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Written<'a> {
    /// Estimated: its index in the model.
    Estimated(usize),
    /// Not estimated on its own.
    Constrained(&'a Constrained),
}

impl Constrained {
    /// Its value in a model with these `parameters`.
    pub fn value(&self, parameters: &[f64]) -> f64 {
        match self.constraint {
            Constraint::Fixed(value) => value,
            Constraint::Tied { to, factor } => factor * parameters[to],
        }
    }
}

impl Model {
    /// The model and its `parameters` without those at a bound, whose terms become known: an estimate is
    /// judged with these held.
    pub fn held_at_bounds(&self, parameters: &[f64]) -> (Self, Vec<f64>) {
        let (mut model, mut left, mut values) = (self.clone(), Vec::new(), parameters.iter());
        for (degree, own) in model.degrees.iter_mut().zip(&self.degrees) {
            (degree.parameters, degree.terms) = (Vec::new(), Vec::new());
            degree.bounds.clear();
            let each = own.parameters.iter().zip(&own.terms).zip(values.by_ref());
            for (i, ((name, term), value)) in each.take(own.terms.len()).enumerate() {
                if own.at_bound(i, *value) {
                    let mut known = |factors: &[Factor], coefficient: f64| {
                        degree.known.push(Product { coefficient, factors: factors.to_vec() });
                    };
                    known(&term.factors, *value);
                    term.tied.iter().for_each(|tied| known(&tied.factors, value * tied.coefficient));
                } else {
                    degree.parameters.push(name.clone());
                    degree.terms.push(term.clone());
                    left.push(*value);
                }
            }
        }
        (model, left)
    }
}
