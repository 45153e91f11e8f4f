//! Properties of pooled regressions that hold by theory.

use approx::assert_relative_eq;
use regression::Sums;
use regression::pooled::Options;
use regression::pooled::{COLLINEAR, Part, Parts, Prior, Regression, Status, Windowed, fit};
use ship::engine::RunView;

use crate::support::craft::{
    COMPLETE, TRUTH, craft, errors, many, part, regressions, simulated, with_instruments,
};
use crate::support::noise::Normals;

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

#[test]
fn law_windows_hold_every_sample_once_and_come_in_any_order() {
    let part = |first: f64, samples: usize| Part {
        label: String::new(),
        source: first.to_string(),
        instrument_exogenous: Vec::new(),
        exogenous: (0..samples).map(|k| first + k as f64).collect(),
        measured: (0..3 * (samples + 1)).map(|k| first + k as f64).collect(),
    };
    let parts = vec![part(100.0, 19), part(200.0, 8), part(300.0, 3)];
    let windows = Windowed::new(&parts, 8);
    assert_eq!((0..windows.count()).map(|i| windows.samples(i)).collect::<Vec<_>>(), [8, 8, 3, 8, 3]);
    let mut inputs = Vec::new();
    let Ok(()) = windows.each(&mut |window| inputs.extend_from_slice(window.run.exogenous));
    assert_eq!(inputs, parts.iter().flat_map(|part| part.exogenous.clone()).collect::<Vec<_>>());
    let mut firsts = Vec::new();
    let Ok(()) = windows.at(&[4, 1, 1, 0], &mut |w| firsts.push((w.source.to_owned(), w.run.measured[0])));
    let named = |source: &str, first| (source.to_owned(), first);
    assert_eq!(firsts, [named("300", 300.0), named("100", 124.0), named("100", 124.0), named("100", 100.0)]);
}
