//! Tests of what a model lacks, on runs for which that is known.

use std::collections::BTreeMap;

use estimation::criticism::{
    Absent, Criticism, Subject, Suspect, Verdict, clearer_under_white, criticise, criticise_each,
};
use estimation::pooled::{Judgement, Pool, Resampling, estimate};
use estimation::predictor::{Flow, InitialState, NoiseModel};
use estimation::runs::{AdditionalUnknowns, RunEstimators};
use estimation::{EstimateStatus, Estimator};
use regression::MeanRemoval;
use regression::pooled::PooledRuns;
use ship::engine::{Compiled, Run, RunView, Segment, simulate_one};
use ship::model::{Model, Term, Vessel};

use crate::support::noise::Normals;
use crate::support::{Experiment, dictionary, paper, truth};

const NOISE: f64 = 0.02;
const STATED: NoiseModel =
    NoiseModel { measurement: [NOISE; 3], current: Flow::Still, force: None, drift: None };

/// The paper's ship with further terms, degree, text and value, which come last in their degrees.
fn with(vessel: &Vessel, more: &[(usize, &str, f64)]) -> (Model, Vec<f64>) {
    let names: Vec<&str> = vessel.model.variables.iter().map(|v| v.name.as_str()).collect();
    let (mut model, theta, layout) = (vessel.model.clone(), truth(vessel), vessel.model.layout());
    let mut values: [Vec<f64>; 3] = [0, 1, 2].map(|d| theta[layout.terms(d)].to_vec());
    for (degree, text, value) in more {
        model.degrees[*degree].parameters.push((*text).to_owned());
        model.degrees[*degree].terms.push(Term::parse(text, &names).unwrap());
        values[*degree].push(*value);
    }
    (model, values.concat())
}

fn experiment(vessel: &Vessel) -> Experiment {
    let plan = [(0, 193), (4, 43), (5, 229), (6, 101), (7, 85), (10, 349)];
    Experiment::of_maneuvers(&dictionary(vessel), &plan)
}

/// `runs` recordings of `experiment` by the model with `more`.
fn recorded(
    experiment: &Experiment,
    vessel: &Vessel,
    more: &[(usize, &str, f64)],
    runs: u64,
) -> Vec<Vec<f64>> {
    let (model, theta) = with(vessel, more);
    let states = simulate_one(&model, &theta, experiment.initial, &experiment.inputs);
    let noisy = |seed: u64| {
        let mut normals = Normals::new(seed);
        states.iter().map(|x| x + NOISE * normals.next()).collect()
    };
    (0..runs).map(noisy).collect()
}

/// `measured` as runs of one segment.
fn whole(experiment: &Experiment, measured: Vec<Vec<f64>>) -> Vec<Run> {
    let run = |(run, measured): (usize, Vec<f64>)| Run {
        design: "test".to_owned(),
        run: run as i32,
        initial: experiment.initial,
        instrument_exogenous: Vec::new(),
        exogenous: experiment.inputs.clone(),
        measured,
        segments: vec![Segment { maneuver: "all".to_owned(), start: 0 }],
    };
    measured.into_iter().enumerate().map(run).collect()
}

fn criticised(
    model: &Model,
    parameters: &[f64],
    experiment: &Experiment,
    measured: &[&Vec<f64>],
    levels: Option<NoiseModel>,
) -> Criticism {
    let (exogenous, initial) = (&experiment.inputs, experiment.initial);
    let views: Vec<RunView> = measured
        .iter()
        .map(|measured| RunView { measured, instrument_exogenous: exogenous, exogenous, initial })
        .collect();
    criticise(
        &Subject { model, runs: &views, rate_hz: 8.0, known_start: true, levels, names: &[], signs: &[] },
        parameters,
    )
    .unwrap()
}

fn found<'a>(criticism: &'a Criticism, name: &str, degree: Option<&str>) -> &'a Absent {
    criticism.absent.iter().find(|a| a.name == name && a.degree.as_deref() == degree).unwrap()
}

