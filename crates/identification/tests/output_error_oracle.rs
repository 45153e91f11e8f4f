//! Output error and the Kalman filter against numbers computed independently: `fixtures/oracle/output_error.json`.

mod support;

use identification::predictor::{
    Fit, Fitted, Flow, Gusts, InitialState, Levels, Recordings, Spread, innovations, output_error,
};
use serde_json::Value;
use support::{paper, truth};
use vessel::{LANES, Lane, Vessel};

const ORACLE: &str = include_str!("../../../fixtures/oracle/output_error.json");

fn oracle() -> Value {
    serde_json::from_str(ORACLE).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    match value.as_array() {
        Some(many) => many.iter().flat_map(numbers).collect(),
        None => vec![value.as_f64().unwrap()],
    }
}

/// A run of the oracle, the same in every lane.
struct Run {
    vessel: Vessel,
    measured: Vec<Lane>,
    inputs: Vec<f64>,
    initial: [Lane; 3],
    expected: Value,
}

impl Run {
    fn all() -> Vec<Self> {
        let whole = oracle();
        let run = |run: &Value| Self {
            vessel: paper(),
            measured: numbers(&run["measured"]).into_iter().map(Lane::splat).collect(),
            inputs: numbers(&run["inputs"]),
            initial: <[f64; 3]>::try_from(numbers(&run["initial"])).unwrap().map(Lane::splat),
            expected: run.clone(),
        };
        whole["runs"].as_array().unwrap().iter().map(run).collect()
    }

    fn recordings(&self) -> Recordings<'_, f64> {
        Recordings {
            model: &self.vessel.model,
            measured: &self.measured,
            exogenous: &self.inputs,
            initial: self.initial,
            samples: [self.inputs.len() / 3; LANES],
        }
    }

    /// From the nominal model and from twice the truth, in turns.
    fn fits(&self, initial: InitialState, spread: Spread) -> Vec<Fitted> {
        let twice: Vec<f64> = truth(&self.vessel).iter().map(|t| 1.2 * t).collect();
        let start = |lane: usize| if lane % 2 == 0 { self.vessel.nominal.clone() } else { twice.clone() };
        let starts = [std::array::from_fn(start)];
        let fits = output_error(&self.recordings(), &starts, initial, spread);
        let converged = |fit: Fit| match fit {
            Fit::Converged(found) => found,
            other => panic!("{other:?}"),
        };
        fits.into_iter().map(converged).collect()
    }
}

fn stated() -> Levels {
    let whole = oracle();
    Levels {
        measurement: numbers(&whole["measurement_std"]).try_into().unwrap(),
        current: Flow::White { std: whole["current_std"].as_f64().unwrap() },
        force: None,
    }
}

/// The filter's levels: `white`, `markov`, `all`.
fn levels(kind: &str) -> Levels {
    let (whole, step) = (oracle(), 1.0 / 8.0);
    let factor = |key: &str| (-step / whole[key]["time_constant_s"].as_f64().unwrap()).exp();
    let markov = Flow::Markov {
        std: whole["markov"]["std"].as_f64().unwrap(),
        factor: factor("markov"),
        turning: step,
    };
    let gusts =
        Gusts { std: numbers(&whole["gusts"]["std"]).try_into().unwrap(), factor: factor("gusts") };
    let white = stated();
    match kind {
        "white" => white,
        "markov" => Levels { current: markov, ..white },
        _ => Levels { current: markov, force: Some(gusts), ..white },
    }
}

#[test]
fn oracle_output_error_estimates_agree_with_least_squares_of_scipy() {
    for run in Run::all() {
        for (initial, key) in [(InitialState::Known, "known"), (InitialState::Estimated, "estimated")] {
            let expected = numbers(&run.expected[key]["unknowns"]);
            let rmse = numbers(&run.expected[key]["rmse"]);
            for found in run.fits(initial, Spread::Residuals) {
                let unknowns = found.parameters.iter().chain(&found.intercepts).chain(&found.offset);
                let errors = numbers(&run.expected["standard_errors"]);
                for (i, (found, expected)) in unknowns.zip(&expected).enumerate() {
                    let size = expected.abs().max(errors.get(i).copied().unwrap_or(0.1));
                    assert!((found - expected).abs() < 1e-6 * size, "{key} {i}: {found}, expected {expected}");
                }
                for (found, expected) in found.rmse.iter().zip(&rmse) {
                    approx::assert_relative_eq!(*found, *expected, max_relative = 1e-9);
                }
            }
        }
    }
}

#[test]
fn oracle_standard_errors_agree_with_the_response_to_every_draw() {
    for run in Run::all() {
        let levels = stated();
        let found = run.fits(InitialState::Known, Spread::Stated(&levels));
        let expected = numbers(&run.expected["standard_errors"]);
        for (i, error) in found[3].standard_errors.iter().enumerate() {
            // The oracle's differences straddle the kink of u |u| at standstill.
            approx::assert_relative_eq!(*error, expected[i], max_relative = 2e-4);
        }
    }
}

#[test]
fn oracle_innovations_agree_with_a_filter_in_plain_matrices() {
    for run in Run::all() {
        let unknowns: Vec<Lane> =
            truth(&run.vessel).into_iter().chain([0.0; 6]).map(Lane::splat).collect();
        for kind in ["white", "markov", "all"] {
            let expected = numbers(&run.expected["innovations"][kind]);
            let found = innovations(&run.recordings(), &unknowns, &levels(kind), InitialState::Known);
            assert_eq!(found.len(), expected.len());
            for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                assert!((found[5] - expected).abs() < 1e-7, "{kind} {i}: {}, expected {expected}", found[5]);
            }
        }
    }
}
