//! Experiments whose inputs change no faster than their rates allow.

use maneuver::Generator;
use numerics::Watch;
use regression::Noise;
use ship::model::{Source, Vessel};
use trial::refining::{Limits, Refinement, RefinementStart};

const NOISE: Noise = Noise { measurement: [0.1, 0.1, 0.1], current: 0.1 };

/// The experiment of `inputs`, not yet simulated.
fn start(vessel: &Vessel, inputs: Vec<f64>) -> RefinementStart {
    RefinementStart {
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
    assert_eq!(
        slow.states,
        ship::engine::simulate_one(&vessel.model, &slow.parameters, slow.initial, &exogenous)
    );
    let again = start(&vessel, slow.inputs.clone()).within_rates(&vessel, &steps).unwrap();
    assert_eq!((again.inputs, again.slowed), (slow.inputs, Vec::<String>::new()));
}

/// The start of a search, to which quick steps to either side are added.
const ZIG_ZAG: &str = r#"
[[maneuver]]
name = "zig-zag"
kind = "zig-zag"
shape = "sine"
speed_m_s = 1.0
yaw_rate_amplitude_rad_s = 0.05
period_s = 20.0
duration_s = 40.0
"#;

#[test]
fn law_inputs_that_rise_and_fall_between_two_knots_as_fast_as_they_may_are_refined() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let last = vessel.model.input_names().len() - 1;
    let name = vessel.model.input_names()[last];
    let limits = format!("[limits]\nu_m_s = 3.0\nv_m_s = 1.0\nr_rad_s = 1.0\nrates = {{ {name} = 60.0 }}\n");
    let generator =
        Generator::without_tables(&vessel, &(ZIG_ZAG.to_owned() + &limits).parse().unwrap()).unwrap();
    let mut start = RefinementStart::new(&vessel, &generator, &[(0, 320)], NOISE).unwrap();
    let names = vessel.model.input_names();
    for (k, row) in start.inputs.chunks_exact_mut(names.len()).enumerate() {
        // Slow changes that tell all parameters apart.
        row[0] += 300.0 * libm::sin(k as f64 / 40.0);
        row[1] += 100.0 * libm::sin(k as f64 / 17.0);
        row[last] += if k % 8 < 4 { 40.0 } else { -40.0 };
    }
    let (limits, start) = Limits::new(&vessel, &generator, start).unwrap();
    assert_eq!(start.slowed, [names[last]]);
    let found = Refinement::search(&vessel, start, limits, 120, &Watch::default()).unwrap();
    assert!(found.efficiency() > 1.1, "{}", found.efficiency());
}
