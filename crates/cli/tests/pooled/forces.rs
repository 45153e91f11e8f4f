//! Ships as physics, fitted to runs through the binaries.

use std::sync::OnceLock;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::*;

const DICTIONARY: &str =
    "simulate dictionary --vessel vessel.toml --dictionary dictionary.toml --out d.parquet";
const LOGGED: &str = "estimate --structure own --vessel vessel.toml --trajectories trajectories.parquet";
/// The runs follow another guess of the ship.
const POOL: &str = "estimate --structure own --vessel vessel.toml --trajectories d.parquet --allow=mixed";

/// The tanker KVLCC2 at 2 Hz, and her zig-zags.
fn trial() -> TempDir {
    of_zigzags(&[(0.175, 10.5), (0.35, 10.5), (0.26, 9.0), (0.6, 12.0)])
}

/// A longer one, which leaves more than it has numbers.
fn long_trial() -> TempDir {
    let angles = [0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.13];
    let all: Vec<(f64, f64)> =
        angles.iter().enumerate().map(|(i, angle)| (*angle, [10.5, 9.0, 12.0][i % 3])).collect();
    of_zigzags(&all)
}

/// KVLCC2 at 2 Hz, and zig-zags with these angles and revolutions.
fn of_zigzags(all: &[(f64, f64)]) -> TempDir {
    let folder = TempDir::new().unwrap();
    put(&folder, "vessel.toml", "preset = \"kvlcc2-l7\"\nsample_rate_hz = 2.0\n");
    let zigzag = |(angle, n): &(f64, f64)| {
        format!(
            "[[maneuver]]\nname = \"z{:.0}\"\nkind = \"zig-zag-test\"\nspeed_m_s = 1.1\nhelm = {{ delta = {angle} }}\n\
             heading_rad = {:.4}\nto = \"starboard\"\nduration_s = 200.0\napproach = {{ n = {n} }}\n",
            angle.to_degrees(),
            angle
        )
    };
    let all: String = all.iter().map(zigzag).collect();
    put(&folder, "dictionary.toml", &all);
    run(&folder, DICTIONARY).succeeds();
    folder
}

/// The numbers of KVLCC2 that a fit begins with.
const GUESS: &str = "preset = \"kvlcc2-l7\"\nsample_rate_hz = 2.0\n[nominal]\nY_v = -0.4\nN_v = -0.1\nN_r = -0.06\nX_0 = -0.03\n\
    \"propeller.wake\" = 0.3\n\"rudder.epsilon\" = 1.2\n";

/// The fit of [`trial`] that begins with [`GUESS`].
fn fitted() -> &'static Study {
    static FITTED: OnceLock<Study> = OnceLock::new();
    FITTED.get_or_init(|| {
        let folder = trial();
        put(&folder, "vessel.toml", GUESS);
        run(&folder, &format!("{POOL} --prior 0.01 --threads 3 --out estimate.json")).succeeds();
        Study::of(&folder)
    })
}

fn parameters(folder: &TempDir, name: &str) -> Vec<Value> {
    json(folder, name)["data"]["forces"]["parameters"].as_array().unwrap().clone()
}

fn fits(folder: &TempDir, name: &str) -> [f64; 3] {
    let document = json(folder, name);
    let errors = &document["data"]["recordings"]["models"][0]["errors"];
    ["fit_u", "fit_v", "fit_r"].map(|fit| errors[fit].as_f64().unwrap())
}

/// The fitted model in Python has its numbers in SI units, their standard errors and the range of the data.
fn exported(folder: &TempDir, sway: &Value) {
    run(folder, "export --model model.json --to python --out python").succeeds();
    let text = String::from_utf8(bytes(folder, "python/kvlcc2_l7.py")).unwrap();
    let number = |key: &str| sway[key].as_f64().unwrap();
    let (value, scale) = (number("si_value"), number("si_value") / number("value"));
    assert!(text.contains(&format!("    \"Y_v\": {value:?},  # [N per (m/s × m/s)] sway: v U\n")), "{text}");
    let line = text.split("STANDARD_ERRORS").nth(1).unwrap().lines().find(|own| own.contains("\"Y_v\""));
    let found: f64 =
        line.unwrap().trim().trim_end_matches(',').split(' ').next_back().unwrap().parse().unwrap();
    assert!((found / (scale.abs() * number("standard_error")) - 1.0).abs() < 1e-12, "{line:?}");
    assert!(text.split("RANGES").nth(1).unwrap().contains("    \"delta\": ("), "{text}");
}

