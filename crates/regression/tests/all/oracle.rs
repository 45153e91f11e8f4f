//! Moments against numbers computed independently: `fixtures/oracle/oracle.json`.

use crate::support::explicit::{Regression, sizes};
use crate::support::{Experiment, Recording, SideBySide, dictionary, paper};
use numerics::LANES;
use regression::moments;
use serde_json::Value;
use ship::model::Source;

const ORACLE: &str = include_str!("../../../../fixtures/oracle/oracle.json");

fn oracle(key: &str) -> Value {
    let mut whole: Value = serde_json::from_str(ORACLE).unwrap();
    whole[key].take()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// Every maneuver of the dictionary, undisturbed and measured without noise.
fn maneuvers() -> Vec<Recording> {
    let vessel = paper();
    let generator = dictionary(&vessel);
    let record = |index: usize| {
        let samples = generator.samples(index).unwrap();
        let experiment = Experiment::of_maneuvers(&generator, &[(index, samples)]);
        Recording {
            measured: experiment.states(&vessel, Source::Value),
            instrument_states: experiment.states(&vessel, Source::Nominal),
            exogenous: experiment.inputs,
            segments: vec![0],
        }
    };
    (0..generator.maneuvers().len()).map(record).collect()
}

#[test]
fn oracle_moments() {
    let (vessel, expected) = (paper(), oracle("moments"));
    let (runs, expected) = (maneuvers(), expected.as_array().unwrap());
    assert_eq!((runs.len(), expected.len()), (11, 11));
    for (runs, expected) in runs.chunks(LANES).zip(expected.chunks(LANES)) {
        let side_by_side = SideBySide::new(&runs.iter().collect::<Vec<_>>());
        let found = moments(&side_by_side.batch(&vessel.model));
        for ((run, found), expected) in runs.iter().zip(found).zip(expected) {
            assert_eq!(found.samples, expected["samples"].as_u64().unwrap());
            for (d, matrix) in found.matrices.iter().enumerate() {
                let named = format!("{} {}", expected["name"], expected["degrees"][d]["name"]);
                compare(run, d, matrix, &numbers(&expected["degrees"][d]["M"]), &named);
            }
        }
    }
}

/// To 1e-9 relative; entries below a thousandth of their row's and column's root mean squares are compared at that
/// scale.
fn compare(run: &Recording, d: usize, found: &[f64], expected: &[f64], named: &str) {
    assert_eq!(found.len(), expected.len(), "{named}");
    let regression = Regression::of(run, d);
    let (mut rows, mut columns) = (sizes(&regression.phi), sizes(&regression.zeta));
    rows.push(1.0);
    columns.push(1.0);
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        let (i, j) = (k / rows.len(), k % rows.len());
        let size = expected.abs().max(1e-3 * rows[i] * columns[j]);
        let error = (found - expected).abs();
        assert!(error <= 1e-9 * size, "{named}, entry {i} {j}: found {found}, expected {expected}");
    }
}
