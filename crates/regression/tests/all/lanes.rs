//! Runs side by side of which some are nearly singular or at a bound.

use numerics::{LANES, dot};
use regression::{Estimate, MeanRemoval, Outcome};
use ship::model::Model;

use crate::any_model::model;
use crate::support::noise::Normals;
use crate::support::{Recording, SideBySide, estimate};

const SAMPLES: usize = 60;

fn two_terms() -> Model {
    model([&["u", "v"], &["v", "n"], &["r", "delta"]])
}

/// A run whose surge follows these parameters exactly; everything else is random, instruments are the measured states.
fn run([own, of_sway]: [f64; 2], seed: u64) -> Recording {
    let mut normals = Normals::new(seed);
    let (mut measured, mut surge) = (Vec::new(), 1.0);
    for _ in 0..=SAMPLES {
        let sway = normals.next();
        measured.extend([surge, sway, normals.next()]);
        surge += own * surge + of_sway * sway;
    }
    let exogenous = (0..2 * SAMPLES).map(|_| normals.next()).collect();
    Recording { instrument_states: measured.clone(), measured, exogenous, segments: vec![0] }
}

/// The same with these instruments of surge and sway.
fn with_instruments(mut run: Recording, instruments: [Vec<f64>; 2]) -> Recording {
    for (d, own) in instruments.iter().enumerate() {
        own.iter().enumerate().for_each(|(k, x)| run.instrument_states[3 * k + d] = *x);
    }
    run
}

/// The states that are regressors: u or v of every sample.
fn regressor(run: &Recording, d: usize) -> Vec<f64> {
    run.measured.iter().skip(d).step_by(3).take(SAMPLES).copied().collect()
}

/// The part of `a` that is orthogonal to `b`.
fn orthogonal(a: &[f64], b: &[f64]) -> Vec<f64> {
    let share = dot(a, b) / dot(b, b);
    a.iter().zip(b).map(|(a, b)| a - share * b).collect()
}

fn outcomes(model: &Model, runs: &[Recording]) -> Vec<Outcome> {
    let side_by_side = SideBySide::new(&runs.iter().collect::<Vec<_>>());
    estimate(&side_by_side.batch(model), MeanRemoval::None)
}

fn estimated(outcome: &Outcome) -> &Estimate {
    match outcome {
        Outcome::Identified(estimate) => estimate,
        other => panic!("{other:?}"),
    }
}

#[test]
fn law_a_lane_whose_pivot_is_small_is_solved_by_itself_and_disturbs_no_other() {
    const TRUTH: [f64; 2] = [-0.3, 0.5];
    let mut runs: Vec<Recording> = (0..LANES as u64).map(|seed| run(TRUTH, seed)).collect();
    let before = outcomes(&two_terms(), &runs);
    let [u, v] = [0, 1].map(|d| regressor(&runs[2], d));
    // Both pivots are nearly zero, and the equations are well conditioned.
    let instrument = |of: &[f64], own: &[f64]| -> Vec<f64> {
        orthogonal(of, own).iter().zip(own).map(|(x, own)| x + 1e-9 * own).collect()
    };
    runs[2] = with_instruments(runs[2].clone(), [instrument(&v, &u), instrument(&u, &v)]);
    let same = regressor(&runs[5], 0);
    runs[5] = with_instruments(runs[5].clone(), [same.clone(), same]);
    let found = outcomes(&two_terms(), &runs);
    for (lane, (found, before)) in found.iter().zip(&before).enumerate() {
        if lane == 5 {
            let Outcome::NotIdentifiable(direction) = found else { panic!("{found:?}") };
            assert_eq!(direction.degree, 0);
            continue;
        }
        for (theta, truth) in estimated(found).parameters.iter().zip(TRUTH) {
            assert!((theta - truth).abs() < 1e-12, "{lane}: {theta}");
        }
        assert!(lane == 2 || found == before, "{lane}: {found:?} {before:?}");
    }
}

#[test]
fn law_bounds_hold_in_the_lanes_that_they_bind() {
    let truth = |lane: usize| if lane == 3 { [-0.3, 0.5] } else { [-0.1, 0.5] };
    let runs: Vec<Recording> = (0..LANES).map(|lane| run(truth(lane), lane as u64)).collect();
    let mut model = two_terms();
    model.degrees[0].bounds = [(0, [-0.2, 0.0])].into();
    for (lane, found) in outcomes(&model, &runs).iter().enumerate() {
        let Estimate { parameters, standard_errors, .. } = estimated(found);
        if lane == 3 {
            assert_eq!((parameters[0], standard_errors[0]), (-0.2, 0.0));
            // The other parameter solves its own equation.
            let [u, v] = [0, 1].map(|d| regressor(&runs[3], d));
            let expected = 0.5 - 0.1 * dot(&u, &v) / dot(&v, &v);
            assert!((parameters[1] - expected).abs() < 1e-12, "{} {expected}", parameters[1]);
        } else {
            let near = |(found, truth): (&f64, f64)| (found - truth).abs() < 1e-12;
            assert!(parameters.iter().zip(truth(lane)).all(near), "{lane}: {parameters:?}");
        }
    }
}
