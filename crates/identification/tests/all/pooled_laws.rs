//! What must hold of pooled estimates by theory.

use approx::assert_relative_eq;
use engine::{Run, RunView, Segment, Streams, simulate_one};
use identification::pooled::{Bootstrap, Follow, Resample, least_errors, redraw};
use identification::predictor::InitialState;
use model::{Vessel, VesselFile};
use regression::pooled::{COLLINEAR, Centring, Options, Part, Prior, Regression, Status, fit, sandwich};
use regression::{MeanRemoval, Sums};

use crate::support::noise::Normals;
use crate::support::{Experiment, dictionary, paper, truth};

const TRUTH: [f64; 8] = [-0.06, 0.7, 0.01, -0.25, -0.3, -0.2, -0.08, 0.1];
const COMPLETE: Options = Options { removal: MeanRemoval::Complete, prior: None, most: f64::INFINITY };

/// Free simulations that start at known states in still water.
fn still() -> Follow {
    Follow::Simulated(InitialState::Known.into())
}

pub fn craft() -> Vessel {
    Vessel::from_file(craft_file()).unwrap()
}

pub fn craft_file() -> VesselFile {
    let oracle: serde_json::Value =
        serde_json::from_str(include_str!("../../../../fixtures/oracle/pooled.json")).unwrap();
    toml::from_str(oracle["vessel"].as_str().unwrap()).unwrap()
}

/// Parts as runs of one segment each.
pub fn runs(parts: &[Part]) -> Vec<Run> {
    let run = |(i, part): (usize, &Part)| Run {
        design: "simulated".to_owned(),
        run: i as i32,
        segments: vec![Segment { maneuver: "zigzag".to_owned(), start: 0 }],
        initial: [0, 1, 2].map(|d| part.measured[d]),
        exogenous: part.exogenous.clone(),
        measured: part.measured.clone(),
    };
    parts.iter().enumerate().map(run).collect()
}

/// A part of `samples` samples with forces that are correlated in time and no measurement noise, or none at all.
pub fn part(vessel: &Vessel, samples: usize, number: usize, normals: &mut Normals, disturbed: bool) -> Part {
    let lifted = vessel.model.with_intercepts();
    let phase = number as f64;
    let (mut exogenous, mut measured) = (Vec::new(), vec![1.2, 0.0, 0.0]);
    let mut force = [0.0; 3];
    for k in 0..samples {
        let k = k as f64;
        let swing = (0.32 * k + phase).sin();
        let row = [3.0 + 0.9 * (0.17 * k + 2.0 * phase).sin(), 0.3 * swing.signum()];
        exogenous.extend(row);
        for (f, size) in force.iter_mut().zip([0.004, 0.002, 0.001]) {
            *f = 0.5 * *f + if disturbed { size * normals.next() } else { 0.0 };
        }
        let state = [0, 1, 2].map(|d| measured[measured.len() - 3 + d]);
        let next = simulate_one(&lifted, &lifted.layout().woven(&TRUTH, force), state, &row);
        measured.extend(&next[3..]);
    }
    Part::new("zigzag", "a", RunView::measured(&measured, &exogenous))
}

fn many(vessel: &Vessel, count: usize, samples: usize, seed: u64) -> Vec<Part> {
    let mut normals = Normals::new(seed);
    (0..count).map(|i| part(vessel, samples, i, &mut normals, true)).collect()
}

/// The nominal simulation over every part.
fn simulated(vessel: &Vessel, parts: &[Part]) -> Vec<Vec<f64>> {
    let lifted = vessel.model.with_intercepts();
    let nominal = lifted.layout().woven(&vessel.nominal, [0.0; 3]);
    parts.iter().map(|part| part.whole().simulated(&lifted, &nominal).unwrap()).collect()
}

fn regressions(vessel: &Vessel, parts: &[Part]) -> Vec<Regression> {
    with_instruments(vessel, parts, &simulated(vessel, parts))
}

