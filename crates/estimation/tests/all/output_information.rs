//! Sensitivities and predicted covariances of free simulation against difference quotients and simulated noise.

use estimation::predictor::{Recordings, Sensitivities};
use estimation::{Simulated, output_information, output_informations, prediction_weights};
use numerics::Lane;
use regression::Noise;
use ship::engine::{Weather, simulate, simulate_one};
use ship::model::Model;

use crate::support::*;

/// The sensitivities of one run to all parameters, ∂x_d(k)/∂θ̃ for k = 1 to N: N × 3 × n, row-major.
fn sensitivities(lifted: &Model, parameters: &[f64], experiment: &Experiment) -> Vec<f64> {
    let n = parameters.len();
    let run = Recordings::simulated(lifted, experiment.initial, &experiment.inputs);
    let unknowns = [parameters, &[0.0; 3]].concat();
    let found = Sensitivities::of(&run, &unknowns, &(0..n).collect::<Vec<_>>(), false);
    let row = |k: usize, d: usize| (0..n).map(|i| found.by(k, i)[d]).collect::<Vec<f64>>();
    (1..=run.longest()).flat_map(|k| (0..3).flat_map(|d| row(k, d)).collect::<Vec<_>>()).collect()
}

/// The model with intercepts, which are zero.
fn lifted(model: &Model, theta: &[f64]) -> (Model, Vec<f64>) {
    let lifted = model.with_intercepts();
    let parameters = lifted.layout().woven(theta, [0.0; 3]);
    (lifted, parameters)
}

#[test]
fn law_sensitivities_are_the_difference_quotients_of_free_simulation() {
    let vessel = paper();
    let generator = dictionary(&vessel);
    let experiment = Experiment::of_maneuvers(&generator, &[(7, 60), (10, 60), (0, 40)]);
    let (model, at) = lifted(&vessel.model, &truth(&vessel));
    let (s, n) = (sensitivities(&model, &at, &experiment), at.len());
    for p in 0..n {
        // A step that changes the states by about a hundredth.
        let step = if at[p] == 0.0 { 1e-6 } else { 1e-5 * at[p].abs() };
        let moved = |sign: f64| {
            let mut theta = at.clone();
            theta[p] += sign * step;
            simulate_one(&model, &theta, experiment.initial, &experiment.inputs)
        };
        let (up, down) = (moved(1.0), moved(-1.0));
        let size = s.iter().skip(p).step_by(n).fold(0.0_f64, |most, x| most.max(x.abs()));
        for (row, found) in s.iter().skip(p).step_by(n).enumerate() {
            let expected = (up[3 + row] - down[3 + row]) / (2.0 * step);
            assert!((found - expected).abs() < 1e-6 * size, "parameter {p}, row {row}: {found} {expected}");
        }
    }
}

#[test]
fn law_the_middle_matrix_is_what_every_single_draw_moves() {
    let vessel = paper();
    let generator = dictionary(&vessel);
    let experiment = Experiment::of_maneuvers(&generator, &[(7, 25), (10, 25)]);
    let (model, theta) = (&vessel.model, truth(&vessel));
    let noise = Noise { measurement: [0.1, 0.2, 0.05], current: 0.3 };
    let found = output_information(model, &theta, experiment.initial, &experiment.inputs, &noise).unwrap();
    let (own, at) = lifted(model, &theta);
    let s = sensitivities(&own, &at, &experiment);
    let (n, samples) = (at.len(), experiment.inputs.len() / 3);
    let weights = noise.measurement.map(|std| 1.0 / (std * std));
    let mut expected = vec![0.0; n * n];
    let mut information = vec![0.0; n * n];
    let parameters: Vec<Lane> = theta.iter().map(|t| Lane::splat(*t)).collect();
    for draw in 0..2 * samples {
        let moved = |sign: f64| {
            let mut current = vec![Lane::ZERO; 2 * samples];
            current[draw] = Lane::splat(sign * 1e-5);
            let mut states = vec![Lane::ZERO; 3 * (samples + 1)];
            let initial = experiment.initial.map(Lane::splat);
            let weather = Weather { current: &current, ..Weather::CALM };
            simulate(model, &parameters, initial, &experiment.inputs, &weather, &mut states);
            states.iter().map(|lane| lane[0]).collect::<Vec<f64>>()
        };
        let (up, down) = (moved(1.0), moved(-1.0));
        let mut g = vec![0.0; n];
        for (row, gradient) in s.chunks_exact(n).enumerate() {
            let change = (up[3 + row] - down[3 + row]) / 2e-5;
            g.iter_mut().zip(gradient).for_each(|(g, s)| *g += weights[row % 3] * s * change);
        }
        (0..n * n).for_each(|e| expected[e] += 0.3 * 0.3 * g[e / n] * g[e % n] / samples as f64);
    }
    for (row, gradient) in s.chunks_exact(n).enumerate() {
        let share = weights[row % 3] / samples as f64;
        (0..n * n).for_each(|e| information[e] += share * gradient[e / n] * gradient[e % n]);
    }
    for (name, found, expected) in [
        ("P", &found.process, &expected),
        ("F", &found.information, &information),
        ("E", &found.measurement, &information),
    ] {
        for e in 0..n * n {
            let size = (expected[e / n * (n + 1)] * expected[e % n * (n + 1)]).sqrt();
            assert!((found[e] - expected[e]).abs() < 1e-6 * size, "{name} {e}: {} {}", found[e], expected[e]);
        }
    }
}

