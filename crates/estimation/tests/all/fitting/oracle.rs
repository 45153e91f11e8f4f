//! Costs and their minimum by `scripts/independent/force_fit.py`.

use estimation::fitting::{Problem, RecordingView, Settings, Starts};
use serde_json::Value;

use crate::fitting::ship::forces;

fn numbers(of: &Value) -> Vec<f64> {
    of.as_array().unwrap().iter().map(|own| own.as_f64().unwrap()).collect()
}

#[test]
fn oracle_the_cost_and_its_minimum_are_those_of_an_independent_program() {
    let all: Value =
        serde_json::from_str(include_str!("../../../../../fixtures/oracle/force_fit.json")).unwrap();
    let forces = forces(all["vessel"].as_str().unwrap());
    let set = |key: &str| all["settings"][key].as_f64().unwrap();
    let settings = Settings {
        window_s: set("window_s"),
        knee: set("knee"),
        prior_weight: set("prior_weight"),
        starts: Starts::Measured,
        ..Settings::new(set("sample_s"))
    };
    let rows = all["recordings"].as_array().unwrap();
    let rows: Vec<[Vec<f64>; 2]> =
        rows.iter().map(|own| ["inputs", "measured"].map(|key| numbers(&own[key]))).collect();
    let recordings =
        rows.iter().map(|[inputs, measured]| RecordingView { name: "recording", inputs, measured });
    let problem = Problem::new(&forces, recordings.collect(), 2, settings).unwrap();
    for own in all["costs"].as_array().unwrap() {
        let found = problem.cost(&numbers(&own["theta"]));
        let expected = own["cost"].as_f64().unwrap();
        assert!((found - expected).abs() <= 1e-10 * expected, "{found} {expected}");
    }
    let fit = problem.fit().unwrap();
    let (theta, least) = (numbers(&all["minimum"]["theta"]), all["minimum"]["cost"].as_f64().unwrap());
    assert!(fit.cost <= least * (1.0 + 1e-6), "{} {least}", fit.cost);
    for ((found, expected), own) in fit.theta.iter().zip(&theta).zip(forces.parameters()) {
        let off = (found - expected).abs() / own.prior.unwrap();
        assert!(off < 2e-3, "{}: {found} {expected}", own.name);
    }
}
