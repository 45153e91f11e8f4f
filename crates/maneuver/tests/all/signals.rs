//! Signals of combined maneuvers, as the vessel follows them exactly.

use maneuver::{DictionaryFile, Generator};
use ship::engine::simulate_one;
use ship::model::Vessel;

const RATE_HZ: f64 = 8.0;

/// The motion of a combined maneuver with these signals of speed and yaw rate, sample by sample.
fn motion(speed: &str, yaw_rate: &str, samples: usize) -> Vec<[f64; 3]> {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    assert_eq!(vessel.sample_rate_hz, RATE_HZ);
    let text = format!(
        "duration_s = {:?}\n[[maneuver]]\nname = \"own\"\nkind = \"combined\"\nexact = true\n\
         speed_m_s = {{ {speed} }}\nyaw_rate_rad_s = {{ {yaw_rate} }}\nsway_m_s = {{ mean = 0.0 }}\n",
        samples as f64 / RATE_HZ
    );
    let file: DictionaryFile = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
    let generator = Generator::without_tables(&vessel, &file).unwrap();
    let run = generator.realize(0, samples).unwrap();
    let states = simulate_one(&vessel.model, generator.parameters(), run.initial, &run.inputs);
    states.as_chunks::<3>().0[..samples].to_vec()
}

fn yaw_rate(signal: &str, samples: usize) -> Vec<f64> {
    motion("mean = 0.7", signal, samples).into_iter().map(|[_, _, r]| r).collect()
}

#[test]
fn law_every_signal_stays_in_its_range_and_all_but_a_constant_use_it() {
    for shape in ["constant", "square", "sine", "flat-sine", "triangle", "ramp", "pseudo-random", "multisine"]
    {
        let more = match shape {
            "flat-sine" => ", steepness = 5.0",
            "ramp" => ", exponent = 0.4, over_s = 30.0",
            _ => "",
        };
        let values = yaw_rate(
            &format!(
                "shape = \"{shape}\", mean = 0.3, amplitude = 0.2, period_s = 4.0, phase = 0.1, seed = 3{more}"
            ),
            320,
        );
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert!(low >= 0.1 - 1e-3 && high <= 0.5 + 1e-3, "{shape}: {low} {high}");
        let used = if shape == "constant" { 0.0 } else { 0.26 };
        assert!(high - low >= used, "{shape}: {low} {high}");
        assert!(shape != "constant" || high - low < 1e-9, "{low} {high}");
    }
}

/// Fourier's coefficient of the fundamental of sin cut off at height h = 1 / s: (2/π) (s asin h + √(1 − h²)).
#[test]
fn law_a_flat_sine_has_the_fundamental_of_a_sine_that_is_cut_off() {
    for s in [1.0_f64, 1.7, 4.9, 50.0] {
        let samples = 1600;
        let signal = format!("shape = \"flat-sine\", amplitude = 0.2, period_s = 200.0, steepness = {s:?}");
        let values = yaw_rate(&signal, samples);
        let sine = |k: usize| (std::f64::consts::TAU * k as f64 / samples as f64).sin();
        let found: f64 = values.iter().enumerate().map(|(k, r)| r / 0.2 * sine(k)).sum();
        let h = 1.0 / s;
        let expected = std::f64::consts::FRAC_2_PI * (s * h.asin() + (1.0 - h * h).sqrt());
        assert!((2.0 * found / samples as f64 - expected).abs() < 1e-4, "{s}: {found} {expected}");
    }
}

#[test]
fn signals_of_one_seed_move_apart_in_different_channels() {
    let levels = |mean: f64| {
        format!("shape = \"pseudo-random\", mean = {mean:?}, amplitude = 0.1, period_s = 1.0, seed = 3")
    };
    let found = motion(&levels(0.7), &levels(0.0), 240);
    assert_eq!(found, motion(&levels(0.7), &levels(0.0), 240));
    let alike = found.iter().filter(|[u, _, r]| (*u > 0.7) == (*r > 0.0)).count();
    assert!((60..180).contains(&alike), "{alike} of 240");
}
