//! Statements about estimates that their covariance cannot distinguish.

use estimation::pooled::{Covariance, Delivered, collinear};
use ship::model::Vessel;

/// Sentences about two parameters of these values, standard errors and correlation.
fn sentences(values: [f64; 2], errors: [f64; 2], correlation: f64) -> Vec<String> {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let crossed = correlation * errors[0] * errors[1];
    let delivered = Delivered {
        theta: values.to_vec(),
        constant: [0.0; 3],
        covariance: Some(Covariance {
            joint: false,
            names: vec!["N_v".to_owned(), "N_r".to_owned()],
            entries: vec![errors[0].powi(2), crossed, crossed, errors[1].powi(2)],
            parts: None,
        }),
        least_squares: None,
        increment_std: [0.0; 3],
        output_rmse: None,
        surroundings: Vec::new(),
        recordings: Vec::new(),
        covered: Vec::new(),
    };
    collinear(&delivered, vessel.model.layout())
}

/// The combination that a sentence says is known best, and its standard error in percent.
fn best(sentence: &str) -> (&str, f64) {
    let (_, best) = sentence.rsplit_once(", ").unwrap();
    let (combination, error) = best.rsplit_once(" to ").unwrap();
    (combination, error.trim_end_matches(" %").parse().unwrap())
}

#[test]
fn what_two_estimates_have_in_common_is_told() {
    // var(N_v + N_r) = 0.04 (2 − 2 · 0.995): 0.02 of 1; the best multiple is 0.995.
    let said = sentences([0.4, 0.6], [0.2, 0.2], -0.995);
    assert_eq!(
        said,
        ["`N_v` and `N_r` cannot be told apart: correlation -0.995, each alone is known to 50 % and 33 %, \
          `N_r` + 0.995 `N_v` to 2.0 %"]
    );
    let said = sentences([0.4, -0.6], [0.2, 0.4], 0.96);
    assert!(said[0].contains("can hardly be told apart"), "{said:?}");
    assert!(said[0].ends_with("`N_v` − 0.480 `N_r` to 8.1 %"), "{said:?}");
}

#[test]
fn what_is_known_or_hardly_correlates_is_not_told() {
    assert!(sentences([0.4, 0.6], [0.2, 0.2], 0.9).is_empty());
    assert!(sentences([0.4, 0.6], [0.01, 0.01], 0.999).is_empty());
    assert!(sentences([0.4, 0.6], [0.2, 0.01], 0.999).is_empty());
}

#[test]
fn law_a_ratio_is_known_where_both_err_alike() {
    let said = sentences([-0.4, 0.6], [0.1, 0.15], -0.999);
    // √(2 (1 − 0.999)) of a quarter.
    assert!(said[0].ends_with("`N_v`/`N_r` to 1.1 %"), "{said:?}");
    // The ratio's variance by the slopes 1/b and −a/b² of a/b.
    let ([a, b], errors, correlation) = ([1.2, 0.7], [0.6, 0.32], 0.96);
    let slopes = [errors[0] / b, -a / (b * b) * errors[1]];
    let variance = slopes[0] * slopes[0] + slopes[1] * slopes[1] + 2.0 * slopes[0] * slopes[1] * correlation;
    let said = sentences([a, b], errors, correlation);
    let (combination, error) = best(&said[0]);
    let expected = 100.0 * f64::sqrt(variance) / (a / b);
    assert!(combination == "`N_v`/`N_r`" && (error - expected).abs() <= 0.5, "{said:?} {expected}");
}

#[test]
fn law_no_other_multiple_leaves_less_error() {
    // Of opposite signs and unequal relative errors, so that a sum is known better than the ratio.
    let (values, errors, correlation) = ([1.0, 2.0], [0.3, 0.5], -0.97);
    let said = sentences(values, errors, correlation);
    let (combination, percent) = best(&said[0]);
    let (one, rest) = combination.split_once(" + ").unwrap();
    let factor: f64 = rest.split_once(' ').unwrap().0.parse().unwrap();
    let first = usize::from(one == "`N_r`");
    let ([a, b], [s, t]) = ([values[first], values[1 - first]], [errors[first], errors[1 - first]]);
    let error = |factor: f64| (s * s + 2.0 * factor * correlation * s * t + factor * factor * t * t).sqrt();
    let expected = 100.0 * error(factor) / (a + factor * b);
    assert!((percent - expected).abs() <= 0.06, "{said:?} {expected}");
    assert!([-0.1, -0.01, 0.01, 0.1].iter().all(|more| error(factor + more) > error(factor)), "{said:?}");
}
