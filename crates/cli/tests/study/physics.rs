//! Ships with forces in continuous time, through the binaries.

use std::collections::BTreeMap;

use seatrial::{CampaignFile, Designed, DictionaryFile, Study as InMemory, Vessel};
use serde_json::Value;
use tempfile::TempDir;

use crate::support::*;

const CAMPAIGN_FILE: &str = "seed = 1\nrealizations = 12\nduration_s = 20.0\n[current]\nkind = \"white\"\nstd_m_s = 0.05\n\
    [measurement]\nstd_u_m_s = 0.01\nstd_v_m_s = 0.01\nstd_r_rad_s = 0.01\n[validation]\nparameter_error_bound = 5.0\n\
    simulation_error_bound = 0.2\n[[validation.maneuver]]\nname = \"v\"\nkind = \"turning-circle\"\nspeed_m_s = 2.0\n\
    duration_s = 10.0\nhelm = { n1 = 10.0, n2 = -10.0 }\nto = \"starboard\"\n";
const MERIT: &str = "validate merit --vessel vessel.toml --dictionary dictionary.toml --out merit.json";

/// Standard maneuvers of published ships by an independent program, in closed loop.
fn reference() -> Vec<Value> {
    let path = repository().join("fixtures/oracle/reference_ships.json");
    let all: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    all["cases"].as_array().unwrap().clone()
}

/// A number of a table in the way that TOML has it.
fn toml(value: &Value) -> String {
    match value {
        Value::Object(all) => {
            let keys: Vec<String> = all.iter().map(|(key, own)| format!("{key} = {}", toml(own))).collect();
            format!("{{ {} }}", keys.join(", "))
        }
        other => other.to_string(),
    }
}

/// The maneuver of a case, with the settings of its approach.
fn maneuver(name: &str, case: &Value, approach: &str) -> String {
    let own = case["maneuver"].as_object().unwrap();
    let keys: String = own.iter().map(|(key, value)| format!("{key} = {}\n", toml(value))).collect();
    let seconds = case["record"].as_array().unwrap().len() as f64 / case["rate_hz"].as_f64().unwrap();
    let approach = if approach.is_empty() { String::new() } else { format!("approach = {approach}\n") };
    format!("[[maneuver]]\nname = \"{name}\"\nduration_s = {:.0}\n{keys}{approach}\n", 1.2 * seconds + 20.0)
}

/// The figures of `ship` in the reference, and those of the preset's, by maneuver and name.
fn compared(preset: &str, rate_hz: f64, ship: &str, approach: &str) -> Vec<(String, String, f64, f64)> {
    let folder = TempDir::new().unwrap();
    put(&folder, "vessel.toml", &format!("preset = \"{preset}\"\nsample_rate_hz = {rate_hz:.1}\n"));
    let cases: Vec<Value> = reference().into_iter().filter(|case| case["ship"] == ship).collect();
    let named: Vec<String> = (0..cases.len()).map(|i| format!("m{i}")).collect();
    let all: String = cases.iter().zip(&named).map(|(case, name)| maneuver(name, case, approach)).collect();
    put(&folder, "dictionary.toml", &all);
    let length = cases[0]["length_m"].as_f64().unwrap();
    run(&folder, "simulate dictionary --vessel vessel.toml --dictionary dictionary.toml --out d.parquet")
        .succeeds();
    run(&folder, &format!("{MERIT} --length-m {length} --trajectories d.parquet")).succeeds();
    let found = json(&folder, "merit.json");
    let figure = |name: &str, figure: &str| {
        let all = found["data"]["maneuvers"].as_array().unwrap();
        let own = all.iter().find(|own| own["name"] == name).unwrap();
        let own = own["figures"].as_array().unwrap().iter().find(|own| own["name"] == figure);
        own.unwrap_or_else(|| panic!("{ship}: {name} has no {figure}: {found:#}"))["value"].as_f64().unwrap()
    };
    let mut pairs = Vec::new();
    for (case, name) in cases.iter().zip(&named) {
        for (key, expected) in case["figures"].as_object().unwrap() {
            let kind = case["maneuver"]["kind"].as_str().unwrap().to_owned();
            pairs.push((kind, key.clone(), figure(name, key), expected.as_f64().unwrap()));
        }
    }
    pairs
}

/// Angles within 0.1°, all others within 0.5 %.
fn agree(pairs: &[(String, String, f64, f64)]) {
    for (kind, key, found, expected) in pairs {
        let most = if key.starts_with("overshoot") { 0.1 } else { 0.005 * expected.abs().max(1e-3) };
        assert!((found - expected).abs() <= most, "{kind} {key}: {found} {expected}\n{pairs:#?}");
    }
}

