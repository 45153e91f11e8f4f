//! Trials in rounds: knowledge of the parameters, and the end of trials.

use trial::rounds::{Arm, Knowledge, Outcome, Row, Shared, Summary};

fn knowledge(spread: f64, floor: [f64; 2]) -> Knowledge {
    Knowledge { about: vec![2.0, -0.5], spread, floor: floor.to_vec(), seed: 1 }
}

#[test]
fn law_what_is_learnt_lies_nearer_to_what_is_known_better() {
    let known = knowledge(0.5, [0.0; 2]);
    let learnt = known.learnt(&[2.0, -0.5], &[4.0, -1.5], &[1.0, 1e-9]);
    assert!((learnt[0] - 3.0).abs() < 1e-12, "equal variances: halfway, {learnt:?}");
    assert!((learnt[1] + 1.5).abs() < 1e-6, "an exact estimate is taken as it is, {learnt:?}");
}

#[test]
fn law_without_spread_crude_models_are_exact_and_nothing_is_learnt() {
    let known = knowledge(0.0, [0.0; 2]);
    assert_eq!(known.crude(7), known.about);
    assert_eq!(known.learnt(&known.about, &[4.0, -1.5], &[1.0, 1.0]), known.about);
    assert_ne!(knowledge(0.3, [0.0; 2]).crude(7), known.about);
}

#[test]
fn small_parameters_count_as_large_as_their_floor() {
    let known = knowledge(0.5, [0.0, 1.0]);
    assert_eq!(known.relative(&[0.6, 0.8], &[-1.0, 0.0]), 1.0);
}

fn row(arm: Arm, realization: u32, round: u32, error: Option<f64>, predicted: f64) -> Row {
    Row {
        arm,
        realization,
        round,
        samples: 10 * (round as usize + 1),
        shared: Shared::Designed,
        outcome: if error.is_some() { Outcome::Identified } else { Outcome::NotConverged },
        parameter_error: error,
        predicted_error: Some(predicted),
        expected_error: None,
    }
}

#[test]
fn trials_end_with_the_first_promise_or_after_the_whole_time() {
    let of = |realization: u32, rounds: [(Option<f64>, f64); 2]| {
        let one = |(round, (error, predicted)): (usize, (Option<f64>, f64))| {
            row(Arm::Sequential, realization, round as u32, error, predicted)
        };
        rounds.into_iter().enumerate().map(one).collect::<Vec<_>>()
    };
    let early = of(0, [(Some(0.5), 0.9), (Some(0.1), 0.1)]);
    let late = of(1, [(Some(3.0), 2.0), (Some(2.0), 1.0)]);
    let never = of(2, [(Some(4.0), 2.0), (Some(0.8), 1.1)]);
    let lost = of(3, [(None, 0.5), (None, 0.5)]);
    let rows = [early, late, never, lost].concat();
    let [found, none] = &Summary::new(&rows, &[10, 20], 1.0, 1.0).stopping[..] else { panic!() };
    assert_eq!((found.stopped, found.mean_time_s), (3, 15.0));
    assert_eq!((found.within, found.within_stopped), (0.5, Some(1.0 / 3.0)));
    assert_eq!(found.rms_over_accuracy, Some((4.25_f64 / 2.0).sqrt()));
    assert_eq!((found.without_estimate, found.median_error), (1, Some(1.4)));
    assert_eq!((none.stopped, none.within_stopped), (0, None));
}

#[test]
fn law_a_gain_is_the_geometric_mean_of_ratios_in_the_same_realization() {
    let pair = |n: u32, a: Option<f64>, b: f64| {
        [row(Arm::Sequential, n, 0, a, 1.0), row(Arm::OneShot, n, 0, Some(b), 1.0)]
    };
    let rows = [pair(0, Some(1.0), 2.0), pair(1, Some(8.0), 2.0), pair(2, None, 1.0)].concat();
    let found = Summary::new(&rows, &[10], 1.0, 2.0).gains[0];
    assert_eq!((found.pairs, found.time_s), (2, 5.0));
    assert!((found.ratio.unwrap() - 2f64.sqrt()).abs() < 1e-12);
    let (low, high) = (found.low.unwrap(), found.high.unwrap());
    assert!((low * high - 2.0).abs() < 1e-9 && low < 1.0 && high > 2.0, "{low} {high}");
}