#[test]
fn a_fit_of_forces_is_compared_simulated_and_judged_in_place_of_vessel_toml() {
    let folder = trial();
    put(&folder, "vessel.toml", GUESS);
    let said = run(&folder, &format!("{POOL} --prior 0.01 --threads 1 --out estimate.json")).succeeds();
    assert!(said.stdout.contains("output-error from "), "{said}");
    let own = parameters(&folder, "model.json");
    assert_eq!(own.len(), 26);
    let sway = own.iter().find(|own| own["name"] == "Y_v").unwrap();
    assert_eq!(
        (&sway["unit"], &sway["prior"], &sway["value"]),
        (&"1".into(), &(-0.4).into(), &sway["prime_value"])
    );
    assert_eq!(sway["si_unit"], "N per (m/s × m/s)");
    run(
        &folder,
        "validate --model model.json --trajectories d.parquet --allow=mixed --window-s 50 --out validation.json",
    )
    .succeeds();
    let found = fits(&folder, "validation.json");
    assert!(found.iter().all(|fit| *fit > 97.0), "{found:?}");
    run(&folder, "simulate dictionary --vessel model.json --dictionary dictionary.toml --out again.parquet")
        .succeeds();
    run(
        &folder,
        "validate merit --model model.json --dictionary dictionary.toml --length-m 7 --out merit.json",
    )
    .succeeds();
    run(
        &folder,
        "validate merit --model model.json --dictionary dictionary.toml --length-m 7 --draws 8 --out drawn.json",
    )
    .succeeds();
    let drawn = json(&folder, "drawn.json");
    let figure = &drawn["data"]["maneuvers"][0]["figures"][0];
    assert!(figure["low"].as_f64().unwrap() < figure["high"].as_f64().unwrap(), "{figure}");
    // Simulated runs have held inputs, and their errors are known.
    assert_eq!(json(&folder, "model.json")["data"]["forces"]["held_inputs"], true);
    assert!(json(&folder, "validation.json")["data"]["recordings"]["bands"]["inside_r"].as_f64().is_some());
    exported(&folder, sway);
    // The same files again, and with three threads, are the same bytes.
    assert!(fitted().bytes("model.json") == bytes(&folder, "model.json"));
}

#[test]
fn a_former_fit_and_that_of_a_sister_are_priors() {
    let folder = trial();
    run(&folder, &format!("{POOL} --out estimate-former.json")).succeeds();
    put(&folder, "vessel.toml", GUESS);
    run(&folder, &format!("{POOL} --prior model-former.json --out estimate.json")).succeeds();
    let (former, own) = (parameters(&folder, "model-former.json"), parameters(&folder, "model.json"));
    for (former, own) in former.iter().zip(&own) {
        assert_eq!(former["value"], own["prior"]);
    }
    assert_eq!(json(&folder, "model.json")["data"]["forces"]["prior_weight"], 10.0);
    // A sister of half the length: her prime numbers are the same.
    let text = std::fs::read_to_string(repository().join("crates/ship/presets/kvlcc2-l7.toml")).unwrap();
    let sister =
        text.replace("length_m = 7.0", "length_m = 3.5").replace("draught_m = 0.46", "draught_m = 0.23");
    // With the rudder of the longer ship.
    let sister = format!("unusual = \"accepted\"\n{sister}");
    put(&folder, "vessel.toml", &sister.replace("sample_rate_hz = 10.0", "sample_rate_hz = 2.0"));
    edit(&folder, "vessel.toml", "mass_kg = 3270.0", "mass_kg = 408.0");
    edit(&folder, "vessel.toml", "gyration_m = 1.75", "gyration_m = 0.875");
    run(&folder, &format!("{POOL} --prior model-former.json --out estimate-sister.json")).succeeds();
    let found = parameters(&folder, "model-sister.json");
    for (former, own) in former.iter().zip(&found) {
        let [former, own] = [&former["value"], &own["prior"]].map(|own| own.as_f64().unwrap());
        assert!((former - own).abs() <= 1e-12 * former.abs(), "{former} {own}");
    }
}

