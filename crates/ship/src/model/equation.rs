use std::collections::BTreeMap;

use refusal::{Invalid, nearest};

use crate::forces::TermSpec;
use crate::model::{Degree, DegreeOfFreedom, Factor, Model, Product, Term};

/// One degree of freedom under construction: its terms as written.
pub(crate) struct Equation<'a> {
    degree: DegreeOfFreedom,
    specs: Vec<(&'a TermSpec, Term)>,
    /// Names in other degrees of freedom.
    others: Vec<&'a str>,
}

/// The role of a written parameter.
enum Role {
    Estimated {
        nominal: f64,
        bounds: Option<[f64; 2]>,
    },
    Fixed(f64),
    /// To the one at this index, which is not tied itself.
    Tied(usize, f64),
}

impl<'a> Equation<'a> {
    /// `specs` are those of `degree` with their terms, `all` those of the vessel.
    pub fn new(degree: DegreeOfFreedom, specs: Vec<(&'a TermSpec, Term)>, all: &[&'a TermSpec]) -> Self {
        let is_of_degree = |name: &str| specs.iter().any(|(spec, _)| spec.parameter == name);
        let others =
            all.iter().map(|spec| spec.parameter.as_str()).filter(|name| !is_of_degree(name)).collect();
        Self { degree, specs, others }
    }

    /// Adds the estimated parameters, with the terms of those that are tied to them, and the others to the `parts` of a model.
    ///
    /// # Errors
    /// A constraint that is meaningless, contradicts itself or the values, or leaves nothing to be estimated.
    pub fn reduce_to(self, parts: &mut Parts) -> Result<(), Invalid> {
        let first = parts.nominal.len();
        let roles: Vec<Role> = (0..self.specs.len()).map(|i| self.role(i)).collect::<Result<_, _>>()?;
        self.check_constants(&roles)?;
        let (mut degree, mut places) = (Degree::default(), BTreeMap::new());
        for (i, ((spec, term), role)) in self.specs.iter().zip(&roles).enumerate() {
            if let Role::Estimated { nominal: number, bounds } = role {
                let place = degree.terms.len();
                places.insert(i, place);
                degree.parameters.push(spec.parameter.clone());
                degree.terms.push(term.clone());
                degree.bounds.extend(bounds.map(|bounds| (place, bounds)));
                parts.value.push(spec.value);
                parts.nominal.push(*number);
            }
        }
        if degree.terms.is_empty() {
            return Err(self.nothing_left());
        }
        for (place, ((spec, term), role)) in self.specs.iter().zip(&roles).enumerate() {
            let constraint = match *role {
                Role::Estimated { .. } => continue,
                Role::Fixed(value) => Constraint::Fixed(value),
                Role::Tied(to, factor) => match (places.get(&to), &roles[to]) {
                    (Some(to), _) => Constraint::Tied { to: first + to, factor },
                    (None, Role::Fixed(value)) => Constraint::Fixed(factor * value),
                    // Chains of ties end at a parameter that is not tied.
                    (None, _) => continue,
                },
            };
            let factors = term.factors.clone();
            match constraint {
                Constraint::Fixed(coefficient) => degree.known.push(Product { coefficient, factors }),
                Constraint::Tied { to, factor: coefficient } => {
                    degree.terms[to - first].tied.push(Product { coefficient, factors });
                }
            }
            let (name, term) = (spec.parameter.clone(), term.clone());
            parts.constrained.push(Constrained { degree: self.degree, place, name, term, constraint });
        }
        parts.degrees[self.degree as usize] = degree;
        Ok(())
    }

    fn role(&self, i: usize) -> Result<Role, Invalid> {
        let (spec, _) = &self.specs[i];
        if let Some(name) = &spec.tied_to {
            let (to, factor) = self.tied(i, name)?;
            return Ok(Role::Tied(to, factor));
        }
        if spec.factor.is_some() {
            let expected = "`factor` together with `tied_to`";
            return Err(refused(
                spec,
                "`factor` alone",
                expected,
                "name the parameter that it is tied to, or remove it",
            ));
        }
        let bounds = spec.bounds.map(|bounds| within(spec, bounds)).transpose()?;
        match (spec.fixed, spec.value, spec.nominal) {
            (false, _, Some(nominal)) => {
                inside(spec, "`nominal`", nominal, bounds)?;
                Ok(Role::Estimated { nominal, bounds })
            }
            (false, _, None) => Err(refused(
                spec,
                "no `nominal`",
                "a crude value, which instruments are made with",
                "add it, or give a `value` and `fixed = true`",
            )),
            (true, None, None) => {
                Err(refused(spec, "`fixed` without a value", "its `value` or `nominal`", "add it"))
            }
            (true, Some(value), Some(nominal)) if value != nominal => Err(refused(
                spec,
                &format!("`fixed` with the value {value} and the nominal value {nominal}"),
                "one value",
                "remove one of them",
            )),
            (true, Some(value), _) | (true, None, Some(value)) => {
                inside(spec, "its value", value, bounds)?;
                Ok(Role::Fixed(value))
            }
        }
    }

