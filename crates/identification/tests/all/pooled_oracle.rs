//! Pooled estimates against numbers computed independently: `fixtures/oracle/pooled.json`.

use std::ops::Range;

use approx::assert_relative_eq;
use engine::RunView;
use identification::pooled::Score;
use model::Vessel;
use numerics::distributions::chi_square_tail;
use regression::pooled::{
    Centring, Options, Part, Prior, Regression, diagnose, fit, residuals, sandwich, strength, whiteness,
};
use regression::{MeanRemoval, Sums};
use serde_json::Value;

const REMOVALS: [(&str, MeanRemoval); 3] =
    [("none", MeanRemoval::None), ("batch", MeanRemoval::Batch), ("complete", MeanRemoval::Complete)];

fn oracle() -> Value {
    serde_json::from_str(include_str!("../../../../fixtures/oracle/pooled.json")).unwrap()
}

fn craft(oracle: &Value) -> Vessel {
    Vessel::from_file(toml::from_str(oracle["vessel"].as_str().unwrap()).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn parts(oracle: &Value) -> Vec<Part> {
    let part = |p: &Value| {
        let (inputs, measured) = (numbers(&p["inputs"]), numbers(&p["measured"]));
        Part::new("zigzag", p["source"].as_str().unwrap(), RunView::measured(&measured, &inputs))
    };
    oracle["parts"].as_array().unwrap().iter().map(part).collect()
}

fn close(found: &[f64], expected: &Value, what: &str) {
    let expected = numbers(expected);
    assert_eq!(found.len(), expected.len(), "{what}");
    let scale = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (found, expected) in found.iter().zip(&expected) {
        assert!(
            (found - expected).abs() < 1e-9 * expected.abs().max(1e-3 * scale),
            "{what}: {found} {expected}"
        );
    }
}

/// The data with instruments of `estimator`.
fn regressions(oracle: &Value, vessel: &Vessel, estimator: &str) -> Vec<Regression> {
    let lifted = vessel.model.with_intercepts();
    let nominal = (estimator == "iv").then(|| lifted.layout().woven(&vessel.nominal, [0.0; 3]));
    parts(oracle).iter().map(|part| regression(vessel, part, nominal.as_deref())).collect()
}

/// The data of `part` with instruments simulated with parameters `model`, or its regressors as instruments.
fn regression(vessel: &Vessel, part: &Part, model: Option<&[f64]>) -> Regression {
    match model {
        None => Regression::of(&vessel.model, &part.whole()),
        Some(model) => {
            let states = part.whole().simulated(&vessel.model.with_intercepts(), model).unwrap();
            Regression::with(&vessel.model, &part.whole(), &states)
        }
    }
}

#[test]
fn oracle_pooled_estimates_priors_covariances_and_tests() {
    let oracle = oracle();
    let vessel = craft(&oracle);
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
fn oracle_cross_validation() {
    let oracle = oracle();
    let vessel = craft(&oracle);
    let lifted = vessel.model.with_intercepts();
    let all = parts(&oracle);
    let window = oracle["window"].as_u64().unwrap() as usize;
    let options = Options { removal: MeanRemoval::Complete, prior: None, most: f64::INFINITY };
    let fitted = |parts: &[&Part], model: Option<&[f64]>| {
        let sums: Vec<Sums> = parts.iter().map(|p| regression(&vessel, p, model).sums()).collect();
        let found = fit(&sums.iter().collect::<Vec<_>>(), &options).map(|d| d.solution.unwrap());
        let theta: Vec<f64> = found.iter().flat_map(|s| s.theta.clone()).collect();
        lifted.layout().woven(&theta, [0, 1, 2].map(|d: usize| found[d].intercept))
    };
    for estimator in ["ls", "iv"] {
        let mut score = Score::default();
        for source in ["a", "b", "c"] {
            let train: Vec<&Part> = all.iter().filter(|p| p.source != source).collect();
            let mut model = fitted(&train, None);
            if estimator == "iv" {
                model = fitted(&train, Some(&model));
            }
            let cut = |p: &'_ Part| -> Vec<Range<usize>> {
                (0..p.samples() / window).map(|i| i * window..(i + 1) * window).collect()
            };
            let own = all.iter().filter(|p| p.source == source);
            let windows = own.flat_map(|p| cut(p).into_iter().map(|samples| p.view().part(samples)));
            score.merge(&Score::of(&lifted, &model, windows));
        }
        let expected = &oracle["cross"][estimator];
        assert_eq!(score.samples, expected["windows"].as_u64().unwrap() * window as u64);
        close(&score.rmse().unwrap(), &expected["rmse"], estimator);
    }
}

#[test]
fn oracle_chi_square() {
    for case in oracle()["chi_square"].as_array().unwrap() {
        let case = numbers(case);
        assert_relative_eq!(chi_square_tail(case[0], case[1]), case[2], max_relative = 1e-10);
    }
}
