//! Properties of pooled estimates that hold by theory.

use approx::assert_relative_eq;
use estimation::pooled::{Bootstrap, Follow, Resample, least_errors, redraw};
use estimation::predictor::InitialState;
use regression::Sums;
use regression::pooled::{Part, Regression, fit};
use ship::engine::{RunView, Streams, simulate_one};

use crate::support::craft::{COMPLETE, TRUTH, craft, errors, many, part, regressions};
use crate::support::noise::Normals;
use crate::support::{Experiment, dictionary, paper, truth};

/// Free simulations that start at known states in still water.
fn still() -> Follow {
    Follow::Simulated(InitialState::Known.into())
}

#[test]
fn law_bootstrap_and_sandwich_agree_on_much_data() {
    let vessel = craft();
    let data = regressions(&vessel, &many(&vessel, 80, 60, 7));
    let sums: Vec<Sums> = data.iter().map(Regression::sums).collect();
    let sums: Vec<&Sums> = sums.iter().collect();
    let (_, errors) = errors(&data, &sums, 8);
    let streams = Streams::new(1, "test");
    let resample = |number: u32| {
        let drawn: Vec<&Sums> = redraw(&streams, number, sums.len()).into_iter().map(|i| sums[i]).collect();
        let fitted = fit(&drawn, &COMPLETE).into_iter();
        let theta = fitted.flat_map(|degree| degree.solution.unwrap().theta.into_iter().map(Some)).collect();
        Resample { number, theta }
    };
    let resamples: Vec<Resample> = (0..600).map(resample).collect();
    assert_eq!(resamples[7], resample(7));
    let resampled = Bootstrap::of_resamples(&resamples, &(0..TRUTH.len())).unwrap();
    assert_eq!(resampled.failed, 0);
    let found: Vec<f64> = resampled.parameters.iter().map(|p| p.std).collect();
    for (bootstrap, sandwich) in found.iter().zip(&errors) {
        assert!((bootstrap / sandwich - 1.0).abs() < 0.3, "{found:?} {errors:?}");
    }
}

#[test]
fn law_output_errors_vanish_at_the_truth_that_undisturbed_data_came_from() {
    let vessel = craft();
    let mut normals = Normals::new(1);
    let parts: Vec<Part> = (0..3).map(|i| part(&vessel, 60, i, &mut normals, false)).collect();
    let lifted = vessel.model.with_intercepts();
    let start = lifted.layout().woven(&vessel.nominal, [0.0; 3]);
    let sizes = lifted.layout().woven(&TRUTH.map(f64::abs), [1e-3; 3]);
    let Ok(found) = least_errors(&lifted, &parts, &start, [0.2, 0.1, 0.05], &sizes, &still());
    for (found, truth) in found.unwrap().parameters.iter().zip(lifted.layout().woven(&TRUTH, [0.0; 3])) {
        assert_relative_eq!(*found, truth, max_relative = 1e-4, epsilon = 1e-6);
    }
    let held = lifted.layout().woven(&[1.0; 8], [0.0; 3]);
    let Ok(found) = least_errors(&lifted, &parts, &start, [0.2, 0.1, 0.05], &held, &still());
    let found = found.unwrap().parameters;
    assert_eq!([3, 6, 10].map(|i: usize| found[i]), [0.0; 3]);
}

