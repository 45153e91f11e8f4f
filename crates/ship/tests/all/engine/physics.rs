//! Ships with forces, stepped as any model.

use numerics::{LANES, Lane};
use ship::engine::Weather;
use ship::engine::{Ambient, Compiled, Pose, Ship, simulate, simulate_one};
use ship::model::{Source, Vessel};

const SHIPS: [(&str, [f64; 3], &[f64]); 3] = [
    ("mariner", [7.0, 0.4, -0.006], &[0.2]),
    ("kvlcc2-l7", [1.1, -0.1, 0.03], &[0.3, 11.0]),
    ("otter", [1.2, 0.1, 0.3], &[60.0, -30.0]),
];

fn ship(name: &str, rate_hz: f64) -> Vessel {
    Vessel::from_file(format!("preset = \"{name}\"\nsample_rate_hz = {rate_hz}").parse().unwrap()).unwrap()
}

#[test]
fn law_a_sample_is_a_step_of_the_forces() {
    for (name, state, inputs) in SHIPS {
        let vessel = ship(name, 4.0);
        let moved = vessel.model.forces.as_ref().unwrap();
        let expected = moved.forces.body(&vessel.nominal).step_held(state, inputs, 0.25);
        let found = Compiled::new(&vessel.model, &vessel.nominal).step(state, inputs, Ambient::default());
        for d in 0..3 {
            assert!((found[d] - expected[d]).abs() < 1e-14, "{name}: {found:?} {expected:?}");
        }
    }
}

#[test]
fn law_lanes_of_ships_are_single_ships_to_the_bit() {
    for (name, state, inputs) in SHIPS {
        let vessel = ship(name, 8.0);
        let exogenous: Vec<f64> = (0..40).flat_map(|_| inputs.to_vec()).collect();
        let parameters: Vec<Lane> = vessel.nominal.iter().map(|own| Lane::splat(*own)).collect();
        let of = |lane: usize| state.map(|own| own * (1.0 + 0.01 * lane as f64));
        let initial = [0, 1, 2].map(|d: usize| Lane(std::array::from_fn(|lane| of(lane)[d])));
        let mut states = vec![Lane::ZERO; 3 * 41];
        simulate(&vessel.model, &parameters, initial, &exogenous, &Weather::CALM, &mut states);
        for lane in 0..LANES {
            let alone = simulate_one(&vessel.model, &vessel.nominal, of(lane), &exogenous);
            let found: Vec<f64> = states.iter().map(|own| own[lane]).collect();
            assert_eq!(found, alone, "{name}");
        }
    }
}

#[test]
fn law_gradients_of_increments_are_central_differences() {
    for (name, state, inputs) in SHIPS {
        let vessel = ship(name, 4.0);
        let mut compiled = Compiled::new(&vessel.model, &vessel.nominal);
        let current = Some([0.1, -0.2]);
        compiled.look(state, inputs, current);
        let mut gradients = vec![[0.0; 3]; vessel.model.variables.len()];
        compiled.gradients(&mut gradients);
        let slopes = compiled.slopes();
        for variable in 0..gradients.len() {
            let mut at = |sign: f64| {
                let (mut state, mut inputs) = (state, inputs.to_vec());
                let own = if variable < 3 { &mut state[variable] } else { &mut inputs[variable - 3] };
                *own += sign * 1e-6;
                compiled.look(state, &inputs, current);
                compiled.increments()
            };
            let (above, below) = (at(1.0), at(-1.0));
            for d in 0..3 {
                let difference = (above[d] - below[d]) / 2e-6;
                let found = gradients[variable][d];
                assert!(
                    (found - difference).abs() <= 1e-5 * found.abs() + 1e-8,
                    "{name} {variable} {d}: {found} {difference}"
                );
                assert!(variable >= 3 || slopes[d][variable] == found);
            }
        }
    }
}

/// North and east speed over the ground.
fn over_ground(ship: &Ship) -> [f64; 2] {
    let ((sin, cos), [u, v, _]) = (libm::sincos(ship.pose.psi), ship.state);
    [u * cos - v * sin, u * sin + v * cos]
}

#[test]
fn law_a_steady_current_carries_a_ship_along_while_she_turns() {
    let vessel = ship("kvlcc2-l7", 10.0);
    let parameters = vessel.parameters(Source::Value).unwrap();
    let begin = |current: [f64; 2]| {
        let mut own = Ship::new(&vessel, &parameters, Pose::default(), 1.0 + current[0]);
        (own.current_m_s, own.state[1]) = (current, current[1]);
        own
    };
    let (mut still, mut carried) = (begin([0.0; 2]), begin([0.3, -0.4]));
    for _ in 0..600 {
        still.step(&[0.5, 11.0]);
        carried.step(&[0.5, 11.0]);
    }
    assert!(still.pose.psi > 3.0, "{}", still.pose.psi);
    let [still, carried] = [&still, &carried].map(over_ground);
    // Headings are summed up by single steps, so that the current's direction is a little late.
    assert!((carried[0] - still[0] - 0.3).abs() < 2e-3, "{still:?} {carried:?}");
    assert!((carried[1] - still[1] + 0.4).abs() < 2e-3, "{still:?} {carried:?}");
}
