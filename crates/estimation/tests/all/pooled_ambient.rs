//! Properties of pooled estimates if a current is unknown, or found by a filter.

use approx::assert_relative_eq;
use estimation::Estimator;
use estimation::pooled::{Follow, Pool, Searched, least_errors};
use estimation::predictor::{
    Fitted, Flow, InitialState, NoiseModel, RunFit, Spread, Unknown, output_error, prediction_error,
};
use estimation::runs::{AdditionalUnknowns, Intercepts, UnknownCurrent};
use numerics::Lane;
use regression::pooled::Part;
use ship::engine::{RunView, Weather, simulate};
use ship::model::Vessel;

use crate::support::noise::Normals;
use crate::support::{Experiment, dictionary, paper, truth};

const EARTH: AdditionalUnknowns =
    AdditionalUnknowns { current: UnknownCurrent::Earth, intercepts: Intercepts::None };
/// Maneuvers of the dictionary that are informative about every parameter, in runs of several lengths.
const PLANS: [&[(usize, usize)]; 4] = [
    &[(0, 80), (5, 110), (7, 50), (10, 90)],
    &[(4, 40), (5, 100), (6, 60), (10, 130)],
    &[(10, 120), (0, 70), (5, 120)],
    &[(7, 60), (10, 110), (5, 120), (4, 40)],
];

fn unknown(vessel: &Vessel, additional: AdditionalUnknowns) -> Unknown {
    Unknown::new(InitialState::Known, additional, 1.0 / vessel.sample_rate_hz)
}

/// Constant or drifting currents over ground, two components per sample.
type Water<'a> = dyn FnMut(usize) -> [f64; 2] + 'a;

/// A run of the paper's vessel in a current, with noise on all samples but the first.
fn part(
    vessel: &Vessel,
    plan: &[(usize, usize)],
    water: &mut Water,
    noise: f64,
    normals: &mut Normals,
) -> Part {
    let experiment = Experiment::of_maneuvers(&dictionary(vessel), plan);
    let samples = experiment.inputs.len() / 3;
    let current: Vec<Lane> = (0..samples).flat_map(|k| water(k).map(Lane::splat)).collect();
    let mut states = vec![Lane::ZERO; 3 * (samples + 1)];
    let weather = Weather { current: &current, turning: 1.0 / vessel.sample_rate_hz, force: &[] };
    let theta: Vec<Lane> = truth(vessel).into_iter().map(Lane::splat).collect();
    simulate(
        &vessel.model,
        &theta,
        experiment.initial.map(Lane::splat),
        &experiment.inputs,
        &weather,
        &mut states,
    );
    let mut measured: Vec<f64> = states.iter().map(|x| x[0]).collect();
    measured[3..].iter_mut().for_each(|y| *y += noise * normals.next());
    Part::new("run", "a", RunView::measured(&measured, &experiment.inputs))
}

/// Runs with a different current in each, and the currents.
fn parts(vessel: &Vessel, noise: f64, seed: u64) -> (Vec<Part>, Vec<[f64; 2]>) {
    let mut normals = Normals::new(seed);
    let waters: Vec<[f64; 2]> = PLANS.iter().map(|_| [0, 1].map(|_| 0.08 * normals.next())).collect();
    let parts = PLANS.iter().zip(&waters).map(|(plan, water)| {
        let water = *water;
        part(vessel, plan, &mut |_| water, noise, &mut normals)
    });
    (parts.collect(), waters)
}

fn found(vessel: &Vessel, parts: &Vec<Part>, std: [f64; 3], start: &[f64], follow: &Follow) -> Searched {
    let sizes: Vec<f64> = truth(vessel).iter().map(|t| t.abs()).collect();
    let Ok(found) = least_errors(&vessel.model, parts, start, std, &sizes, follow);
    found.unwrap()
}

#[test]
fn law_the_current_of_every_run_is_found_with_the_parameters_of_all() {
    let vessel = paper();
    let (parts, waters) = parts(&vessel, 0.0, 5);
    let of = |additional| {
        let follow = Follow::Simulated(unknown(&vessel, additional));
        found(&vessel, &parts, [0.3, 0.1, 0.1], &vessel.nominal, &follow)
    };
    let own = of(EARTH);
    for (found, truth) in own.parameters.iter().zip(truth(&vessel)) {
        assert_relative_eq!(*found, truth, max_relative = 1e-4);
    }
    for ([found, _], truth) in own.currents.iter().zip(waters) {
        assert_relative_eq!(found[0], truth[0], max_relative = 1e-3);
        assert_relative_eq!(found[1], truth[1], max_relative = 1e-3);
    }
    let still = of(AdditionalUnknowns { current: UnknownCurrent::None, ..EARTH });
    assert!(still.currents.is_empty());
    let mut pairs = still.parameters.iter().zip(truth(&vessel));
    assert!(pairs.any(|(found, truth)| (found / truth - 1.0).abs() > 0.05));
}

fn converged(fits: Vec<RunFit>) -> Fitted {
    match fits.into_iter().next() {
        Some(RunFit::Converged(found)) => found,
        other => panic!("{other:?}"),
    }
}

