//! The inputs of maneuvers make the vessel move as requested.

use approx::assert_relative_eq;
use maneuver::{DictionaryFile, Generator};
use refusal::Invalid;
use ship::engine::simulate_one;
use ship::model::{Source, Vessel};

const PAPER_DICTIONARY: &str = include_str!("../../../../pipelines/paper/dictionary.toml");
/// The same maneuvers, held steady.
const HELD: &str = include_str!("../../../../pipelines/scenarios/dictionary.toml");

fn vessel() -> Vessel {
    Vessel::from_file("preset = \"ljungberg-model-ship\"".parse().unwrap()).unwrap()
}

fn generator(dictionary: &str) -> Result<Generator, Invalid> {
    let file: DictionaryFile = dictionary.parse().unwrap();
    Generator::new(&vessel(), &file, |path| Ok(std::fs::read_to_string(path).unwrap()))
}

/// States (N+1) × 3 of maneuver `index`, undisturbed, by the true model.
fn states(generator: &Generator, index: usize, samples: usize) -> Vec<[f64; 3]> {
    let vessel = vessel();
    let run = generator.realize(index, samples).unwrap();
    let truth = vessel.parameters(Source::Value).unwrap();
    let states = simulate_one(&vessel.model, &truth, run.initial, &run.inputs);
    states.chunks(3).map(|s| [s[0], s[1], s[2]]).collect()
}

fn column(states: &[[f64; 3]], i: usize) -> impl Iterator<Item = f64> + Clone {
    states.iter().map(move |s| s[i])
}

fn spread(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max))
}

/// Zig-zags as the paper prints them: place, u, and how far v and r swing to either side.
const ZIG_ZAGS: [(usize, f64, f64, f64); 6] = [
    (2, 0.35, 0.1, 0.2),
    (3, 0.8, 0.1, 0.2),
    (4, 1.15, 0.1, 0.2),
    (5, 0.35, 0.15, 0.35),
    (6, 0.7, 0.15, 0.35),
    (7, 1.0, 0.15, 0.35),
];

/// Spirals as the paper prints them: place, u, v; r goes from 0 to -0.6.
const SPIRALS: [(usize, f64, f64); 3] = [(8, 0.4, 0.05), (9, 0.75, 0.125), (10, 1.0, 0.2)];

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (n, sum) = values.fold((0.0, 0.0), |(n, sum), x| (n + 1.0, sum + x));
    sum / n
}

/// What the true model does keeps every printed range and reaches its ends; v is opposite to r; v of a spiral is as printed on
/// average.
#[test]
fn law_the_papers_maneuvers_keep_the_ranges_that_it_prints() {
    let generator = generator(PAPER_DICTIONARY).unwrap();
    assert_eq!((generator.maneuvers().len(), generator.samples(0).unwrap()), (11, 320));
    let close = |found: f64, printed: f64| (found - printed).abs() < 1e-9;
    for (index, u, v, r) in ZIG_ZAGS {
        let states = states(&generator, index, 320);
        assert!(column(&states, 0).all(|own| close(own, u)), "{index}");
        for (i, printed) in [(1, v), (2, r)] {
            let (low, high) = spread(column(&states, i));
            assert!(close(low, -printed) && close(high, printed), "{index}: state {i} {low} {high}");
        }
        let (opposite, sizes) =
            (mean(states.iter().map(|s| s[1] * s[2])), mean(states.iter().map(|s| (s[1] * s[2]).abs())));
        assert!(opposite < -0.98 * sizes, "{index}: {opposite} {sizes}");
    }
    for (index, u, v) in SPIRALS {
        let states = states(&generator, index, 320);
        assert!(column(&states, 0).all(|own| close(own, u)), "{index}");
        assert!(close(mean(column(&states, 1)), v), "{index}: {}", mean(column(&states, 1)));
        assert!(close(states[0][2], 0.0) && close(states[320][2], -0.6), "{index}");
        assert!(states.windows(2).all(|s| s[1][2] < s[0][2]), "{index}: does not wind in all the way");
    }
    for (index, from, to) in [(0, 1.0, 0.0), (1, 0.0, 1.0)] {
        let states = states(&generator, index, 320);
        assert!(states[..=20].iter().all(|s| close(s[0], from)), "{index}: not held for 2.5 s");
        let way = to - from;
        assert!(states[20..].windows(2).all(|s| (s[1][0] - s[0][0]) * way > 0.0), "{index}: turns back");
        assert!((states[320][0] - to).abs() < 0.01, "{index}: ends at {}", states[320][0]);
        assert!(states.iter().all(|s| s[1] == 0.0 && s[2] == 0.0), "{index}: sway or yaw");
    }
}