#[test]
fn law_a_score_is_by_how_much_errors_fall_when_the_term_is_added() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let measured = recorded(&experiment, &vessel, &[], 1);
    let squares = |criticism: &Criticism, parameters: usize| {
        let samples = measured[0].len() / 3 - 1;
        criticism.error_ratio.unwrap().powi(2) * (3 * samples - parameters) as f64
    };
    let runs = [&measured[0]];
    let without = criticised(&vessel.model, &truth(&vessel), &experiment, &runs, Some(STATED));
    let (richer, theta) = with(&vessel, &[(2, "r |r|", 0.0)]);
    let within = criticised(&richer, &theta, &experiment, &runs, Some(STATED));
    let score = found(&without, "r |r|", Some("yaw"));
    let statistic = (score.value[0] / score.standard_error[0] * without.error_ratio.unwrap()).powi(2);
    let fall = squares(&without, 10) - squares(&within, 11);
    assert!((fall - statistic).abs() < 0.02 * statistic.max(0.1), "{fall} {statistic}");
    let ratio = without.error_ratio.unwrap();
    assert!((ratio - 1.0).abs() < 0.06, "{ratio}");
}

#[test]
fn two_missing_terms_are_found_and_a_right_model_is_seldom_rejected() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let all = |more: &[(usize, &str, f64)], levels: Option<NoiseModel>, runs: u64| -> Vec<Criticism> {
        let measured = recorded(&experiment, &vessel, more, runs);
        let one = |own: &Vec<f64>| criticised(&vessel.model, &truth(&vessel), &experiment, &[own], levels);
        measured.iter().map(one).collect()
    };
    // With a rate of 5 % more than four of sixteen have a probability below 1 in 1000.
    let rejected = all(&[], Some(STATED), 16).iter().filter(|c| c.rejected).count();
    assert!(rejected <= 4, "{rejected} of 16");
    for criticism in all(&[(1, "v |v|", -0.4), (2, "r |r|", -0.3)], Some(STATED), 4) {
        let first = criticism.absent[0].label();
        assert!(
            criticism.rejected && ["`v |v|` in sway", "`r |r|` in yaw"].contains(&first.as_str()),
            "{first}"
        );
        assert!(criticism.statements[0].starts_with("model rejected (p < 0.0001): most likely missing: `"));
    }
}

fn turn(run: &mut Run, input: usize) {
    run.exogenous.iter_mut().skip(input).step_by(3).for_each(|x| *x = -*x);
}

#[test]
fn law_an_input_with_the_opposite_sign_is_named_and_a_right_one_is_not() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let pool = Pool::new(&vessel);
    let found = |negated: Option<usize>| {
        let mut runs = whole(&experiment, recorded(&experiment, &vessel, &[], 4));
        if let Some(input) = negated {
            runs.iter_mut().for_each(|run| turn(run, input));
        }
        let (runs, quick) = (PooledRuns::new(runs, &BTreeMap::new()), Judgement { replicates: 0, seed: 1 });
        estimate(&pool, &runs, Estimator::Ls, &quick, Resampling::Given(&[])).unwrap()
    };
    let right = found(None);
    let criticism = right.criticism.unwrap();
    let signs: Vec<&Absent> = criticism.absent.iter().filter(|a| a.kind == Suspect::Sign).collect();
    assert!(right.turned.is_none() && criticism.wrong_signs().next().is_none(), "{signs:?}");
    assert!(["`tau1`", "`tau2`", "`tau3`"].iter().all(|name| signs.iter().any(|s| s.name.contains(name))));
    assert!(signs.iter().all(|sign| sign.value[0] > 0.0 && sign.p_value == 1.0), "{signs:?}");
    for (input, name) in ["tau1", "tau2", "tau3"].into_iter().enumerate() {
        let turned = found(Some(input));
        let criticism = turned.criticism.unwrap();
        let first = &criticism.absent[0];
        assert!(
            first.candidate && first.name == format!("`{name}` acts with the opposite sign"),
            "{first:?}"
        );
        assert!(first.value[0] < -0.5 && criticism.rejected, "{first:?}");
        let said = &criticism.statements[0];
        let remedy = format!("compare `{name}` with the motion, and set `sign = -1`");
        assert!(said.starts_with("model rejected (p < 0.0001): `tau") && said.contains(&remedy), "{said}");
        assert!(turned.turned.unwrap().contains("acts with the opposite sign"));
        assert_eq!(turned.statements.iter().filter(|line| line.contains("opposite sign")).count(), 1);
    }
}

