//! Standard maneuvers: orders that are executed where the ship has turned, and their figures of merit.

use std::f64::consts::PI;

use maneuver::merit::{Figure, Hull, Record, figures as found};
use maneuver::{DictionaryFile, Generator, Standard};
use refusal::Invalid;
use serde_json::Value;
use ship::engine::{Pose, Progress, Seen, Ship, simulate_command};
use ship::model::{Actuator, Source, Vessel, VesselFile};

/// The figures of a simulated maneuver.
fn figures(standard: Standard, record: &Record, hull: &Hull) -> Result<Vec<Figure>, Invalid> {
    found(Some(standard), record, hull).map(|found| found.figures)
}

/// The ship of scripts/independent/standard_maneuvers.py, in steps of 1/`rate` s.
fn ship(rate: f64) -> Vessel {
    let terms = |terms: &[(&str, &str, f64)]| {
        let one = |(name, term, value): &(&str, &str, f64)| {
            let value = value / rate;
            format!("{{ parameter = \"{name}\", term = \"{term}\", value = {value:e}, nominal = {value:e} }}")
        };
        terms.iter().map(one).collect::<Vec<_>>().join(",\n    ")
    };
    let surge = terms(&[
        ("a", "u |u|", -0.015),
        ("b", "n", 0.0216),
        ("c", "v r", 0.4),
        ("d", "delta |delta|", -0.01),
    ]);
    let sway = terms(&[("e", "v", -0.25), ("f", "u r", -0.35), ("g", "u |u| delta", 0.02)]);
    let yaw =
        terms(&[("h", "r", -0.45), ("i", "u |u| delta", 0.06), ("j", "r |r|", -0.8), ("k", "v", -0.05)]);
    let text = format!(
        "name = \"coaster\"\nsample_rate_hz = {rate:.1}\n\
         input = [{{ name = \"n\", unit = \"1\", range = [-1.5, 1.5] }},\n\
         {{ name = \"delta\", unit = \"rad\", range = [-0.62, 0.62] }}]\n\
         surge = [{surge}]\nsway = [{sway}]\nyaw = [{yaw}]\n"
    );
    Vessel::from_file(text.parse::<VesselFile>().unwrap()).unwrap()
}

fn oracle() -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/oracle/standard_maneuvers.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn generator(vessel: &Vessel, keys: &str, duration_s: f64) -> Generator {
    let text = format!("[[maneuver]]\nname = \"m\"\nduration_s = {duration_s:.1}\nspeed_m_s = 1.2\n{keys}\n");
    let file: DictionaryFile = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
    Generator::without_tables(vessel, &file).unwrap()
}

/// Inputs and states of a standard maneuver.
fn run(vessel: &Vessel, generator: &Generator) -> (Vec<f64>, Vec<f64>) {
    let samples = generator.samples(0).unwrap();
    let realized = generator.realize(0, samples).unwrap();
    let parameters = vessel.parameters(Source::Value).unwrap();
    let helm = realized.helm.unwrap();
    let rate_hz = vessel.sample_rate_hz;
    let run = simulate_command(&vessel.model, &parameters, realized.initial, samples, rate_hz, &helm);
    (run.exogenous, run.states)
}

fn measured(vessel: &Vessel, keys: &str, duration_s: f64) -> Vec<Figure> {
    let generator = generator(vessel, keys, duration_s);
    let (inputs, states) = run(vessel, &generator);
    let record = Record::of_states(&states, inputs, vessel.sample_rate_hz);
    let standard = generator.maneuvers()[0].kind.standard().unwrap();
    figures(standard, &record, &Hull { vessel, length_m: 7.0 }).unwrap()
}

fn value(figures: &[Figure], name: &str) -> f64 {
    figures.iter().find(|figure| figure.name == name).unwrap_or_else(|| panic!("{name}")).value
}

fn zig_zag_keys(test: &Value) -> String {
    let number = |key: &str| test[key].as_f64().unwrap();
    let side = if number("first") > 0.0 { "starboard" } else { "port" };
    format!(
        "kind = \"zig-zag-test\"\nhelm = {{ delta = {} }}\nheading_rad = {}\nto = \"{side}\"\ndelay_s = {:.2}",
        number("rudder"),
        number("heading"),
        number("delay_s")
    )
}