#[test]
fn fits_of_forces_that_cannot_be_are_refused_in_one_line() {
    let folder = trial();
    for estimator in ["ls", "iv", "auto", "prediction-error"] {
        let line = format!("{POOL} --estimator {estimator} --out estimate.json");
        let computes = format!("`{estimator}` computes");
        refused(&folder, 3, &line, &["vessel.toml", "`forces`, which have no terms per sample", &computes]);
    }
    for (flags, words) in [
        ("--nominal least-squares", ["--nominal", "which has no instruments"]),
        ("--bootstrap 10", ["--bootstrap", "terms per sample"]),
        ("--fitted-window-s 0.1", ["--fitted-window-s", "at least a sample"]),
        ("--prior=-1", ["--prior", "a number from 0"]),
    ] {
        refused(&folder, 2, &format!("{POOL} {flags} --out estimate.json"), &words);
    }
    refused(&folder, 2, &format!("{POOL} --out model.parquet"), &["ends in .json", "write --out model.json"]);
    run(&folder, &format!("{POOL} --out estimate-former.json")).succeeds();
    let text = std::fs::read_to_string(repository().join("crates/ship/presets/kvlcc2-l7.toml")).unwrap();
    let text = text.replace("sample_rate_hz = 10.0", "sample_rate_hz = 2.0");
    put(
        &folder,
        "vessel.toml",
        &text.replace("term = \"v^3 / U\", prime = -1.607", "term = \"v |v|\", prime = -1.607"),
    );
    let line = format!("{POOL} --prior model-former.json --out estimate.json");
    refused(
        &folder,
        3,
        &line,
        &["model-former.json", "`Y_vvv` v^3 / U in sway", "`Y_vvv` v |v| in sway, as this vessel has"],
    );
    put(
        &folder,
        "vessel.toml",
        &text.replace("name = \"n\"", "name = \"shaft\"").replace("input = \"n\"", "input = \"shaft\""),
    );
    refused(&folder, 3, &format!("{POOL} --out estimate.json"), &["d.parquet", "shaft"]);
    let fixed: String = text.lines().map(known).collect();
    put(&folder, "vessel.toml", &fixed);
    refused(
        &folder,
        3,
        &format!("{POOL} --out estimate.json"),
        &["vessel.toml", "no number of the model is free"],
    );
    let terms = "name = \"t\"\nsample_rate_hz = 2.0\n[[input]]\nname = \"delta\"\nunit = \"rad\"\n[[input]]\nname = \"n\"\n\
        unit = \"1/s\"\n[[surge]]\nparameter = \"a\"\nterm = \"u\"\nnominal = -0.1\n[[sway]]\nparameter = \"b\"\nterm = \"v\"\n\
        nominal = -0.1\n[[yaw]]\nparameter = \"c\"\nterm = \"r\"\nnominal = -0.1\n";
    put(&folder, "vessel.toml", terms);
    refused(
        &folder,
        2,
        &format!("{POOL} --fitted-window-s 50 --out estimates.parquet"),
        &["--fitted-window-s", "terms per sample"],
    );
    refused(
        &folder,
        2,
        &format!("{POOL} --prior model-former.json --out estimates.parquet"),
        &["--prior", "terms per sample"],
    );
}

