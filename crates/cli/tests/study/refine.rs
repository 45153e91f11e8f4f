//! `design --refine` through the binaries, on a short experiment of the paper's maneuvers.

use std::sync::OnceLock;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::*;

const OUTPUT_ERROR: &str = "moments --vessel vessel.toml --trajectories dictionary.parquet --campaign campaign.toml --estimator \
     output-error --out moments.json";
const DESIGN_FOR: &str = "design --moments moments.json --for output-error --criterion a-relative --relative-to value --out design.json";
const REFINE: &str = "design --refine design.json --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --out refined/";
const LIMITS: &str = "\n[limits]\nu_m_s = 1.2\nv_m_s = 0.3\nr_rad_s = 0.7\n[limits.inputs]\ntau1 = 6500.0\ntau2 = 1600.0\ntau3 = 800.0\n";

/// A folder with a design, and a folder for the result.
fn designed() -> TempDir {
    static MADE: OnceLock<Study> = OnceLock::new();
    let make = || {
        let folder = written(8);
        edit(&folder, "campaign.toml", "duration_s = 125.0", "duration_s = 40.0");
        [DICTIONARY, OUTPUT_ERROR, DESIGN_FOR].iter().for_each(|line| drop(run(&folder, line).succeeds()));
        Study::of(&folder)
    };
    let folder = MADE.get_or_init(make).with(&["design.json", "moments.json"]);
    std::fs::create_dir(folder.path().join("refined")).unwrap();
    folder
}

fn refined(folder: &TempDir) -> Value {
    json(folder, "refined/design.json")["data"]["refined"].clone()
}

/// Refines within `limits`, which the maneuvers' file did not have when the design was made.
fn within(folder: &TempDir, limits: &str) -> String {
    let written = std::fs::read_to_string(folder.path().join("dictionary.toml")).unwrap();
    let maneuvers = written.split("\n[limits]").next().unwrap();
    put(folder, "dictionary.toml", &format!("{maneuvers}{limits}"));
    format!("{REFINE} --allow=mixed")
}

const WRITES: [&str; 3] = ["inputs.csv", "refined-dictionary.toml", "design.json"];

#[test]
fn law_refined_inputs_stay_within_the_range_of_the_vessel() {
    let folder = designed();
    let own = std::fs::read_to_string(repository().join("pipelines/paper/vessel.toml")).unwrap();
    let ranged = |range: &str| own.replace("name = \"tau1\"", &format!("name = \"tau1\"\nrange = {range}"));
    let lowest = |range: &str, limits: &str| {
        let refine = within(&folder, limits);
        put(&folder, "vessel.toml", &ranged(range));
        [DICTIONARY, OUTPUT_ERROR, DESIGN_FOR].iter().for_each(|line| drop(run(&folder, line).succeeds()));
        run(&folder, &refine).succeeds();
        let text = String::from_utf8(bytes(&folder, "refined/inputs.csv")).unwrap();
        assert!(text.starts_with("tau1,") || text.starts_with("t,tau1,"), "{}", &text[..40]);
        let column = usize::from(text.starts_with("t,"));
        let value = |line: &str| line.split(',').nth(column).unwrap().parse::<f64>().unwrap();
        text.lines().skip(1).map(value).fold(f64::INFINITY, f64::min)
    };
    // Without a range the descent goes astern.
    assert!(lowest("[-6500.0, 6500.0]", "") < -100.0);
    for limits in ["", LIMITS] {
        assert!(lowest("[0.0, 6500.0]", limits) >= 0.0, "{limits}");
    }
}