#[test]
fn oracle_zig_zags_overshoot_as_in_continuous_time() {
    let oracle = oracle();
    for rate in [200.0, 50.0] {
        let vessel = ship(rate);
        for test in oracle["zig_zags"].as_array().unwrap() {
            let found = measured(&vessel, &zig_zag_keys(test), 120.0);
            for (number, name) in ["overshoot_1", "overshoot_2"].iter().enumerate() {
                let expected = test["overshoots_deg"][number].as_f64().unwrap();
                let off = (value(&found, name) - expected).abs();
                // The heading at which a helm goes over late is measured, too.
                let is_late = test["delay_s"].as_f64().unwrap() > 0.0;
                assert!(
                    off < if is_late {
                        0.06
                    } else if rate > 100.0 {
                        0.01
                    } else {
                        0.04
                    },
                    "{rate} Hz, {test}: {name} off by {off}°"
                );
            }
        }
    }
}

#[test]
fn oracle_circles_and_stops_are_as_in_continuous_time() {
    let (oracle, vessel) = (oracle(), ship(200.0));
    let length = oracle["length_m"].as_f64().unwrap();
    for circle in oracle["circles"].as_array().unwrap() {
        let side = if circle["side"].as_f64().unwrap() > 0.0 { "starboard" } else { "port" };
        let rudder = circle["rudder"].as_f64().unwrap();
        let keys = format!("kind = \"turning-circle\"\nhelm = {{ delta = {rudder} }}\nto = \"{side}\"");
        let found = measured(&vessel, &keys, 250.0);
        for (name, expected) in [
            ("advance", "advance_m"),
            ("transfer", "transfer_m"),
            ("tactical_diameter", "tactical_diameter_m"),
            ("steady_diameter", "steady_diameter_m"),
        ] {
            let off = value(&found, name) - circle[expected].as_f64().unwrap() / length;
            assert!(off.abs() < 0.005, "{side}: {name} off by {off} L");
        }
        let off = value(&found, "steady_yaw_rate") - circle["steady_yaw_rate_deg_s"].as_f64().unwrap();
        assert!(off.abs() < 0.01, "{side}: yaw rate off by {off}°/s");
        let passes = |name: &str| found.iter().find(|own| own.name == name).unwrap().passes();
        assert_eq!(
            [passes("advance"), passes("tactical_diameter"), passes("transfer")],
            [Some(true), Some(true), None]
        );
    }
    for (stop, inputs) in oracle["stops"].as_array().unwrap().iter().zip(["{ n = -1.0, delta = 0.2 }", "{ }"])
    {
        let found = measured(&vessel, &format!("kind = \"stop\"\ninputs = {inputs}"), 1200.0);
        for (name, key, scale) in [
            ("track_reach", "track_reach_m", length),
            ("head_reach", "head_reach_m", length),
            ("lateral_deviation", "lateral_m", length),
            ("stopping_time", "time_s", 1.0),
        ] {
            let expected = stop[key].as_f64().unwrap() / scale;
            let off = (value(&found, name) - expected).abs();
            assert!(
                off < 0.005 && off < 1e-3 * expected.max(1.0) || name == "stopping_time" && off < 0.02,
                "{name} off by {off}"
            );
        }
    }
}

