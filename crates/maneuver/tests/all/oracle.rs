//! Maneuvers and their simulation against numbers computed independently: `fixtures/oracle/oracle.json` (steady inputs
//! by a bracketed root instead of Newton's method, states by scalar loops).

use maneuver::{DictionaryFile, Generator};
use serde_json::Value;
use ship::engine::simulate_one;
use ship::model::{Source, Vessel, VesselFile};

const ORACLE: &str = include_str!("../../../../fixtures/oracle/oracle.json");
const VESSEL: &str = include_str!("../../../../pipelines/paper/vessel.toml");
const DICTIONARY: &str = include_str!("../../../../pipelines/scenarios/dictionary.toml");

/// Smallest sizes that count as such: a thousandth of what the dictionary uses of u, v \[m/s\], r \[rad/s\] and of
/// τ1, τ2 \[N\], τ3 \[N m\].
const STATE_FLOOR: [f64; 3] = [1e-3, 1e-4, 3e-4];
const INPUT_FLOOR: [f64; 3] = [5.0, 0.5, 0.2];

fn vessel() -> Vessel {
    Vessel::from_file(VESSEL.parse::<VesselFile>().unwrap()).unwrap()
}

fn generator(vessel: &Vessel) -> Generator {
    let file: DictionaryFile = DICTIONARY.parse().unwrap();
    Generator::without_tables(vessel, &file).unwrap()
}

fn oracle(key: &str) -> Value {
    serde_json::from_str::<Value>(ORACLE).unwrap()[key].take()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// Row k of `found` (row-major, three columns) against row i of `expected`, to 1e-9 relative.
fn assert_row_close(found: &[f64], k: usize, expected: &Value, floor: [f64; 3], what: &str) {
    let (found, expected) = (&found[3 * k..3 * k + 3], numbers(expected));
    assert_eq!(expected.len(), 3, "{what}");
    for i in 0..3 {
        let bound = 1e-9 * expected[i].abs().max(floor[i]);
        let error = (found[i] - expected[i]).abs();
        assert!(error <= bound, "{what}, sample {k}, {i}: found {}, expected {}", found[i], expected[i]);
    }
}

#[test]
fn oracle_inputs_and_states_of_every_maneuver() {
    let (vessel, expected) = (vessel(), oracle("maneuvers"));
    let (generator, expected) = (generator(&vessel), expected.as_array().unwrap());
    assert_eq!((generator.maneuvers().len(), expected.len()), (11, 11));
    for (index, (maneuver, expected)) in generator.maneuvers().iter().zip(expected).enumerate() {
        assert_eq!(maneuver.name, expected["name"]);
        let samples = generator.samples(index).unwrap();
        assert_eq!(samples as u64, expected["samples"].as_u64().unwrap(), "{}", maneuver.name);
        let run = generator.realize(index, samples).unwrap();
        assert_eq!(run.initial.to_vec(), numbers(&expected["initial"]), "{}", maneuver.name);
        check_samples(&vessel, &run.inputs, run.initial, expected);
    }
}

/// Inputs, true and nominal states of one maneuver at the samples that the oracle keeps.
fn check_samples(vessel: &Vessel, inputs: &[f64], initial: [f64; 3], expected: &Value) {
    let name = expected["name"].as_str().unwrap();
    let states =
        |source: Source| simulate_one(&vessel.model, &vessel.parameters(source).unwrap(), initial, inputs);
    let (truth, nominal) = (states(Source::Value), states(Source::Nominal));
    let samples = expected["k"].as_array().unwrap();
    assert!(samples.len() >= 4, "{name}");
    for (i, k) in samples.iter().map(|k| k.as_u64().unwrap() as usize).enumerate() {
        assert_row_close(inputs, k, &expected["inputs"][i], INPUT_FLOOR, &format!("{name}, inputs"));
        assert_row_close(&truth, k, &expected["states"][i], STATE_FLOOR, &format!("{name}, states"));
        let expected = &expected["nominal_states"][i];
        assert_row_close(&nominal, k, expected, STATE_FLOOR, &format!("{name}, nominal states"));
    }
}

#[test]
fn oracle_parameters_of_the_papers_vessel() {
    let (vessel, expected) = (vessel(), oracle("parameters"));
    let truth = vessel.parameters(Source::Value).unwrap();
    assert_eq!(expected.as_object().unwrap().len(), truth.len());
    for (name, found) in vessel.model.parameter_names().zip(truth) {
        assert_eq!(found, expected[name].as_f64().unwrap(), "{name}");
    }
}

/// The maneuvers of pipelines/paper by `scripts/paper_reading.py`: exact motions by an affine inversion instead of Newton's method.
#[test]
fn oracle_inputs_and_states_of_the_papers_reading() {
    let reading: Value =
        serde_json::from_str(include_str!("../../../../fixtures/oracle/reading.json")).unwrap();
    let vessel = vessel();
    let file: DictionaryFile = include_str!("../../../../pipelines/paper/dictionary.toml").parse().unwrap();
    let generator = Generator::without_tables(&vessel, &file).unwrap();
    let expected = reading["maneuvers"].as_array().unwrap();
    assert_eq!((generator.maneuvers().len(), expected.len()), (11, 11));
    for (index, expected) in expected.iter().enumerate() {
        assert_eq!(generator.maneuvers()[index].name, expected["name"]);
        let run = generator.realize(index, 320).unwrap();
        for (source, key) in [(Source::Value, "states"), (Source::Nominal, "nominal_states")] {
            let theta = vessel.parameters(source).unwrap();
            let states = simulate_one(&vessel.model, &theta, run.initial, &run.inputs);
            for (i, k) in numbers(&reading["k"]).into_iter().enumerate() {
                let what = format!("maneuver {index}, {key}");
                assert_row_close(&states, k as usize, &expected[key][i], STATE_FLOOR, &what);
                assert_row_close(&run.inputs, k as usize, &expected["inputs"][i], INPUT_FLOOR, &what);
            }
        }
    }
}
