//! Gradients by adjoints against difference quotients; limits of what is refined.

use std::sync::atomic::{AtomicUsize, Ordering};

use approx::assert_relative_eq;
use estimation::output_information;
use estimation::refine::{Effort, SignalLimits, TraceCriterion, refine};
use numerics::Watch;
use regression::Noise;

use crate::support::noise::Normals;
use crate::support::*;

/// 1/θ².
fn relative(theta: &[f64]) -> Vec<f64> {
    theta.iter().map(|t| 1.0 / (t * t)).collect()
}

const NOISES: [Noise; 3] = [
    Noise { measurement: [0.15, 0.1, 0.2], current: 0.16 },
    Noise { measurement: [0.15, 0.1, 0.2], current: 0.0 },
    // Channels are weighted evenly then, and the meat matrix is not the information.
    Noise { measurement: [0.15, 0.0, 0.2], current: 0.1 },
];

#[test]
fn law_the_gradient_is_the_difference_quotient_of_the_criterion() {
    let vessel = paper();
    let experiment = Experiment::of_maneuvers(&dictionary(&vessel), &[(7, 60), (10, 60), (0, 40)]);
    let theta = truth(&vessel);
    let weights = relative(&theta);
    let samples = experiment.inputs.len() / 3;
    let mut normals = Normals::new(5);
    for noise in NOISES {
        let (model, initial) = (&vessel.model, experiment.initial);
        let criterion = TraceCriterion { model, parameters: &theta, weights: &weights, noise, initial };
        let at = criterion.forward(&experiment.inputs).unwrap();
        let state_slopes: Vec<f64> = (0..3 * (samples + 1)).map(|_| 0.01 * normals.next()).collect();
        let slopes = criterion.gradient(&at, &experiment.inputs, &state_slopes);
        let value = |inputs: &[f64]| {
            let run = criterion.forward(inputs).unwrap();
            let other: f64 = run.states.iter().zip(&state_slopes).map(|(x, s)| x * s).sum();
            run.value.ln() + other
        };
        let size = [500.0, 100.0, 50.0];
        let quotient = |direction: &[f64], h: f64| {
            let moved = |h: f64| -> Vec<f64> {
                experiment.inputs.iter().zip(direction).map(|(x, d)| x + h * d).collect()
            };
            // Richardson extrapolation: the error is of the fourth order.
            let central = |h: f64| (value(&moved(h)) - value(&moved(-h))) / (2.0 * h);
            (4.0 * central(h / 2.0) - central(h)) / 3.0
        };
        for _ in 0..4 {
            let direction: Vec<f64> = (0..3 * samples).map(|e| size[e % 3] * normals.next()).collect();
            let along: f64 = slopes.iter().zip(&direction).map(|(g, d)| g * d).sum();
            assert_relative_eq!(along, quotient(&direction, 2e-3), max_relative = 1e-6);
        }
        let largest = (0..3 * samples).map(|e| (size[e % 3] * slopes[e]).abs()).fold(0.0, f64::max);
        for e in [0, 1, 2, 100, 221, 307, 3 * samples - 4] {
            let mut direction = vec![0.0; 3 * samples];
            direction[e] = size[e % 3];
            let found = size[e % 3] * slopes[e];
            // One sample moves the criterion little: a longer way, against rounding.
            let expected = quotient(&direction, 0.05);
            assert!((found - expected).abs() < 1e-6 * largest, "input {e}: {found} {expected} of {largest}");
        }
    }
}

