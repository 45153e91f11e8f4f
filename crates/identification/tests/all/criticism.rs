//! What a model is found to lack, on runs of which that is known.

use crate::support::noise::Normals;
use crate::support::{Experiment, dictionary, paper, truth};
use identification::criticism::{Absent, Criticism, Subject, criticise};
use identification::predictor::{Flow, Levels};
use vessel::{Model, RunView, Term, Vessel, simulate_one};

const NOISE: f64 = 0.02;
const STATED: Levels = Levels { measurement: [NOISE; 3], current: Flow::Still, force: None };

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

fn criticised(
    model: &Model,
    parameters: &[f64],
    experiment: &Experiment,
    measured: &[&Vec<f64>],
    levels: Option<Levels>,
) -> Criticism {
    let (exogenous, initial) = (&experiment.inputs, experiment.initial);
    let views: Vec<RunView> =
        measured.iter().map(|measured| RunView { measured, exogenous, initial }).collect();
    let subject = Subject { model, parameters, runs: &views, rate_hz: 8.0, known_start: true, levels };
    criticise(&subject).unwrap()
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
        criticism.error_ratio.powi(2) * (3 * samples - parameters) as f64
    };
    let runs = [&measured[0]];
    let without = criticised(&vessel.model, &truth(&vessel), &experiment, &runs, Some(STATED));
    let (richer, theta) = with(&vessel, &[(2, "r |r|", 0.0)]);
    let within = criticised(&richer, &theta, &experiment, &runs, Some(STATED));
    let score = found(&without, "r |r|", Some("yaw"));
    let statistic = (score.value[0] / score.standard_error[0] * without.error_ratio).powi(2);
    let fall = squares(&without, 10) - squares(&within, 11);
    assert!((fall - statistic).abs() < 0.02 * statistic.max(0.1), "{fall} {statistic}");
    assert!((without.error_ratio - 1.0).abs() < 0.06, "{}", without.error_ratio);
}

#[test]
fn two_missing_terms_are_found_and_a_right_model_is_seldom_rejected() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let all = |more: &[(usize, &str, f64)], levels: Option<Levels>, runs: u64| -> Vec<Criticism> {
        let measured = recorded(&experiment, &vessel, more, runs);
        let one = |own: &Vec<f64>| criticised(&vessel.model, &truth(&vessel), &experiment, &[own], levels);
        measured.iter().map(one).collect()
    };
    // With a rate of 5 % more than four of sixteen have a probability below 1 in 1000.
    let rejected = all(&[], Some(STATED), 16).iter().filter(|c| c.rejected).count();
    assert!(rejected <= 4, "{rejected} of 16");
    for criticism in all(&[(1, "v |v|", -0.4), (2, "r |r|", -0.3)], Some(STATED), 4) {
        let first = criticism.absent[0].told();
        assert!(
            criticism.rejected && ["`v |v|` in sway", "`r |r|` in yaw"].contains(&first.as_str()),
            "{first}"
        );
        assert!(criticism.statements[0].starts_with("model rejected (p < 0.0001): most likely missing: `"));
    }
}

#[test]
fn noise_that_is_not_stated_is_found_by_its_likelihood() {
    let vessel = paper();
    let experiment = experiment(&vessel);
    let measured = recorded(&experiment, &vessel, &[], 4);
    let runs: Vec<&Vec<f64>> = measured.iter().collect();
    let found = criticised(&vessel.model, &truth(&vessel), &experiment, &runs, None);
    for noise in [found.noise_u, found.noise_v, found.noise_r] {
        assert!((noise / NOISE - 1.0).abs() < 0.07, "{noise}");
    }
    assert!(found.current_std < 0.01 && !found.stated_noise, "{}", found.current_std);
    assert!((found.error_ratio - 1.0).abs() < 0.05, "{}", found.error_ratio);
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
    let told = criticised(&vessel.model, &truth(&vessel), &experiment, &[&measured[0]], Some(STATED));
    assert!(told.rejected, "{:?}", told.statements);
    let lag = found(&told, "lag of the inputs", None);
    assert!(lag.candidate && (lag.value[0] / 0.5 - 1.0).abs() < 0.2, "{lag:?}");
}
