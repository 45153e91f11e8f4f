use vessel::{Factor, Model, Term, Variable, simulate_one};

/// A model with one more term per degree of freedom, the constant 1, whose parameter is the intercept.
#[derive(Clone, Debug)]
pub struct Lifted {
    /// The model; its last variable is the constant.
    pub model: Model,
}

impl Lifted {
    /// `model` with intercepts.
    pub fn new(model: &Model) -> Self {
        let mut model = model.clone();
        let variable = model.variables.len();
        model.variables.push(Variable { name: "1".to_owned(), unit: "1".to_owned() });
        for degree in &mut model.degrees {
            degree.parameters.push("intercept".to_owned());
            degree
                .terms
                .push(Term { text: "1".to_owned(), factors: vec![Factor { variable, modulus: false }] });
        }
        Self { model }
    }

    /// Parameters in the order of the lifted model: `theta` (surge, sway, yaw) with an intercept after each degree of
    /// freedom.
    pub fn parameters(&self, theta: &[f64], intercepts: [f64; 3]) -> Vec<f64> {
        let mut out = Vec::with_capacity(theta.len() + 3);
        let mut rest = theta;
        for (degree, intercept) in self.model.degrees.iter().zip(intercepts) {
            let (own, after) = rest.split_at(degree.terms.len() - 1);
            out.extend_from_slice(own);
            out.push(intercept);
            rest = after;
        }
        out
    }

    /// Inputs and measured disturbances (N × exogenous, row-major) with the constant beside them.
    pub fn exogenous(&self, exogenous: &[f64], samples: usize) -> Vec<f64> {
        let width = self.model.exogenous() - 1;
        let row = |k: usize| exogenous[k * width..(k + 1) * width].iter().copied().chain([1.0]);
        (0..samples).flat_map(row).collect()
    }

    /// Simulates `parameters` (as of [`Self::parameters`]) over `samples` rows of `exogenous`: (N+1) × 3 states.
    pub fn simulate(
        &self,
        parameters: &[f64],
        initial: [f64; 3],
        exogenous: &[f64],
        samples: usize,
    ) -> Vec<f64> {
        simulate_one(&self.model, parameters, initial, &self.exogenous(exogenous, samples))
    }
}
