//! Criteria of the covariance for the paper's eleven maneuvers against numbers computed independently
//! (`fixtures/oracle/criteria.json`: SLSQP from twelve starts).

use design::{
    Bounds, Candidates, Covariance, CovariancePoint, Norm, Objective, Options, Status, solve_covariance,
};
use serde_json::Value;

const MOMENTS: &str = include_str!("../../../../fixtures/oracle/oracle.json");
const CRITERIA: &str = include_str!("../../../../fixtures/oracle/criteria.json");
const DIMENSIONS: [usize; 3] = [5, 4, 4];
/// Agrees to what numerical gradients find.
const CASES: [(&str, f64, f64); 3] = [("d", 1e-8, 1e-6), ("a", 1e-8, 1e-6), ("a-relative", 1e-8, 1e-6)];

fn floats(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn candidates(maneuvers: &Value, of: impl Fn(&Value) -> Vec<f64>) -> Candidates {
    let mut candidates = Candidates::new(DIMENSIONS.to_vec());
    for maneuver in maneuvers.as_array().unwrap() {
        candidates.push(&of(maneuver)).unwrap();
    }
    candidates
}

fn covariance(name: &str) -> Covariance {
    let (moments, criteria): (Value, Value) =
        (serde_json::from_str(MOMENTS).unwrap(), serde_json::from_str(CRITERIA).unwrap());
    let information = candidates(&moments["moments"], |m| {
        m["degrees"].as_array().unwrap().iter().flat_map(|d| floats(&d["M"])).collect()
    });
    let meat = candidates(&criteria["B"], |b| b.as_array().unwrap().iter().flat_map(floats).collect());
    let truth = ["X_u", "X_uu", "X_vr", "X_tau", "", "Y_v", "Y_ur", "Y_tau", "", "N_r", "N_uv", "N_tau", ""];
    let weight = |parameter: &&str| match moments["parameters"][*parameter].as_f64() {
        Some(theta) if name == "a-relative" => 1.0 / (theta * theta),
        Some(_) => 1.0,
        None => 0.0,
    };
    let weights: Vec<f64> = truth.iter().map(weight).collect();
    let norm = match name {
        "d" => Norm::LogDet,
        _ => Norm::Trace,
    };
    Covariance::new(&information, &meat, &weights, norm).unwrap()
}

/// The criterion as the oracle has it.
fn value(name: &str, objective: f64) -> f64 {
    if name == "d" { -objective } else { (-objective).exp() }
}

#[test]
fn oracle_shares_and_values_of_every_criterion() {
    let criteria: Value = serde_json::from_str(CRITERIA).unwrap();
    for (name, of_value, of_shares) in CASES {
        let expected = &criteria["criteria"][name];
        let c = covariance(name);
        let options = Options { tolerance: 1e-7, ..Options::default() };
        let design = solve_covariance(&c, &Bounds::default(), &options).unwrap();
        assert_eq!(design.status, Status::Stationary, "{name}: {}", design.gap);
        let (found, best) = (value(name, design.log_det), expected["value"].as_f64().unwrap());
        assert!((found - best).abs() < of_value * best.abs(), "{name}: {found} {best}");
        for (q, (found, expected)) in design.shares.iter().zip(floats(&expected["shares"])).enumerate() {
            assert!((found - expected).abs() < of_shares, "{name} {q}: {found} {expected}");
        }
        let variances = c.variances(&design.shares).unwrap();
        let rows = [0, 1, 2, 3, 5, 6, 7, 9, 10, 11];
        for (row, expected) in rows.iter().zip(floats(&expected["standard_errors"])) {
            let found = variances[*row].sqrt();
            assert!(
                (found - expected).abs() < 10.0 * of_shares * expected,
                "{name} {row}: {found} {expected}"
            );
        }
    }
}

#[test]
fn oracle_values_at_equal_shares() {
    let criteria: Value = serde_json::from_str(CRITERIA).unwrap();
    for (name, ..) in CASES {
        let c = covariance(name);
        let found = value(name, c.value(&[1.0 / 11.0; 11], &mut CovariancePoint::default()).unwrap());
        let expected = criteria["criteria"][name]["value_equal_shares"].as_f64().unwrap();
        assert!((found - expected).abs() < 1e-6 * expected.abs(), "{name}: {found} {expected}");
    }
}
