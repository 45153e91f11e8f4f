//! Experiments whose inputs change no faster than their rates allow.

use model::{Source, Vessel};
use regression::Noise;
use trial::refining::Start;

const NOISE: Noise = Noise { measurement: [0.1, 0.1, 0.1], current: 0.1 };

/// The experiment of `inputs`, not yet simulated.
fn start(vessel: &Vessel, inputs: Vec<f64>) -> Start {
    Start {
        inputs,
        initial: [1.0, 0.0, 0.0],
        states: Vec::new(),
        source: Source::Value,
        parameters: vessel.parameters(Source::Value).unwrap(),
        weights: Vec::new(),
        noise: NOISE,
        slowed: Vec::new(),
    }
}

#[test]
fn law_slowed_inputs_keep_their_steps_across_jumps_and_end_where_they_were_to() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let names = vessel.model.input_names();
    // The first input jumps by 5, where a maneuver ends; the others have no limit.
    let jumps = [0.0, 0.5, 5.5, 5.5, 5.5, 5.5, 5.5];
    let other = [1.0, 9.0, 9.0, -3.0, -3.0, -3.0, 0.0];
    let inputs: Vec<f64> = jumps
        .iter()
        .zip(other)
        .flat_map(|(own, other)| {
            let mut row = vec![other; names.len()];
            row[0] = *own;
            row
        })
        .collect();
    let mut steps = vec![f64::INFINITY; names.len()];
    steps[0] = 2.0;
    let slow = start(&vessel, inputs.clone()).within_rates(&vessel, &steps).unwrap();
    assert_eq!(slow.slowed, [names[0]]);
    let own: Vec<f64> = slow.inputs.iter().copied().step_by(names.len()).collect();
    assert_eq!(own, [0.0, 0.5, 2.5, 4.5, 5.5, 5.5, 5.5]);
    let others = slow.inputs.iter().zip(&inputs).enumerate().filter(|(e, _)| e % names.len() != 0);
    others.for_each(|(_, (now, before))| assert_eq!(now, before));
    // Simulated with these inputs, and not slowed any more.
    let exogenous = vessel.model.undisturbed(&slow.inputs);
    assert_eq!(slow.states, engine::simulate_one(&vessel.model, &slow.parameters, slow.initial, &exogenous));
    let again = start(&vessel, slow.inputs.clone()).within_rates(&vessel, &steps).unwrap();
    assert_eq!((again.inputs, again.slowed), (slow.inputs, Vec::<String>::new()));
}