#[test]
fn refined_inputs_are_worth_more_keep_the_limits_and_run_as_a_campaign() {
    let folder = designed();
    run(&folder, &within(&folder, LIMITS)).succeeds();
    let found = refined(&folder);
    let of = |experiment: &str, key: &str| found[experiment][key].as_f64().unwrap();
    assert!(of("after", "value") < 0.8 * of("before", "value"), "{found}");
    assert!(of("after", "measurement_value") < of("after", "value"));
    assert!((found["worth"].as_f64().unwrap() - of("before", "value") / of("after", "value")).abs() < 1e-9);
    let limits = found["limits"].as_array().unwrap();
    let moved = limits.iter().filter(|l| l["before"] != l["after"]).count();
    assert!(moved > 3, "{found}");
    for limit in limits.iter().filter(|l| l["allowed"].is_number()) {
        assert!(
            limit["after"].as_f64().unwrap() <= limit["allowed"].as_f64().unwrap() * (1.0 + 1e-9),
            "{limit}"
        );
    }
    // The predicted errors of the start are those of the design's own criterion, but for the state that carries over.
    let design = json(&folder, "refined/design.json")["data"].clone();
    assert_eq!(design["shares"]["refined"], 1.0);
    assert_eq!(design["covariance"]["standard_errors"], found["after"]["standard_errors"]);
    // Fields that only a design of shares has are absent.
    for key in ["sensitivities", "dimension", "gap", "relative_gap", "efficiency", "mean_removal"] {
        assert!(design.get(key).is_none(), "{key}: {design}");
    }
    // A campaign simulates the refined experiment.
    run(
        &folder,
        "simulate campaign --vessel vessel.toml --dictionary refined/refined-dictionary.toml --campaign campaign.toml --design \
         refined/design.json --out campaign.parquet",
    )
    .succeeds();
    run(
        &folder,
        "simulate dictionary --vessel vessel.toml --dictionary refined/refined-dictionary.toml --out refined/alone.parquet",
    )
    .succeeds();
    run(
        &folder,
        "moments --vessel vessel.toml --trajectories refined/alone.parquet --campaign campaign.toml --estimator output-error --out \
         refined/moments.json",
    )
    .succeeds();
    run(
        &folder,
        "design --moments refined/moments.json --for output-error --criterion a-relative --relative-to value --duration-s 40 --out \
         refined/again.json",
    )
    .succeeds();
    let again = json(&folder, "refined/again.json")["data"]["covariance"]["value"].as_f64().unwrap();
    assert!((again / of("after", "value") - 1.0).abs() < 1e-6, "{again} {found}");
}

#[test]
fn law_the_same_bytes_for_any_number_of_threads() {
    let folder = designed();
    std::fs::create_dir(folder.path().join("other")).unwrap();
    run(&folder, &format!("{REFINE} --threads 1")).succeeds();
    run(&folder, &REFINE.replace("refined/", "other/ --threads 3")).succeeds();
    for name in WRITES {
        assert_eq!(
            bytes(&folder, &format!("refined/{name}")),
            bytes(&folder, &format!("other/{name}")),
            "{name}"
        );
    }
}

#[test]
fn rates_limit_how_fast_inputs_change() {
    let folder = designed();
    let rates = |found: &Value, when: &str| -> Vec<f64> {
        let limits = found["limits"].as_array().unwrap().iter();
        let rates = limits.filter(|l| l["limit"].as_str().unwrap().starts_with("rates."));
        rates.map(|l| l[when].as_f64().unwrap()).collect()
    };
    run(&folder, &within(&folder, LIMITS)).succeeds();
    let start = rates(&refined(&folder), "before");
    let allowed = format!("tau1 = {:?}\ntau2 = {:?}\ntau3 = {:?}\n", start[0], start[1], start[2]);
    run(&folder, &within(&folder, &format!("{LIMITS}[limits.rates]\n{allowed}"))).succeeds();
    let slow = refined(&folder);
    let kept =
        rates(&slow, "after").into_iter().zip(start).all(|(after, start)| after <= start * (1.0 + 1e-9));
    assert!(kept, "{slow}");
    assert!(slow["after"]["value"].as_f64() < slow["before"]["value"].as_f64(), "{slow}");
}

#[test]
fn law_a_start_that_jumps_is_slowed_and_the_result_keeps_its_rates_everywhere() {
    let folder = designed();
    // Full range of an input in two seconds; the maneuvers of the start jump at their joints.
    let allowed = [6500.0, 1600.0, 800.0];
    let rates = "[limits.rates]\ntau1 = 6500.0\ntau2 = 1600.0\ntau3 = 800.0\n";
    run(&folder, &within(&folder, LIMITS)).succeeds();
    let jumps = refined(&folder);
    assert!(jumps.get("slowed").is_none());
    let said = run(&folder, &within(&folder, &format!("{LIMITS}{rates}"))).succeeds();
    let slow = refined(&folder);
    assert!(!slow["slowed"].as_array().unwrap().is_empty(), "{slow}");
    assert!(said.stdout.contains("as fast as their rates allow"), "{}", said.stdout);
    let table = String::from_utf8(bytes(&folder, "refined/inputs.csv")).unwrap();
    let rows: Vec<Vec<f64>> =
        table.lines().skip(1).map(|row| row.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 320);
    for pair in rows.windows(2) {
        for (i, rate) in allowed.iter().enumerate() {
            let change = 8.0 * (pair[1][i] - pair[0][i]).abs();
            assert!(change <= rate * (1.0 + 1e-9), "{pair:?}");
        }
    }
    let value = |of: &Value, when: &str| of[when]["value"].as_f64().unwrap();
    // Nothing worse than its start, and within reach of the experiment that jumps.
    assert!(value(&slow, "after") <= value(&slow, "before"), "{slow}");
    assert!(value(&slow, "after") < 1.5 * value(&jumps, "after"), "{slow}\n{jumps}");
}