#[test]
fn law_the_criterion_is_that_of_the_predicted_covariance() {
    let vessel = paper();
    let experiment = Experiment::of_maneuvers(&dictionary(&vessel), &[(7, 60), (10, 60), (0, 40)]);
    let (model, theta) = (&vessel.model, truth(&vessel));
    let weights = relative(&theta);
    let (noise, initial) = (NOISES[0], experiment.initial);
    let criterion = TraceCriterion { model, parameters: &theta, weights: &weights, noise, initial };
    let found = criterion.forward(&experiment.inputs).unwrap();
    let predicted = output_information(model, &theta, initial, &experiment.inputs, &noise).unwrap();
    let n = model.layout().with_intercepts().parameters();
    let samples = (experiment.inputs.len() / 3) as f64;
    let meat: Vec<f64> = predicted.measurement.iter().zip(&predicted.process).map(|(e, p)| e + p).collect();
    let mut inverse = vec![0.0; n * n];
    numerics::inverse(n, &mut predicted.information.clone(), &mut inverse).unwrap();
    let variance = |i: usize| -> f64 {
        let pairs = (0..n * n).map(|e| inverse[i * n + e / n] * meat[e] * inverse[e % n * n + i]);
        pairs.sum::<f64>() / samples
    };
    let rows = [0, 1, 2, 3, 5, 6, 7, 9, 10, 11];
    for (found, row) in found.variances.iter().zip(rows) {
        assert_relative_eq!(*found, variance(row), max_relative = 1e-6);
    }
    let sum: f64 = found.variances.iter().zip(&weights).map(|(v, w)| v * w).sum();
    assert_relative_eq!(found.value, sum, max_relative = 1e-12);
}

#[test]
fn law_refined_inputs_keep_every_limit_and_make_the_criterion_smaller() {
    let vessel = paper();
    let experiment = Experiment::of_maneuvers(&dictionary(&vessel), &[(7, 100), (10, 100), (0, 60)]);
    let (model, theta) = (&vessel.model, truth(&vessel));
    let weights = relative(&theta);
    let criterion = TraceCriterion {
        model,
        parameters: &theta,
        weights: &weights,
        noise: NOISES[0],
        initial: experiment.initial,
    };
    let largest =
        |values: &[f64], i: usize| values.iter().skip(i).step_by(3).fold(0.0_f64, |m, x| m.max(x.abs()));
    let states = experiment.states(&vessel, ship::model::Source::Value);
    let free = SignalLimits {
        states: [0, 1, 2].map(|d| largest(&states, d)),
        inputs: (0..3).map(|i| largest(&experiment.inputs, i)).map(|most| [-most, most]).collect(),
        steps: vec![f64::INFINITY; 3],
    };
    let changes: Vec<f64> =
        (3..experiment.inputs.len()).map(|e| experiment.inputs[e] - experiment.inputs[e - 3]).collect();
    let slow = SignalLimits { steps: (0..3).map(|i| largest(&changes, i)).collect(), ..free.clone() };
    let watched = |limits: &SignalLimits, effort: Effort, watch: &Watch| {
        refine(&criterion, &experiment.inputs, limits, &effort, watch).unwrap()
    };
    let run = |limits: &SignalLimits, knot: usize| {
        watched(limits, Effort { knot, iterations: 400 }, &Watch::default())
    };
    let lowest =
        |i: usize| experiment.inputs.iter().skip(i).step_by(3).copied().fold(f64::INFINITY, f64::min);
    let one_sided = SignalLimits {
        inputs: free.inputs.iter().enumerate().map(|(i, [_, high])| [lowest(i), *high]).collect(),
        ..free.clone()
    };
    for (limits, knot) in [(&free, 1), (&free, 8), (&slow, 1), (&one_sided, 1)] {
        let found = run(limits, knot);
        assert!(limits.kept(&found.after.states, &found.inputs));
        assert!(found.after.value < 0.9 * found.before.value, "{} {}", found.after.value, found.before.value);
    }
    let nothing = watched(&free, Effort { knot: 1, iterations: 0 }, &Watch::default());
    assert_eq!(nothing.inputs, experiment.inputs);
    let seen = AtomicUsize::new(0);
    let impatient = Watch::new(move || seen.fetch_add(1, Ordering::Relaxed) < 5);
    let begun = watched(&slow, Effort { knot: 1, iterations: 400 }, &impatient);
    assert!(impatient.ended() && !begun.settled && begun.iterations <= 6, "{}", begun.iterations);
    assert!(begun.after.value <= begun.before.value && slow.kept(&begun.after.states, &begun.inputs));
}