/// Parts of one run cannot be compared: the errors of its predictions tell how far estimates are from zero.
#[test]
fn law_an_input_with_the_opposite_sign_is_named_by_one_run() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    for negated in [None, Some(2)] {
        let mut runs = whole(&experiment, recorded(&experiment, &vessel, &[], 1));
        negated.into_iter().for_each(|input| turn(&mut runs[0], input));
        let (runs, quick) = (PooledRuns::new(runs, &BTreeMap::new()), Judgement { replicates: 0, seed: 1 });
        let found =
            estimate(&Pool::new(&vessel), &runs, Estimator::PredictionError, &quick, Resampling::Given(&[]));
        let criticism = found.unwrap().criticism.unwrap();
        let named: Vec<&str> = criticism.wrong_signs().map(|sign| sign.name.as_str()).collect();
        assert_eq!(named, negated.map(|_| "`tau3` acts with the opposite sign").as_slice());
    }
}

#[test]
fn law_a_logged_channel_that_no_term_has_is_named() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let measured = recorded(&experiment, &vessel, &[], 1);
    let mut poorer = vessel.model.clone();
    let steering = poorer.degrees[2].terms.iter().position(|term| term.text == "tau3").unwrap();
    poorer.degrees[2].terms.remove(steering);
    poorer.degrees[2].parameters.remove(steering);
    let mut theta = truth(&vessel);
    theta.remove(vessel.model.layout().terms(2).start + steering);
    let found = criticised(&poorer, &theta, &experiment, &[&measured[0]], Some(STATED));
    let steering = self::found(&found, "tau3", Some("yaw"));
    assert!(found.verdict == Verdict::Rejected && steering.p_value < 0.05, "{steering:?}");
    // With the term nothing is logged in vain.
    let right = criticised(&vessel.model, &truth(&vessel), &experiment, &[&measured[0]], Some(STATED));
    assert!(!right.absent.iter().any(|absent| absent.name.contains("tau")), "{:?}", right.absent);
}

#[test]
fn law_white_noise_rejects_at_half_the_level_and_where_it_is_the_clearer() {
    let absent = |p_value: f64| vec![Absent { p_value, candidate: true, ..Absent::default() }];
    let clearer = |likeliest: f64, white: f64| {
        clearer_under_white(&absent(likeliest), absent(white)).map(|found| found[0].p_value)
    };
    assert_eq!(clearer(0.3, 0.02), Some(0.04));
    assert_eq!(clearer(0.3, 0.026), None);
    assert_eq!(clearer(0.01, 0.006), None);
    assert_eq!(clearer(0.01, 0.004), Some(0.008));
}

#[test]
fn noise_that_is_not_stated_is_found_by_its_likelihood() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let measured = recorded(&experiment, &vessel, &[], 4);
    let runs: Vec<&Vec<f64>> = measured.iter().collect();
    let found = criticised(&vessel.model, &truth(&vessel), &experiment, &runs, None);
    for noise in [found.noise_u, found.noise_v, found.noise_r].map(Option::unwrap) {
        assert!((noise / NOISE - 1.0).abs() < 0.07, "{noise}");
    }
    assert!(found.current_std.unwrap() < 0.01 && !found.stated_noise, "{:?}", found.current_std);
    assert!((found.error_ratio.unwrap() - 1.0).abs() < 0.05, "{:?}", found.error_ratio);
}

#[test]
fn a_lag_of_the_inputs_is_told_with_its_size() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let lagged = {
        let mut state = experiment.inputs[..3].to_vec();
        let keep = (-1.0_f64 / 4.0).exp();
        let mut inputs = Vec::new();
        for row in experiment.inputs.chunks_exact(3) {
            inputs.extend_from_slice(&state);
            state.iter_mut().zip(row).for_each(|(s, input)| *s = keep * *s + (1.0 - keep) * input);
        }
        Experiment { initial: experiment.initial, inputs, segments: experiment.segments.clone() }
    };
    let measured = recorded(&lagged, &vessel, &[], 1);
    let lagged = criticised(&vessel.model, &truth(&vessel), &experiment, &[&measured[0]], Some(STATED));
    assert!(lagged.rejected, "{:?}", lagged.statements);
    let lag = found(&lagged, "lag of the inputs", None);
    assert!(lag.candidate && (lag.value[0] / 0.5 - 1.0).abs() < 0.2, "{lag:?}");
}

#[test]
fn law_the_verdict_on_a_run_does_not_depend_on_its_company() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let measured = recorded(&experiment, &vessel, &[(2, "r |r|", -0.1)], 9);
    let (exogenous, initial) = (&experiment.inputs, experiment.initial);
    let views: Vec<RunView> = measured
        .iter()
        .map(|measured| RunView { measured, instrument_exogenous: exogenous, exogenous, initial })
        .collect();
    let subject = |runs, levels| Subject {
        model: &vessel.model,
        runs,
        rate_hz: 8.0,
        known_start: true,
        levels,
        names: &[],
        signs: &[],
    };
    let theta = truth(&vessel);
    for (levels, among) in [(Some(STATED), 9), (None, 3)] {
        let all = criticise_each(&subject(&views[9 - among..], levels), &vec![theta.clone(); among]);
        let alone = criticise(&subject(&views[8..], levels), &theta);
        assert_eq!(all[among - 1], alone);
        assert!(all.iter().all(Option::is_some));
    }
}

