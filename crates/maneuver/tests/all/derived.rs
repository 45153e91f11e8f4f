//! Channels that are computed from others.

use maneuver::InputTable;
use refusal::Invalid;
use ship::engine::simulate_one;
use ship::model::{Formula, Vessel, VesselFile, Written};

const SHIP: &str = r#"
name = "coaster"
sample_rate_hz = 1.0
input = [{ name = "n", unit = "1/s" }, { name = "delta", unit = "rad" }]
measured = [{ name = "wind", unit = "m/s", simulated = 2.0 }, { name = "from", unit = "rad", simulated = 0.5 }]
derived = [
    { name = "stream", unit = "rad/s^2", formula = "n_ahead^2 delta" },
    { name = "n_ahead", unit = "1/s", formula = "positive(n)" },
    { name = "wind_y", unit = "m^2/s^2", formula = "-1 wind^2 sin(from)" },
]
surge = [{ parameter = "a", term = "u |u|", nominal = -0.01 }, { parameter = "b", term = "n |n|", nominal = 0.001 }]
sway = [{ parameter = "c", term = "v", nominal = -0.1 }, { parameter = "d", term = "wind_y", nominal = 0.001 }]
yaw = [
    { parameter = "e", term = "r", nominal = -0.1 },
    { parameter = "f", term = "stream", nominal = 0.0002 },
    { parameter = "g", term = "n_ahead delta u", nominal = 0.0001 },
]
"#;

fn read(text: &str) -> Result<Vessel, Invalid> {
    Vessel::from_file(text.parse::<VesselFile>().unwrap())
}

fn ship() -> Vessel {
    read(SHIP).unwrap()
}

#[test]
fn rows_are_completed_in_the_order_of_the_file_for_any_sources() {
    let model = ship().model;
    let rows = model.undisturbed(&[3.0, 0.1, -3.0, 0.2]);
    let wind_y = -4.0 * 0.5_f64.sin();
    let expected = [3.0, 0.1, 2.0, 0.5, 9.0 * 0.1, 3.0, wind_y, -3.0, 0.2, 2.0, 0.5, 0.0, 0.0, wind_y];
    for (found, expected) in rows.iter().zip(expected) {
        approx::assert_relative_eq!(*found, expected, max_relative = 1e-14);
    }
    assert_eq!(rows.len(), 14);
}

#[test]
fn law_a_derived_channel_moves_the_vessel_as_a_logged_one_does() {
    let derived = ship();
    let logged = SHIP.replace("derived = [", "ignored = [").replace("measured = [", "measured = [MORE");
    let logged = &logged[..logged.find("ignored").unwrap()];
    let more = r#"{ name = "stream", unit = "1" }, { name = "n_ahead", unit = "1" }, { name = "wind_y", unit = "1" }, "#;
    let terms = &SHIP[SHIP.find("surge = ").unwrap()..];
    let logged = read(&format!("{}{terms}", logged.replace("MORE", more))).unwrap();
    let inputs: Vec<f64> = (0..60).flat_map(|k| [f64::from(20 - k), 0.3 * f64::from(k % 7 - 3)]).collect();
    let wind_y = -4.0 * 0.5_f64.sin();
    let row = |own: &[f64]| {
        let ahead = own[0].max(0.0);
        [own[0], own[1], ahead * ahead * own[1], ahead, wind_y, 2.0, 0.5]
    };
    let rows: Vec<f64> = inputs.chunks(2).flat_map(row).collect();
    let expected = simulate_one(&logged.model, &logged.nominal, [1.0, 0.0, 0.0], &rows);
    let found =
        simulate_one(&derived.model, &derived.nominal, [1.0, 0.0, 0.0], &derived.model.undisturbed(&inputs));
    for (found, expected) in found.iter().zip(expected) {
        approx::assert_relative_eq!(*found, expected, epsilon = 1e-14, max_relative = 1e-12);
    }
}

