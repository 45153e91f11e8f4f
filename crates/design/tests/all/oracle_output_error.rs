//! Designs for output-error estimates of the paper's eleven maneuvers against numbers computed independently
//! (`fixtures/oracle/output_information.json`: SLSQP from six starts).

use design::{
    Bounds, Candidates, Covariance, CovariancePoint, Norm, Objective, Options, Status, solve_covariance,
};
use serde_json::Value;

const ORACLE: &str = include_str!("../../../../fixtures/oracle/output_information.json");
const TRUTH: &str = include_str!("../../../../fixtures/oracle/oracle.json");
const ROWS: [&str; 13] =
    ["X_u", "X_uu", "X_vr", "X_tau", "", "Y_v", "Y_ur", "Y_tau", "", "N_r", "N_uv", "N_tau", ""];

fn floats(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn covariance(oracle: &Value, noise: &str, name: &str) -> Covariance {
    let truth: Value = serde_json::from_str(TRUTH).unwrap();
    let (mut information, mut meat) = (Candidates::new(vec![13]), Candidates::new(vec![13]));
    for (f, p) in oracle["F"].as_array().unwrap().iter().zip(oracle["P"].as_array().unwrap()) {
        let (f, p) = (floats(f), floats(p));
        information.push(&f).unwrap();
        let sum: Vec<f64> = f.iter().zip(&p).map(|(f, p)| f + p).collect();
        meat.push(if noise == "all" { &sum } else { &f }).unwrap();
    }
    if name == "v" {
        return Covariance::of_matrices(&information, &meat, &[floats(&oracle["G"])]).unwrap();
    }
    let weight = |parameter: &&str| match truth["parameters"][*parameter].as_f64() {
        Some(theta) if name == "a-relative" => 1.0 / (theta * theta),
        Some(_) => 1.0,
        None => 0.0,
    };
    let weights: Vec<f64> = ROWS.iter().map(weight).collect();
    let norm = if name == "d" { Norm::LogDet } else { Norm::Trace };
    Covariance::new(&information, &meat, &weights, norm).unwrap()
}

#[test]
fn oracle_designs_for_output_error() {
    let oracle: Value = serde_json::from_str(ORACLE).unwrap();
    for noise in ["measurement", "all"] {
        for name in ["d", "a-relative", "v"] {
            let c = covariance(&oracle, noise, name);
            let design =
                solve_covariance(&c, &Bounds::default(), &Options { tolerance: 1e-8, ..Options::default() })
                    .unwrap();
            // White measurement errors alone make the problem concave: the certificate is one of the global optimum.
            let status = if noise == "measurement" { Status::Optimal } else { Status::Stationary };
            assert_eq!(design.status, status, "{noise} {name}: {}", design.gap);
            let expected = &oracle["criteria"][noise][name];
            let value = |objective: f64| if name == "d" { -objective } else { (-objective).exp() };
            let (found, best) = (value(design.log_det), expected["value"].as_f64().unwrap());
            assert!((found - best).abs() < 1e-7 * best.abs(), "{noise} {name}: {found} {best}");
            let equal = value(c.value(&[1.0 / 11.0; 11], &mut CovariancePoint::default()).unwrap());
            let best = expected["value_equal_shares"].as_f64().unwrap();
            assert!((equal - best).abs() < 1e-6 * best.abs(), "{noise} {name}: {equal} {best}");
            for (q, (found, expected)) in design.shares.iter().zip(floats(&expected["shares"])).enumerate() {
                assert!((found - expected).abs() < 1e-4, "{noise} {name} {q}: {found} {expected}");
            }
        }
    }
}
