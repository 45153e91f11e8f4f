//! Several models whose trajectories are averaged: `fixtures/oracle/average.json`, and laws.

use std::collections::BTreeMap;

use regression::pooled::PooledRuns;
use serde_json::{Value, json};
use ship::engine::Run;
use ship::model::{Vessel, VesselFile};
use validation::comparison::{
    CompareOptions, Compared, Contestant, EstimatedErrors, Ship, Standing, Traced, compare,
};

fn oracle() -> Value {
    serde_json::from_str(include_str!("../../../../fixtures/oracle/average.json")).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn three(value: &Value) -> [f64; 3] {
    numbers(value).try_into().unwrap()
}

/// A vessel with inputs a and b whose parameters are those of `model`.
pub fn vessel(model: &Value) -> Vessel {
    let terms = |degree: &str| -> Vec<Value> {
        let all = model[degree].as_object().unwrap().iter();
        all.map(
            |(term, value)| json!({"parameter": format!("{degree} {term}"), "term": term, "nominal": value}),
        )
        .collect()
    };
    let input = |name: &str| json!({"name": name, "unit": "1"});
    let file: VesselFile = serde_json::from_value(json!({
        "name": "small",
        "sample_rate_hz": 1.0,
        "input": [input("a"), input("b")],
        "surge": terms("surge"),
        "sway": terms("sway"),
        "yaw": terms("yaw"),
    }))
    .unwrap();
    Vessel::from_file(file).unwrap()
}

fn runs(oracle: &Value) -> PooledRuns {
    let run = |(number, own): (usize, &Value)| {
        let measured = numbers(&own["measured"]);
        Run {
            design: "measured".to_owned(),
            run: number as i32,
            segments: Vec::new(),
            initial: [0, 1, 2].map(|d: usize| measured[d]),
            measured,
            instrument_exogenous: Vec::new(),
            exogenous: numbers(&own["inputs"]),
        }
    };
    let all = oracle["runs"].as_array().unwrap().iter().enumerate().map(run).collect();
    PooledRuns::new(all, &BTreeMap::new())
}

fn compared(vessels: &[Vessel], oracle: &Value, rmse: Option<[f64; 3]>) -> (Compared, Vec<Traced>) {
    let ships = vessels.iter().map(|v| Ship { model: &v.model, theta: &v.nominal, columns: None }).collect();
    let standing = if vessels.len() > 1 { Standing::Average } else { Standing::Model };
    let known: Vec<EstimatedErrors> =
        rmse.into_iter().map(|rmse| EstimatedErrors { covariance: None, rmse }).collect();
    let options = CompareOptions {
        vessel: "",
        window: None,
        known: &known,
        covered: &[],
        magnitudes: None,
        rate_hz: 1.0,
    };
    compare(&[Contestant { standing, place: None, ships }], &runs(oracle), &options).unwrap()
}

#[track_caller]
fn near(found: &[f64], expected: &Value) {
    let expected = numbers(expected);
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(&expected) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
}

#[test]
fn oracle_mean_spread_errors_and_shares_inside() {
    let oracle = oracle();
    let vessels: Vec<Vessel> = oracle["models"].as_array().unwrap().iter().map(vessel).collect();
    let (found, trace) = compared(&vessels, &oracle, Some(three(&oracle["output_rmse"])));
    let flat = |of: fn(&Traced) -> [f64; 3]| -> Vec<f64> { trace.iter().flat_map(of).collect() };
    near(&flat(|row| row.simulated), &oracle["mean"]);
    near(&flat(|row| row.half.map(Option::unwrap)), &oracle["half"]);
    let errors = &found.models[0].errors;
    near(&errors.rmse().map(Option::unwrap), &oracle["rmse"]);
    near(&[errors.bias_u, errors.bias_v, errors.bias_r].map(Option::unwrap), &oracle["bias"]);
    let spread = found.spread.unwrap();
    assert_eq!((spread.models, found.models[0].name), (3, Standing::Average));
    near(&[spread.spread_u, spread.spread_v, spread.spread_r], &oracle["spread"]);
    near(&[spread.inside_u, spread.inside_v, spread.inside_r], &oracle["inside_alone"]);
    let bands = found.bands.unwrap();
    near(&[bands.inside_u, bands.inside_v, bands.inside_r], &oracle["inside"]);
    assert!(found.statements.iter().any(|said| said.starts_with("3 models are averaged, which differ by")));
}

#[test]
fn law_the_average_of_equal_models_is_that_model_to_the_bit() {
    let oracle = oracle();
    let single = vessel(&oracle["models"][1]);
    let (alone, trace) = compared(std::slice::from_ref(&single), &oracle, None);
    assert_eq!((alone.spread, alone.bands), (None, None));
    for count in [2, 3, 7, 49] {
        let (several, traces) = compared(&vec![single.clone(); count], &oracle, None);
        assert_eq!(several.models[0].errors, alone.models[0].errors);
        assert_eq!(traces, trace);
        assert_eq!(several.correlations, alone.correlations);
        let spread = several.spread.unwrap();
        assert_eq!([spread.spread_u, spread.spread_v, spread.spread_r], [0.0; 3]);
        // Without the errors on the fitted recordings there is no band.
        assert_eq!(several.bands, None);
    }
}

#[test]
fn a_window_in_which_one_model_diverges_is_no_average() {
    let oracle = oracle();
    let mut vessels: Vec<Vessel> = oracle["models"].as_array().unwrap().iter().map(vessel).collect();
    vessels[2].nominal[0] = 1e9;
    let (found, _) = compared(&vessels, &oracle, Some([0.1; 3]));
    let errors = &found.models[0].errors;
    assert_eq!((errors.diverged, errors.rmse_u), (2, None));
    assert_eq!((found.spread, found.bands), (None, None));
    assert!(found.statements[0].starts_with("useless: 2 of 2 windows diverge"), "{:?}", found.statements);
}