#[test]
fn runs_that_reject_the_model_say_so_with_every_estimator() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let runs = |more: &[(usize, &str, f64)]| -> Vec<Run> {
        whole(&experiment, recorded(&experiment, &vessel, more, 3))
    };
    let estimators = RunEstimators {
        vessel: &vessel,
        estimators: vec![Estimator::Iv, Estimator::OutputError],
        removal: MeanRemoval::Complete,
        initial: InitialState::Known,
        additional: AdditionalUnknowns::default(),
        levels: Some(STATED),
    };
    let statuses = |runs: Vec<Run>| -> Vec<EstimateStatus> {
        let mut rows = estimators.estimates(&runs).unwrap();
        estimators.criticise(&runs, &mut rows);
        rows.iter().map(|row| row.status).collect()
    };
    assert_eq!(statuses(runs(&[(1, "v |v|", -0.4), (2, "r |r|", -0.3)])), [EstimateStatus::Rejected; 6]);
    let right = statuses(runs(&[]));
    assert!(right.iter().filter(|status| **status == EstimateStatus::Identified).count() >= 4, "{right:?}");
    assert!(right.chunks(2).all(|own| own[0] == own[1]), "one verdict for a run: {right:?}");
    assert!(estimators.asks());
    let silent = NoiseModel { measurement: [NOISE, NOISE, 0.0], ..STATED };
    assert!(!RunEstimators { levels: Some(silent), ..estimators }.asks());
}

/// An estimate at a bound is tested as delivered: held there, not as it would be without the bound.
#[test]
fn a_bound_that_excludes_the_truth_is_rejected_by_the_runs_whose_estimates_lie_at_it() {
    let mut vessel = paper();
    let experiment = experiment(&vessel);
    let runs = whole(&experiment, recorded(&experiment, &vessel, &[], 3));
    let mut judged = |bounds: Option<[f64; 2]>| -> Vec<(bool, EstimateStatus)> {
        vessel.model.degrees[2].bounds = bounds.map(|bounds| (0, bounds)).into_iter().collect();
        let estimators = RunEstimators {
            vessel: &vessel,
            estimators: vec![Estimator::Iv],
            removal: MeanRemoval::Complete,
            initial: InitialState::Known,
            additional: AdditionalUnknowns::default(),
            levels: Some(STATED),
        };
        let mut rows = estimators.estimates(&runs).unwrap();
        estimators.criticise(&runs, &mut rows);
        let place = vessel.model.layout().terms(2).start;
        let ends = |theta: f64| bounds.is_some_and(|bounds| bounds.contains(&theta));
        rows.iter().map(|row| (ends(row.estimate.as_ref().unwrap().0[place]), row.status)).collect()
    };
    let free = judged(None);
    // N_r is −0.35.
    assert_eq!(judged(Some([-0.25, 0.0])), [(true, EstimateStatus::Rejected); 3]);
    assert_eq!(judged(Some([-1.0, 0.0])), free);
    assert!(free.iter().any(|(_, status)| *status == EstimateStatus::Identified), "{free:?}");
    // Some of the estimates lie at this bound, with any verdict; the others are tested as without it.
    let some = judged(Some([-0.35, 0.0]));
    assert!(some.iter().zip(&free).all(|((ends, with), (_, without))| *ends || with == without), "{some:?}");
}

/// A filter that trusts its stated noise can get stuck far from the least errors.
#[test]
fn an_estimate_that_is_far_off_does_not_change_what_is_found_to_be_missing() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let measured = recorded(&experiment, &vessel, &[(1, "v |v|", -0.4), (2, "r |r|", -0.3)], 2);
    let theta = truth(&vessel);
    let far: Vec<f64> =
        theta.iter().enumerate().map(|(i, x)| if i % 2 == 0 { 0.2 * x } else { -x }).collect();
    for own in &measured {
        let [near, far] =
            [&theta, &far].map(|start| criticised(&vessel.model, start, &experiment, &[own], Some(STATED)));
        assert_eq!(near.absent[0].label(), far.absent[0].label());
        let [near, far] = [near, far].map(|found| found.error_ratio.unwrap());
        assert!((near / far - 1.0).abs() < 0.01, "{near} {far}");
    }
}