    /// The parameter that spec `i` is finally tied to, and the factor.
    fn tied(&self, i: usize, name: &str) -> Result<(usize, f64), Invalid> {
        let (spec, term) = &self.specs[i];
        let tie = format!("tied to `{name}`");
        let refuse = |given: &str, expected: &str, remedy: &str| Err(refused(spec, given, expected, remedy));
        if spec.fixed || spec.bounds.is_some() {
            let given = format!("{tie}, and {}", if spec.fixed { "`fixed`" } else { "`bounds`" });
            return refuse(&given, "one of them", "state it for the parameter that it is tied to");
        }
        let (mut at, mut factor, mut seen) = (i, 1.0, vec![i]);
        while let (here, Some(next)) = (self.specs[at].0, &self.specs[at].0.tied_to) {
            let ratio = here.factor.unwrap_or(1.0);
            if !ratio.is_finite() || ratio == 0.0 {
                return Err(refused(
                    here,
                    &format!("`factor` {ratio}"),
                    "a finite number other than 0",
                    "correct it",
                ));
            }
            factor *= ratio;
            let Some(place) = self.specs.iter().position(|(other, _)| other.parameter == *next) else {
                return Err(self.unknown(here, next));
            };
            if seen.contains(&place) {
                let remedy = "leave one of them untied, which is then estimated";
                let expected = "a parameter that is not tied to this one";
                return refuse(
                    &if place == i && at == i {
                        "tied to itself".into()
                    } else {
                        format!("{tie}, in a circle")
                    },
                    expected,
                    remedy,
                );
            }
            seen.push(place);
            at = place;
        }
        if term.is_constant() || self.specs[at].1.is_constant() {
            return refuse(
                &format!("{tie}, and one of them with the term `1`"),
                "terms that vary",
                "leave it untied",
            );
        }
        let (target, _) = &self.specs[at];
        for (what, number, other) in
            [("value", spec.value, target.value), ("nominal value", spec.nominal, target.nominal)]
        {
            if let (Some(number), Some(other)) = (number, other)
                && (number - factor * other).abs() > 1e-9 * number.abs()
            {
                let given = format!("a {what} of {number}, tied to `{}`", target.parameter);
                return refuse(&given, &format!("{}", factor * other), "remove it: it follows from the tie");
            }
        }
        Ok((at, factor))
    }

    fn unknown(&self, spec: &TermSpec, name: &str) -> Invalid {
        let given = format!("tied to `{name}`");
        if self.others.contains(&name) {
            return refused(
                spec,
                &format!("{given}, a parameter of another degree of freedom"),
                &format!("a parameter of {}", self.degree.name()),
                "tie parameters of one degree of freedom, or fix both",
            );
        }
        let others = || {
            self.specs
                .iter()
                .map(|(other, _)| other.parameter.as_str())
                .filter(|name| *name != spec.parameter)
        };
        let remedy =
            nearest(name, others()).map_or("remove it".into(), |near| format!("did you mean `{near}`?"));
        let expected = format!("a parameter of {}", self.degree.name());
        refused(spec, &format!("{given}, which no term has"), &expected, &remedy)
    }

    /// Refuses several estimated terms 1, which cannot be distinguished.
    fn check_constants(&self, roles: &[Role]) -> Result<(), Invalid> {
        let estimated =
            self.specs.iter().zip(roles).filter(|(_, role)| matches!(role, Role::Estimated { .. }));
        let mut constants = estimated.filter(|((_, term), _)| term.is_constant());
        match (constants.next(), constants.next()) {
            (Some(((one, _), _)), Some(((other, _), _))) => Err(refused(
                other,
                &format!("the term `1`, which `{}` has already", one.parameter),
                &format!("one constant in {}", self.degree.name()),
                "remove one of them",
            )),
            _ => Ok(()),
        }
    }

    fn nothing_left(&self) -> Invalid {
        Invalid::new(
            format!("[[{}]]", self.degree.name()),
            "every parameter fixed, which leaves nothing to be estimated",
            "at least one parameter per degree of freedom that is not fixed",
            "remove `fixed` from one",
        )
    }
}

fn refused(spec: &TermSpec, found: &str, expected: &str, remedy: &str) -> Invalid {
    Invalid::new(format!("parameter `{}`", spec.parameter), found, expected, remedy)
}

/// Bounds that are not empty.
fn within(spec: &TermSpec, bounds: [f64; 2]) -> Result<[f64; 2], Invalid> {
    let [low, high] = bounds;
    if low < high && low < f64::INFINITY && high > f64::NEG_INFINITY {
        return Ok(bounds);
    }
    let given = format!("`bounds` [{low}, {high}]");
    Err(refused(spec, &given, "a lower bound and a higher one", "swap or correct them, or fix the parameter"))
}

fn inside(spec: &TermSpec, what: &str, value: f64, bounds: Option<[f64; 2]>) -> Result<(), Invalid> {
    match bounds {
        Some([low, high]) if !(low..=high).contains(&value) => Err(refused(
            spec,
            &format!("{what} {value}, which its `bounds` [{low}, {high}] exclude"),
            "a value within them",
            "correct the value or the bounds",
        )),
        _ => Ok(()),
    }
}

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
    /// The model and its `parameters` without those at a bound, whose terms become known: an estimate is judged with these held.
    pub fn held_at_bounds(&self, parameters: &[f64]) -> (Self, Vec<f64>) {
        let (mut model, mut left, mut values) = (self.clone(), Vec::new(), parameters.iter());
        for (degree, degree_terms) in model.degrees.iter_mut().zip(&self.degrees) {
            (degree.parameters, degree.terms) = (Vec::new(), Vec::new());
            degree.bounds.clear();
            let each = degree_terms.parameters.iter().zip(&degree_terms.terms).zip(values.by_ref());
            for (i, ((name, term), value)) in each.take(degree_terms.terms.len()).enumerate() {
                if degree_terms.at_bound(i, *value) {
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

/// What a kind of model gives a vessel.
#[derive(Default)]
pub(crate) struct Parts {
    pub degrees: [Degree; 3],
    pub value: Vec<Option<f64>>,
    pub nominal: Vec<f64>,
    pub constrained: Vec<Constrained>,
}
