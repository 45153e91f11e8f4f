//! What is known of parameters before a trial in rounds, and with its estimates.

use trial::rounds::Knowledge;

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
