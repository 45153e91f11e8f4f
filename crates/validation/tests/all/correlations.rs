//! Correlations of errors against numbers computed independently: `fixtures/oracle/correlations.json`.

use serde_json::Value;
use validation::comparison::{autocorrelations, cross_correlations};

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn windows(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(numbers).collect()
}

#[track_caller]
fn near(found: Option<Vec<f64>>, expected: &Value) {
    let (found, expected) = (found.unwrap(), numbers(expected));
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(&expected) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
}

#[test]
fn oracle_correlations_of_errors_within_windows() {
    let oracle: Value =
        serde_json::from_str(include_str!("../../../../fixtures/oracle/correlations.json")).unwrap();
    for case in oracle["cases"].as_array().unwrap() {
        let (errors, inputs) = (windows(&case["errors"]), windows(&case["inputs"]));
        let lags = case["lags"].as_u64().unwrap() as usize;
        near(autocorrelations(&errors, lags), &case["own"]);
        near(cross_correlations(&errors, &inputs, lags), &case["crossed"]);
    }
}

#[test]
fn law_an_input_that_moves_the_error_three_samples_later_is_found_at_lag_three() {
    let inputs: Vec<Vec<f64>> =
        (1..4).map(|w| (0..60).map(|k| f64::from(k * k * w % 17) - 8.0).collect()).collect();
    let delayed = |window: &Vec<f64>| -> Vec<f64> {
        (0..window.len()).map(|k| if k < 3 { 0.0 } else { window[k - 3] }).collect()
    };
    let errors: Vec<Vec<f64>> = inputs.iter().map(delayed).collect();
    let crossed = cross_correlations(&errors, &inputs, 10).unwrap();
    let largest = (0..21).max_by(|a, b| crossed[*a].abs().total_cmp(&crossed[*b].abs())).unwrap();
    assert!(largest == 10 + 3 && crossed[largest] > 0.9, "{crossed:?}");
}

#[test]
fn what_does_not_vary_has_no_correlations() {
    let (still, moving) = (vec![vec![2.0; 9]], vec![vec![1.0, 2.0, 4.0]]);
    assert_eq!(autocorrelations(&still, 5), None);
    assert_eq!(cross_correlations(&moving, &[vec![1.0; 3]], 5), None);
    assert_eq!(autocorrelations(&moving, 40).unwrap().len(), 2);
    assert_eq!(autocorrelations(&[], 5), None);
}
