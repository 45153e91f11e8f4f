//! Pooled estimates against numbers computed independently: `fixtures/oracle/pooled.json`.

use approx::assert_relative_eq;
use numerics::statistics::chi_square_tail;
use regression::pooled::{
    Centring, Options, Prior, Regression, diagnose, fit, residuals, sandwich, strength, whiteness,
};
use regression::{MeanRemoval, Sums};
use serde_json::Value;
use ship::model::Vessel;

use crate::support::craft::{close, craft, numbers, oracle, parts, regression};

const REMOVALS: [(&str, MeanRemoval); 3] =
    [("none", MeanRemoval::None), ("batch", MeanRemoval::Batch), ("complete", MeanRemoval::Complete)];

/// The data with instruments of `estimator`.
fn regressions(oracle: &Value, vessel: &Vessel, estimator: &str) -> Vec<Regression> {
    let lifted = vessel.model.with_intercepts();
    let nominal = (estimator == "iv").then(|| lifted.layout().woven(&vessel.nominal, [0.0; 3]));
    parts(oracle).iter().map(|part| regression(vessel, part, nominal.as_deref())).collect()
}

#[test]
fn oracle_pooled_estimates_priors_covariances_and_tests() {
    let oracle = oracle();
    let vessel = craft();
    let bandwidth = oracle["bandwidth"].as_u64().unwrap() as usize;
    let lags = oracle["lags"].as_u64().unwrap() as usize;
    for estimator in ["ls", "iv"] {
        let data = regressions(&oracle, &vessel, estimator);
        let data: Vec<&Regression> = data.iter().collect();
        let sums: Vec<Sums> = data.iter().map(|r| r.sums()).collect();
        let sums: Vec<&Sums> = sums.iter().collect();
        for (name, removal) in REMOVALS {
            let expected = &oracle["fits"][estimator][name];
            let plain = Options { removal, prior: None, most: f64::INFINITY };
            let prior = Prior { strength: oracle["strength"].as_f64().unwrap(), nominal: &vessel.nominal };
            let (found, pulled) = (fit(&sums, &plain), fit(&sums, &Options { prior: Some(prior), ..plain }));
            let centring = Centring::new(&sums, removal);
            for d in 0..3 {
                let what = |thing: &str| format!("{estimator} {name} {d} {thing}");
                let solution = found[d].solution.as_ref().unwrap();
                close(&solution.theta, &expected["theta"][d], &what("theta"));
                if name != "batch" {
                    let intercept = expected["intercept"][d].as_f64().unwrap();
                    assert_relative_eq!(solution.intercept, intercept, max_relative = 1e-9, epsilon = 1e-14);
                    let index = expected["index"][d].as_f64().unwrap();
                    let found = diagnose(&sums, removal, d).index;
                    assert_relative_eq!(found, index, max_relative = 1e-9);
                }
                let theta = &pulled[d].solution.as_ref().unwrap().theta;
                close(theta, &expected["prior"][d], &what("prior"));
                let covariance = sandwich(&data, &centring, solution, d, bandwidth);
                close(&covariance, &expected["covariance"][d], &what("covariance"));
                close(&strength(&data, &centring, d).unwrap(), &expected["strength"][d], &what("strength"));
                let white = whiteness(&residuals(&data, &centring, solution, d), lags);
                let test = &expected["whiteness"][d];
                assert_relative_eq!(
                    white.statistic,
                    test["statistic"].as_f64().unwrap(),
                    max_relative = 1e-9
                );
                assert_relative_eq!(
                    white.p_value,
                    test["p_value"].as_f64().unwrap(),
                    max_relative = 1e-7,
                    epsilon = 1e-14
                );
            }
        }
    }
}

#[test]
fn oracle_chi_square() {
    for case in oracle()["chi_square"].as_array().unwrap() {
        let case = numbers(case);
        assert_relative_eq!(chi_square_tail(case[0], case[1]), case[2], max_relative = 1e-10);
    }
}
