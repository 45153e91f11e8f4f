//! Slopes of figures of merit: against a formula, and against smaller and larger steps. Draws of which some diverge.

use std::collections::BTreeMap;

use estimation::pooled::{Covariance, Uncertain};
use maneuver::{DictionaryFile, Generator};
use refusal::Invalid;
use serde_json::{Value, json};
use ship::model::{Vessel, VesselFile};
use validation::merit::{ManeuverMerit, Merit};

fn term(name: &str, text: &str, value: f64) -> Value {
    json!({"parameter": name, "term": text, "value": value, "nominal": value})
}

fn vessel(file: Value) -> Vessel {
    Vessel::from_file(serde_json::from_value::<VesselFile>(file).unwrap()).unwrap()
}

/// A ship whose speed decays by a part in every sample.
fn linear(decay: f64) -> Vessel {
    vessel(json!({
        "name": "linear", "sample_rate_hz": 8.0,
        "input": [{"name": "ahead", "unit": "N"}, {"name": "across", "unit": "N"}, {"name": "turn", "unit": "N m"}],
        "surge": [term("X_u", "u", decay), term("X_x", "ahead", 1e-3)],
        "sway": [term("Y_v", "v", -0.1), term("Y_y", "across", 1e-3)],
        "yaw": [term("N_r", "r", -0.2), term("N_n", "turn", 1e-3)],
    }))
}

/// The ship of crates/maneuver/tests/all/standard.rs.
fn coaster() -> Vessel {
    let rate = 20.0;
    vessel(json!({
        "name": "coaster", "sample_rate_hz": rate,
        "input": [{"name": "n", "unit": "1", "range": [-1.5, 1.5]}, {"name": "delta", "unit": "rad", "range": [-0.62, 0.62]}],
        "surge": [term("a", "u |u|", -0.015 / rate), term("b", "n", 0.0216 / rate), term("c", "v r", 0.4 / rate),
                  term("d", "delta |delta|", -0.01 / rate)],
        "sway": [term("e", "v", -0.25 / rate), term("f", "u r", -0.35 / rate), term("g", "u |u| delta", 0.02 / rate)],
        "yaw": [term("h", "r", -0.45 / rate), term("i", "u |u| delta", 0.06 / rate), term("j", "r |r|", -0.8 / rate),
                term("k", "v", -0.05 / rate)],
    }))
}

fn generator(vessel: &Vessel, maneuvers: Value) -> Generator {
    let file: DictionaryFile = serde_json::from_value(json!({ "maneuver": maneuvers })).unwrap();
    Generator::without_tables(vessel, &file).unwrap()
}

fn differentiated(vessel: &Vessel, maneuvers: Value, length_m: f64, step: f64) -> Vec<ManeuverMerit> {
    let generator = generator(vessel, maneuvers);
    let mut merit = Merit::new(vessel, Some(&generator), length_m).unwrap();
    let parameters = vessel.parameters(vessel.best_known()).unwrap();
    merit.simulate(&parameters, 0).unwrap();
    merit.differentiate(&parameters, step).unwrap();
    merit.summary(false).unwrap()
}

fn slopes<'a>(found: &'a [ManeuverMerit], figure: &str) -> (f64, &'a BTreeMap<String, f64>) {
    let own = found.iter().flat_map(|own| &own.figures).find(|own| own.name == figure).unwrap();
    (own.value, own.slopes.as_ref().unwrap_or_else(|| panic!("{:?}", own.without_slopes)))
}

/// With u(k) = (1 + X)^k an inertial stop takes ln 0.05/ln(1 + X) samples, and reaches (1 − 0.05)/−X times a sample's way.
#[test]
fn law_the_slopes_of_an_inertial_stop_are_those_of_its_formula() {
    let (decay, rate) = (-0.02, 8.0);
    let ship = linear(decay);
    let stop = json!([{"name": "stop", "kind": "stop", "speed_m_s": 1.0, "duration_s": 40.0}]);
    let found = differentiated(&ship, stop, 1.0, 0.02);
    let close = |found: f64, expected: f64, to: f64| {
        assert!((found - expected).abs() < to * expected.abs(), "{found} {expected}");
    };
    let (time, of_time) = slopes(&found, "stopping_time");
    let log = (1.0 + decay).ln();
    close(time, 0.05f64.ln() / log / rate, 2e-3);
    close(of_time["X_u"], -0.05f64.ln() / (rate * (1.0 + decay) * log * log), 3e-3);
    let (reach, of_reach) = slopes(&found, "track_reach");
    close(reach, 0.95 / -decay / rate, 5e-3);
    close(of_reach["X_u"], 0.95 / (decay * decay) / rate, 3e-3);
    for name in ["X_x", "Y_v", "Y_y", "N_r", "N_n"] {
        assert!(of_time[name].abs() < 1e-9 && of_reach[name].abs() < 1e-9, "{name}");
    }
}

/// Under astern thrust of d a sample, u(k) = (1 − d/X) (1 + X)^k + d/X, which is zero between samples.
#[test]
fn law_the_slopes_of_a_crash_stop_are_those_of_its_formula() {
    let time = |decay: f64, gain: f64| {
        let fixed = 100.0 * gain / decay;
        (-fixed / (1.0 - fixed)).ln() / (1.0 + decay).ln() / 8.0
    };
    let stop = json!([{"name": "stop", "kind": "stop", "speed_m_s": 1.0, "duration_s": 10.0, "inputs": {"ahead": -100.0}}]);
    for decay in [-0.02, -0.03, -0.045] {
        let found = differentiated(&linear(decay), stop.clone(), 1.0, 0.02);
        let (value, own) = slopes(&found, "stopping_time");
        assert!((value - time(decay, 1e-3)).abs() < 2e-3 * value, "{value} {}", time(decay, 1e-3));
        let expected = [
            ("X_u", (time(1.001 * decay, 1e-3) - time(0.999 * decay, 1e-3)) / (0.002 * decay)),
            ("X_x", (time(decay, 1.001e-3) - time(decay, 0.999e-3)) / 2e-6),
        ];
        for (name, expected) in expected {
            assert!((own[name] - expected).abs() < 0.02 * expected.abs(), "{name}: {} {expected}", own[name]);
        }
    }
}

