//! The response of actuators to commands.

use ship::model::{Actuator, ActuatorState, SampleCommand, VesselFile};

const RUDDER: Actuator =
    Actuator { range: Some([-0.6, 0.6]), lag_s: 2.0, rate_per_s: Some(0.05), dead_band: 0.0, hold_s: 0.0 };

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
    for (key, value) in [
        ("lag_s", "-1.0"),
        ("lag_s", "nan"),
        ("rate_per_s", "0.0"),
        ("rate_per_s", "inf"),
        ("dead_band", "-0.01"),
        ("dead_band", "inf"),
        ("dead_band", "nan"),
        ("hold_s", "0.0"),
        ("hold_s", "-1.0"),
        ("hold_s", "inf"),
        ("hold_s", "nan"),
    ] {
        let own = text.replacen("unit = \"rad\"", &format!("unit = \"rad\"\n{key} = {value}"), 1);
        let refused = own.parse::<VesselFile>().unwrap_err().to_string();
        assert!(refused.contains(&format!("`{key}` of input `delta`")), "{refused}");
    }
}

/// Numbers from 0 to 1 that look random.
fn scattered(k: u32) -> f64 {
    ((f64::from(k) * 12.9898).sin() * 43_758.545_3).rem_euclid(1.0)
}

/// A command that wanders, and sometimes jumps.
fn wandering(samples: u32) -> Vec<f64> {
    let mut command = 0.0;
    let next = |k: u32| {
        let far = if k.is_multiple_of(37) { 0.5 } else { 0.03 };
        command = (command + far * (2.0 * scattered(k) - 1.0)).clamp(-0.6, 0.6);
        command
    };
    (1..=samples).map(next).collect()
}

/// Settings after each of `commands`, from 0.
fn followed(own: &Actuator, commands: &[f64], sample_s: f64) -> Vec<f64> {
    let mut acting = ActuatorState::at(0.0);
    commands.iter().map(|command| acting.follow(own, (*command).into(), sample_s)).collect()
}

/// A steering gear with contacts, in steps of a 1000th of a sample. They close where the rudder is too far off, and open where it
/// arrives. An order that is nearer shortens the way; one that has been passed opens them.
fn by_contacts(own: &Actuator, commands: &[f64], sample_s: f64) -> Vec<f64> {
    let (step_s, rate) = (sample_s / 1000.0, own.rate_per_s.unwrap());
    let (mut rudder, mut goal, mut is_to_starboard) = (0.0_f64, None::<f64>, false);
    let mut of = |command: &f64| {
        let is_passed = (*command > rudder) != is_to_starboard;
        if (command - rudder).abs() > own.dead_band {
            (goal, is_to_starboard) = (Some(*command), *command > rudder);
        } else if is_passed {
            goal = None;
        } else if goal.is_some_and(|to| (to - rudder).abs() > (command - rudder).abs()) {
            goal = Some(*command);
        }
        for _ in 0..1000 {
            let Some(to) = goal else { break };
            if (to - rudder).abs() <= rate * step_s {
                (rudder, goal) = (to, None);
            } else if is_to_starboard {
                rudder += rate * step_s;
            } else {
                rudder -= rate * step_s;
            }
        }
        rudder
    };
    commands.iter().map(&mut of).collect()
}

#[test]
fn oracle_a_dead_band_is_that_of_a_gear_whose_contacts_close_and_open() {
    let commands = wandering(2000);
    for dead_band in [0.01, 0.05, 0.2] {
        let own = Actuator { rate_per_s: Some(0.0937), dead_band, ..Actuator::default() };
        let (found, wanted) = (followed(&own, &commands, 0.5), by_contacts(&own, &commands, 0.5));
        let off = found.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9, "dead band {dead_band}: {off}");
        let still = found.windows(2).filter(|two| two[0] == two[1]).count();
        assert!(still > 100 && still < 1990, "dead band {dead_band}: at rest in {still} samples");
    }
}

#[test]
fn oracle_a_hold_takes_the_command_at_the_first_sample_after_its_end() {
    let commands = wandering(2000);
    for (hold_ms, sample_ms) in [(1000, 100), (250, 100), (100, 100), (30, 100), (700, 500), (3600, 7)] {
        let [hold_s, sample_s] = [hold_ms, sample_ms].map(|ms| f64::from(ms) / 1000.0);
        let own = Actuator { lag_s: 0.8, hold_s, ..Actuator::default() };
        // The times of samples in whole milliseconds.
        let mut due = 0;
        let mut taken = Vec::new();
        for (k, command) in (0..).zip(&commands) {
            let now = k * sample_ms;
            if now >= due {
                taken.push(*command);
                due = (now / hold_ms + 1) * hold_ms;
            } else {
                taken.push(*taken.last().unwrap());
            }
        }
        let lag = Actuator { hold_s: 0.0, ..own };
        assert_eq!(
            followed(&own, &commands, sample_s),
            followed(&lag, &taken, sample_s),
            "{hold_ms} {sample_ms}"
        );
    }
}