/// A ship whose yaw is steady with `n_r` below 0, and unstable above it but for large rates.
fn of_yaw(n_r: f64) -> String {
    format!(
        r#"name = "ship"
unusual = "accepted"
model = "forces"
sample_rate_hz = 1.0
density_kg_m3 = 1000.0
surge = [
  {{ parameter = "X_0", term = "u U", prime = -0.022, prior = 0.02 }},
  {{ parameter = "X_n", term = "n |n|", nominal = 0.4, fixed = true }},
]
sway = [{{ parameter = "Y_v", term = "v U", prime = -0.3, fixed = true }}]
yaw = [
  {{ parameter = "N_r", term = "r U", prime = {n_r}, fixed = true }},
  {{ parameter = "N_rr", term = "r |r|", prime = -0.5, fixed = true }},
  {{ parameter = "N_d", term = "delta", nominal = 100.0, fixed = true }},
  {{ parameter = "Y_d", term = "n", nominal = 0.0, fixed = true }},
]
input = [
  {{ name = "n", unit = "1/s", range = [0.0, 20.0] }},
  {{ name = "delta", unit = "rad", range = [-0.61, 0.61] }},
]

[ship]
length_m = 7.0
draught_m = 0.46
speed_m_s = 1.2
mass_kg = 3270.0
x_g_m = 0.0
gyration_m = 1.75
added_mass = {{ surge = 0.022, sway = 0.223, yaw = 0.011 }}
"#
    )
}

#[test]
fn a_window_that_depends_on_its_start_beyond_all_numbers_is_named_with_its_recording_and_time() {
    let folder = TempDir::new().unwrap();
    put(&folder, "vessel.toml", &of_yaw(-0.05));
    let kept = "speed_m_s = 1.1\nto = \"starboard\"\n";
    let swings = "kind = \"zig-zag-test\"\nhelm = { delta = 0.3 }\nheading_rad = 0.35\nduration_s = 200.0\n";
    let straight = "kind = \"stop\"\nspeed_m_s = 1.1\nduration_s = 600.0\ninputs = { n = 8.0 }\n";
    let approach = "approach = { n = 10.5, delta = 0.0 }\n";
    let all = [("swings", format!("{kept}{swings}")), ("straight", straight.to_owned())];
    let all = all.map(|(name, own)| format!("[[maneuver]]\nname = \"{name}\"\n{own}{approach}"));
    put(&folder, "dictionary.toml", &all.concat());
    run(&folder, &format!("{DICTIONARY} --allow=unreached")).succeeds();
    // Straight ahead she stays where she is, to all digits, and a start off it grows to more than any number.
    put(&folder, "vessel.toml", &of_yaw(0.3));
    let words = ["d.parquet", "in `1`, the state at 0 s", "take shorter windows", "--fitted-window-s"];
    refused(&folder, 4, &format!("{POOL} --fitted-window-s 600 --out estimate.json"), &words);
    run(&folder, &format!("{POOL} --fitted-window-s 100 --out estimate.json")).succeeds();
}

/// A line of the preset with its numbers known.
fn known(line: &str) -> String {
    let mut line = line.to_owned();
    while let Some(at) = line.find(", prior = ") {
        let end = line[at + 2..].find([',', ' ', '}']).map_or(line.len(), |_| {
            let rest = &line[at + 10..];
            at + 10 + rest.find([',', ' ', '}']).unwrap_or(rest.len())
        });
        line.replace_range(at..end, ", fixed = true");
    }
    line + "\n"
}

/// Recordings of a study with forces, joined to its `ingest.toml`; `None` without the logs.
fn logged(vessel: &str, ingest: &str, data: &str) -> Option<TempDir> {
    let logs = repository().join("../shared/data").join(data);
    if !logs.is_dir() {
        eprintln!("skipped: there is no {}", logs.display());
        return None;
    }
    let folder = TempDir::new().unwrap();
    put(&folder, "vessel.toml", vessel);
    put(&folder, "ingest.toml", ingest);
    run(
        &folder,
        &format!(
            "ingest --config ingest.toml --vessel vessel.toml --logs {} --out trajectories.parquet --quiet",
            logs.display()
        ),
    )
    .succeeds();
    Some(folder)
}

/// A file of the repository.
fn file(path: &str) -> String {
    std::fs::read_to_string(repository().join(path)).unwrap()
}