/// A standard normal number from two of an LCG.
pub fn normal(state: &mut u64) -> f64 {
    let mut uniform = || {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((*state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    };
    let (a, b) = (uniform(), uniform());
    (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

#[test]
fn law_noise_does_not_lengthen_overshoots() {
    let (oracle, rate) = (oracle(), 35.0);
    // 0.005 L/U a sample, as logs of a gyro have; headings with half a degree of noise.
    let vessel = ship(rate);
    let test = &oracle["zig_zags"][2];
    let generator = generator(&vessel, &zig_zag_keys(test), 60.0);
    let (inputs, states) = run(&vessel, &generator);
    let record = Record::of_states(&states, inputs, rate);
    let standard = generator.maneuvers()[0].kind.standard().unwrap();
    let hull = Hull { vessel: &vessel, length_m: 7.0 };
    let clean = value(&figures(standard, &record, &hull).unwrap(), "overshoot_1");
    let (mut seed, mut sum, mut largest) = (7, 0.0, 0.0);
    let runs = 200;
    for _ in 0..runs {
        let heading = record.heading.iter().map(|psi| psi + 0.5_f64.to_radians() * normal(&mut seed));
        let noisy = Record { heading: heading.collect(), ..record.clone() };
        sum += value(&figures(standard, &noisy, &hull).unwrap(), "overshoot_1") - clean;
        let most = noisy.heading[..23 * rate as usize].iter().copied().fold(0.0, f64::max);
        largest += most.to_degrees() - 20.0 - clean;
    }
    let (bias, largest) = (sum / f64::from(runs), largest / f64::from(runs));
    assert!(bias.abs() < 0.15, "{bias}°");
    assert!(largest > 0.7, "the largest sample is {largest}° too high");
}

#[test]
fn law_orders_are_executed_within_samples() {
    // The heading at which the helm goes over is the stated one at any rate of samples, and later by a period or a delay.
    for rate in [2.0, 5.0, 20.0] {
        let vessel = ship(rate);
        let keys = "kind = \"zig-zag-test\"\nhelm = { delta = 0.35 }\nheading_rad = 0.35";
        let over = |keys: &str| {
            let generator = generator(&vessel, keys, 60.0);
            let (inputs, states) = run(&vessel, &generator);
            let amidships = inputs[0];
            assert!(amidships > 0.0);
            let changes = inputs.chunks(2).position(|row| row[1] < 0.35 - 1e-9).unwrap();
            // The part of the sample before the order.
            let part = (inputs[2 * changes + 1] + 0.35) / 0.7;
            let heading: f64 = states.chunks(3).take(changes).map(|state| state[2] / rate).sum();
            (heading + part * states[3 * changes + 2] / rate, (changes as f64 + part) / rate)
        };
        let (heading, seconds) = over(keys);
        assert!((heading - 0.35).abs() < 1e-9, "{rate} Hz: {heading}");
        let (_, delayed) = over(&format!("{keys}\ndelay_s = 1.3"));
        assert!((delayed - seconds - 1.3).abs() < 1e-9, "{rate} Hz: {delayed}");
        let (_, periodic) = over(&format!("{keys}\nevery_s = 0.7"));
        assert!(periodic >= seconds && periodic < seconds + 0.7, "{rate} Hz: {periodic}");
        assert!((periodic / 0.7 - (periodic / 0.7).round()).abs() < 1e-9, "{rate} Hz: {periodic}");
    }
}

#[test]
fn law_a_stable_ship_has_no_loop_in_either_spiral() {
    let vessel = ship(10.0);
    let direct = measured(
        &vessel,
        "kind = \"spiral-test\"\nhelm = { delta = 0.4 }\nsteps = 4\ndwell_s = 60.0",
        1020.0,
    );
    assert!(value(&direct, "loop_width") < 0.01, "{direct:?}");
    let reverse = measured(
        &vessel,
        "kind = \"reverse-spiral\"\nhelm = { delta = 0.6 }\nyaw_rate_rad_s = 0.05\nsteps = 3\ndwell_s = 60.0",
        420.0,
    );
    assert!(value(&reverse, "loop_width") < 0.01, "{reverse:?}");
    assert!(value(&reverse, "neutral_helm").abs() < 0.01, "{reverse:?}");
}

#[test]
fn law_pull_outs_of_a_stable_ship_leave_no_turn() {
    let vessel = ship(10.0);
    for side in ["starboard", "port"] {
        let keys = format!("kind = \"pull-out\"\nhelm = {{ delta = 0.35 }}\nto = \"{side}\"\nturn_s = 60.0");
        let found = measured(&vessel, &keys, 160.0);
        assert!(value(&found, "turning_yaw_rate").abs() > 2.0, "{found:?}");
        assert!(value(&found, "residual_yaw_rate").abs() < 0.02, "{found:?}");
    }
}

#[test]
fn law_slow_rudders_lengthen_overshoots_as_in_continuous_time() {
    let oracle = oracle();
    let of = |keys: &str| {
        let vessel = ship(100.0);
        let mut actuators = vessel.actuators.clone();
        let slow = toml::from_str::<std::collections::BTreeMap<String, f64>>(keys).unwrap();
        actuators[1].lag_s = slow.get("lag_s").copied().unwrap_or(0.0);
        actuators[1].rate_per_s = slow.get("rate_per_s").copied();
        Vessel { actuators, ..vessel }
    };
    let slow = oracle["slow_rudders"].as_array().unwrap();
    assert_eq!(slow.len(), 2);
    for test in slow {
        let keys = if test["rate_rad_s"].as_f64().unwrap() > 0.0 {
            format!("rate_per_s = {}", test["rate_rad_s"])
        } else {
            format!("lag_s = {}", test["lag_s"])
        };
        let found = measured(&of(&keys), &zig_zag_keys(test), 120.0);
        for (number, name) in ["overshoot_1", "overshoot_2"].iter().enumerate() {
            let off = value(&found, name) - test["overshoots_deg"][number].as_f64().unwrap();
            assert!(off.abs() < 0.05, "{keys}: {name} off by {off}°");
        }
    }
}

/// The ship with a rudder that is changed.
fn with_rudder(rate_hz: f64, change: impl Fn(&mut Actuator)) -> Vessel {
    let mut vessel = ship(rate_hz);
    change(&mut vessel.actuators[1]);
    vessel
}

const ZIG_ZAG_20: &str = "kind = \"zig-zag-test\"\nhelm = { delta = 0.35 }\nheading_rad = 0.35";

#[test]
fn oracle_a_rudder_that_holds_its_command_is_one_of_a_helmsman_who_looks_as_often() {
    for hold_s in [0.5, 1.0, 2.5] {
        let holds = with_rudder(10.0, |own| own.hold_s = hold_s);
        let by_hold = run(&holds, &generator(&holds, ZIG_ZAG_20, 120.0));
        let looks = ship(10.0);
        let keys = format!("{ZIG_ZAG_20}\nevery_s = {hold_s:.1}");
        let by_look = run(&looks, &generator(&looks, &keys, 120.0));
        let most_off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let off = [most_off(&by_hold.0, &by_look.0), most_off(&by_hold.1, &by_look.1)];
        assert!(off[0] < 1e-9 && off[1] < 1e-9, "{hold_s} s: {off:?}");
        let continuous = run(&looks, &generator(&looks, ZIG_ZAG_20, 120.0));
        assert!(most_off(&by_hold.0, &continuous.0) > 0.3);
    }
}

#[test]
fn law_overshoots_grow_with_the_hold_by_half_of_what_the_ship_turns_in_it() {
    // A mean over headings, since a hold ends at any time after one is reached.
    let overshoot = |hold_s: f64| {
        let vessel = with_rudder(20.0, |own| own.hold_s = hold_s);
        let one = |step: u32| {
            let heading = 0.5 + 0.0125 * f64::from(step);
            let keys = format!("kind = \"zig-zag-test\"\nhelm = {{ delta = 0.35 }}\nheading_rad = {heading}");
            value(&measured(&vessel, &keys, 60.0), "overshoot_1")
        };
        (0..32).map(one).sum::<f64>() / 32.0
    };
    let [none, one, two, four] = [0.0, 1.0, 2.0, 4.0].map(overshoot);
    let more = [one - none, two - none, four - none];
    assert!(more[0] > 0.5, "{none} {more:?}");
    for (added, hold_s) in more.into_iter().zip([1.0, 2.0, 4.0]) {
        assert!((added / hold_s / more[0] - 1.0).abs() < 0.2, "{hold_s} s: {none} {more:?}");
    }
}

#[test]
fn law_a_dead_band_that_no_order_is_within_changes_nothing() {
    let wide = with_rudder(10.0, |own| (own.dead_band, own.rate_per_s) = (0.3, Some(0.1)));
    let plain = with_rudder(10.0, |own| own.rate_per_s = Some(0.1));
    assert_eq!(
        run(&wide, &generator(&wide, ZIG_ZAG_20, 120.0)),
        run(&plain, &generator(&plain, ZIG_ZAG_20, 120.0))
    );
    // Corrections of a motion by feedback are small, and within it.
    let keys = "kind = \"zig-zag\"\nshape = \"sine\"\nyaw_rate_amplitude_rad_s = 0.02\nperiod_s = 40.0\nexecuted = \"feedback\"";
    let moves = |vessel: &Vessel| {
        let (rows, _) = run(vessel, &generator(vessel, keys, 120.0));
        rows.windows(4).skip(1).step_by(2).filter(|two| two[0] != two[2]).count()
    };
    let counts = [0.0, 0.01, 0.04].map(|band| moves(&with_rudder(10.0, |own| own.dead_band = band)));
    assert!(counts[0] > 1000 && counts[1] < 200 && counts[2] < counts[1] && counts[2] > 4, "{counts:?}");
}

/// Rudder before a sample, command in it and rudder after it, in a zig-zag of 120 s at 10 Hz.
fn rudder_and_command(change: impl Fn(&mut Actuator)) -> Vec<[f64; 3]> {
    let vessel = with_rudder(10.0, change);
    let of = generator(&vessel, ZIG_ZAG_20, 120.0);
    let (realized, parameters) = (of.realize(0, 1200).unwrap(), vessel.parameters(Source::Value).unwrap());
    let helm = realized.helm.unwrap();
    let found = simulate_command(&vessel.model, &parameters, realized.initial, 1200, 10.0, &helm);
    let rows = found.commands.as_chunks::<2>().0.iter().zip(found.exogenous.as_chunks::<2>().0);
    // The engine is immediate.
    assert!(rows.clone().all(|(command, row)| command[0] == row[0]));
    let mut before = found.exogenous[1];
    let of =
        |(command, row): (&[f64; 2], &[f64; 2])| [std::mem::replace(&mut before, row[1]), command[1], row[1]];
    rows.map(of).skip(1).collect()
}

#[test]
fn law_what_is_commanded_leads_to_the_settings_by_the_actuator() {
    for [before, command, after] in rudder_and_command(|own| own.lag_s = 2.0) {
        assert!((after - (command + (before - command) * (-0.05_f64).exp())).abs() < 1e-12);
    }
    for [before, command, after] in rudder_and_command(|own| own.rate_per_s = Some(0.05)) {
        let step = (command - before).clamp(-0.005, 0.005);
        assert!((after - before - step).abs() < 1e-12, "{before} {command} {after}");
    }
    let held = rudder_and_command(|own| own.hold_s = 1.5);
    let moves: Vec<usize> = (1..).zip(&held).filter(|(_, own)| own[0] != own[2]).map(|(k, _)| k).collect();
    assert!(moves.len() > 4 && moves.iter().all(|k| k.is_multiple_of(15)), "{moves:?}");
    assert!(held.iter().any(|own| own[1] != own[2]) && held.iter().any(|own| own[1] > 0.34));
}

#[test]
fn a_maneuver_no_longer_than_the_hold_is_refused() {
    let vessel = with_rudder(10.0, |own| own.hold_s = 60.0);
    let text = format!("[[maneuver]]\nname = \"m\"\nduration_s = 60.0\nspeed_m_s = 1.2\n{ZIG_ZAG_20}\n");
    let file: DictionaryFile = text.parse().unwrap();
    let refused = Generator::without_tables(&vessel, &file).unwrap_err().to_string();
    assert!(
        refused.contains("maneuver `m` of 60 s") && refused.contains("`hold_s` = 60 s of input `delta`"),
        "{refused}"
    );
}

#[test]
fn law_the_most_helm_is_at_the_stop() {
    // The rudder's neutral angle is a little to starboard.
    let vessel = ship(10.0);
    let text = "[[maneuver]]\nname = \"m\"\nkind = \"turning-circle\"\nspeed_m_s = 1.2\nduration_s = 200.0\n";
    let rudder = |helm: f64| {
        let file: DictionaryFile = format!("{text}helm = {{ delta = {helm} }}\n").parse().unwrap();
        let realized = Generator::without_tables(&vessel, &file).unwrap().realize(0, 100);
        realized.map(|own| own.inputs[2 * 50 + 1])
    };
    assert_eq!(rudder(0.61).unwrap(), 0.61);
    assert_eq!(rudder(0.63).unwrap(), 0.62);
    assert!(rudder(0.75).unwrap_err().to_string().contains("from -0.62 to 0.62"));
}

#[test]
fn law_the_limit_of_a_stopping_distance_is_one_of_a_stop_full_astern() {
    let vessel = ship(20.0);
    let limit = |vessel: &Vessel, inputs: &str| {
        let found = measured(vessel, &format!("kind = \"stop\"\ninputs = {inputs}"), 1200.0);
        assert!(found.iter().all(|own| own.name == "track_reach" || own.most.is_none()));
        found.iter().find(|own| own.name == "track_reach").unwrap().most
    };
    assert_eq!(limit(&vessel, "{ n = -1.5 }"), Some(15.0));
    // Part of the astern power, the helm alone at the end of its range, and none.
    for inputs in ["{ n = -1.0 }", "{ n = -1.0, delta = 0.62 }", "{ }"] {
        assert_eq!(limit(&vessel, inputs), None, "{inputs}");
    }
    // What full astern is, is known from the range.
    let mut unknown = vessel;
    unknown.actuators[0].range = None;
    assert_eq!(limit(&unknown, "{ n = -1.5 }"), None);
}

/// The record of a standard maneuver, which is held for 5 s first.
fn recorded(vessel: &Vessel, keys: &str, duration_s: f64) -> (Generator, Record) {
    let generator = generator(vessel, keys, duration_s);
    let (inputs, states) = run(vessel, &generator);
    let record = Record::of_states(&states, inputs, vessel.sample_rate_hz);
    (generator, record)
}

#[test]
fn law_figures_depend_on_no_course_place_or_turns_of_the_compass() {
    let vessel = ship(20.0);
    let hull = Hull { vessel: &vessel, length_m: 7.0 };
    for keys in [
        "kind = \"zig-zag-test\"\nhelm = { delta = 0.35 }\nheading_rad = 0.35\nto = \"port\"\nhold_s = 5.0",
        "kind = \"turning-circle\"\nhelm = { delta = 0.6 }\nhold_s = 5.0",
        "kind = \"stop\"\ninputs = { n = -1.0, delta = 0.2 }\nhold_s = 5.0",
    ] {
        let (generator, record) = recorded(&vessel, keys, 150.0);
        let standard = generator.maneuvers()[0].kind.standard().unwrap();
        let (sin, cos) = 2.5_f64.sin_cos();
        let moved = record.place.iter().zip(&record.heading).map(|([x, y], psi)| {
            let compass = (psi + 2.5 + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU);
            [100.0 + x * cos - y * sin, -50.0 + x * sin + y * cos, compass - std::f64::consts::PI]
        });
        let moved = record.clone().with_poses(&moved.collect::<Vec<_>>());
        let [one, other] = [&record, &moved].map(|own| figures(standard, own, &hull).unwrap());
        assert_eq!(one.len(), other.len());
        for (a, b) in one.iter().zip(&other) {
            assert!((a.value - b.value).abs() < 1e-6 * a.value.abs().max(1.0), "{keys}: {a:?} {b:?}");
        }
    }
}

/// The first samples of a record.
fn begun(record: &Record, samples: usize) -> Record {
    Record {
        heading: record.heading[..samples].to_vec(),
        place: record.place[..samples].to_vec(),
        surge: record.surge[..samples].to_vec(),
        sway: record.sway[..samples].to_vec(),
        speed: record.speed[..samples].to_vec(),
        yaw_rate: record.yaw_rate[..samples].to_vec(),
        ..record.clone()
    }
}

#[test]
fn records_that_end_too_early_have_no_figures() {
    let vessel = ship(10.0);
    let hull = Hull { vessel: &vessel, length_m: 7.0 };
    let keys = "kind = \"spiral-test\"\nhelm = { delta = 0.4 }\nsteps = 2\ndwell_s = 20.0";
    let (generator, record) = recorded(&vessel, keys, 180.0);
    let standard = generator.maneuvers()[0].kind.standard().unwrap();
    assert!(figures(standard, &record, &hull).is_ok());
    let cut = begun(&record, 1500);
    let refused = figures(standard, &cut, &hull).unwrap_err().to_string();
    assert!(refused.contains("found 149.9 s, expected 180 s"), "{refused}");
    let late = Record { rate_hz: 0.5, ..cut };
    assert!(figures(standard, &late, &hull).unwrap_err().to_string().contains("at least 0.857 Hz"));
}

#[test]
fn what_is_wanted_of_a_motion_is_its_mean_speed_and_its_turn() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let text = "[[maneuver]]\nname = \"m\"\nkind = \"steady-turn\"\nspeed_m_s = 0.5\nyaw_rate_rad_s = 0.1\nduration_s = 40.0\n";
    let generator = Generator::without_tables(&vessel, &text.parse().unwrap()).unwrap();
    let states = [0.5, 0.0, 0.1].repeat(321);
    let aims = generator.reached(0, &states);
    for (aim, value) in aims.iter().zip([0.5, 4.0_f64.to_degrees()]) {
        assert!(
            (aim.wanted - value).abs() < 1e-9 && (aim.reached - value).abs() < 1e-9 && aim.is_met,
            "{aim}"
        );
    }
    // Half a turn more than is wanted, and twice the speed.
    let states = [[0.5, 0.0, 0.1].to_vec(), [1.0, 0.0, 0.18].repeat(320)].concat();
    let aims = generator.reached(0, &states);
    assert!(aims.iter().all(|aim| !aim.is_met), "{aims:?}");
}

#[test]
fn a_turn_without_its_pull_out_has_no_figures() {
    let vessel = ship(10.0);
    let hull = Hull { vessel: &vessel, length_m: 7.0 };
    let keys = "kind = \"pull-out\"\nhelm = { delta = 0.35 }\nturn_s = 60.0";
    let (generator, record) = recorded(&vessel, keys, 100.0);
    let standard = generator.maneuvers()[0].kind.standard().unwrap();
    assert!(figures(standard, &record, &hull).is_ok());
    let cut = begun(&record, 500);
    let refused = figures(standard, &cut, &hull).unwrap_err().to_string();
    assert!(refused.contains("found 49.9 s, expected more than 60 s"), "{refused}");
}

/// How far the commands of a maneuver have come after every sample, with heading \[rad\] and speed \[m/s\] there.
fn progress(keys: &str, duration_s: f64) -> Vec<(Progress, f64, f64)> {
    let vessel = ship(4.0);
    let generator = generator(&vessel, keys, duration_s);
    let samples = generator.samples(0).unwrap();
    let mut command = generator.program(0, samples).unwrap().unwrap().begin();
    let parameters = vessel.parameters(Source::Value).unwrap();
    let mut ship = Ship::new(&vessel, &parameters, Pose::default(), 1.2);
    let mut inputs = vec![0.0; 2];
    let mut step = |_| {
        let seen = Seen { state: ship.state, own: ship.state, pose: ship.pose };
        command.command(&seen, &mut inputs);
        ship.command(&inputs, command.ends());
        (command.progress(), ship.pose.psi, ship.state[0])
    };
    (0..samples).map(&mut step).collect()
}

#[test]
fn law_commands_are_over_where_the_ship_has_done_what_they_are_for() {
    let until_done =
        |own: &[(Progress, f64, f64)]| own.iter().position(|(at, ..)| *at == Progress::Done).unwrap();
    let circle = progress("kind = \"turning-circle\"\nhelm = { delta = 0.6 }\nhold_s = 5.0", 200.0);
    let end = until_done(&circle);
    assert!(
        circle[end].1 >= 2.9 * PI && circle[end - 1].1 < 3.0 * PI + 1e-9,
        "{} {}",
        circle[end].1,
        circle[end - 1].1
    );
    assert!((circle[end].1 - 3.0 * PI).abs() < 0.02, "{}", circle[end].1);
    assert!(circle[..end].iter().all(|(at, ..)| matches!(at, Progress::Waiting(_))));
    let stop = progress("kind = \"stop\"\ninputs = { n = -1.0 }", 100.0);
    let end = until_done(&stop);
    assert!(
        stop[end].2.abs() < 0.02 && stop[..end].iter().all(|(_, _, speed)| *speed > 0.0),
        "{:?}",
        stop[end]
    );
    // So many steps of four seconds.
    let spiral = progress("kind = \"spiral-test\"\nhelm = { delta = 0.3 }\nsteps = 1\ndwell_s = 4.0", 100.0);
    let orders = until_done(&spiral) + 1;
    assert_eq!(orders % 16, 0, "{orders}");
    assert!(orders > 16);
}

#[test]
fn law_a_zig_zag_may_end_once_the_helm_went_over_to_either_side() {
    let zig_zag = progress("kind = \"zig-zag-test\"\nhelm = { delta = 0.3 }\nheading_rad = 0.3", 100.0);
    let open = zig_zag.iter().position(|(at, ..)| *at == Progress::Open).unwrap();
    assert!(zig_zag[open..].iter().all(|(at, ..)| *at == Progress::Open));
    let before = &zig_zag[..open];
    assert!(before.iter().all(|(at, ..)| *at == Progress::Waiting("change of heading")));
    let headings = || before.iter().map(|(_, psi, _)| *psi);
    assert!(headings().fold(0.0, f64::max) >= 0.3 && headings().fold(0.0, f64::min) > -0.3);
    assert!(zig_zag[open].1 <= -0.28, "{}", zig_zag[open].1);
    let motion = "kind = \"zig-zag\"\nshape = \"sine\"\nyaw_rate_amplitude_rad_s = 0.05\nperiod_s = 20.0";
    assert!(
        progress(&format!("{motion}\nexecuted = \"feedback\""), 40.0)
            .iter()
            .all(|(at, ..)| *at == Progress::Open)
    );
}