/// An exact motion is the wanted one at every sample, for any parameters; the signals are not the paper's.
#[test]
fn law_an_exact_motion_is_followed_from_the_first_sample_to_the_last() {
    let text = "duration_s = 20.0\ninputs_from = \"nominal\"\n[[maneuver]]\nname = \"m\"\nkind = \"combined\"\nexact = true\n\
                speed_m_s = { shape = \"ramp\", mean = 0.6, amplitude = 0.2, exponent = 2.0 }\n\
                yaw_rate_rad_s = { shape = \"triangle\", amplitude = 0.3, period_s = 7.0 }\n\
                sway_m_s = { shape = \"sine\", mean = 0.02, amplitude = 0.1, period_s = 5.0, phase = 0.1 }\n";
    let vessel = vessel();
    let run = generator(text).unwrap().realize(0, 160).unwrap();
    let states = simulate_one(&vessel.model, &vessel.nominal, run.initial, &run.inputs);
    assert_eq!(states.len(), 161 * 3);
    for (k, state) in states.chunks(3).enumerate() {
        let t = k as f64 / 8.0;
        let r = -0.3 * 2.0 / std::f64::consts::PI * (std::f64::consts::TAU * t / 7.0).sin().asin();
        let v = 0.02 + 0.1 * (std::f64::consts::TAU * (t / 5.0 + 0.1)).sin();
        for (found, wanted) in state.iter().zip([0.4 + 0.4 * (t / 20.0).powi(2), v, r]) {
            assert!((found - wanted).abs() < 1e-9, "sample {k}: {found} {wanted}");
        }
    }
}

/// The ranges that the paper prints: for u the printed value (± 0.05 m/s for "≈") or the printed way, for v and r the
/// printed interval. Zig-zags must also use their interval: at least two thirds of it.
#[test]
fn law_held_maneuvers_stay_in_the_ranges_that_the_paper_prints() {
    let generator = generator(HELD).unwrap();
    for (index, u, v, r) in ZIG_ZAGS {
        let states = states(&generator, index, 300);
        let (u_low, u_high) = spread(column(&states, 0));
        assert!(u_low > u - 0.05 && u_high < u + 0.05, "{index}: u {u_low} {u_high}");
        for (i, bound) in [(1, v), (2, r)] {
            let (low, high) = spread(column(&states, i));
            assert!(low >= -bound && high <= bound, "{index}: state {i} {low} {high}");
            assert!(
                low < -bound * 0.66 && high > bound * 0.66,
                "{index}: state {i} {low} {high} uses little of its range"
            );
        }
    }
    for (index, u, v) in SPIRALS {
        let states = states(&generator, index, 300);
        let (u_low, u_high) = spread(column(&states, 0));
        assert!(u_low > u - 0.05 && u_high < u + 0.05, "{index}: u {u_low} {u_high}");
        let (v_low, v_high) = spread(column(&states[60..], 1));
        assert!(v_low > v - 0.02 && v_high < v + 0.02, "{index}: v {v_low} {v_high}");
        assert!(states[0][2] == 0.0 && (states[300][2] + 0.6).abs() < 0.02, "{index}: r {}", states[300][2]);
    }
    for (index, from, to) in [(0, 1.0, 0.0), (1, 0.0, 1.0)] {
        let states = states(&generator, index, 300);
        assert!((states[0][0] - from).abs() < 1e-12 && (states[300][0] - to).abs() < 0.01, "{index}");
        assert!(states.iter().all(|s| s[1] == 0.0 && s[2] == 0.0), "{index}: sway or yaw");
    }
}