#[test]
fn recordings_left_out_of_the_esso_osaka_are_followed_by_forces() {
    let (vessel, ingest) =
        (file("pipelines/esso-osaka/vessel-forces.toml"), file("pipelines/esso-osaka/ingest.toml"));
    let Some(folder) = logged(&vessel, &ingest, "esso_osaka") else { return };
    let test = "random_06-Aug-2020_16_24_25_4,random_31-Jul-2020_14_52_18,turn_14-Oct-2020_14_39_54,\
        turn_14-Sep-2020_13_51_45,zigzag_31-Jul-2020_13_14_21,zigzag_31-Jul-2020_13_50_28";
    run(&folder, &format!("{LOGGED} --leave-out {test} --out estimate.json")).succeeds();
    run(
        &folder,
        &format!("validate --model model.json --trajectories trajectories.parquet --runs {test} --window-s 100 --out validation.json"),
    )
    .succeeds();
    let found = fits(&folder, "validation.json");
    println!("{found:?}");
    assert!(parameters(&folder, "model.json").len() <= 45);
    assert!(found[0] > 76.0 && found[1] > 73.5 && found[2] > 73.5, "{found:?}");
}

#[test]
fn recordings_left_out_of_the_kvlcc2_are_followed_by_forces() {
    let (vessel, ingest) =
        (file("pipelines/kvlcc2/vessel-forces.toml"), file("pipelines/kvlcc2/ingest.toml"));
    let Some(folder) = logged(&vessel, &ingest, "kvlcc2_hsva") else { return };
    let test = "kvlcc2_hsva_Z_10_05,kvlcc2_hsva_Z_20_10_S,kvlcc2_hsva_Z_35_05";
    run(&folder, &format!("{LOGGED} --leave-out {test} --fitted-window-s 150 --out estimate.json"))
        .succeeds();
    run(
        &folder,
        &format!("validate --model model.json --trajectories trajectories.parquet --runs {test} --out validation.json"),
    )
    .succeeds();
    let found = fits(&folder, "validation.json");
    println!("{found:?}");
    assert!(found[0] >= 91.5 && found[1] >= 86.0 && found[2] >= 88.5, "{found:?}");
}

/// Otter's dictionary: turns by one propeller against the other, to either side.
const TURNS: &str = "inputs_from = \"nominal\"\n[[maneuver]]\nname = \"a\"\nkind = \"zig-zag-test\"\nspeed_m_s = 1.5\n\
    duration_s = 60.0\nhelm = { n1 = 10.0, n2 = -10.0 }\nheading_rad = 0.35\nto = \"starboard\"\n[[maneuver]]\nname = \"b\"\n\
    kind = \"zig-zag-test\"\nspeed_m_s = 1.2\nduration_s = 60.0\nhelm = { n1 = 20.0, n2 = -20.0 }\nheading_rad = 0.7\n\
    to = \"port\"\n[[maneuver]]\nname = \"c\"\nkind = \"turning-circle\"\nspeed_m_s = 1.5\nduration_s = 60.0\n\
    helm = { n1 = 20.0, n2 = -20.0 }\nto = \"starboard\"\n";