#[test]
fn refusals_of_what_to_refine() {
    let folder = designed();
    let try_with = |from: &str, to: &str, pieces: &[&str]| {
        assert!(LIMITS.contains(from));
        refused(&folder, 3, &within(&folder, &LIMITS.replace(from, to)), pieces);
    };
    try_with(
        "u_m_s = 1.2",
        "u_m_s = 0.5",
        &["dictionary.toml", "`u_m_s`", "in the design's experiment", "at most 0.5"],
    );
    try_with("tau3 = 800.0", "tau3 = 100.0", &["dictionary.toml", "`inputs.tau3`", "at most 100"]);
    try_with("tau2 = 1600.0", "tau4 = 1600.0", &["dictionary.toml", "`tau4`", "did you mean `tau"]);
    try_with("v_m_s = 0.3", "w_m_s = 0.3", &["dictionary.toml", "w_m_s", "v_m_s"]);
    try_with("v_m_s = 0.3", "v_m_s = -0.3", &["dictionary.toml", "`limits.v_m_s`", "-0.3", "above 0"]);
    let _ = within(&folder, "");
    refused(&folder, 2, &REFINE.replace("refined/", "."), &["--out", "design.json", "also an input"]);
    refused(&folder, 2, "design --refine design.json --out refined/", &["--vessel", "--help"]);
    let text = std::fs::read_to_string(folder.path().join("campaign.toml")).unwrap();
    put(&folder, "campaign.toml", &text.replace("kind = \"white\"", "kind = \"constant\""));
    refused(
        &folder,
        3,
        &format!("{REFINE} --allow=mixed"),
        &["campaign.toml", "`current.kind`", "a current that lasts"],
    );
    put(&folder, "campaign.toml", &text);
    // Parameters of zero have no relative error.
    let vessel = std::fs::read_to_string(folder.path().join("vessel.toml")).unwrap();
    let paper = std::fs::read_to_string(repository().join("pipelines/paper/vessel.toml")).unwrap();
    assert!(paper.contains("\nvalue = -0.03\n"));
    put(&folder, "vessel.toml", &paper.replace("\nvalue = -0.03\n", "\nvalue = 0.0\n"));
    refused(
        &folder,
        3,
        &format!("{REFINE} --allow=mixed"),
        &["vessel.toml", "`N_uv`", "found 0", "other than 0"],
    );
    put(&folder, "vessel.toml", &vessel);
    edit(&folder, "dictionary.toml", "name = \"", "name = \"renamed ");
    refused(&folder, 3, &format!("{REFINE} --allow=mixed"), &["design.json", "`data.shares`"]);
    assert!(WRITES.iter().all(|name| !folder.path().join("refined").join(name).exists()));
}

#[test]
fn a_start_that_excites_not_every_parameter_is_no_start() {
    let folder = designed();
    let mut design = json(&folder, "design.json");
    design["seal"] = Value::Null;
    let shares = design["data"]["shares"].as_object_mut().unwrap();
    let first = shares.keys().next().unwrap().clone();
    shares.iter_mut().for_each(|(name, share)| *share = f64::from(u8::from(*name == first)).into());
    put(&folder, "design.json", &design.to_string());
    refused(&folder, 4, &within(&folder, LIMITS), &["design.json", "does not distinguish"]);
}

#[test]
fn documents_of_kinds_that_are_gone_are_refused_with_what_writes_them_again() {
    let folder = designed();
    let mut old = json(&folder, "design.json");
    let line = "simulate campaign --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --design old.json --out \
                campaign.parquet";
    for (kind, again) in [
        ("refined/1", "design --refine"),
        ("trust/1", "estimate --fit together"),
        ("search/2", "estimate --structure library"),
        ("crossval/1", "--folds each"),
        ("design-update/1", "--promised design.json"),
        ("average/1", "--structure average"),
        ("tally/1", "monte-carlo"),
        ("compare/1", "validate --model"),
        ("selection/1", "validate --design"),
        ("sequential/1", "monte-carlo"),
        ("follow/1", "plan --rest-of"),
    ] {
        old["schema"] = kind.into();
        put(&folder, "old.json", &old.to_string());
        refused(&folder, 3, line, &["old.json", kind, "design/2", again]);
    }
}