/// The figures called `key`, in the order of the reference, compared with a table of another program, whose numbers have two
/// or three digits.
fn tabled(pairs: &[(String, String, f64, f64)], key: &str, expected: &[f64]) {
    let found = pairs.iter().filter(|own| own.1 == key);
    let own: Vec<_> = found
        .zip(expected)
        .map(|(own, expected)| (own.0.clone(), key.to_owned(), own.2, *expected))
        .collect();
    assert_eq!(own.len(), expected.len(), "{key}");
    agree(&own);
}

// Rates at which a rudder that is held during samples moves almost as one that moves all the time.

#[test]
fn oracle_the_mariner_turns_as_her_source_does() {
    let pairs = compared("mariner", 10.0, "Mariner", "{ delta = 0.0 }");
    assert_eq!(pairs.len(), 4 * 3 + 2 * 8);
    agree(&pairs);
    tabled(&pairs, "advance", &[3.54, 3.71]);
    tabled(&pairs, "tactical_diameter", &[6.40, 6.65]);
    tabled(&pairs, "overshoot_1", &[4.95, 3.46, 7.79, 6.74]);
    tabled(&pairs, "overshoot_2", &[4.47, 6.20, 6.31, 7.28]);
}

#[test]
fn oracle_kvlcc2_turns_as_her_source_does() {
    let of = |n: &str| {
        let pairs = compared("kvlcc2-l7", 40.0, &format!("KVLCC2 L7, n = {n}"), &format!("{{ n = {n} }}"));
        assert_eq!(pairs.len(), 4 * 3 + 2 * 8);
        agree(&pairs);
        pairs
    };
    let (holding, tank) = (of("11.85"), of("10.4"));
    tabled(&holding, "advance", &[3.08, 3.09]);
    tabled(&holding, "tactical_diameter", &[3.12, 3.11]);
    tabled(&holding, "overshoot_1", &[4.95, 7.03, 10.5, 13.7]);
    tabled(&holding, "overshoot_2", &[13.6, 8.79, 15.7, 11.7]);
    tabled(&tank, "advance", &[3.24, 3.26]);
    tabled(&tank, "tactical_diameter", &[3.23, 3.22]);
    tabled(&tank, "overshoot_1", &[5.16, 7.47, 10.7]);
    tabled(&tank, "overshoot_2", &[14.3, 9.12, 15.8]);
}

#[test]
fn oracle_otter_turns_and_stops_as_her_source_does() {
    let pairs = compared("otter", 100.0, "Otter", "");
    assert_eq!(pairs.len(), 4 * 3 + 2 * 4);
    // The table of another program is of the inertia before April 2026: overshoots of 5.80, 6.44, 10.7 and 12.0°.
    agree(&pairs);
}

/// A folder with KVLCC2's whole file, changed, and one maneuver.
fn tanker(from: &str, to: &str, maneuver: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    let text = std::fs::read_to_string(repository().join("crates/ship/presets/kvlcc2-l7.toml")).unwrap();
    assert!(text.contains(from), "{from}");
    put(&folder, "vessel.toml", &text.replacen(from, to, 1));
    put(&folder, "dictionary.toml", &format!("[[maneuver]]\nname = \"m\"\n{maneuver}\n"));
    folder
}

const CIRCLE: &str = "kind = \"turning-circle\"\nspeed_m_s = 1.179\nhelm = { delta = 0.35 }\nto = \"port\"\nduration_s = 250.0";
const CRASH: &str = "kind = \"stop\"\nspeed_m_s = 1.179\ninputs = { n = -10.0 }\nduration_s = 100.0";

#[test]
fn descriptions_that_are_no_ship_are_refused_in_one_line() {
    let cases = [
        (
            "mass_kg = 3270.0",
            "mass_kg = { nominal = 3270.0 }",
            ["ship.mass_kg", "a free mass without a prior"],
        ),
        ("behind = \"propeller\"", "behind = \"main\"", ["`behind` of rudder `rudder`", "found `main`"]),
        ("unit = \"rad\"", "unit = \"m\"", ["`input` of `rudder`", "rad, deg"]),
        ("prime = -0.04,", "prime = -0.04, nominal = 1.0,", ["`X_vv`", "both `nominal` and `prime`"]),
        ("v^2 r / U", "v^2 r / n", ["division by `n`, which can be 0", "`range` is without 0"]),
        ("prior = 0.02", "prior = 0.0", ["`X_0`", "`fixed = true`"]),
        (
            "range = [0.0, 20.0]",
            "range = [-20.0, 20.0]",
            ["[[propeller]] `propeller`", "thrust law holds ahead only"],
        ),
        ("area_m2 = 0.0539", "area_m2 = 0.0539\nare_m2 = 1.0", ["are_m2", "area_m2"]),
        ("wake_change = 2.0", "wake_change = \"2\"", ["wake_change", "a number, or a table"]),
        ("coriolis = \"without-munk\"", "coriolis = \"munk\"", ["munk", "without-munk"]),
    ];
    for (from, to, words) in cases {
        let folder = tanker(from, to, CIRCLE);
        refused(&folder, 3, DICTIONARY, &[&["vessel.toml"][..], &words].concat());
    }
}