/// Otter with priors, sampled at 5 Hz.
fn otter() -> String {
    let text =
        file("crates/ship/presets/otter.toml").replace("sample_rate_hz = 20.0", "sample_rate_hz = 5.0");
    let lines = text.lines().map(|line| match line.split_once(", value = -") {
        Some((begin, _)) => format!("{begin}, prior = 20.0 }},"),
        None => line.to_owned(),
    });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn exchanged_thrusters_are_named_and_a_late_rudder_is_told_with_its_time() {
    let folder = TempDir::new().unwrap();
    put(&folder, "vessel.toml", &otter());
    put(&folder, "dictionary.toml", TURNS);
    run(&folder, DICTIONARY).succeeds();
    let line = format!("{POOL} --fitted-window-s 15 --out estimate.json");
    let swapped = otter().replace("\"n1\"\nx_m", "\"n\"\nx_m").replace("\"n2\"\nx_m", "\"n1\"\nx_m");
    put(&folder, "vessel.toml", &swapped.replace("\"n\"\nx_m", "\"n2\"\nx_m"));
    let said = run(&folder, &line).succeeds();
    assert!(said.stdout.contains("model rejected") && said.stdout.contains("not tested"), "{said}");
    let found = json(&folder, "model.json");
    let own = &found["data"]["forces"]["criticism"];
    assert_eq!((&found["data"]["rejected"], &own["p_value"]), (&true.into(), &Value::Null));
    let all = own["absent"].as_array().unwrap();
    assert!(all[0]["candidate"] == true && all.iter().all(|absent| absent["kind"] == "sign"), "{own}");
    let name = all[0]["name"].as_str().unwrap();
    assert!(name.contains("are exchanged, the inputs of `port` and `starboard`"), "{own}");
    // Simulations hold inputs during samples, so in simulated runs none acts late. In a table without true states, which is a log,
    // inputs are linear between samples: held ones act half a sample late.
    let folder = long_trial();
    put(&folder, "vessel.toml", GUESS);
    run(&folder, &format!("{POOL} --prior 0.01 --out estimate.json")).succeeds();
    let late = || {
        let all = json(&folder, "model.json")["data"]["forces"]["criticism"]["absent"].clone();
        let late = |absent: &&Value| absent["kind"] == "late" && absent["name"] == "delta";
        all.as_array().unwrap().iter().find(late).unwrap().clone()
    };
    let right = late();
    assert!(
        right["value"][0].as_f64().unwrap().abs() < 0.01 && right["p_value"].as_f64().unwrap() > 0.05,
        "{right}"
    );
    let table = folder.path().join("d.parquet");
    craft::read(&table, "trajectories").without(&["u", "v", "r"]).write(&table);
    let said = run(&folder, &format!("{POOL} --prior 0.01 --out estimate.json")).succeeds();
    let late = late();
    let off = late["value"][0].as_f64().unwrap() - 0.25;
    assert!(off.abs() < 0.05 && late["p_value"].as_f64().unwrap() < 0.05, "{late}");
    assert!(said.stdout.contains("`delta` acts 0.2"), "{said}");
    run(&folder, "validate --model model.json --trajectories d.parquet --allow=mixed --window-s 50 --out validation.json")
        .succeeds();
    run(&folder, "report --study . --results . --allow=mixed --out report.html").succeeds();
    let page = String::from_utf8(bytes(&folder, "report.html")).unwrap();
    assert!(
        page.contains("What is wrong with the model") && page.contains("acts later by"),
        "{}",
        page.len()
    );
}

/// Published values of KVLCC2, which the simulated runs follow.
const CAPTIVE: &str = "source = \"Yasukawa and Yoshimura 2015\"\n[derivatives]\nY_v = -0.315\nY_r = 0.083\nY_vvv = -1.607\n\
    Y_vvr = 0.379\nY_vrr = -0.391\nY_rrr = 0.008\nN_v = -0.137\nN_r = -0.049\nN_vvv = -0.03\nN_vvr = -0.294\nN_vrr = 0.055\n\
    N_rrr = -0.013\n\"rudder.ell\" = -0.71\n";

#[test]
fn captive_values_stand_beside_estimates_and_sums_are_of_what_was_sailed() {
    let folder = trial();
    put(&folder, "vessel.toml", GUESS);
    put(&folder, "reference.toml", CAPTIVE);
    let line = format!("{POOL} --prior 0.01 --reference reference.toml --out estimate.json");
    let said = run(&folder, &line).succeeds();
    assert!(
        said.stdout.contains("sums along v = -0.") && said.stdout.contains("of 13 captive values"),
        "{said}"
    );
    let found = json(&folder, "model.json");
    let own = &found["data"]["forces"];
    assert_eq!(own["captive_source"], "Yasukawa and Yoshimura 2015");
    let interval = |own: &Value| [0, 1].map(|i: usize| own[i].as_f64().unwrap());
    let all = own["parameters"].as_array().unwrap();
    let compared: Vec<&Value> = all.iter().filter(|own| own.get("captive").is_some()).collect();
    assert_eq!(compared.len(), 13);
    for own in compared {
        let ([low, high], captive) =
            (interval(&own["prime_interval"]), own["captive"]["value"].as_f64().unwrap());
        assert_eq!(own["captive"]["within"], (low..=high).contains(&captive), "{own}");
        let [value, prime] = ["si_value", "prime_value"].map(|key| own[key].as_f64().unwrap());
        let [least, _] = interval(&own["si_interval"]);
        assert!((least / value - low / prime).abs() < 1e-9, "{own}");
    }
    let a = own["sailed"]["drift"].as_f64().unwrap();
    assert!((-0.6..-0.2).contains(&a), "{a}");
    run(&folder, "validate --model model.json --trajectories d.parquet --allow=mixed --window-s 50 --out validation.json")
        .succeeds();
    run(&folder, "report --study . --results . --allow=mixed --out report.html").succeeds();
    let page = String::from_utf8(bytes(&folder, "report.html")).unwrap();
    for words in ["Yasukawa and Yoshimura 2015", "Captive tests", "within", "outside", "sway, cubic"] {
        assert!(page.contains(words), "{words}");
    }
    let expected = [
        -0.315 * a + 0.083,
        -1.607 * a.powi(3) + 0.379 * a * a - 0.391 * a + 0.008,
        -0.137 * a - 0.049,
        -0.03 * a.powi(3) - 0.294 * a * a + 0.055 * a - 0.013,
    ];
    let sums = own["sailed"]["sums"].as_array().unwrap();
    assert_eq!(sums.len(), 4);
    for (sum, expected) in sums.iter().zip(expected) {
        let number = |key: &str| sum[key].as_f64().unwrap();
        assert!((sum["captive"]["value"].as_f64().unwrap() - expected).abs() < 1e-12, "{sum} {expected}");
        // The runs follow these values.
        let off = (number("value") - expected).abs();
        assert!(
            off < 4.0 * number("standard_error") + 0.01 && off < number("prior_deviation"),
            "{sum} {expected}"
        );
    }
    // They change no estimate.
    put(&folder, "model.json", str::from_utf8(fitted().bytes("model.json")).unwrap());
    let alone = parameters(&folder, "model.json");
    assert!(alone.iter().zip(all).all(|(alone, own)| alone["value"] == own["value"]));
    put(&folder, "wrong.toml", "source = \"S\"\n[derivatives]\nY_vw = 1.0\n");
    let line = format!("{POOL} --reference wrong.toml --out estimate.json");
    refused(&folder, 3, &line, &["wrong.toml: `derivatives.Y_vw`", "did you mean"]);
}

/// The tanker by terms per sample, with a channel that the forces do not have.
const TERMS: &str = "name = \"terms\"\nsample_rate_hz = 2.0\n\
    input = [{ name = \"delta\", unit = \"rad\" }, { name = \"n\", unit = \"1/s\" }]\n\
    derived = [{ name = \"n_ahead\", formula = \"positive(n)\", unit = \"1/s\" }]\n\
    surge = [{ parameter = \"a\", term = \"u |u|\", nominal = 0 }, { parameter = \"b\", term = \"n_ahead |n|\", nominal = 0 }, \
    { parameter = \"c\", term = \"v r\", nominal = 0 }]\n\
    sway = [{ parameter = \"d\", term = \"v\", nominal = 0 }, { parameter = \"e\", term = \"u r\", nominal = 0 }, \
    { parameter = \"f\", term = \"u |u| delta\", nominal = 0 }]\n\
    yaw = [{ parameter = \"g\", term = \"r\", nominal = 0 }, { parameter = \"h\", term = \"u v\", nominal = 0 }, \
    { parameter = \"i\", term = \"u |u| delta\", nominal = 0 }]\n";

#[test]
fn several_models_are_compared_with_the_first() {
    let folder = trial();
    put(&folder, "vessel.toml", GUESS);
    run(&folder, &format!("{POOL} --out estimate.json")).succeeds();
    put(&folder, "terms.toml", TERMS);
    std::fs::create_dir(folder.path().join("terms")).unwrap();
    let terms =
        "estimate --structure own --vessel terms.toml --trajectories d.parquet --allow=mixed --estimator ls";
    run(&folder, &format!("{terms} --out terms/")).succeeds();
    let line = "validate --trajectories d.parquet --allow=mixed --window-s 50 --model";
    let tried = |models: &str| {
        run(&folder, &format!("{line} {models} --out validation.json")).succeeds();
        json(&folder, "validation.json")["data"]["recordings"].clone()
    };
    let rmse = |of: &Value, i: usize| of["models"][i]["errors"]["rmse_v"].as_f64().unwrap();
    let alone = tried("model.json");
    let two = tried("terms/model.json --model model.json");
    assert_eq!(
        (&two["models"][1]["name"], &two["models"][1]["place"]),
        (&"other model".into(), &Value::Null)
    );
    assert_eq!(rmse(&two, 1), rmse(&alone, 0));
    let three = tried("terms/model.json,model.json,vessel.toml");
    let places = [1, 2].map(|i| three["models"][i]["place"].clone());
    assert_eq!((places, rmse(&three, 1)), ([2.into(), 3.into()], rmse(&alone, 0)));
    let said = three["statements"].to_string();
    assert!(said.contains("model 2: ") && said.contains("better than model 3: "), "{said}");
    // Another ship's channels.
    put(&folder, "other.toml", GUESS.replace("kvlcc2-l7", "otter").split("[nominal]").next().unwrap());
    let words = ["other.toml: channel `", "a channel of this model alone"];
    refused(&folder, 3, &format!("{line} model.json,other.toml --out c.json"), &words);
    refused(
        &folder,
        2,
        &format!("{line} model.json --against other.toml --out c.json"),
        &["`--model` again"],
    );
}

#[test]
fn recordings_are_left_out_of_fits_of_forces() {
    let folder = trial();
    put(&folder, "vessel.toml", GUESS);
    let line = "estimate --structure own --vessel vessel.toml --trajectories d.parquet --allow=mixed --window-s 50 --folds 2";
    run(&folder, &format!("{line} --prior 0.01 --out scores.json")).succeeds();
    let found = json(&folder, "scores.json")["data"]["left_out"].clone();
    assert_eq!((&found["forces"], &found["prior"], &found["folds"]), (&true.into(), &0.01.into(), &2.into()));
    let own = &found["estimators"][0];
    assert_eq!((&own["name"], &own["status"]), (&"output-error".into(), &"scored".into()));
    assert_eq!(own["sources"].as_array().unwrap().len(), 4);
    assert!(own["errors"]["fit_r"].as_f64().unwrap() > 90.0, "{own}");
    // A fold is the fit without its runs.
    let fold = "--runs 1,3 --out validation.json";
    run(&folder, &format!("{POOL} --prior 0.01 --leave-out 1,3 --out estimate.json")).succeeds();
    let compare = "validate --model model.json --trajectories d.parquet --allow=mixed --window-s 50";
    run(&folder, &format!("{compare} {fold}")).succeeds();
    let alone = json(&folder, "validation.json")["data"]["recordings"]["models"][0]["recordings"].clone();
    for own in own["sources"].as_array().unwrap() {
        let same = alone.as_array().unwrap().iter().find(|other| other["source"] == own["source"]);
        if let Some(same) = same {
            let [same, left] = [same, own].map(|own| own["errors"]["rmse_v"].as_f64().unwrap());
            assert!((same / left - 1.0).abs() < 1e-12, "{own}");
        }
    }
    let computes = ["vessel.toml", "`ls` computes"];
    refused(&folder, 3, &format!("{line} --estimator ls --out c.json"), &computes);
    refused(&folder, 2, &format!("{line} --nominal least-squares --out c.json"), &["--nominal"]);
    put(&folder, "vessel.toml", TERMS);
    refused(&folder, 2, &format!("{line} --fitted-window-s 50 --out c.json"), &["--fitted-window-s"]);
}