/// The current that is projected out equals the one that is estimated with the parameters.
#[test]
fn law_of_one_run_pooled_and_single_estimates_are_the_same() {
    let vessel = paper();
    let (mut parts, _) = parts(&vessel, 0.02, 6);
    parts.truncate(1);
    let (view, starts) = (parts[0].view(), vec![vec![vessel.nominal.clone()]]);
    let ambient = unknown(&vessel, EARTH);
    let single = converged(output_error(&vessel.model, &[view], &starts, ambient, Spread::Blocks));
    // The final weights of the likelihood.
    let pooled = found(&vessel, &parts, single.rmse, &vessel.nominal, &Follow::Simulated(ambient));
    for (a, b) in pooled.parameters.iter().zip(&single.parameters) {
        assert_relative_eq!(*a, *b, max_relative = 1e-5);
    }
    for (a, b) in pooled.currents[0][0].iter().zip(single.current.unwrap()[0]) {
        assert_relative_eq!(*a, b, max_relative = 1e-4, epsilon = 1e-9);
    }
}

#[test]
fn law_standard_errors_of_currents_are_their_spread() {
    let vessel = paper();
    let follow = Follow::Simulated(unknown(&vessel, EARTH));
    let (mut squares, mut predicted, runs) = ([[0.0; 2]; 4], [[0.0; 2]; 4], 60);
    for seed in 0..runs {
        let (parts, waters) = parts(&vessel, 0.02, 100 + seed);
        let own = found(&vessel, &parts, [0.02; 3], &truth(&vessel), &follow);
        for (i, ([values, errors], truth)) in own.currents.iter().zip(waters).enumerate() {
            for c in 0..2 {
                squares[i][c] += (values[c] - truth[c]).powi(2);
                predicted[i][c] += errors[c].powi(2);
            }
        }
    }
    // Of 60 squares the mean varies by a fifth; standard errors count few samples as correlated and four parts as many.
    for (square, predicted) in squares.iter().flatten().zip(predicted.iter().flatten()) {
        let ratio = (predicted / square).sqrt();
        assert!((0.6..1.6).contains(&ratio), "{ratio}: {squares:?} {predicted:?}");
    }
}

/// The same gains, and an equally unknown start.
#[test]
fn law_of_one_run_pooled_and_single_predictions_are_the_same() {
    let vessel = paper();
    let mut normals = Normals::new(8);
    let rate = vessel.sample_rate_hz;
    let levels = NoiseModel {
        measurement: [0.02; 3],
        current: Flow::Markov { std: 0.05, factor: (-1.0 / (30.0 * rate)).exp(), turning: 1.0 / rate },
        force: None,
        drift: None,
    };
    let parts = vec![drifted(&vessel, PLANS[1], &levels, &mut normals)];
    let (view, starts) = (parts[0].view(), vec![vec![truth(&vessel)]]);
    let single =
        converged(prediction_error(&vessel.model, &[view], &starts, InitialState::Estimated, &levels));
    let follow = Follow::Predicted(levels, single.parameters.clone());
    let pooled = found(&vessel, &parts, [1.0; 3], &single.parameters, &follow);
    for ((a, b), error) in pooled.parameters.iter().zip(&single.parameters).zip(&single.standard_errors) {
        assert!((a - b).abs() < 0.1 * error, "{a} {b} {error}");
    }
}

/// In a current that drifts as `levels` say.
fn drifted(vessel: &Vessel, plan: &[(usize, usize)], levels: &NoiseModel, normals: &mut Normals) -> Part {
    let Flow::Markov { std, factor, .. } = levels.current else { panic!("drifts") };
    let mut own = Normals::new((1e6 * normals.next().abs()) as u64);
    let mut water = [0, 1].map(|_| std * own.next());
    let mut drift = |_| {
        let now = water;
        water = now.map(|c| factor * c + std * (1.0 - factor * factor).sqrt() * own.next());
        now
    };
    part(vessel, plan, &mut drift, levels.measurement[0], normals)
}

/// For runs in a drifting current, which a simulation does not model: the filter's levels are found, and its
/// parameters are closer to the truth.
#[test]
fn law_predictions_of_pooled_runs_find_the_drift_and_better_parameters() {
    let vessel = paper();
    let mut normals = Normals::new(9);
    let rate = vessel.sample_rate_hz;
    let levels = NoiseModel {
        measurement: [0.02; 3],
        current: Flow::Markov { std: 0.08, factor: (-1.0 / (20.0 * rate)).exp(), turning: 1.0 / rate },
        force: None,
        drift: None,
    };
    let pool = Pool::new(&vessel);
    let distance = |theta: &[f64]| {
        let relative = theta.iter().zip(truth(&vessel)).map(|(a, b)| (a / b - 1.0).powi(2));
        relative.sum::<f64>().sqrt()
    };
    let (mut simulated, mut predicted) = (0.0, 0.0);
    for _ in 0..4 {
        let parts: Vec<Part> =
            PLANS.iter().map(|plan| drifted(&vessel, plan, &levels, &mut normals)).collect();
        let of = |estimator| pool.estimate(&parts, estimator).unwrap_or_else(|_| panic!("{estimator}"));
        let (free, filtered) = (of(Estimator::OutputError), of(Estimator::PredictionError));
        assert_eq!(filtered.used, [Estimator::PredictionError; 3]);
        simulated += distance(&free.theta().unwrap().0);
        predicted += distance(&filtered.theta().unwrap().0);
        let (_, scales) = filtered.searched.as_ref().unwrap();
        let Follow::Predicted(own, _) = scales.follow() else { panic!("predicted") };
        let Flow::Markov { std, factor, .. } = own.current else { panic!("{own:?}") };
        let time_s = -1.0 / (rate * factor.ln());
        assert!((0.04..0.16).contains(&std) && (5.0..80.0).contains(&time_s), "{std} {time_s}");
        own.measurement.iter().for_each(|noise| assert_relative_eq!(*noise, 0.02, max_relative = 0.2));
    }
    assert!(predicted < 0.6 * simulated, "{predicted} {simulated}");
}
