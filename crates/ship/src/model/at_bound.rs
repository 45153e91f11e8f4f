//! Parameters that a trial cannot determine, because it holds disturbances constant or does not excite their terms.

use std::collections::BTreeMap;
use std::sync::Arc;

use refusal::Invalid;

use crate::model::{
    Constrained, Constraint, Degree, DegreeOfFreedom, Factor, ForceModel, ORDER, Product, RateChange, Term,
    Vessel, Written,
};

impl Vessel {
    /// The vessel as simulated trials can identify it. They hold measured disturbances at `simulated`: terms
    /// of these are either zero or a constant that no trial can distinguish from others, so they become
    /// known, with their values if these are known.
    #[must_use]
    pub fn with_disturbances_held(self) -> Self {
        // The parameters of forces belong to no terms.
        if self.model.forces.is_some() {
            return self;
        }
        let held = self.held_variables();
        let is_held = |term: &Term| term.products().flatten().any(|Factor { variable, .. }| held[*variable]);
        let degrees = &self.model.degrees;
        let all_of = |degree: &Degree| degree.terms.iter().all(is_held);
        let of_degree = |degree: &Degree| {
            // An equation needs at least one estimated term.
            let none = all_of(degree);
            degree.terms.iter().map(|term| none || !is_held(term)).collect::<Vec<bool>>()
        };
        let kept: Vec<bool> = degrees.iter().flat_map(of_degree).collect();
        self.estimating(&kept)
    }

    /// The vessel with parameter `name` at its value, which is known from then on. A name that it has not changes nothing.
    #[must_use]
    pub fn with_held(self, name: &str) -> Self {
        let kept: Vec<bool> = self.model.parameter_names().map(|own| own != name).collect();
        self.estimating(&kept)
    }

    /// The vessel of which only those parameters are estimated that are `kept`.
    fn estimating(self, kept: &[bool]) -> Self {
        if !kept.contains(&false) {
            return self;
        }
        let degrees = &self.model.degrees;
        let constrained = self.constrained_but(kept);
        let mut model = self.model.clone();
        let mut first = 0;
        for (degree, own) in model.degrees.iter_mut().zip(degrees) {
            let values =
                self.nominal.iter().zip(&self.value).map(|(nominal, value)| value.unwrap_or(*nominal));
            let each = values.zip(kept.iter().copied()).skip(first).take(own.terms.len());
            *degree = without(own, each);
            first += own.terms.len();
        }
        let left = |i: &usize| kept[*i];
        let value = (0..kept.len()).filter(left).map(|i| self.value[i]).collect();
        let nominal = (0..kept.len()).filter(left).map(|i| self.nominal[i]).collect();
        Self { model, value, nominal, constrained, ..self }
    }

    /// Per variable, whether simulated trials hold it constant.
    fn held_variables(&self) -> Vec<bool> {
        let mut held = vec![false; self.model.variables.len()];
        self.model.simulated.keys().for_each(|variable| held[*variable] = true);
        for own in &self.model.derived {
            held[own.variable] = own.sources.iter().all(|source| held[*source]);
        }
        held
    }

    /// The constrained parameters if only those that are `kept` are estimated.
    fn constrained_but(&self, kept: &[bool]) -> Vec<Constrained> {
        let known = |i: usize| self.value[i].unwrap_or(self.nominal[i]);
        let place_of = |i: usize| kept[..i].iter().filter(|kept| **kept).count();
        let mut all = self.constrained.clone();
        for own in &mut all {
            own.constraint = match own.constraint {
                Constraint::Tied { to, factor } if kept[to] => Constraint::Tied { to: place_of(to), factor },
                Constraint::Tied { to, factor } => Constraint::Fixed(factor * known(to)),
                fixed => fixed,
            };
        }
        let terms: Vec<(&String, &Term)> = self
            .model
            .degrees
            .iter()
            .flat_map(|degree| degree.parameters.iter().zip(&degree.terms))
            .collect();
        for degree in DegreeOfFreedom::ALL {
            for (place, written) in self.written(degree).into_iter().enumerate() {
                if let Written::Estimated(i) = written
                    && !kept[i]
                {
                    let (name, term) = (terms[i].0.clone(), Term { tied: Vec::new(), ..terms[i].1.clone() });
                    all.push(Constrained {
                        degree,
                        place,
                        name,
                        term,
                        constraint: Constraint::Fixed(known(i)),
                    });
                }
            }
        }
        all.sort_by_key(|own| (own.degree as usize, own.place));
        all
    }
}

/// A degree of freedom in which some terms, with their values, are known.
fn without(degree: &Degree, each: impl Iterator<Item = (f64, bool)>) -> Degree {
    let mut left = Degree { known: degree.known.clone(), intercept: degree.intercept, ..Degree::default() };
    let mut bounds = BTreeMap::new();
    for (i, (value, kept)) in each.enumerate() {
        let term = &degree.terms[i];
        if kept {
            bounds.extend(degree.bounds.get(&i).map(|bound| (left.terms.len(), *bound)));
            left.parameters.push(degree.parameters[i].clone());
            left.terms.push(term.clone());
        } else {
            left.known.push(Product { coefficient: value, factors: term.factors.clone() });
            let tied = term.tied.iter();
            left.known.extend(tied.map(|tied| Product {
                coefficient: value * tied.coefficient,
                factors: tied.factors.clone(),
            }));
        }
    }
    Degree { bounds, ..left }
}

/// Most samples that a step of terms is divided into, and most that are one sample.
const MOST: f64 = 10.0;
const MOST_REPEATED: f64 = 1000.0;

impl Vessel {
    /// The same vessel sampled at another rate \[Hz\]. Forces are integrated in other steps. Terms per sample are repeated, or
    /// divided by Newton's forward formula.
    ///
    /// # Errors
    /// For terms: a rate of which neither is a whole multiple of the other, or above tenfold.
    pub fn at_rate(mut self, rate_hz: f64) -> Result<Self, Invalid> {
        let sample_rate_hz = self.sample_rate_hz;
        self.sample_rate_hz = rate_hz;
        if let Some(moved) = &self.model.forces {
            let forces = moved.forces.clone();
            self.model.forces = Some(Arc::new(ForceModel { forces, sample_s: 1.0 / rate_hz }));
            return Ok(self);
        }
        let refused = |expected: String, remedy: &str| {
            Err(Invalid::new("sampling rate", format!("{rate_hz} Hz wanted"), expected, remedy))
        };
        let whole = |ratio: f64| ((ratio - ratio.round()).abs() <= 1e-9 * ratio).then(|| ratio.round());
        self.model.pace = match (whole(rate_hz / sample_rate_hz), whole(sample_rate_hz / rate_hz)) {
            (Some(1.0), _) => RateChange::Own,
            (Some(by), _) if (2.0..=MOST).contains(&by) => {
                RateChange::Divided { by: by as u32, order: ORDER }
            }
            (_, Some(count)) if (2.0..=MOST_REPEATED).contains(&count) => RateChange::Repeated(count as u32),
            (Some(by), _) if by > MOST => {
                let expected = format!(
                    "at most {} Hz, {MOST} times the vessel's {sample_rate_hz} Hz",
                    MOST * sample_rate_hz
                );
                return refused(expected, "take a lower rate, or a vessel with `model = \"forces\"`");
            }
            _ => {
                let expected = format!("a whole multiple or part of the vessel's {sample_rate_hz} Hz");
                return refused(expected, "take such a rate, or estimate a model at this one");
            }
        };
        Ok(self)
    }
}