fn with_instruments(vessel: &Vessel, parts: &[Part], states: &[Vec<f64>]) -> Vec<Regression> {
    let pairs = parts.iter().zip(states);
    pairs.map(|(part, states)| Regression::with(&vessel.model, &part.whole(), states)).collect()
}

fn errors(data: &[Regression], sums: &[&Sums], bandwidth: usize) -> (Vec<f64>, Vec<f64>) {
    let found = fit(sums, &COMPLETE);
    let (data, centring): (Vec<&Regression>, _) =
        (data.iter().collect(), Centring::new(sums, MeanRemoval::Complete));
    let (mut theta, mut errors) = (Vec::new(), Vec::new());
    for (d, degree) in found.iter().enumerate() {
        let solution = degree.solution.as_ref().unwrap();
        let p = solution.theta.len();
        let covariance = sandwich(&data, &centring, solution, d, bandwidth);
        theta.extend(&solution.theta);
        errors.extend((0..p).map(|i| covariance[i * p + i].sqrt()));
    }
    (theta, errors)
}

#[test]
fn law_sums_of_parts_are_those_of_their_concatenation_without_the_seam() {
    let vessel = craft();
    let mut normals = Normals::new(3);
    let [a, b] = [0, 1].map(|i| part(&vessel, 30 + i, i, &mut normals, true));
    let of = |measured: Vec<f64>, inputs: &[f64]| Part::new("", "", RunView::measured(&measured, inputs));
    let inputs = [&a.exogenous[..], &[2.0, 0.1], &b.exogenous[..]].concat();
    let whole = of([&a.measured[..], &b.measured[..]].concat(), &inputs);
    let seam = of([&a.measured[a.measured.len() - 3..], &b.measured[..3]].concat(), &[2.0, 0.1]);
    let sums = |part: &Part| Regression::of(&vessel.model, &part.whole()).sums();
    let (mut parts, whole) = (sums(&a), sums(&whole));
    parts.merge(&sums(&b));
    parts.merge(&sums(&seam));
    assert_eq!(parts.samples, whole.samples);
    for (found, expected) in parts.degrees.iter().zip(&whole.degrees) {
        for (found, expected) in found.a.iter().chain(&found.b).zip(expected.a.iter().chain(&expected.b)) {
            assert_relative_eq!(found, expected, max_relative = 1e-12, epsilon = 1e-15);
        }
    }
}

#[test]
fn law_a_weak_prior_is_none_and_a_strong_one_is_the_nominal_model() {
    let vessel = craft();
    let data = regressions(&vessel, &many(&vessel, 4, 60, 5));
    let sums: Vec<Sums> = data.iter().map(Regression::sums).collect();
    let sums: Vec<&Sums> = sums.iter().collect();
    let theta = |strength: f64| {
        let prior = Some(Prior { strength, nominal: &vessel.nominal });
        let found = fit(&sums, &Options { prior, ..COMPLETE });
        found.into_iter().flat_map(|d| d.solution.unwrap().theta).collect::<Vec<f64>>()
    };
    let (none, weak, strong) = (theta(0.0), theta(1e-7), theta(1e7));
    for i in 0..TRUTH.len() {
        assert_relative_eq!(weak[i], none[i], max_relative = 1e-6);
        assert_relative_eq!(strong[i], vessel.nominal[i], max_relative = 1e-6);
        assert_ne!(none[i], vessel.nominal[i]);
    }
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
fn law_standard_errors_are_the_spread_over_realizations() {
    let vessel = craft();
    let (mut thetas, mut mean_errors) = (Vec::new(), vec![0.0; TRUTH.len()]);
    const RUNS: usize = 400;
    for seed in 0..RUNS {
        let data = regressions(&vessel, &many(&vessel, 10, 80, 1000 + seed as u64));
        let sums: Vec<Sums> = data.iter().map(Regression::sums).collect();
        let (theta, errors) = errors(&data, &sums.iter().collect::<Vec<_>>(), 8);
        mean_errors.iter_mut().zip(errors).for_each(|(m, e)| *m += e / RUNS as f64);
        thetas.push(theta);
    }
    for i in 0..TRUTH.len() {
        let mean = thetas.iter().map(|t| t[i]).sum::<f64>() / RUNS as f64;
        let variance = thetas.iter().map(|t| (t[i] - mean).powi(2)).sum::<f64>() / (RUNS - 1) as f64;
        let ratio = mean_errors[i] / variance.sqrt();
        assert!((ratio - 1.0).abs() < 0.15, "parameter {i}: predicted over found {ratio}");
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

/// The definition of a jackknife, with every estimate searched for anew.
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
        assert!((2.0..=g * (1.0 + 1e-9)).contains(&found.telling[i]), "{i}: {}", found.telling[i]);
    }
}

/// Parts that are the same tell the same; a part that is repeated adds nothing but its number.
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
        for telling in found.unwrap().telling {
            assert_relative_eq!(telling, count as f64, max_relative = 1e-6);
        }
    }
}

