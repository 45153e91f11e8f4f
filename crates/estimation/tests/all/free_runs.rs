//! Free simulations: their errors by independent computation, and that a diverging one is reported.

use approx::assert_relative_eq;
use estimation::predictor::{Recordings, Sensitivities};
use estimation::{FreeRun, free_runs};
use numerics::{LANES, Lane};
use proptest::prelude::*;
use ship::engine::{DIVERGED, simulate_one};
use ship::model::Source;

use crate::support::craft::numbers;
use crate::support::noise::Normals;
use crate::support::{self, Experiment, Recording, SideBySide, lanes, paper, truth};

fn oracle() -> serde_json::Value {
    let mut whole: serde_json::Value =
        serde_json::from_str(include_str!("../../../../fixtures/oracle/oracle.json")).unwrap();
    whole["validation"].take()
}

#[test]
fn oracle_validation_errors_of_free_simulation() {
    let (vessel, expected) = (paper(), oracle());
    let inputs: Vec<f64> = expected["inputs"].as_array().unwrap().iter().flat_map(numbers).collect();
    let initial: [f64; 3] = numbers(&expected["initial"]).try_into().unwrap();
    let reference = simulate_one(&vessel.model, &support::truth(&vessel), initial, &inputs);
    let scores = expected["scores"].as_array().unwrap();
    let thetas: Vec<Vec<f64>> = scores.iter().map(|s| numbers(&s["theta"])).collect();
    let parameters = lanes(std::array::from_fn(|lane| thetas[lane % thetas.len()].as_slice()));
    let exogenous: Vec<Lane> = inputs.iter().map(|x| Lane::splat(*x)).collect();
    let found = free_runs(&vessel.model, &parameters, &exogenous, &reference);
    for (lane, run) in found.iter().enumerate() {
        let score = &scores[lane % scores.len()];
        let FreeRun::Rmse(rmse) = run else { panic!("lane {lane}: {run:?}") };
        for (found, expected) in rmse.iter().zip(numbers(&score["rmse"])) {
            assert_relative_eq!(*found, expected, max_relative = 1e-9);
        }
        let norm = score["simulation_error"].as_f64().unwrap();
        assert_relative_eq!(run.norm().unwrap(), norm, max_relative = 1e-9);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// An additional channel that no term uses changes no sensitivity.
    #[test]
    fn law_a_channel_that_no_term_has_changes_no_bit(seed in 0u64..1000, lengths in [20usize..90, 20usize..90]) {
        let vessel = paper();
        let mut any = vessel.model.clone();
        any.variables.push(ship::model::Variable { name: "idle".to_owned(), unit: "1".to_owned() });
        let mut normals = Normals::new(seed);
        let experiment = Experiment::random(&mut normals, &lengths);
        let runs: Vec<Recording> = (0..LANES).map(|_| experiment.record(&vessel, 0.1, &mut normals)).collect();
        let side_by_side = SideBySide::new(&runs.iter().collect::<Vec<_>>());
        let own = side_by_side.batch(&vessel.model);
        let wider: Vec<Lane> =
            own.exogenous.chunks_exact(3).flat_map(|row| row.iter().copied().chain([Lane::ONE])).collect();
        let initial = [0, 1, 2].map(|d: usize| own.measured[d]);
        let free: Vec<usize> = (0..13).collect();
        let unknowns: Vec<Lane> = (0..16).map(|i| Lane::splat(0.01 * f64::from(i) - 0.1)).collect();
        let paths = [(&vessel.model, own.exogenous), (&any, wider.as_slice())].map(|(model, exogenous)| {
            let model = &model.with_intercepts();
            let samples = [own.samples(); LANES];
            let recordings = Recordings { model, measured: own.measured, exogenous, initial, samples };
            format!("{:?}", Sensitivities::of(&recordings, &unknowns, &free, true))
        });
        prop_assert_eq!(&paths[0], &paths[1]);
    }

    /// A free simulation either has finite errors or is reported with its first sample beyond the bound.
    #[test]
    fn law_a_diverging_model_is_reported_and_is_never_a_nan(seed in 0u64..1_000_000) {
        let vessel = paper();
        let mut normals = Normals::new(seed);
        let experiment = Experiment::random(&mut normals, &[60]);
        let reference = experiment.states(&vessel, Source::Value);
        let scale = 10.0_f64.powi((seed % 5) as i32 - 1);
        let models: Vec<Vec<f64>> = (0..LANES)
            .map(|_| truth(&vessel).iter().map(|t| t * (1.0 + scale * normals.next())).collect())
            .collect();
        let parameters = lanes(std::array::from_fn(|lane| models[lane].as_slice()));
        let exogenous: Vec<Lane> = experiment.inputs.iter().map(|x| Lane::splat(*x)).collect();
        let found = free_runs(&vessel.model, &parameters, &exogenous, &reference);
        for (model, run) in models.iter().zip(found) {
            match (run, first_beyond(model, &experiment)) {
                (FreeRun::Diverged(found), Some(expected)) => {
                    prop_assert_eq!(found, expected);
                    prop_assert!(run.norm().is_none());
                }
                (FreeRun::Rmse(rmse), None) => prop_assert!(rmse.iter().all(|e| e.is_finite() && *e >= 0.0)),
                other => prop_assert!(false, "{:?}", other),
            }
        }
    }
}

/// First sample with a state beyond the bound, by plain loops.
fn first_beyond(model: &[f64], experiment: &Experiment) -> Option<usize> {
    let mut state = experiment.initial.to_vec();
    for (k, tau) in experiment.inputs.chunks(3).enumerate() {
        let phi = support::explicit::regressors(&state, tau);
        let mut next = 0;
        for (d, phi) in phi.iter().enumerate() {
            state[d] += phi.iter().zip(&model[next..]).map(|(f, t)| f * t).sum::<f64>();
            next += phi.len();
        }
        if !state.iter().all(|x| x.abs() <= DIVERGED) {
            return Some(k + 1);
        }
    }
    None
}

#[test]
fn a_model_of_nans_and_infinities_is_reported_as_diverged() {
    let (vessel, mut normals) = (paper(), Normals::new(1));
    let experiment = Experiment::random(&mut normals, &[20]);
    let reference = experiment.states(&vessel, Source::Value);
    let mut parameters: Vec<Lane> = truth(&vessel).into_iter().map(Lane::splat).collect();
    (parameters[0][1], parameters[3][2], parameters[9][5]) = (f64::NAN, f64::INFINITY, f64::NEG_INFINITY);
    let exogenous: Vec<Lane> = experiment.inputs.iter().map(|x| Lane::splat(*x)).collect();
    let found = free_runs(&vessel.model, &parameters, &exogenous, &reference);
    for (lane, run) in found.iter().enumerate() {
        let expected = if [1, 2, 5].contains(&lane) { FreeRun::Diverged(1) } else { FreeRun::Rmse([0.0; 3]) };
        assert_eq!(*run, expected, "lane {lane}");
    }
}