#[test]
fn law_without_dead_band_and_hold_every_command_is_followed() {
    let commands = wandering(500);
    let mut setting = 0.0;
    let by_sample = commands.iter().map(|command| {
        setting = RUDDER.after(setting, *command, 0.5);
        setting
    });
    assert_eq!(followed(&RUDDER, &commands, 0.5), by_sample.collect::<Vec<f64>>());
}

#[test]
fn law_an_order_within_a_sample_moves_a_gear_by_its_part_and_a_hold_not_at_all() {
    let ordered = SampleCommand { first: 0.0, mean: 0.1, last: 0.4 };
    for dead_band in [0.0, 0.15] {
        let own = Actuator { dead_band, ..Actuator::default() };
        let mut acting = ActuatorState::at(0.0);
        // A quarter of the sample; the mean alone is within the dead band.
        assert_eq!(acting.follow(&own, ordered, 1.0), 0.1);
        assert_eq!(acting.follow(&own, 0.4.into(), 1.0), 0.4);
    }
    let own = Actuator { hold_s: 3.0, ..Actuator::default() };
    let mut acting = ActuatorState::at(0.0);
    let orders = [ordered, 0.4.into(), 0.4.into(), 0.4.into()];
    assert_eq!(orders.map(|order| acting.follow(&own, order, 1.0)), [0.0, 0.0, 0.0, 0.4]);
}

/// The greatest heading of a ship that does not keep her course by herself, under a proportional and derivative controller, after
/// beginning with one; a mean over beginnings.
fn limit_cycle(own: &Actuator) -> f64 {
    let one = |start: u32| {
        let (sample_s, [mut psi, mut r]) = (0.1, [0.01 * f64::from(start), 0.0]);
        let (mut acting, mut most) = (ActuatorState::at(0.0), 0.0_f64);
        for k in 0..40_000 {
            let rudder = acting.follow(own, (-1.5 * psi - 15.0 * r).into(), sample_s);
            r += sample_s * (r / 40.0 + 0.01 * rudder);
            psi += sample_s * r;
            if k > 10_000 {
                most = most.max(psi.abs());
            }
        }
        most
    };
    (1..=16).map(one).sum::<f64>() / 16.0
}

#[test]
fn law_limit_cycles_grow_with_the_dead_band() {
    let of = |dead_band: f64| limit_cycle(&Actuator { dead_band, lag_s: 1.0, ..Actuator::default() });
    assert!(of(0.0) < 1e-6, "{}", of(0.0));
    let [one, two, four] = [0.005, 0.01, 0.02].map(of);
    // All but the dead band is linear, and beginnings are forgotten.
    for ratio in [two / one, four / two] {
        assert!((ratio - 2.0).abs() < 0.3, "{one} {two} {four}");
    }
    assert!(one > 0.001, "{one}");
}

#[test]
fn law_what_is_wanted_is_reached_at_the_end_of_a_hold() {
    let own = Actuator { lag_s: 2.0, hold_s: 1.0, range: Some([-0.6, 0.6]), ..Actuator::default() };
    let mut acting = ActuatorState::at(0.1);
    let reached: Vec<f64> = (0..2).map(|_| acting.reach(&own, 0.25, 0.5)).collect();
    assert!(reached[0] > 0.15 && reached[0] < 0.2 && (reached[1] - 0.25).abs() < 1e-12, "{reached:?}");
    let band = Actuator { dead_band: 0.02, ..own };
    assert_eq!(ActuatorState::at(0.1).reach(&band, 0.105, 0.5), 0.1, "within the dead band");
}

#[test]
fn law_commands_that_are_no_numbers_do_not_panic() {
    // A ship that diverges is refused by her states, after the run.
    for own in [RUDDER, Actuator { dead_band: 0.01, hold_s: 0.7, ..RUDDER }] {
        let mut acting = ActuatorState::at(0.1);
        for command in [f64::INFINITY, f64::NAN, f64::NAN, 0.1, f64::NEG_INFINITY] {
            acting.follow(&own, command.into(), 0.5);
            acting.reach(&own, command, 0.5);
        }
    }
}