/// Orders within samples make figures smooth in the parameters: else the slopes of overshoots would depend on the step.
#[test]
fn law_slopes_do_not_depend_on_the_step() {
    let ship = coaster();
    let maneuvers = json!([
        {"name": "zig-zag", "kind": "zig-zag-test", "speed_m_s": 1.2, "duration_s": 60.0, "helm": {"delta": 0.35},
         "heading_rad": 0.349},
        {"name": "circle", "kind": "turning-circle", "speed_m_s": 1.2, "duration_s": 150.0, "helm": {"delta": 0.61}},
        {"name": "stop", "kind": "stop", "speed_m_s": 1.2, "duration_s": 120.0, "inputs": {"n": -1.0}},
    ]);
    let [half, whole, double] =
        [0.01, 0.02, 0.04].map(|step| differentiated(&ship, maneuvers.clone(), 7.0, step));
    let parameters = ship.parameters(ship.best_known()).unwrap();
    for figure in
        ["overshoot_1", "overshoot_2", "initial_turning", "advance", "tactical_diameter", "track_reach"]
    {
        let (value, own) = slopes(&whole, figure);
        let relative = |(name, at): (&str, f64), of: &BTreeMap<String, f64>| at * of[name] / value;
        let named = || ship.model.parameter_names().zip(parameters.iter().copied());
        let largest = named().map(|one| relative(one, own).abs()).fold(0.0, f64::max);
        assert!(largest > 0.1, "{figure}: {largest}");
        for one in named() {
            let at = relative(one, own);
            for other in [&half, &double] {
                let other = relative(one, slopes(other, figure).1);
                assert!((at - other).abs() < 0.02 * largest, "{figure}, {}: {at} {other}", one.0);
            }
        }
    }
}

#[test]
fn what_a_ship_with_another_parameter_does_not_do_has_no_slope_and_says_so() {
    let ship = coaster();
    let circle = |duration_s: f64| {
        json!([{"name": "circle", "kind": "turning-circle", "speed_m_s": 1.2, "duration_s": duration_s,
                "helm": {"delta": 0.61}}])
    };
    let found = differentiated(&ship, circle(150.0), 7.0, 0.02);
    let half = slopes(&found, "time_180").0;
    let short = differentiated(&ship, circle(half + 0.1), 7.0, 0.02);
    assert!(short[0].figures.iter().all(|figure| figure.slopes.is_none()), "{:?}", short[0].figures);
    let reasons: Vec<_> =
        short[0].figures.iter().filter_map(|figure| figure.without_slopes.as_ref()).collect();
    assert!(reasons.len() > 2, "{reasons:?}");
    for why in reasons {
        assert!(why.contains("with another `") && why.contains("expected 180.0°"), "{why}");
    }
    let generator = generator(&ship, circle(150.0));
    let mut merit = Merit::new(&ship, Some(&generator), 7.0).unwrap();
    let refused = merit.differentiate(&[0.0; 11], 0.02).unwrap_err();
    assert!(refused.thing.contains("`a`") && refused.found == "0", "{refused}");
}

#[test]
fn draws_that_diverge_are_counted_and_refuse_nothing() {
    let vessel = coaster();
    let circle = json!([{
        "name": "circle", "kind": "turning-circle", "speed_m_s": 1.2, "duration_s": 120.0, "helm": {"delta": 0.6},
        "to": "starboard"
    }]);
    let generator = generator(&vessel, circle);
    let mut merit = Merit::new(&vessel, Some(&generator), 5.0).unwrap();
    // Nearly half of the draws have a resistance that drives the ship; if weakly, her turn slows her down.
    let names: Vec<String> = vessel.model.parameter_names().map(str::to_owned).collect();
    let mut entries = vec![0.0; names.len() * names.len()];
    entries[0] = 0.02 * 0.02;
    let covariance = Covariance { joint: true, names, entries, parts: None };
    let parameters = generator.parameters().to_vec();
    let positive = |own: &Uncertain| {
        let streams = ship::engine::Streams::new(1, "merit");
        (0..40).filter(|draw| own.drawn(&streams, *draw)[0] > 0.0).count() as u64
    };
    let uncertain = Uncertain::new(&vessel, parameters, &covariance).unwrap();
    merit.simulate_drawn(&uncertain, 40, 1);
    let found = merit.summary(true).unwrap().remove(0);
    assert_eq!(found.runs + found.without, 40);
    assert!((5..=positive(&uncertain)).contains(&found.diverged), "{}", found.diverged);
    // As many as are refused one by one for it.
    let streams = ship::engine::Streams::new(1, "merit");
    let diverges = |draw: &u32| {
        let mut one = Merit::new(&vessel, Some(&generator), 5.0).unwrap();
        one.simulate(&uncertain.drawn(&streams, *draw), 0)
            .is_err_and(|why| Invalid::from(why).to_string().contains("diverges"))
    };
    assert_eq!(found.diverged, (0..40).filter(diverges).count() as u64);
    assert!(found.lacking().unwrap().ends_with(&format!(", {} diverge", found.diverged)));
    assert!(found.figures.iter().all(|own| own.value.is_finite()));
}