#[test]
fn law_the_variance_of_a_free_run_is_the_trace_of_weights_and_covariance() {
    let vessel = paper();
    let generator = dictionary(&vessel);
    let experiment = Experiment::of_maneuvers(&generator, &[(8, 80)]);
    let (model, theta) = (&vessel.model, truth(&vessel));
    let weights = prediction_weights(model, &theta, experiment.initial, &experiment.inputs).unwrap();
    let n = model.layout().with_intercepts().parameters();
    // One direction of small errors: δᵀ G δ is the mean square of its effect.
    let error = |(i, t): (usize, &f64)| 1e-4 * t * if i.is_multiple_of(2) { 1.0 } else { -0.5 };
    let by: Vec<f64> = theta.iter().enumerate().map(error).collect();
    let moved: Vec<f64> = theta.iter().zip(&by).map(|(t, e)| t + e).collect();
    let errors = model.layout().with_intercepts().woven(&by, [0.0; 3]);
    let run = |theta: &[f64]| simulate_one(model, theta, experiment.initial, &experiment.inputs);
    let difference = run(&moved).iter().zip(run(&theta)).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / 80.0;
    let predicted: f64 = (0..n * n).map(|e| errors[e / n] * weights[e] / 80.0 * errors[e % n]).sum();
    assert!((difference - predicted).abs() < 1e-3 * predicted, "{difference} {predicted}");
}

#[test]
fn law_runs_side_by_side_tell_what_each_tells_alone() {
    let vessel = paper();
    let generator = dictionary(&vessel);
    let (model, theta) = (&vessel.model, truth(&vessel));
    let noise = Noise { measurement: [0.1, 0.2, 0.05], current: 0.3 };
    let lengths = (0..generator.maneuvers().len()).map(|index| if index == 4 { 90 } else { 120 });
    let runs: Vec<_> = lengths.enumerate().map(|(q, n)| generator.realize(q, n).unwrap()).collect();
    // Each with its own model.
    let scaled = |q: usize| theta.iter().map(move |t| t * (1.0 + 0.01 * q as f64)).collect();
    let models: Vec<Vec<f64>> = (0..runs.len()).map(scaled).collect();
    let each = runs.iter().zip(&models);
    let views: Vec<Simulated> =
        each.map(|(run, theta)| Simulated { theta, initial: run.initial, exogenous: &run.inputs }).collect();
    let together = output_informations(model, &views, &noise);
    assert_eq!(together.len(), runs.len());
    for (run, found) in views.iter().zip(together) {
        let alone = output_information(model, run.theta, run.initial, run.exogenous, &noise).unwrap();
        let found = found.unwrap();
        let n = model.layout().with_intercepts().parameters();
        let pairs = [(&found.information, &alone.information), (&found.process, &alone.process)];
        for (found, alone) in pairs.into_iter().chain([(&found.measurement, &alone.measurement)]) {
            for e in 0..n * n {
                let size = (alone[e / n * (n + 1)] * alone[e % n * (n + 1)]).sqrt();
                assert!((found[e] - alone[e]).abs() <= 1e-12 * size, "{e}: {} {}", found[e], alone[e]);
            }
        }
    }
}

/// Finite differences of whole simulations agree to their own accuracy.
#[test]
fn oracle_information_of_every_maneuver() {
    let oracle: serde_json::Value =
        serde_json::from_str(include_str!("../../../../fixtures/oracle/output_information.json")).unwrap();
    let floats = |value: &serde_json::Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let vessel = paper();
    let generator = dictionary(&vessel);
    let (model, theta) = (&vessel.model, truth(&vessel));
    let std = 0.158_113_883_008_418_97;
    let noise = Noise { measurement: [std; 3], current: std };
    let n = model.layout().with_intercepts().parameters();
    for index in 0..generator.maneuvers().len() {
        let run = generator.realize(index, 300).unwrap();
        let found = output_information(model, &theta, run.initial, &run.inputs, &noise).unwrap();
        for (name, found) in [("F", &found.information), ("P", &found.process)] {
            let expected = floats(&oracle[name][index]);
            for e in 0..n * n {
                let size = (expected[e / n * (n + 1)] * expected[e % n * (n + 1)]).sqrt();
                assert!(
                    (found[e] - expected[e]).abs() <= 1e-6 * size + 1e-300,
                    "{name} of {index}, {e}: {} {}",
                    found[e],
                    expected[e]
                );
            }
        }
    }
    let run = generator.realize(0, 300).unwrap();
    let found = prediction_weights(model, &theta, run.initial, &run.inputs).unwrap();
    let expected = floats(&oracle["G"]);
    for e in 0..n * n {
        let size = (expected[e / n * (n + 1)] * expected[e % n * (n + 1)]).sqrt();
        let found = found[e] / 300.0;
        assert!((found - expected[e]).abs() <= 1e-6 * size + 1e-300, "G {e}: {found} {}", expected[e]);
    }
}
