//! Measured runs whose instruments are collinear.

use estimation::Estimator;
use estimation::predictor::InitialState;
use estimation::runs::{AdditionalUnknowns, RunEstimators};
use regression::MeanRemoval;
use ship::engine::{Run, Segment};
use ship::model::Vessel;

/// A zig-zag of the tanker, `thrust(k)` its thrust.
fn zig_zag(vessel: &Vessel, design: &str, thrust: impl Fn(usize) -> f64) -> Run {
    let rudder = |k: usize| if (k / 25).is_multiple_of(2) { 0.35 } else { -0.35 };
    let exogenous: Vec<f64> = (0..400).flat_map(|k| [thrust(k), rudder(k)]).collect();
    let initial = [1.0, 0.0, 0.0];
    Run {
        design: design.to_owned(),
        run: 0,
        segments: vec![Segment { maneuver: "zig-zag".to_owned(), start: 0 }],
        measured: ship::engine::simulate_one(&vessel.model, &vessel.nominal, initial, &exogenous),
        instrument_exogenous: Vec::new(),
        exogenous,
        initial,
    }
}

#[test]
fn a_measured_run_at_steady_thrust_is_not_answered_and_a_simulated_one_is() {
    let file = include_str!("../../../../pipelines/kvlcc2/vessel.toml");
    let vessel = Vessel::from_file(file.parse().unwrap()).unwrap();
    let estimators = RunEstimators {
        vessel: &vessel,
        estimators: vec![Estimator::Iv],
        removal: MeanRemoval::Complete,
        initial: InitialState::Known,
        additional: AdditionalUnknowns::default(),
        levels: None,
    };
    let judged =
        |design: &str, thrust: &dyn Fn(usize) -> f64| estimators.collinear(&zig_zag(&vessel, design, thrust));
    let steady = |k: usize| 45.0 + (k as f64 / 9.0).sin();
    let found = judged("measured", &steady).unwrap();
    assert_eq!((found.degree, vessel.model.degrees[0].parameters[found.parameter].as_str()), (0, "X_thrust"));
    assert!(found.words.starts_with("surge: `thrust` (hardly varies, by 1.6 %)"), "{}", found.words);
    assert!(found.words.contains("cannot be told from the intercept"), "{}", found.words);
    assert_eq!(judged("random", &steady), None);
    let found = judged("measured", &|k| if (k / 60).is_multiple_of(3) { 5.0 } else { 60.0 });
    assert!(found.is_none_or(|found| !found.words.contains("`thrust` (hardly")));
}