/// The definition of a jackknife, with a new search for every estimate.
#[test]
fn law_standard_errors_of_output_error_are_those_of_estimates_with_a_part_left_out() {
    let vessel = craft();
    let parts = many(&vessel, 12, 60, 11);
    let lifted = vessel.model.with_intercepts();
    let start = lifted.layout().woven(&TRUTH, [0.0; 3]);
    let sizes = lifted.layout().woven(&TRUTH.map(f64::abs), [1e-3; 3]);
    let of = |parts: &Vec<Part>| {
        let Ok(found) = least_errors(&lifted, parts, &start, [0.2, 0.1, 0.05], &sizes, &still());
        found.unwrap()
    };
    let found = of(&parts);
    let without = |i: usize| {
        let others = parts.iter().enumerate().filter(|(k, _)| *k != i).map(|(_, part)| part.clone());
        of(&others.collect()).parameters
    };
    let left: Vec<Vec<f64>> = (0..parts.len()).map(without).collect();
    let (n, g) = (start.len(), parts.len() as f64);
    for i in 0..n {
        let squares: f64 = left.iter().map(|own| (own[i] - found.parameters[i]).powi(2)).sum();
        let (expected, own) = ((squares * (g - 1.0) / g).sqrt(), found.covariance[i * n + i].sqrt());
        assert!((own / expected - 1.0).abs() < 0.1, "{i}: {own} {expected}");
        assert!(
            (2.0..=g * (1.0 + 1e-9)).contains(&found.effective_parts[i]),
            "{i}: {}",
            found.effective_parts[i]
        );
    }
}

/// Equal parts are equally informative; a repeated part only increases the number of parts.
#[test]
fn law_as_many_parts_tell_of_a_parameter_as_there_are_where_all_are_alike() {
    let vessel = craft();
    let one = many(&vessel, 1, 90, 12).pop().unwrap();
    let lifted = vessel.model.with_intercepts();
    let start = lifted.layout().woven(&TRUTH, [0.0; 3]);
    let sizes = lifted.layout().woven(&TRUTH.map(f64::abs), [1e-3; 3]);
    for count in [1, 2, 5] {
        let Ok(found) =
            least_errors(&lifted, &vec![one.clone(); count], &start, [0.2, 0.1, 0.05], &sizes, &still());
        for effective_parts in found.unwrap().effective_parts {
            assert_relative_eq!(effective_parts, count as f64, max_relative = 1e-6);
        }
    }
}

/// Sub-experiments of which every sample is noisy, the first too: with the start of each as an unknown, intervals
/// have about their nominal coverage; with measured starts, they do not.
#[test]
fn law_standard_errors_hold_where_parts_start_at_noisy_samples() {
    const SETS: u64 = 16;
    let vessel = paper();
    let plan = [(0, 193), (4, 43), (5, 229), (6, 101), (7, 85), (10, 349)];
    let experiment = Experiment::of_maneuvers(&dictionary(&vessel), &plan);
    let theta = truth(&vessel);
    let states = simulate_one(&vessel.model, &theta, experiment.initial, &experiment.inputs);
    let sets: Vec<Vec<Part>> = (0..SETS)
        .map(|set| {
            let mut normals = Normals::new(set);
            let run = |_| {
                let noisy: Vec<f64> = states.iter().map(|x| x + 0.16 * normals.next()).collect();
                let whole = RunView::measured(&noisy, &experiment.inputs);
                let ends = plan.iter().scan(0, |end, (_, samples)| {
                    *end += samples;
                    Some(*end - samples..*end)
                });
                ends.map(|samples| Part::new("", "", whole.part(samples))).collect::<Vec<Part>>()
            };
            (0..8).flat_map(run).collect()
        })
        .collect();
    let sizes: Vec<f64> = theta.iter().map(|value| value.abs()).collect();
    let held = |initial: InitialState| {
        let of = |parts: &Vec<Part>| {
            let follow = Follow::Simulated(initial.into());
            let Ok(found) = least_errors(&vessel.model, parts, &theta, [0.3, 0.2, 0.3], &sizes, &follow);
            let found = found.unwrap();
            let errors = found.covariance.iter().step_by(theta.len() + 1).map(|variance| variance.sqrt());
            let all = found.parameters.iter().zip(&theta).zip(errors);
            all.filter(|((found, truth), error)| (*found - *truth).abs() < 1.96 * error).count()
        };
        let held: usize = sets.iter().map(of).sum();
        held as f64 / (sets.len() * theta.len()) as f64
    };
    let (unknown, measured) = (held(InitialState::Estimated), held(InitialState::Known));
    assert!(unknown >= 0.85 && measured < unknown - 0.15, "{unknown} {measured}");
}