#[test]
fn law_slopes_of_formulas_and_by_way_of_channels_are_those_of_quotients() {
    let at = [1.3, -0.7];
    for text in ["a^3 |b|", "-2 positive(a) sin(b)^2", "negative(b) cos(a) a", "|a|^2 negative(a) b"] {
        let formula = Formula::parse(text).unwrap();
        for by in 0..formula.channels.len() {
            let value = |h: f64| formula.of(|channel| at[channel] + if channel == by { h } else { 0.0 });
            let quotient = (value(1e-5) - value(-1e-5)) / 2e-5;
            approx::assert_relative_eq!(
                formula.slope(by, |channel| at[channel]),
                quotient,
                epsilon = 1e-9,
                max_relative = 1e-8
            );
        }
    }
    let model = ship().model;
    let last = |n: f64| model.undisturbed(&[n, 0.1])[4];
    let (row, quotient) = (model.undisturbed(&[3.0, 0.1]), (last(3.0 + 1e-5) - last(3.0 - 1e-5)) / 2e-5);
    let mut slopes = vec![[0.0]; model.variables.len()];
    slopes[3 + 4] = [1.0];
    model.by_sources(&row, &mut slopes);
    approx::assert_relative_eq!(slopes[3][0], quotient, max_relative = 1e-8);
    approx::assert_relative_eq!(slopes[4][0], 9.0, max_relative = 1e-12);
}

#[test]
fn what_cannot_be_derived_is_refused_by_name() {
    let refused = |formula: &str| read(&SHIP.replace("positive(n)", formula)).unwrap_err().to_string();
    let circle = refused("positive(stream)");
    assert!(circle.contains("stream from n_ahead from stream"), "{circle}");
    assert!(refused("n_ahead n").contains("n_ahead from n_ahead"));
    assert!(refused("u n").contains("`u`, a state"));
    assert!(refused("positive(m)").contains("declared nowhere"));
    assert!(refused("positive(n").contains("unclosed"));
    let twice = read(&SHIP.replace("name = \"n_ahead\"", "name = \"n\"")).unwrap_err().to_string();
    assert!(twice.contains("derived channel `n`"), "{twice}");
}

#[test]
fn a_measured_disturbance_that_no_one_gives_a_value_is_not_simulated() {
    assert!(ship().model.check_simulated().is_ok());
    let unknown = read(&SHIP.replace(", simulated = 0.5", "")).unwrap();
    let refusal = unknown.model.check_simulated().unwrap_err().to_string();
    assert!(refusal.contains("`from`") && refusal.contains("simulated = 0.0"), "{refusal}");
}

#[test]
fn tables_of_inputs_may_repeat_derived_channels_and_not_contradict_them() {
    let model = ship().model;
    let table = InputTable::parse("n,delta,n_ahead\n3,0.1,3\n-3,0.1,0\n", &model).unwrap();
    assert_eq!(table.inputs, [3.0, 0.1, -3.0, 0.1]);
    let refusal = InputTable::parse("n,delta,n_ahead\n3,0.1,3\n-3,0.1,-3\n", &model).unwrap_err().to_string();
    assert!(refusal.contains("line 3, column `n_ahead`"), "{refusal}");
    assert!(InputTable::parse("n,delta,wind\n3,0.1,0\n", &model).is_err());
}

#[test]
fn law_what_trials_hold_constant_is_known_and_acts_as_before() {
    let (whole, held) = (ship(), ship().with_disturbances_held());
    assert_eq!(whole.model.parameter_names().collect::<Vec<_>>(), ["a", "b", "c", "d", "e", "f", "g"]);
    assert_eq!(held.model.parameter_names().collect::<Vec<_>>(), ["a", "b", "c", "e", "f", "g"]);
    assert_eq!(held.nominal, [-0.01, 0.001, -0.1, -0.1, 0.0002, 0.0001]);
    let sway = held.written(ship::model::DegreeOfFreedom::Sway);
    assert!(matches!(sway[..], [Written::Estimated(2), Written::Constrained(own)] if own.name == "d"));
    let rows = whole.model.undisturbed(&[5.0, 0.1].repeat(50));
    let states = |ship: &Vessel| simulate_one(&ship.model, &ship.nominal, [0.3, 0.0, 0.0], &rows);
    for (found, expected) in states(&held).iter().zip(states(&whole)) {
        approx::assert_relative_eq!(*found, expected, epsilon = 1e-16, max_relative = 1e-13);
    }
    assert!(states(&held)[3 * 50 + 1] < -1e-3, "the wind drives the ship");
    // A vessel without disturbances is unchanged.
    let plain = Vessel::preset("ljungberg-model-ship").unwrap();
    assert_eq!(plain.clone().with_disturbances_held(), plain);
}