#[test]
fn products_of_wind_are_no_wind_speed() {
    let wind = "[[measured]]\nname = \"wind_x\"\nunit = \"m^2/s^2\"\nsimulated = 0.0\n[[measured]]\nname = \"from\"\n\
         unit = \"rad\"\nsimulated = 0.0\n[[wind]]\nname = \"wind\"\nspeed = \"wind_x\"\ndirection = \"from\"\n\
         frontal_area_m2 = 1.0\nlateral_area_m2 = 3.0\nsurge = [0.7]\n[[propeller]]\n";
    let folder = tanker("[[propeller]]\n", wind, CIRCLE);
    refused(
        &folder,
        3,
        DICTIONARY,
        &["vessel.toml", "`speed` of `wind`", "`wind_x` in `m^2/s^2`", "m/s, kn"],
    );
    edit(&folder, "vessel.toml", "m^2/s^2", "m/s");
    run(&folder, DICTIONARY).succeeds();
}

#[test]
fn a_crash_stop_by_a_thrust_law_that_holds_ahead_only_is_refused() {
    let folder = tanker("KVLCC2 L7", "KVLCC2", CRASH);
    refused(&folder, 3, DICTIONARY, &["dictionary.toml", "maneuver `m`", "n = -10", "holds ahead only"]);
    let astern = "x_m = { prime = -0.48, fixed = true }\nastern = { surge = [0.3, -0.2], yaw = [0.02, 0.0] }";
    let folder = tanker("x_m = { prime = -0.48, fixed = true }", astern, CRASH);
    edit(&folder, "vessel.toml", "range = [0.0, 20.0]", "range = [-20.0, 20.0]");
    run(&folder, DICTIONARY).succeeds();
}

#[test]
fn stages_that_need_terms_per_sample_refuse_a_ship_with_forces_by_name() {
    let folder = tanker("KVLCC2 L7", "KVLCC2", CIRCLE);
    run(&folder, DICTIONARY).succeeds();
    put(&folder, "campaign.toml", CAMPAIGN_FILE);
    in_rounds(&folder, FEW_ROUNDS);
    std::fs::create_dir(folder.path().join("refined")).unwrap();
    std::fs::create_dir(folder.path().join("pool")).unwrap();
    std::fs::create_dir(folder.path().join("exported")).unwrap();
    let runs = "--vessel vessel.toml --trajectories dictionary.parquet";
    let lines = [
        format!("moments {runs} --out moments.json"),
        format!("estimate {runs} --estimator ls --out estimates.parquet"),
        format!("estimate --structure own {runs} --estimator iv --out pool/"),
        format!("estimate --structure own --folds each {runs} --estimator iv --out scores.json"),
        format!("validate {runs} --design design.json --out scores.parquet"),
        "monte-carlo --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --out scores.parquet".to_owned(),
        "design --refine design.json --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --out \
         refined/"
            .to_owned(),
    ];
    for line in lines {
        let words =
            ["vessel.toml", "`model`", "`forces`, which have no terms per sample", "terms per sample"];
        refused(&folder, 3, &line, &words);
    }
    let compare = "validate --model vessel.toml --trajectories dictionary.parquet --window-s 10 --out c.json";
    // A ship is compared by her nominal numbers before any fit, here with what she did herself.
    // Her forces take the rate of the runs, whatever her own is.
    for line in [compare.to_owned(), format!("{compare} --set vessel.sample_rate_hz=3")] {
        let said = run(&folder, &line).succeeds();
        assert!(said.stdout.contains("fit u 100.0 %, v 100.0 %, r 100.0 %"), "{said}");
    }
}

