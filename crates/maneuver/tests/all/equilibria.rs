//! Steady motion of ships whose forces have no slope at rest.

use approx::assert_relative_eq;
use maneuver::{DictionaryFile, Generator, Motion, Steady};
use ship::engine::simulate_one;
use ship::model::{Vessel, VesselFile};

const PROPELLER: &str = include_str!("../../../../fixtures/propeller/vessel.toml");
const DICTIONARY: &str = include_str!("../../../../fixtures/propeller/dictionary.toml");
const ESSO_OSAKA: &str = include_str!("../../../../pipelines/esso-osaka/vessel.toml");

fn ship(text: &str) -> Vessel {
    Vessel::from_file(text.parse::<VesselFile>().unwrap()).unwrap()
}

/// Inputs, and the drift of the turn.
fn held(vessel: &Vessel, u: f64, r: f64) -> Result<Vec<f64>, refusal::Invalid> {
    let mut unknowns = vec![0.0; vessel.model.inputs + 1];
    Steady::new(vessel, &vessel.nominal).solve(Motion { u, v: None, r }, &mut unknowns)?;
    Ok(unknowns)
}

/// The state after `samples` under constant `inputs`, from a motion nearby.
fn settled(vessel: &Vessel, inputs: &[f64], near: [f64; 3], samples: usize) -> [f64; 3] {
    let rows = vessel.model.undisturbed(&inputs.repeat(samples));
    let states = simulate_one(&vessel.model, &vessel.nominal, near, &rows);
    *states.last_chunk().unwrap()
}

/// Asserts that a long simulation under the inputs that hold `u` and `r` converges to them.
#[track_caller]
fn comes_to(vessel: &Vessel, u: f64, r: f64) {
    let unknowns = held(vessel, u, r).unwrap();
    let found = settled(vessel, &unknowns[..2], [0.9 * u, 0.5 * unknowns[2], 0.5 * r], 4000);
    for (found, expected) in found.into_iter().zip([u, unknowns[2], r]) {
        assert!(
            (found - expected).abs() <= 1e-6,
            "{u} m/s, {r} rad/s by {unknowns:?}: {found}, not {expected}"
        );
    }
}

#[test]
fn law_equilibria_are_what_long_simulations_of_propeller_ships_come_to() {
    let without_ranges = PROPELLER.replace("\nrange = ", "\n# ");
    for (text, name) in [(PROPELLER, "ranges"), (&without_ranges, "none"), (ESSO_OSAKA, "Esso Osaka")] {
        let vessel = ship(text);
        assert_eq!(name != "none", vessel.actuators[0].range.is_some());
        for u in [0.15, 0.3, 0.5] {
            for r in [-0.02, -0.005, 0.0, 0.01, 0.025] {
                comes_to(&vessel, u, r);
            }
        }
    }
}

#[test]
fn law_a_vessel_whose_wind_is_simulated_steers_against_it() {
    let calm = held(&ship(PROPELLER), 0.4, 0.0).unwrap();
    assert_relative_eq!(calm[1], 0.0, epsilon = 1e-12);
    let windy = ship(&PROPELLER.replace("simulated = 0.0", "simulated = 4.0"));
    let unknowns = held(&windy, 0.4, 0.0).unwrap();
    assert!(unknowns[1].abs() > 1e-3 && unknowns[2] > 1e-3, "{unknowns:?}");
    comes_to(&windy, 0.4, 0.0);
}

#[test]
fn a_ship_at_rest_or_astern_is_held_too() {
    let vessel = ship(PROPELLER);
    assert_eq!(held(&vessel, 0.0, 0.0).unwrap()[..2], [0.0, 0.0]);
    let astern = held(&vessel, -0.1, 0.0).unwrap();
    assert!((-10.0..0.0).contains(&astern[0]), "{astern:?}");
    // X_u u + X_uu u |u| + (X_nn + X_astern) n |n| = 0.
    let (n, thrust) = (astern[0], 0.002 * 0.1 + 0.03 * 0.01);
    assert_relative_eq!(n * n.abs(), -thrust / 3e-5, max_relative = 1e-9);
}

#[test]
fn motion_that_nothing_holds_and_settings_beyond_the_range_are_refused() {
    let weak: String = PROPELLER.replace("term = \"stream\"", "term = \"u |u| stream\"");
    let refusal = held(&ship(&weak), 0.0, 0.01).unwrap_err().to_string();
    assert!(refusal.contains("r = 0.01 rad/s, which no inputs were found to hold steady"), "{refusal}");
    let generator = |text: &str| {
        let file: DictionaryFile = text.parse().unwrap();
        Generator::new(&ship(PROPELLER), &file, |_| Ok("n,delta\n3,0.1\n16,0.1\n".to_owned()))
    };
    let fast = DICTIONARY.replace("to_m_s = 0.5", "to_m_s = 0.8");
    let refusal = generator(&fast).unwrap().realize(0, 120).unwrap_err().to_string();
    assert!(refusal.contains("maneuver `accelerate`, wanted motion: u = 0.8 m/s"), "{refusal}");
    assert!(refusal.contains("a setting from -10 to 15"), "{refusal}");
    let table = "[[maneuver]]\nname = \"a\"\nkind = \"inputs\"\nfile = \"a.csv\"\n";
    let refusal = generator(table).unwrap_err().to_string();
    assert!(refusal.contains("a.csv: row 2") && refusal.contains("n = 16"), "{refusal}");
}

#[test]
fn law_every_maneuver_of_a_propeller_ship_asks_for_settings_within_the_range() {
    let generate = "\n[generate]\ncandidates = 60\nspeed_m_s = [0.2, 0.5]\nperiod_s = [20.0, 60.0]\n\
        limits = { u_m_s = 0.6, v_m_s = 0.2, r_rad_s = 0.03 }\n";
    let file: DictionaryFile = format!("{DICTIONARY}{generate}").parse().unwrap();
    let vessel = ship(PROPELLER);
    let generator = Generator::without_tables(&vessel, &file).unwrap();
    let (mut swung, mut held) = (0, 0);
    for index in 0..generator.maneuvers().len() {
        let Ok(run) = generator.realize(index, 60) else {
            assert!(index >= file.maneuvers.len(), "{}", generator.maneuvers()[index].name);
            continue;
        };
        assert!(run.inputs.chunks(2).all(|row| vessel.beyond_range(row).is_none()));
        held += 1;
        swung += usize::from(run.inputs.chunks(2).any(|row| row[1].abs() > 0.05));
    }
    // Candidates with a commanded sway would leave hardly any: 27 of 65.
    assert!(held > 50 && swung > 40, "{held} {swung}");
}
