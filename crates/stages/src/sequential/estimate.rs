use identification::MeanRemoval;
use identification::Sums;
use identification::pooled::{Lifted, Options, Part, Regression, fit, output_error};
use vessel::{Model, check_diverged, simulate_one};

/// What one leg of a trial brought home.
#[derive(Clone, Debug)]
pub struct Leg {
    /// Where the vessel started: u, v \[m/s\], r \[rad/s\].
    pub initial: [f64; 3],
    /// Inputs and measured disturbances: N × exogenous, row-major.
    pub exogenous: Vec<f64>,
    /// Measured states: (N+1) × 3, row-major; the first is the known initial state.
    pub measured: Vec<f64>,
}

impl Leg {
    /// Number of samples N.
    pub fn samples(&self) -> usize {
        self.measured.len() / 3 - 1
    }

    fn part(&self) -> Part {
        Part::new("", "", self.exogenous.clone(), self.measured.clone())
    }
}

/// θ̂ by the errors of free simulations over all legs together, with one intercept per degree of freedom, started at
/// instrumental variables with instruments from the model with parameters `known`, and at that model where those lead
/// nowhere. `std`: of the measured u, v, r. `None` where no search ends at a minimum.
pub fn estimate(lifted: &Lifted, model: &Model, legs: &[Leg], known: &[f64], std: [f64; 3]) -> Option<Vec<f64>> {
    let parts: Vec<Part> = legs.iter().map(Leg::part).collect();
    let free = vec![1.0; lifted.model.parameters()];
    let starts = [instrumental(model, legs, known), Some(known.to_vec())];
    let fitted = |theta: Vec<f64>| {
        let start = lifted.parameters(&theta, [0.0; 3]);
        output_error(lifted, &parts, &start, std, &free).filter(|found| found.converged)
    };
    let found = starts.into_iter().flatten().find_map(fitted)?;
    Some(without_intercepts(model, &found.parameters))
}

/// Instrumental variables over all legs, complete mean removal.
fn instrumental(model: &Model, legs: &[Leg], known: &[f64]) -> Option<Vec<f64>> {
    let own = |leg: &Leg| {
        let states = simulate_one(model, known, leg.initial, &leg.exogenous);
        let diverges = check_diverged(states.iter().copied()).is_some();
        let part = Part { instrument_states: states, ..leg.part() };
        (!diverges).then(|| Regression::of(model, &part).sums())
    };
    let sums: Vec<Sums> = legs.iter().map(own).collect::<Option<_>>()?;
    let options = Options { removal: MeanRemoval::Complete, prior: None, most: f64::INFINITY };
    let degrees = fit(&sums.iter().collect::<Vec<_>>(), &options);
    let thetas: Option<Vec<Vec<f64>>> =
        degrees.into_iter().map(|degree| degree.solution.map(|solution| solution.theta)).collect();
    thetas.map(|thetas| thetas.concat())
}

fn without_intercepts(model: &Model, lifted: &[f64]) -> Vec<f64> {
    let mut out = Vec::with_capacity(model.parameters());
    let mut rest = lifted;
    for degree in &model.degrees {
        out.extend_from_slice(&rest[..degree.terms.len()]);
        rest = &rest[degree.terms.len() + 1..];
    }
    out
}
