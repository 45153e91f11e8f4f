//! Thrusters with limits.

use logs::chain::{Actuator, Hits, Logged};
use logs::{Law, Setting};
use refusal::strictly;

const ACTUATOR: Actuator = Actuator {
    position_m: [-0.4, 0.1],
    coefficient: 2.0,
    law: Law::Quadratic,
    speed_limit_rps: Some(10.0),
    speed_rate_limit_rps_s: Some(4.0),
    angle_rate_limit_rad_s: Some(0.5),
    speed_std_rps: 0.0,
    speed_resolution_rps: 0.0,
    angle_std_rad: 0.0,
    angle_resolution_rad: 0.0,
    logged: Logged::Setting,
};

#[test]
fn a_thruster_gets_there_in_steps_and_says_so() {
    let (mut hits, mut at) = (Hits::default(), Some(Setting::default()));
    let wanted = Setting { n: -12.0, alpha: 0.3 };
    let mut speeds = Vec::new();
    for _ in 0..6 {
        at = Some(ACTUATOR.follow(at, wanted, 0.5, &mut hits));
        speeds.push(at.unwrap().n);
    }
    assert_eq!(speeds, [-2.0, -4.0, -6.0, -8.0, -10.0, -10.0]);
    assert_eq!(at.unwrap().alpha, 0.3);
    assert_eq!(hits, Hits { speed: 6, speed_rate: 4, angle_rate: 1 });
}

#[test]
fn at_the_start_it_is_where_it_is_wanted() {
    let mut hits = Hits::default();
    let found = ACTUATOR.follow(None, Setting { n: 9.0, alpha: 3.0 }, 0.1, &mut hits);
    assert_eq!((found, hits), (Setting { n: 9.0, alpha: 3.0 }, Hits::default()));
}

#[test]
fn numbers_without_meaning_are_refused() {
    let read = |keys: &str| {
        let text = format!("position_m = [0.0, 1.0]\ncoefficient = 1.0\n{keys}");
        toml::Deserializer::parse(&text).and_then(strictly::<Actuator, _>).map_err(|e| e.to_string())
    };
    assert!(read("").is_ok());
    for (keys, thing) in
        [("speed_limit_rps = 0.0", "`speed_limit_rps`"), ("angle_std_rad = -1.0", "`angle_std_rad`")]
    {
        let said = read(keys).unwrap_err();
        assert!(said.contains(thing), "{said}");
    }
}