#[test]
fn a_dead_time_is_refused_where_trials_are_simulated() {
    let folder = TempDir::new().unwrap();
    let text = std::fs::read_to_string(repository().join("crates/ship/presets/otter.toml")).unwrap();
    let lags = text.replacen("lag_s = 0.1\n", "", 1).replacen(
        "curve = ",
        "lag_s = 0.1\ndead_time_s = 0.2\ncurve = ",
        1,
    );
    put(&folder, "vessel.toml", &lags);
    put(
        &folder,
        "dictionary.toml",
        "[[maneuver]]\nname = \"m\"\nkind = \"stop\"\nspeed_m_s = 2.0\nduration_s = 8.0\n",
    );
    refused(&folder, 3, DICTIONARY, &["vessel.toml", "`dead_time_s`", "remove it"]);
    // The lag of a thruster is that of its input.
    edit(&folder, "vessel.toml", "dead_time_s = 0.2\n", "");
    run(&folder, DICTIONARY).succeeds();
    let first = bytes(&folder, "dictionary.parquet");
    put(&folder, "vessel.toml", &text);
    run(&folder, DICTIONARY).succeeds();
    let columns = |bytes: &[u8]| {
        put(&folder, "one.parquet", "");
        std::fs::write(folder.path().join("one.parquet"), bytes).unwrap();
        let made = craft::read(&folder.path().join("one.parquet"), "trajectories");
        let place = made.schema.columns.iter().position(|own| own.name == "u").unwrap();
        made.blocks[0].columns[place].as_f64().unwrap().to_vec()
    };
    assert_eq!(columns(&first), columns(&bytes(&folder, "dictionary.parquet")));
}

#[test]
fn an_approach_is_stated_for_standard_maneuvers_alone_and_by_inputs_of_the_ship() {
    for (maneuver, words) in [
        (format!("{CIRCLE}\napproach = {{ rudder = 0.1 }}"), ["approach.rudder", "one of `delta`, `n`"]),
        (format!("{CIRCLE}\napproach = {{ n = 50.0 }}"), ["`approach`", "from 0 to 20"]),
        (
            "kind = \"steady-turn\"\nspeed_m_s = 1.0\nyaw_rate_rad_s = 0.01\nduration_s = 9.0\napproach = { n = 9.0 }"
                .to_owned(),
            ["`approach`", "standard maneuver"],
        ),
    ] {
        let folder = tanker("KVLCC2 L7", "KVLCC2", &maneuver);
        refused(&folder, 3, DICTIONARY, &[&["dictionary.toml"][..], &words].concat());
    }
}

#[test]
fn golden_a_ship_with_forces_is_validated_at_any_rate() {
    let mut last = Vec::new();
    for rate in ["5.0", "20.0"] {
        let folder = TempDir::new().unwrap();
        put(&folder, "vessel.toml", &format!("preset = \"otter\"\nsample_rate_hz = {rate}\n"));
        put(&folder, "campaign.toml", CAMPAIGN_FILE);
        run(&folder, "simulate validation --vessel vessel.toml --campaign campaign.toml --out v.parquet")
            .succeeds();
        let made = craft::read(&folder.path().join("v.parquet"), "trajectories");
        let end = |name: &str| {
            let place = made.schema.columns.iter().position(|own| own.name == name).unwrap();
            *made.blocks[0].columns[place].as_f64().unwrap().last().unwrap()
        };
        last.push(["u", "v", "r"].map(end));
    }
    for d in 0..3 {
        assert!((last[0][d] - last[1][d]).abs() < 2e-3 * last[1][0], "{last:?}");
    }
}

#[test]
fn a_campaign_of_a_ship_with_forces_is_simulated_and_its_moments_are_refused() {
    let vessel = Vessel::from_file("preset = \"otter\"\nsample_rate_hz = 10.0".parse().unwrap()).unwrap();
    let maneuver = |to: &str| {
        format!(
            "[[maneuver]]\nname = \"{to}\"\nkind = \"turning-circle\"\nspeed_m_s = 2.0\nduration_s = 10.0\n\
             helm = {{ n1 = 10.0, n2 = -10.0 }}\nto = \"{to}\"\n"
        )
    };
    let dictionary: DictionaryFile = (maneuver("port") + &maneuver("starboard")).parse().unwrap();
    let campaign: CampaignFile = toml::from_str(CAMPAIGN_FILE).unwrap();
    let study = InMemory::new(vessel, &dictionary, campaign).unwrap();
    let shares: BTreeMap<String, f64> =
        BTreeMap::from(["port", "starboard"].map(|name| (name.to_owned(), 0.5)));
    let runs = study.simulate(&Designed { shares, order: None }).unwrap();
    assert!(runs.len() >= 12);
    let last = |i: usize| runs[i].states[runs[i].states.len() - 3..].to_vec();
    assert!((0..12).all(|i| last(i)[0] > 1.0 && last(i)[2] > 0.1), "{:?}", last(0));
    assert_ne!(last(0), last(1));
    let refused = study.moments(&study.dictionary().unwrap()).unwrap_err().to_string();
    assert!(refused.contains("`forces`") && refused.contains("`moments`"), "{refused}");
}