/// Sub-experiments of which every sample is noisy, the first too: with the start of each an unknown, intervals hold the truth about
/// as often as they say; from the measured one on, they do not.
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

#[test]
fn a_term_that_hardly_varies_is_collinear_with_the_intercept() {
    let vessel = craft();
    let mut parts = many(&vessel, 4, 60, 5);
    let states = simulated(&vessel, &parts);
    for row in parts.iter_mut().flat_map(|p| p.exogenous.chunks_exact_mut(2)) {
        row[0] = 3.0 + 0.001 * row[0];
    }
    let data = with_instruments(&vessel, &parts, &states);
    let sums: Vec<Sums> = data.iter().map(Regression::sums).collect();
    let sums: Vec<&Sums> = sums.iter().collect();
    let [surge, sway, yaw] = fit(&sums, &Options { most: COLLINEAR, ..COMPLETE });
    let Status::Collinear(diagnosis) = surge.status else { panic!("{:?}", surge.status) };
    assert!(surge.solution.is_none() && diagnosis.index > COLLINEAR && diagnosis.variation[2] < 0.01);
    assert_eq!(diagnosis.weakest, 2);
    assert!(sway.solution.is_some() && yaw.solution.is_some());
}

#[test]
fn a_nominal_simulation_that_diverges_is_told_with_part_and_sample() {
    let vessel = craft();
    let mut parts = many(&vessel, 1, 60, 5);
    parts[0].measured[0] = -1e4;
    parts[0].source = "second".to_owned();
    let lifted = vessel.model.with_intercepts();
    let nominal = lifted.layout().woven(&vessel.nominal, [0.0; 3]);
    let diverged = parts[0].whole().simulated(&lifted, &nominal).unwrap_err();
    assert_eq!((diverged.recording.as_str(), diverged.at.sample, diverged.at.state), ("second", 0, 0));
}

#[test]
fn too_little_data_and_constant_terms_are_not_identified() {
    let vessel = craft();
    let short = regressions(&vessel, &many(&vessel, 1, 3, 5));
    let sums: Vec<Sums> = short.iter().map(Regression::sums).collect();
    let found = fit(&sums.iter().collect::<Vec<_>>(), &COMPLETE);
    assert_eq!(found[0].status, Status::TooShort);
    let mut parts = many(&vessel, 2, 30, 5);
    let states = simulated(&vessel, &parts);
    parts.iter_mut().flat_map(|p| p.exogenous.iter_mut().skip(1).step_by(2)).for_each(|delta| *delta = 0.0);
    let data = with_instruments(&vessel, &parts, &states);
    let sums: Vec<Sums> = data.iter().map(Regression::sums).collect();
    let found = fit(&sums.iter().collect::<Vec<_>>(), &COMPLETE);
    assert_eq!(found[2].status, Status::NotExcited(2));
    assert!(found[0].solution.is_some());
}