#[test]
fn law_inputs_of_a_steady_turn_hold_it() {
    let dictionary = "duration_s = 100.0\n[[maneuver]]\nname = \"turn\"\nkind = \"steady-turn\"\nspeed_m_s = 0.7\nyaw_rate_rad_s = 0.3\n";
    let last = *states(&generator(dictionary).unwrap(), 0, 800).last().unwrap();
    assert_relative_eq!(last[0], 0.7, max_relative = 1e-9);
    assert_relative_eq!(last[2], 0.3, max_relative = 1e-9);
    assert!(last[1] < 0.0, "a turn to starboard drifts to port: {}", last[1]);
}

#[test]
fn law_a_heading_amplitude_is_the_integral_of_the_yaw_rate() {
    for shape in ["sine", "square", "triangle"] {
        let text = format!(
            "duration_s = 400.0\n[[maneuver]]\nname = \"z\"\nkind = \"zig-zag\"\nshape = \"{shape}\"\nspeed_m_s = 0.5\nheading_amplitude_rad = 0.35\nperiod_s = 200.0\n"
        );
        let states = states(&generator(&text).unwrap(), 0, 3200);
        let mut heading = 0.0;
        let track: Vec<f64> = column(&states[1600..], 2)
            .map(|r| {
                heading += r / 8.0;
                heading
            })
            .collect();
        let (low, high) = spread(track.iter().copied());
        assert_relative_eq!((high - low) / 2.0, 0.35, max_relative = 0.02);
    }
}

#[test]
fn a_sway_zig_zag_keeps_the_heading_and_a_pseudo_random_one_switches() {
    let text = "duration_s = 30.0\n[[maneuver]]\nname = \"s\"\nkind = \"sway-zig-zag\"\nsway_amplitude_m_s = 0.2\nperiod_s = 20.0\n\
         [[maneuver]]\nname = \"p\"\nkind = \"pseudo-random-binary\"\nspeed_m_s = 0.6\nyaw_rate_amplitude_rad_s = 0.3\ndwell_s = 2.0\n";
    let generator = generator(text).unwrap();
    let sway = states(&generator, 0, 240);
    assert!(column(&sway, 2).all(|r| r.abs() < 1e-12));
    assert!(spread(column(&sway, 1)).1 > 0.15);
    let binary = generator.realize(1, 240).unwrap();
    let levels: std::collections::BTreeSet<u64> = binary.inputs.chunks(3).map(|i| i[2].to_bits()).collect();
    assert_eq!(levels.len(), 2);
}

#[test]
fn dictionaries_that_cannot_be_meant_are_refused() {
    let zig_zag = "[[maneuver]]\nname = \"a\"\nkind = \"zig-zag\"\nspeed_m_s = 1.0\nperiod_s = 10.0\nyaw_rate_amplitude_rad_s = 0.2\n";
    let refused = |text: &str| generator(text).unwrap_err().to_string();
    assert!(refused(&format!("duration_s = 0.0\n{zig_zag}")).contains("`duration_s`"));
    assert!(refused(&format!("duration_s = 9.0\n{zig_zag}{zig_zag}")).contains("used twice"));
    assert!(
        refused(&format!("duration_s = 9.0\n{zig_zag}heading_amplitude_rad = 0.1\n")).contains("one of them")
    );
    assert!(refused("duration_s = 9.0\n[[maneuver]]\nname = \"a\"\nkind = \"accelerate\"\nfrom_m_s = 1.0\nto_m_s = 0.5\n").contains("more than from_m_s"));
    let misspelt = format!("duration_s = 9.0\n{}", zig_zag.replace("period_s", "preiod_s"));
    let error = misspelt.parse::<DictionaryFile>().unwrap_err().to_string();
    assert!(error.contains("unknown field `preiod_s`") && error.contains("`period_s`"), "{error}");
    let short = generator("duration_s = 0.01\n[[maneuver]]\nname = \"a\"\nkind = \"steady-turn\"\nspeed_m_s = 1.0\nyaw_rate_rad_s = 0.1\n").unwrap();
    assert!(short.samples(0).unwrap_err().to_string().contains("zero samples"));
}