/// Runs of a ship on a square course under an autopilot of heading and rate, which reads the rate from the sensor that is logged,
/// or from one of its own. `current`: new at every sample.
fn steered(vessel: &Vessel, shared: bool, current: f64, seed: u64) -> (Experiment, Vec<f64>) {
    let mut compiled = Compiled::<f64>::new(&vessel.model, &truth(vessel));
    let (mut normals, mut state, mut heading) = (Normals::new(seed), [0.6, 0.0, 0.0], 0.0);
    let (mut measured, mut inputs) = (Vec::new(), Vec::new());
    for k in 0..=1000 {
        let seen = state.map(|x| x + NOISE * normals.next());
        measured.extend(seen);
        let rate = if shared { seen[2] } else { state[2] + NOISE * normals.next() };
        let course = if (k / 120) % 2 == 0 { 0.6 } else { -0.6 };
        let moment = 300.0 * (course - heading) - 400.0 * rate;
        let tau = [2000.0 + 500.0 * f64::from((k / 200) % 2), -2.5 * moment, moment];
        if k < 1000 {
            inputs.extend(tau);
        }
        let water = [current * normals.next(), current * normals.next()];
        compiled.look(state, &tau, Some(water));
        heading += state[2] / 8.0;
        state = compiled.next(state, None);
    }
    (Experiment { initial: [0.6, 0.0, 0.0], inputs, segments: vec![0] }, measured)
}

#[test]
fn an_autopilot_that_steers_by_the_logged_sensor_is_told_from_one_with_its_own() {
    let vessel = paper();
    for current in [0.0, 0.05] {
        for (shared, seed) in [(true, 1), (true, 2), (false, 3), (false, 4)] {
            let (experiment, measured) = steered(&vessel, shared, current, seed);
            let flow = if current > 0.0 { Flow::White { std: current } } else { Flow::Still };
            let levels = Some(NoiseModel { current: flow, ..STATED });
            let found =
                criticised(&vessel.model, &truth(&vessel), &experiment, &[&measured], levels).feedback;
            match found {
                Some(found) if shared => {
                    assert!(found.state == "r" && found.correlation.abs() > 0.4, "{found:?}");
                }
                found => assert!(!shared && found.is_none(), "{shared} {current}: {found:?}"),
            }
        }
    }
}

/// Standard errors are too small if parameters attribute a current to the vessel's own motion.
#[test]
fn a_current_that_lasts_is_said_to_spoil_standard_errors() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let said = |current: Flow| {
        let measured = recorded(&experiment, &vessel, &[], 1);
        let levels = Some(NoiseModel { current, ..STATED });
        let found = criticised(&vessel.model, &truth(&vessel), &experiment, &[&measured[0]], levels);
        // Whether it is so depends on the estimate.
        assert!(!found.statements.iter().any(|line| line.starts_with("standard errors do not hold")));
        (found.persistent_current().unwrap_or_default(), found.current_time_s)
    };
    let drifting = |factor: f64, std: f64| Flow::Markov { std, factor, turning: 0.125 };
    let (words, time) = said(drifting((-1.0_f64 / 240.0).exp(), 0.1));
    assert!(
        words.contains("0.100 m/s changes within 30 s") && (time.unwrap() - 30.0).abs() < 1e-9,
        "{words}"
    );
    assert!(said(drifting(1.0, 0.1)).0.contains("0.100 m/s stays"));
    for harmless in [drifting(1.0, 0.001), drifting(0.5, 0.1), Flow::White { std: 0.1 }, Flow::Still] {
        assert_eq!(said(harmless).0, "");
    }
}

/// Tests overlap: without correction for their number the mean would be below 0.1, and above 0.7 with a factor for each.
#[test]
fn law_the_probability_of_the_likeliest_candidate_is_uniform_under_a_right_model() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let measured = recorded(&experiment, &vessel, &[], 32);
    let probability = |own: &Vec<f64>| {
        let found = criticised(&vessel.model, &truth(&vessel), &experiment, &[own], Some(STATED));
        found.p_value.unwrap()
    };
    let mean = measured.iter().map(probability).sum::<f64>() / 32.0;
    // Three standard errors of a mean of 32.
    assert!((mean - 0.5).abs() < 0.153, "{mean}");
}
