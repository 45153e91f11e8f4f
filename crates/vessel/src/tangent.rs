use crate::{Lane, Model, Number, Term};

/// A model's terms and how they change with the states, as products of two places each: places hold one, every variable,
/// its modulus, its sign, and the leading products of terms of more than two factors.
#[derive(Clone, Debug)]
pub struct Tangent {
    variables: usize,
    moduli: Vec<usize>,
    signs: Vec<usize>,
    products: Vec<[usize; 2]>,
    terms: Vec<[usize; 2]>,
    /// Parameters of surge, sway and yaw begin here, and end.
    degrees: [usize; 4],
    slopes: Vec<Slope>,
    places: Vec<Lane>,
}

/// A part of ∂φ/∂(state) of one parameter's term.
#[derive(Clone, Copy, Debug)]
struct Slope {
    degree: usize,
    state: usize,
    parameter: usize,
    places: [usize; 2],
}

impl Tangent {
    /// Of `model`.
    pub fn new(model: &Model) -> Self {
        let mut tangent = Self {
            variables: model.variables.len(),
            moduli: Vec::new(),
            signs: Vec::new(),
            products: Vec::new(),
            terms: Vec::new(),
            degrees: [0; 4],
            slopes: Vec::new(),
            places: Vec::new(),
        };
        for (degree, own) in model.degrees.iter().enumerate() {
            for term in &own.terms {
                let places: Vec<usize> = (0..term.factors.len()).map(|i| tangent.factor(term, i)).collect();
                let parameter = tangent.terms.len();
                let product = tangent.product(&places);
                tangent.terms.push(product);
                (0..places.len()).for_each(|i| tangent.add_slope(term, &places, i, degree, parameter));
            }
            tangent.degrees[degree + 1] = tangent.terms.len();
        }
        tangent.places = vec![Lane::ONE; 1 + 3 * tangent.variables + tangent.products.len()];
        tangent
    }

    /// The place of factor `i`.
    fn factor(&mut self, term: &Term, i: usize) -> usize {
        let factor = term.factors[i];
        if factor.modulus {
            note(&mut self.moduli, factor.variable);
        }
        1 + factor.variable + if factor.modulus { self.variables } else { 0 }
    }

    /// Two places whose product is that of all of `places`.
    fn product(&mut self, places: &[usize]) -> [usize; 2] {
        match places {
            [] => [0, 0],
            [one] => [*one, 0],
            [one, two] => [*one, *two],
            [one, two, rest @ ..] => {
                let place = 1 + 3 * self.variables + self.products.len();
                self.products.push([*one, *two]);
                let shorter: Vec<usize> = [place].into_iter().chain(rest.iter().copied()).collect();
                self.product(&shorter)
            }
        }
    }

    /// The part of the product rule in which factor `i` is differentiated, where it is of a state.
    fn add_slope(&mut self, term: &Term, places: &[usize], i: usize, degree: usize, parameter: usize) {
        let factor = term.factors[i];
        if factor.variable > 2 {
            return;
        }
        let mut others: Vec<usize> =
            places.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, p)| *p).collect();
        if factor.modulus {
            note(&mut self.signs, factor.variable);
            others.push(1 + 2 * self.variables + factor.variable);
        }
        let places = self.product(&others);
        self.slopes.push(Slope { degree, state: factor.variable, parameter, places });
    }

    /// Goes to `states` (u, v relative to the water, r) and one number per input and measured disturbance.
    #[inline(always)]
    pub fn set(&mut self, states: [Lane; 3], exogenous: &[impl Number]) {
        let Self { variables, moduli, signs, products, places, .. } = self;
        places[1..4].copy_from_slice(&states);
        places[4..].iter_mut().zip(exogenous).for_each(|(place, value)| *place = value.lane());
        for variable in moduli {
            places[1 + *variables + *variable] = places[1 + *variable].abs();
        }
        for variable in signs {
            places[1 + 2 * *variables + *variable] = places[1 + *variable].sign();
        }
        for (i, [one, two]) in products.iter().enumerate() {
            places[1 + 3 * *variables + i] = places[*one] * places[*two];
        }
    }

    /// φ of parameter `i`.
    #[inline(always)]
    pub fn term(&self, i: usize) -> Lane {
        let [one, two] = self.terms[i];
        self.places[one] * self.places[two]
    }

    /// θᵀφ of surge, sway and yaw. `parameters`: one lane per parameter.
    #[inline(always)]
    pub fn increments(&self, parameters: &[Lane]) -> [Lane; 3] {
        let mut sums = [Lane::ZERO; 3];
        for (d, sum) in sums.iter_mut().enumerate() {
            for i in self.degrees[d]..self.degrees[d + 1] {
                *sum += parameters[i] * self.term(i);
            }
        }
        sums
    }

    /// J with J\[d\]\[i\] = θ_dᵀ ∂φ_d/∂(state i).
    #[inline(always)]
    pub fn slopes(&self, parameters: &[Lane]) -> [[Lane; 3]; 3] {
        let mut slopes = [[Lane::ZERO; 3]; 3];
        for Slope { degree, state, parameter, places: [one, two] } in &self.slopes {
            slopes[*degree][*state] += parameters[*parameter] * (self.places[*one] * self.places[*two]);
        }
        slopes
    }

    /// The degree of freedom of parameter `i`.
    pub fn degree(&self, i: usize) -> usize {
        (0..3).find(|d| i < self.degrees[d + 1]).unwrap_or(2)
    }
}

fn note(variables: &mut Vec<usize>, variable: usize) {
    if !variables.contains(&variable) {
        variables.push(variable);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Degree, Variable};

    #[test]
    fn law_terms_and_slopes_are_those_of_the_scalar_model() {
        let names = ["u", "v", "r", "n", "delta"];
        let degree = |texts: &[&str]| Degree {
            parameters: texts.iter().map(|t| (*t).to_owned()).collect(),
            terms: texts.iter().map(|t| Term::parse(t, &names).unwrap()).collect(),
        };
        let degrees = [
            degree(&["u", "u |u|", "u^2 |v| delta", "n |n|", "r", "|delta| |v| v^3"]),
            degree(&["v r", "delta"]),
            degree(&["|r| r u"]),
        ];
        let variable = |name: &&str| Variable { name: (*name).to_owned(), unit: String::new() };
        let model = Model { variables: names.iter().map(variable).collect(), inputs: 2, degrees };
        let x = [-0.7, 0.3, 0.2, 5.0, -0.4];
        let theta: Vec<f64> = (1..=9).map(f64::from).collect();
        let lanes: Vec<Lane> = theta.iter().map(|t| Lane::splat(*t)).collect();
        let mut tangent = Tangent::new(&model);
        tangent.set([x[0], x[1], x[2]].map(Lane::splat), &x[3..]);
        let (found, slopes) = (tangent.increments(&lanes), tangent.slopes(&lanes));
        let mut first = 0;
        for (d, own) in model.degrees.iter().enumerate() {
            let theta = &theta[first..first + own.terms.len()];
            let sum = |f: &dyn Fn(&Term) -> f64| own.terms.iter().zip(theta).map(|(t, p)| p * f(t)).sum::<f64>();
            approx::assert_relative_eq!(found[d][3], sum(&|t| t.evaluate(&x)), max_relative = 1e-13);
            for i in 0..3 {
                let expected = sum(&|t| t.derivative(&x, i));
                approx::assert_relative_eq!(slopes[d][i][5], expected, max_relative = 1e-13);
            }
            assert!((first..first + own.terms.len()).all(|i| tangent.degree(i) == d));
            first += own.terms.len();
        }
    }
}