/// Refusals of the keys of combined maneuvers and changes of speed: key, found, expected.
#[test]
fn shapes_holds_and_exact_motions_that_cannot_be_meant_are_refused() {
    let refused = |text: &str| generator(&format!("duration_s = 9.0\n{text}")).unwrap_err().to_string();
    let combined = |own: &str| {
        refused(&format!(
            "[[maneuver]]\nname = \"a\"\nkind = \"combined\"\nspeed_m_s = {{ mean = 0.5 }}\n{own}"
        ))
    };
    let contains = |text: String, texts: &[&str]| {
        assert!(texts.iter().all(|own| text.contains(own)), "{text}");
    };
    let signal = |own: &str| format!("yaw_rate_rad_s = {{ amplitude = 0.2, period_s = 5.0, {own} }}\n");
    contains(
        combined(&signal("shape = \"flat-sine\"")),
        &["`yaw_rate_rad_s.steepness`", "found none", "1 or more"],
    );
    contains(
        combined(&signal("shape = \"flat-sine\", steepness = 0.5")),
        &["steepness`", "found 0.5", "from 1"],
    );
    // Numbers that are none are refused where the file is read.
    let nan = format!(
        "[[maneuver]]\nname = \"a\"\nkind = \"combined\"\nspeed_m_s = {{ mean = 0.5 }}\n{}",
        signal("steepness = nan")
    );
    let nan = nan.parse::<DictionaryFile>().unwrap_err().to_string();
    contains(nan, &["steepness`", "found NaN", "a finite number"]);
    contains(combined(&signal("shape = \"sine\", steepness = 2.0")), &["steepness`", "found 2", "flat-sine"]);
    contains(combined(&signal("shape = \"ramp\", exponent = 0.0")), &["exponent`", "found 0", "above 0"]);
    contains(combined(&signal("shape = \"sine\", exponent = 0.5")), &["exponent`", "found 0.5", "\"ramp\""]);
    contains(combined(&signal("shape = \"ramp\", over_s = 0.0")), &["over_s`", "found 0", "more than 0 s"]);
    contains(combined(&signal("over_s = 2.0")), &["over_s`", "found 2", "\"ramp\""]);
    contains(combined("exact = true\n"), &["`sway_m_s`", "found none", "remove `exact`"]);
    let start = "exact = true\nstart_m_s = 0.4\nsway_m_s = { mean = 0.0 }\n";
    contains(combined(start), &["`start_m_s`", "found 0.4", "remove it"]);
    contains(
        combined("keeps = { u_m_s = [0.6, 0.4] }\n"),
        &["`keeps.u_m_s`", "[0.6, 0.4]", "the lower one first"],
    );
    let step =
        "[[maneuver]]\nname = \"a\"\nkind = \"decelerate\"\nfrom_m_s = 1.0\nto_m_s = 0.5\nhold_s = -1.0\n";
    contains(refused(step), &["`hold_s`", "found -1", "from 0"]);
}

