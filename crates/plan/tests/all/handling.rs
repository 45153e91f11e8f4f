//! How a vessel is handled, by its abilities.

use plan::{Ability, DerivedHandling, Mode, StatedHandling};
use ship::engine::{Pose, Ship};
use ship::model::Vessel;

const MODES: [f64; 2] = [2.5, 4.0];

/// The coaster with keys for its thrust and its rudder.
pub fn coaster(thrust: &str, rudder: &str) -> Vessel {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/ships/coaster60/vessel.toml");
    let text = std::fs::read_to_string(file).unwrap();
    let text = text.replacen("unit = \"kN\"", &format!("unit = \"kN\"\n{thrust}"), 1).replacen(
        "unit = \"rad\"",
        &format!("unit = \"rad\"\n{rudder}"),
        1,
    );
    Vessel::from_file(text.parse().unwrap()).unwrap()
}

fn derived(vessel: &Vessel) -> DerivedHandling {
    let modes = MODES.map(|speed_m_s| Mode { name: speed_m_s.to_string(), speed_m_s });
    DerivedHandling::of(vessel, &modes, 60.0).unwrap()
}

#[test]
fn law_the_largest_yaw_rate_is_what_a_long_turn_with_the_rudder_hard_over_comes_to() {
    let vessel = coaster("range = [-400.0, 1200.0]", "range = [-0.6, 0.6]");
    let turn = |speed: f64| {
        let mut ship = Ship::new(&vessel, &vessel.nominal, Pose::default(), speed);
        let mut thrust = 0.0;
        for _ in 0..20_000 {
            thrust += 20.0 * (speed - ship.state[0]);
            ship.step(&[thrust, 0.6]);
        }
        assert!((ship.state[0] - speed).abs() < 1e-9 && thrust < 1200.0, "{thrust}");
        ship.state[2]
    };
    let slowest = MODES.map(turn).into_iter().fold(f64::INFINITY, f64::min);
    let found = derived(&vessel).ability.turn_rate_rad_s.unwrap();
    assert!((found - slowest).abs() < 1e-6, "{found} {slowest}");
}

#[test]
fn law_speed_is_gained_and_lost_as_fast_as_a_step_of_the_thrust_does_it() {
    let vessel = coaster("range = [-400.0, 1200.0]", "range = [-0.6, 0.6]");
    let gain = |speed: f64, thrust: f64| {
        let mut ship = Ship::new(&vessel, &vessel.nominal, Pose::default(), speed);
        ship.step(&[thrust, 0.0]);
        ship.state[0] - speed
    };
    let least = |thrust: f64| MODES.map(|speed| gain(speed, thrust).abs()).into_iter().reduce(f64::min);
    let Ability { acceleration_m_s2, braking_m_s2, coasting_m_s2, .. } = derived(&vessel).ability;
    for (found, expected) in [(acceleration_m_s2, least(1200.0)), (braking_m_s2, least(-400.0))] {
        assert!((found.unwrap() - expected.unwrap()).abs() < 1e-12, "{found:?} {expected:?}");
    }
    assert!((coasting_m_s2 + gain(2.5, 0.0)).abs() < 1e-12);
}

#[test]
fn law_speeds_change_as_in_coasting_unless_the_thrust_cannot_be_taken_away() {
    // The rudder brakes, too.
    let drag =
        "[[surge]]\nparameter = \"X_uudd\"\nterm = \"u u delta delta\"\nvalue = -0.01\nnominal = -0.01";
    let with = |range: &str| derived(&coaster(range, &format!("range = [-0.6, 0.6]\n{drag}")));
    let DerivedHandling { handling, ability } = with("range = [-400.0, 1200.0]");
    assert_eq!(handling.acceleration_m_s2, ability.coasting_m_s2);
    // The thrusts of both speeds are between these: with the least of them she hardly loses speed.
    let DerivedHandling { handling, ability } = with("range = [145.0, 1200.0]");
    let least = ability.acceleration_m_s2.unwrap().min(ability.braking_m_s2.unwrap());
    assert!(ability.coasting_m_s2 < 0.1 * least, "{ability:?}");
    assert_eq!(handling.acceleration_m_s2, 0.5 * least);
}

/// A point that is always headed for the point ahead on a line turns no faster than the vessel can, in its fastest mode.
#[test]
fn law_a_line_is_aimed_at_as_near_as_the_yaw_rate_can_follow() {
    for (rudder, binding) in [("0.6", false), ("0.05", true)] {
        let vessel = coaster("range = [-400.0, 1200.0]", &format!("range = [-{rudder}, {rudder}]"));
        let handling = derived(&vessel).handling;
        let (mut across, mut before, mut most, step_s) = (20.0 * handling.lookahead_m, None, 0.0_f64, 0.01);
        while across > 0.1 {
            let course = (across / handling.lookahead_m).atan();
            most = before.map_or(most, |before: f64| most.max((before - course) / step_s));
            before = Some(course);
            across -= MODES[1] * course.sin() * step_s;
        }
        let part = most / handling.turn_rate_rad_s;
        let expected = if binding { 0.999..1.001 } else { 0.0..0.999 };
        assert!(expected.contains(&part), "rudder {rudder}: {part} of the yaw rate");
    }
}

#[test]
fn what_is_stated_is_taken_unless_the_vessel_cannot_do_it() {
    let vessel = coaster("range = [-400.0, 1200.0]", "range = [-0.6, 0.6]\nlag_s = 8.0");
    let own = derived(&vessel);
    assert_eq!(StatedHandling::default().completed(&own).unwrap(), own.handling);
    assert!(own.handling.response_s >= 64.0, "{own:?}");
    let stated = StatedHandling { turn_rate_rad_s: Some(0.006), ..StatedHandling::default() };
    assert_eq!(stated.completed(&own).unwrap().turn_rate_rad_s, 0.006);
    let fast = StatedHandling { turn_rate_rad_s: Some(0.2), ..StatedHandling::default() };
    let strong = StatedHandling { acceleration_m_s2: Some(2.0), ..StatedHandling::default() };
    for (stated, key) in [(fast, "turn_rate_rad_s"), (strong, "acceleration_m_s2")] {
        let refused = stated.completed(&own).unwrap_err().to_string();
        assert!(refused.contains(key) && refused.contains("`range`"), "{refused}");
    }
    // Where no range is known nothing is refused, and turns are as wide as usual for the length.
    let free = derived(&coaster("", ""));
    assert_eq!((free.ability.turn_rate_rad_s, free.ability.braking_m_s2), (None, None));
    assert!((2.5 / free.handling.turn_rate_rad_s - 240.0).abs() < 1e-9 && fast.completed(&free).is_ok());
}

#[test]
fn a_speed_beyond_the_thrust_is_refused_by_name() {
    let weak = coaster("range = [-40.0, 120.0]", "range = [-0.6, 0.6]");
    let mode = Mode { name: "fast".to_owned(), speed_m_s: 4.0 };
    let refused = DerivedHandling::of(&weak, &[mode], 60.0).unwrap_err().to_string();
    assert!(refused.contains("`thrust`") && refused.contains("-40 to 120"), "{refused}");
}
