//! Motions that are executed by feedback.

use maneuver::{DictionaryFile, Generator};
use ship::engine::{simulate_command, simulate_one};
use ship::model::{Source, Vessel};

fn dictionary(executed: &str) -> DictionaryFile {
    let text = format!(
        "duration_s = 40.0\ninputs_from = \"nominal\"\n\
         [[maneuver]]\nname = \"accelerate\"\nkind = \"accelerate\"\nfrom_m_s = 0.2\nto_m_s = 1.0\n{executed}\n\
         [[maneuver]]\nname = \"zig-zag\"\nkind = \"zig-zag\"\nspeed_m_s = 0.6\nyaw_rate_amplitude_rad_s = 0.15\n\
         period_s = 10.0\n{executed}\n\
         [[maneuver]]\nname = \"spin\"\nkind = \"steady-turn\"\nspeed_m_s = 0.5\nyaw_rate_rad_s = 0.1\nsway_speed_m_s = 0.1\n\
         {executed}\n"
    );
    text.parse().unwrap()
}

/// The greatest differences of u, v, r from the nominal ship's motion in the second half.
fn errors(vessel: &Vessel, generator: &Generator, index: usize) -> [f64; 3] {
    let samples = generator.samples(index).unwrap();
    let realized = generator.realize(index, samples).unwrap();
    let exogenous = vessel.model.undisturbed(&realized.inputs);
    let reference = simulate_one(&vessel.model, generator.parameters(), realized.initial, &exogenous);
    let truth = vessel.parameters(Source::Value).unwrap();
    let states = match &realized.helm {
        None => simulate_one(&vessel.model, &truth, realized.initial, &exogenous),
        Some(helm) => {
            simulate_command(&vessel.model, &truth, realized.initial, samples, vessel.sample_rate_hz, helm)
                .states
        }
    };
    [0, 1, 2].map(|d| {
        let pairs = states.iter().zip(&reference).skip(d).step_by(3).skip(samples / 2);
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    })
}

#[test]
fn law_feedback_makes_another_ship_move_as_the_nominal_one() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let open = Generator::without_tables(&vessel, &dictionary("")).unwrap();
    let closed = Generator::without_tables(&vessel, &dictionary("executed = \"feedback\"")).unwrap();
    for index in 0..3 {
        let [without, with] = [&open, &closed].map(|generator| errors(&vessel, generator, index));
        let worst = |errors: [f64; 3]| errors.into_iter().fold(0.0, f64::max);
        assert!(worst(with) < 0.25 * worst(without), "maneuver {index}: {without:?}, {with:?}");
        assert!(worst(with) < 0.03, "maneuver {index}: {with:?}");
    }
}

#[test]
fn law_feedback_changes_nothing_of_the_nominal_ship() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let closed = Generator::without_tables(&vessel, &dictionary("executed = \"feedback\"")).unwrap();
    for index in 0..3 {
        let samples = closed.samples(index).unwrap();
        let realized = closed.realize(index, samples).unwrap();
        let run = simulate_command(
            &vessel.model,
            closed.parameters(),
            realized.initial,
            samples,
            vessel.sample_rate_hz,
            realized.helm.as_ref().unwrap(),
        );
        let inputs = vessel.model.inputs_of(&run.exogenous);
        let off = inputs.iter().zip(&realized.inputs).map(|(a, b)| (a - b).abs() / b.abs().max(1.0));
        let worst = off.fold(0.0, f64::max);
        assert!(worst < 1e-9, "maneuver {index}: {worst}");
    }
}

#[test]
fn law_a_motion_that_another_ship_does_not_reach_is_said_and_feedback_reaches_it() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let truth = vessel.parameters(Source::Value).unwrap();
    let met = |executed: &str| {
        let generator = Generator::without_tables(&vessel, &dictionary(executed)).unwrap();
        let one = |index: usize| {
            let samples = generator.samples(index).unwrap();
            let realized = generator.realize(index, samples).unwrap();
            let states = match &realized.helm {
                None => simulate_one(
                    &vessel.model,
                    &truth,
                    realized.initial,
                    &vessel.model.undisturbed(&realized.inputs),
                ),
                Some(helm) => {
                    let (model, rate) = (&vessel.model, vessel.sample_rate_hz);
                    simulate_command(model, &truth, realized.initial, samples, rate, helm).states
                }
            };
            generator.reached(index, &states).iter().all(|aim| aim.is_met)
        };
        [0, 1, 2].map(one)
    };
    assert_eq!(met("executed = \"feedback\""), [true; 3]);
    assert!(met("").contains(&false));
}