#[test]
fn law_an_unstretched_maneuver_begins_like_a_shorter_one() {
    let shapes =
        ["constant", "square", "sine", "flat-sine", "triangle", "ramp", "pseudo-random", "multisine"];
    let combined = |shape: &&str| {
        let steepness = if *shape == "flat-sine" { "steepness = 3.0, " } else { "" };
        format!(
            "[[maneuver]]\nname = \"{shape}\"\nkind = \"combined\"\nspeed_m_s = {{ mean = 0.7 }}\n\
             yaw_rate_rad_s = {{ shape = \"{shape}\", {steepness}amplitude = 0.2, period_s = 10.0 }}\n"
        )
    };
    let binary = "[[maneuver]]\nname = \"binary\"\nkind = \"pseudo-random-binary\"\nspeed_m_s = 0.6\n\
                  yaw_rate_amplitude_rad_s = 0.2\ndwell_s = 3.0\n";
    let own: String = shapes.iter().map(combined).collect();
    // The paper's spirals take 40 s at any length.
    for (dictionary, stretched) in [(HELD, 4), (PAPER_DICTIONARY, 1)] {
        let generator = generator(&format!("{dictionary}{own}{binary}")).unwrap();
        let is_unstretched: Vec<bool> =
            (0..generator.maneuvers().len()).map(|q| generator.is_unstretched(q)).collect();
        assert_eq!(
            is_unstretched.iter().filter(|is_unstretched| !**is_unstretched).count(),
            stretched,
            "{is_unstretched:?}"
        );
        for (q, is_unstretched) in is_unstretched.into_iter().enumerate() {
            let [short, long] = [120, 330].map(|samples| generator.realize(q, samples).unwrap());
            let same = short.initial == long.initial && long.inputs.starts_with(&short.inputs);
            assert_eq!(same, is_unstretched, "{}", generator.maneuvers()[q].name);
        }
    }
}

#[test]
fn law_limits_with_two_ends_and_rates_keep_candidates_within() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    // The inputs of all candidates within these limits.
    let kept = |limits: &str| {
        let text = format!(
            "[generate]\ncandidates = 120\nduration_s = 20.0\n\
             [generate.limits]\nu_m_s = 1.0\nv_m_s = 0.2\nr_rad_s = 0.3\n{limits}\n"
        );
        let file: DictionaryFile = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
        let generator = Generator::without_tables(&vessel, &file).unwrap();
        let within = |index: usize| {
            let realized = generator.realize(index, 160).ok()?;
            let (model, rate_hz) = (&vessel.model, vessel.sample_rate_hz);
            let exogenous = model.undisturbed(&realized.inputs);
            let states = simulate_one(model, generator.parameters(), realized.initial, &exogenous);
            let limits = generator.limits(index).unwrap();
            limits.exceeded(model, &states, &realized.inputs, rate_hz).is_none().then_some(realized.inputs)
        };
        (0..120).filter_map(within).collect::<Vec<Vec<f64>>>()
    };
    let free = kept("");
    let only = |holds: &dyn Fn(&[f64]) -> bool| {
        let some: Vec<Vec<f64>> = free.iter().filter(|own| holds(own)).cloned().collect();
        assert!(some.len() > 2 && some.len() < free.len(), "{} of {}", some.len(), free.len());
        some
    };
    let thrusts = |own: &[f64]| own.iter().step_by(3).copied().collect::<Vec<f64>>();
    let ahead = only(&|own| thrusts(own).iter().all(|tau| (0.0..=4000.0).contains(tau)));
    assert_eq!(kept("inputs.tau1 = [0.0, 4000.0]"), ahead);
    let small = only(&|own| thrusts(own).iter().all(|tau| tau.abs() <= 4000.0));
    assert_eq!(kept("inputs.tau1 = 4000.0"), small);
    let slow = only(&|own| thrusts(own).windows(2).all(|pair| (pair[1] - pair[0]).abs() * 8.0 <= 500.0));
    assert_eq!(kept("rates.tau1 = 500.0"), slow);
}
