//! The response of actuators to commands.

use model::{Actuator, Vessel};

const RUDDER: Actuator = Actuator { range: Some([-0.6, 0.6]), lag_s: 2.0, rate_per_s: Some(0.05) };

#[test]
fn law_an_actuator_follows_a_command_by_the_equation_of_its_lag_at_any_sampling_rate() {
    let own = Actuator { rate_per_s: None, ..RUDDER };
    for samples in [1, 7, 100] {
        let seconds = 3.0 / f64::from(samples);
        let there = (0..samples).fold(0.1, |setting, _| own.after(setting, 0.5, seconds));
        assert!((there - (0.5 - 0.4 * (-3.0_f64 / 2.0).exp())).abs() < 1e-12, "{there}");
    }
    assert_eq!(Actuator::default().after(0.1, 0.5, 0.01), 0.5);
}

#[test]
fn law_no_command_takes_an_actuator_farther_than_its_rate_and_its_range() {
    let mut setting = 0.0;
    for second in 0..100 {
        let next = RUDDER.after(setting, if second < 50 { 0.6 } else { -0.6 }, 1.0);
        assert!((next - setting).abs() <= 0.05 + 1e-15 && next.abs() <= 0.6);
        setting = next;
    }
}

#[test]
fn law_what_is_wanted_is_reached_where_some_command_does_it() {
    // All commands within the range, tried out.
    for own in [RUDDER, Actuator { rate_per_s: None, ..RUDDER }, Actuator { lag_s: 0.0, ..RUDDER }] {
        for (setting, wanted) in [(0.0, 0.01), (0.3, -0.6), (-0.55, 0.9), (0.58, 0.6)] {
            let tried = (0..=12_000).map(|k| own.after(setting, -0.6 + 1e-4 * f64::from(k), 0.5));
            let nearest = tried.min_by(|a, b| (a - wanted).abs().total_cmp(&(b - wanted).abs())).unwrap();
            assert!((own.towards(setting, wanted, 0.5) - nearest).abs() < 1e-4, "{own:?} {setting} {wanted}");
        }
    }
}

#[test]
fn actuators_that_make_no_sense_are_refused() {
    let text = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../fixtures/ships/coaster60/vessel.toml"
    ))
    .unwrap();
    for (key, value) in [("lag_s", "-1.0"), ("lag_s", "nan"), ("rate_per_s", "0.0"), ("rate_per_s", "inf")] {
        let own = text.replacen("unit = \"rad\"", &format!("unit = \"rad\"\n{key} = {value}"), 1);
        let refused = Vessel::from_file(toml::from_str(&own).unwrap()).unwrap_err().to_string();
        assert!(refused.contains(&format!("`{key}` of input `delta`")), "{refused}");
    }
}
