use crate::{Lane, Model, Number};

/// A model with its parameters, its terms as products of two places each, so that a step of a simulation decides nothing: places hold one, every
/// variable, every modulus, and the leading products of terms of more than two factors.
pub(crate) struct Program {
    variables: usize,
    moduli: Vec<usize>,
    products: Vec<[usize; 2]>,
    degrees: [Vec<[Weighted; 4]>; 3],
    places: Vec<Lane>,
}

/// A parameter and the two places of its term.
#[derive(Clone, Copy)]
struct Weighted {
    parameter: Lane,
    places: [usize; 2],
}

impl Weighted {
    /// Adds nothing: fills up the last four of a degree of freedom.
    const NOTHING: Self = Self { parameter: Lane::ZERO, places: [0; 2] };
}

impl Program {
    /// `parameters`: one lane per parameter.
    pub(crate) fn new(model: &Model, parameters: &[Lane]) -> Self {
        let variables = model.variables.len();
        let mut program = Self {
            variables,
            moduli: Vec::new(),
            products: Vec::new(),
            degrees: [const { Vec::new() }; 3],
            places: Vec::new(),
        };
        let mut parameters = parameters.iter();
        for (d, degree) in model.degrees.iter().enumerate() {
            let mut weighted = Vec::new();
            for (term, parameter) in degree.terms.iter().zip(&mut parameters) {
                let mut product = [0, 0];
                for (i, factor) in term.factors.iter().enumerate() {
                    let place = 1 + factor.variable + if factor.modulus { variables } else { 0 };
                    if factor.modulus && !program.moduli.contains(&factor.variable) {
                        program.moduli.push(factor.variable);
                    }
                    if i > 1 {
                        let leading = product;
                        product = [1 + 2 * variables + program.products.len(), 0];
                        program.products.push(leading);
                    }
                    product[i.min(1)] = place;
                }
                weighted.push(Weighted { parameter: *parameter, places: product });
            }
            let four = |terms: &[Weighted]| {
                std::array::from_fn(|i| terms.get(i).copied().unwrap_or(Weighted::NOTHING))
            };
            program.degrees[d] = weighted.chunks(4).map(four).collect();
        }
        program.places = vec![Lane::ONE; 1 + 2 * variables + program.products.len()];
        program
    }

    /// θᵀφ of each degree of freedom. `states`: u, v relative to the water, r; `exogenous`: one number per input and
    /// measured disturbance.
    #[inline(always)]
    pub(crate) fn increments(&mut self, states: [Lane; 3], exogenous: &[impl Number]) -> [Lane; 3] {
        let Self { variables, moduli, products, degrees, places } = self;
        places[1..4].copy_from_slice(&states);
        places[4..].iter_mut().zip(exogenous).for_each(|(place, value)| *place = value.lane());
        for variable in moduli {
            places[1 + *variables + *variable] = places[1 + *variable].abs();
        }
        for (i, [one, two]) in products.iter().enumerate() {
            places[1 + 2 * *variables + i] = places[*one] * places[*two];
        }
        let mut sums = [Lane::ZERO; 3];
        for (sum, terms) in sums.iter_mut().zip(degrees) {
            for four in terms {
                for Weighted { parameter, places: [one, two] } in four {
                    *sum += *parameter * (places[*one] * places[*two]);
                }
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Degree, LANES, Term, Variable};

    #[test]
    fn law_increments_are_the_terms_times_their_parameters() {
        let names = ["u", "v", "r", "n", "delta"];
        let degree = |texts: &[&str]| Degree {
            parameters: texts.iter().map(|t| (*t).to_owned()).collect(),
            terms: texts.iter().map(|t| Term::parse(t, &names).unwrap()).collect(),
        };
        let degrees = [
            degree(&["u", "u |u|", "u^2 |v| delta", "n |n|", "r", "|delta| |v| v^3"]),
            degree(&["v r", "delta"]),
            degree(&[]),
        ];
        let variable = |name: &&str| Variable { name: (*name).to_owned(), unit: String::new() };
        let model = Model { variables: names.iter().map(variable).collect(), inputs: 2, degrees };
        let x = [-0.7, 0.3, 0.2, 5.0, -0.4];
        let parameters: Vec<Lane> = (1..=8).map(|i| Lane::splat(f64::from(i))).collect();
        let mut program = Program::new(&model, &parameters);
        for _ in 0..2 {
            let found = program.increments([x[0], x[1], x[2]].map(Lane::splat), &x[3..]);
            let mut next = 0.0;
            for (degree, found) in model.degrees.iter().zip(found) {
                let mut expected = 0.0;
                for term in &degree.terms {
                    next += 1.0;
                    expected += next * term.evaluate(&x);
                }
                approx::assert_relative_eq!(found[LANES - 1], expected, max_relative = 1e-14);
            }
        }
    }
}
