//! Forces of thrusters.

use std::f64::consts::FRAC_PI_2;

use logs::{Law, Thruster};

const AFT_STARBOARD: Thruster = Thruster { law: Law::Quadratic, coefficient: 2.0, position_m: [-0.4, 0.1] };

#[test]
fn a_thruster_on_the_starboard_side_that_pushes_forward_turns_the_bow_to_port() {
    let [forward, starboard, moment] = AFT_STARBOARD.forces(3.0, 0.0);
    assert_eq!((forward, starboard), (18.0, 0.0));
    approx::assert_abs_diff_eq!(moment, -1.8, epsilon = 1e-15);
}

#[test]
fn a_stern_that_is_pushed_to_starboard_turns_the_bow_to_port() {
    let moment = AFT_STARBOARD.forces(3.0, FRAC_PI_2)[2];
    approx::assert_abs_diff_eq!(moment, -0.4 * 18.0, epsilon = 1e-14);
}

#[test]
fn law_reversing_reverses_the_force() {
    for law in [Law::Quadratic, Law::Linear] {
        let thruster = Thruster { law, ..AFT_STARBOARD };
        assert_eq!(thruster.forces(-3.0, 0.7), thruster.forces(3.0, 0.7).map(|f| -f));
    }
}
