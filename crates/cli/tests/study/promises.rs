//! What designs promise: ranges, motions that inputs miss, and what became of them after the trial.

use std::sync::OnceLock;

use files::{Provenance, read_document};
use seatrial::{ModelDocument, Promised, UpdateError, Updating};
use serde_json::Value;
use tempfile::TempDir;

use crate::support::*;

const MOMENTS: &str = "moments --vessel vessel.toml --trajectories dictionary.parquet --campaign campaign.toml --estimator \
     output-error --out moments.json";
const DESIGN: &str = "design --moments moments.json --for output-error --criterion a-relative --duration-s 125 --out design.json";
/// The model of the trial, with what became of the promise.
const UPDATE: &str = "estimate --fit together --estimator ls --vessel vessel.toml --trajectories campaign.parquet --promised design.json \
     --out pooled.parquet";

const MANEUVERS: &str = "duration_s = 30.0\n
[generate]\ncandidates = 80\nexecuted = \"inputs\"\nstart_m_s = [0.4, 0.8]\n
[generate.limits]\nu_m_s = 1.3\nv_m_s = 0.3\nr_rad_s = 0.5\n";

const CAMPAIGN: &str = "seed = 1\nrealizations = 1\nduration_s = 125.0\n
[current]\nkind = \"white\"\nstd_m_s = 0.158\n
[measurement]\nstd_u_m_s = 0.158\nstd_v_m_s = 0.158\nstd_r_rad_s = 0.158\n
[validation]\nparameter_error_bound = 5.0\nsimulation_error_bound = 0.15\n
[[validation.maneuver]]\nname = \"slow\"\nkind = \"accelerate\"\nduration_s = 20.0\nfrom_m_s = 0.2\nto_m_s = 0.3\n";

/// The paper's vessel with nominal values alone, each a fifth off, and again with the true ones.
fn vessels(folder: &TempDir) {
    let text = std::fs::read_to_string(repository().join("pipelines/paper/vessel.toml")).unwrap();
    let (mut truth, mut count) = (0.0, 0);
    let off = |line: &str| {
        if let Some(value) = line.strip_prefix("value = ") {
            truth = value.parse::<f64>().unwrap();
        }
        if !line.starts_with("nominal = ") {
            return line.to_owned();
        }
        count += 1;
        format!("nominal = {:?}", if count % 2 == 0 { 0.8 * truth } else { 1.2 * truth })
    };
    let all: Vec<String> = text.lines().map(off).collect();
    put(folder, "true.toml", &all.join("\n"));
    let nominal: Vec<String> = all.into_iter().filter(|line| !line.starts_with("value = ")).collect();
    put(folder, "vessel.toml", &nominal.join("\n"));
}

/// A folder with a design for a nominal vessel, and the estimate of one trial of it.
fn sailed() -> TempDir {
    static MADE: OnceLock<Study> = OnceLock::new();
    let make = || {
        let folder = written(1);
        vessels(&folder);
        put(&folder, "dictionary.toml", MANEUVERS);
        put(&folder, "campaign.toml", CAMPAIGN);
        for line in [DICTIONARY, MOMENTS, DESIGN] {
            run(&folder, line).succeeds();
        }
        trial(&folder);
        Study::of(&folder)
    };
    let names = [
        "design.json",
        "moments.json",
        "model.json",
        "campaign.parquet",
        "true.toml",
        "vessel.toml",
        "dictionary.toml",
        "campaign.toml",
    ];
    MADE.get_or_init(make).with(&names)
}

/// Runs the designed trial once with the true vessel, and estimates it.
fn trial(folder: &TempDir) {
    let sail = "simulate campaign --allow=mixed --vessel true.toml --dictionary dictionary.toml --campaign campaign.toml --design \
         design.json --out campaign.parquet";
    let estimate = "estimate --allow=mixed --vessel true.toml --trajectories campaign.parquet --campaign campaign.toml --estimator \
         output-error --out estimates.parquet";
    run(folder, sail).succeeds();
    run(folder, estimate).succeeds();
}

/// What became of the promise of design.json by `model.json`, or why there is nothing to be said.
fn updated(folder: &TempDir, figures: Option<&str>) -> Result<Value, String> {
    let path = |name: &str| folder.path().join(name);
    let mut noted = Provenance { allow_mixed: true, ..Provenance::default() };
    let (design, moments, figures) = (path("design.json"), path("moments.json"), figures.map(path));
    let promised = Promised::read(&design, &moments, figures.as_deref(), &mut noted);
    let promised = promised.map_err(|e| e.to_string())?;
    let model = read_document::<ModelDocument>(path("model.json")).map_err(|e| e.to_string())?.data;
    match Updating::new(&promised).after(&model) {
        Ok(found) => Ok(serde_json::to_value(found).unwrap()),
        Err(UpdateError::Design(e)) => Err(format!("design.json: {e}")),
        Err(UpdateError::Model(e)) => Err(format!("model.json: {e}")),
    }
}

fn data(folder: &TempDir, name: &str) -> Value {
    json(folder, name)["data"].clone()
}

fn number(of: &Value) -> f64 {
    of.as_f64().unwrap_or_else(|| panic!("{of}"))
}

/// Writes `name` again, changed and without its seal.
fn change(folder: &TempDir, name: &str, change: impl Fn(&mut Value)) {
    let mut document = json(folder, name);
    document["seal"] = Value::Null;
    change(&mut document);
    put(folder, name, &document.to_string());
}

#[test]
fn law_a_promise_by_a_guess_has_a_range_and_one_by_the_truth_has_none() {
    let folder = sailed();
    let design = data(&folder, "design.json");
    let promise = &design["promise"];
    let errors = design["covariance"]["standard_errors"].as_object().unwrap();
    let weights = &design["covariance"]["weights"];
    let sum: f64 = errors.iter().map(|(name, e)| number(e).powi(2) * number(&weights[name])).sum();
    assert!((number(&promise["parameter_error"]) - sum.sqrt()).abs() < 1e-9 * sum, "{promise}");
    // By inputs it is wide: promised over found was .26 to 5.4.
    let over = |end: usize| number(&promise["parameter_error"]) / number(&promise["range"][end]);
    assert!((over(0) - 5.4).abs() < 1e-9 && (over(1) - 0.26).abs() < 1e-9, "{promise}");
    let said = run(&folder, &DESIGN.replace("design.json", "again.json")).succeeds();
    assert!(said.stdout.contains("as the nominal model may be off by some 40 %"), "{}", said.stdout);
    // An accuracy has it too.
    run(&folder, &format!("{DESIGN} --accuracy 0.5").replace("--duration-s 125 ", "")).succeeds();
    let accuracy = data(&folder, "design.json")["accuracy"].clone();
    let [low, high] = [0, 1].map(|end| number(&accuracy["range"][end]) / number(&accuracy["reached"]));
    assert!((low * 5.4 - 1.0).abs() < 1e-9 && (high * 0.26 - 1.0).abs() < 1e-9, "{accuracy}");
    // By feedback it is narrower.
    put(&folder, "dictionary.toml", &MANEUVERS.replace("\"inputs\"", "\"feedback\""));
    for line in [DICTIONARY, MOMENTS, DESIGN] {
        run(&folder, line).succeeds();
    }
    let steered = data(&folder, "design.json");
    let factor = number(&steered["promise"]["range"][1]) / number(&steered["promise"]["parameter_error"]);
    assert!((factor - 1.7).abs() < 1e-9, "{steered}");
    assert!(steered.get("unreached").is_none());
    // Where the truth is known, or the criterion predicts nothing, no range is stated.
    run(
        &folder,
        &format!("{DESIGN} --criterion d-hessian").replace("--for output-error --criterion a-relative", ""),
    )
    .succeeds();
    assert!(data(&folder, "design.json").get("promise").is_none());
    let with = |line: &str| line.replace("vessel.toml", "true.toml");
    for line in [with(DICTIONARY), with(MOMENTS), DESIGN.into()] {
        run(&folder, &line).succeeds();
    }
    let known = data(&folder, "design.json");
    assert!(known.get("promise").is_none() && known.get("unreached").is_none(), "{known}");
    assert!(data(&folder, "moments.json").get("sampled").is_none());
}

#[test]
fn law_a_refined_design_promises_the_range_of_inputs_where_its_parameters_are_a_guess() {
    let folder = sailed();
    std::fs::create_dir(folder.path().join("refined")).unwrap();
    let refine = "design --refine design.json --allow=mixed --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --out \
         refined/";
    edit(&folder, "campaign.toml", "duration_s = 125.0", "duration_s = 20.0");
    // Motions by feedback are refined as inputs, too.
    for executed in ["inputs", "feedback"] {
        put(&folder, "dictionary.toml", &MANEUVERS.replace("\"inputs\"", &format!("\"{executed}\"")));
        let said = run(&folder, refine).succeeds();
        let found = data(&folder, "refined/design.json");
        let (promise, error) = (&found["promise"], number(&found["refined"]["after"]["parameter_error"]));
        assert_eq!(number(&promise["parameter_error"]), error);
        let over = |end: usize| error / number(&promise["range"][end]);
        assert!((over(0) - 5.4).abs() < 1e-9 && (over(1) - 0.26).abs() < 1e-9, "{promise}");
        let stated = promise["statement"].as_str().unwrap();
        assert!(
            said.stdout.contains(stated) && !found["statement"].to_string().contains(stated),
            "{}",
            said.stdout
        );
    }
    for known in ["true.toml", "model.json"] {
        let said = run(&folder, &refine.replace("vessel.toml", known)).succeeds();
        assert!(!said.stdout.contains("Promised"), "{known}: {}", said.stdout);
        assert!(data(&folder, "refined/design.json").get("promise").is_none(), "{known}");
    }
}

#[test]
fn law_motions_that_ships_miss_are_warned_of_with_a_remedy() {
    let folder = sailed();
    let found = data(&folder, "design.json")["unreached"].clone();
    assert_eq!(found["from"], "nominal");
    let motions = found["motions"].as_array().unwrap();
    assert!(!motions.is_empty());
    let design = data(&folder, "design.json");
    for motion in motions {
        let share = number(&motion["missed"]["share"]);
        assert!(share >= 0.25, "{motion}");
        let [low, high] = [0, 1].map(|end| number(&motion["missed"]["interval"][end]));
        assert!(low < share && share < high, "{motion}");
        assert!(number(&design["shares"][motion["maneuver"].as_str().unwrap()]) > 0.0, "{motion}");
    }
    let said = found["statement"].as_str().unwrap();
    assert!(said.contains("executed = \"feedback\"") && said.contains("of 64 ships"), "{said}");
    // A model of which little is uncertain reaches its motions, and promises without a guess.
    change(&folder, "model.json", |model| {
        let names: Vec<String> = standard_errors(&model["data"]).into_iter().map(|(name, _)| name).collect();
        let n = names.len();
        let zeros: Vec<f64> = vec![0.0; n * n];
        model["data"]["covariance"] = serde_json::json!({"joint": true, "names": names, "entries": zeros});
    });
    let next = |line: &str| line.replace("--vessel vessel.toml", "--vessel model.json");
    for line in [next(DICTIONARY), next(MOMENTS), DESIGN.into()] {
        run(&folder, &line).succeeds();
    }
    let sampled = data(&folder, "moments.json")["sampled"].clone();
    assert_eq!(sampled["from"], "covariance");
    let by_inputs = sampled["by_inputs"].as_array().unwrap();
    assert!(by_inputs.len() > 10);
    let missed = |motion: &Value| {
        motion["missed"].as_array().unwrap().iter().map(|m| m["ships"].as_u64().unwrap()).sum::<u64>()
    };
    assert_eq!(by_inputs.iter().map(missed).sum::<u64>(), 0);
    let design = data(&folder, "design.json");
    assert!(design.get("promise").is_none() && design.get("unreached").is_none(), "{design}");
}

#[test]
fn law_standard_maneuvers_are_not_played_by_inputs() {
    let folder = sailed();
    let zig_zag = "name = \"zig-zag\"\nkind = \"zig-zag-test\"\nspeed_m_s = 0.6\nhelm = { tau3 = 30.0 }\nheading_rad = 0.2";
    let written = "name = \"steady\"\nkind = \"steady-turn\"\nspeed_m_s = 0.6\nyaw_rate_rad_s = 0.1";
    put(
        &folder,
        "dictionary.toml",
        &format!("duration_s = 40.0\n[[maneuver]]\n{zig_zag}\n[[maneuver]]\n{written}\n"),
    );
    run(&folder, &format!("{DICTIONARY} --allow=unreached")).succeeds();
    run(&folder, MOMENTS).succeeds();
    let sampled = data(&folder, "moments.json")["sampled"].clone();
    let names: Vec<&Value> =
        sampled["by_inputs"].as_array().unwrap().iter().map(|own| &own["maneuver"]).collect();
    assert_eq!(names, ["steady"], "{sampled}");
}

#[test]
fn oracle_an_update_compares_promised_and_estimated_errors_over_fixed_scales() {
    let folder = sailed();
    let found = updated(&folder, None).unwrap();
    let (model, design) = (data(&folder, "model.json"), data(&folder, "design.json"));
    let vessel: toml::Value =
        toml::from_str(&String::from_utf8(bytes(&folder, "vessel.toml")).unwrap()).unwrap();
    let nominal = |name: &str| {
        let terms = ["surge", "sway", "yaw"].iter().flat_map(|degree| vessel[*degree].as_array().unwrap());
        let own = terms.into_iter().find(|term| term["parameter"].as_str() == Some(name)).unwrap();
        own["nominal"].as_float().unwrap()
    };
    let degrees = model["degrees"].as_array().unwrap().iter();
    let estimated: Vec<&Value> =
        degrees.flat_map(|degree| degree["parameters"].as_array().unwrap()).collect();
    let (samples, mut before, mut now) = (number(&model["samples"]), 0.0, 0.0);
    let shorter = (number(&design["covariance"]["samples"]) / samples).sqrt();
    for (own, parameter) in estimated.iter().zip(found["parameters"].as_array().unwrap()) {
        let name = own["name"].as_str().unwrap();
        let promised = shorter * number(&design["covariance"]["standard_errors"][name]);
        let error = number(&own["standard_error"]);
        let stated = &parameter["standard_error"];
        assert_eq!(parameter["name"], name);
        assert!((number(&parameter["scale"]) / nominal(name).abs() - 1.0).abs() < 1e-12, "{parameter}");
        assert!((number(&stated["promised"]) / promised - 1.0).abs() < 1e-12, "{parameter}");
        assert!((number(&stated["ratio"]) / (promised / error) - 1.0).abs() < 1e-9, "{parameter}");
        before += (promised / nominal(name)).powi(2);
        now += (error / nominal(name)).powi(2);
    }
    let all = &found["parameter_error"];
    assert!((number(&all["promised"]) - before.sqrt()).abs() < 1e-9, "{all}");
    assert!((number(&all["now"]) - now.sqrt()).abs() < 1e-9, "{all}");
    // The criterion a-relative is that of the same scales.
    assert!((number(&found["criterion"]["error"]["now"]) / now.sqrt() - 1.0).abs() < 1e-9, "{found}");
    assert!((number(&found["after_another"]) - now.sqrt() / 2.0_f64.sqrt()).abs() < 1e-9);
    assert!((number(&found["duration_s"]) - samples / 8.0).abs() < 1e-9);
}

/// By another vessel.toml than the design's, from whose files the trial was not made otherwise.
#[test]
fn an_estimate_of_all_says_what_became_of_the_promise_of_its_design() {
    let folder = sailed();
    let line = UPDATE.replace("vessel.toml", "true.toml");
    for fit in ["--fit together", "--fit each"] {
        let line = line.replace("--fit together", fit);
        let said = run(&folder, &format!("{line} --allow=mixed")).succeeds();
        let promise = data(&folder, "pooled-estimate.json")["promise"].clone();
        assert!(said.stdout.contains(promise["statement"].as_str().unwrap()), "{promise}{said}");
        std::fs::copy(folder.path().join("pooled-model.json"), folder.path().join("model.json")).unwrap();
        assert_eq!(promise, updated(&folder, None).unwrap());
    }
}

#[test]
fn oracle_figures_of_an_update_have_the_errors_that_slopes_and_covariance_give() {
    let folder = sailed();
    let circle = "name = \"circle\"\nkind = \"turning-circle\"\nspeed_m_s = 0.6\nhelm = { tau3 = 150.0 }\nduration_s = 120.0";
    put(&folder, "circle.toml", &format!("[[maneuver]]\n{circle}\n"));
    let slopes =
        "validate merit --vessel vessel.toml --dictionary circle.toml --length-m 2 --slopes --out merit.json";
    run(&folder, slopes).succeeds();
    run(&folder, &format!("{DESIGN} --figures merit.json")).succeeds();
    trial(&folder);
    let update = || updated(&folder, Some("merit.json")).unwrap();
    // The estimate of one run has standard errors without covariances.
    figures_follow(&folder, &update(), 0.0);
    change(&folder, "model.json", |model| correlate(model, -0.6));
    figures_follow(&folder, &update(), -0.6);
    // Without the file they are left out, and the update says so.
    let without = updated(&folder, None).unwrap();
    assert!(without.get("figures").is_none_or(|all| all.as_array().unwrap().is_empty()), "{without}");
    assert!(without["statements"].to_string().contains("without --figures"), "{without}");
}

/// Names and standard errors of the parameters of a `model.json`.
fn standard_errors(model: &Value) -> Vec<(String, f64)> {
    let degrees = model["degrees"].as_array().unwrap().iter();
    let all = degrees.flat_map(|degree| degree["parameters"].as_array().unwrap());
    all.map(|own| (own["name"].as_str().unwrap().to_owned(), number(&own["standard_error"]))).collect()
}

/// Gives a model a covariance in which parameters that are k apart have the correlation `next`ᵏ, the last parameter first.
fn correlate(model: &mut Value, next: f64) {
    let mut own = standard_errors(&model["data"]);
    own.reverse();
    let entry = |i: usize, j: usize| own[i].1 * own[j].1 * next.powi(i.abs_diff(j) as i32);
    let n = own.len();
    let entries: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
    let names: Vec<&str> = own.iter().map(|(name, _)| name.as_str()).collect();
    model["data"]["covariance"] = serde_json::json!({"joint": true, "names": names, "entries": entries});
}

/// Compares the figures of the update `found` with gᵀCg: slopes g of `merit.json`, C as [`correlate`] gives it to `model.json`.
fn figures_follow(folder: &TempDir, found: &Value, next: f64) {
    let of = |name: &str| data(folder, name);
    let (merit, model, design) = (of("merit.json"), of("model.json"), of("design.json"));
    let errors = standard_errors(&model);
    let shorter = (number(&design["figures"]["samples"]) / number(&model["samples"])).sqrt();
    let figures = found["figures"].as_array().unwrap();
    assert!(figures.len() > 3, "{found}");
    for own in figures {
        let same = |all: &Value| {
            all.as_array().unwrap().iter().find(|other| other["name"] == own["name"]).unwrap().clone()
        };
        let figure = same(&merit["maneuvers"][0]["figures"]);
        // Distances are in ship lengths there, in metres here.
        let metres = if figure["unit"] == "L" { number(&merit["length_m"]) } else { 1.0 };
        let share = |(name, error): &(String, f64)| metres * number(&figure["slopes"][name]) * error;
        let shares: Vec<f64> = errors.iter().map(share).collect();
        let products = |i: usize| {
            let one = |(j, share): (usize, &f64)| share * next.powi(i.abs_diff(j) as i32);
            shares[i] * shares.iter().enumerate().map(one).sum::<f64>()
        };
        let now = (0..shares.len()).map(products).sum::<f64>().sqrt();
        let stated = &own["standard_error"];
        assert!(now > 0.0 && (number(&stated["now"]) / now - 1.0).abs() < 1e-9, "{own}: {now}");
        let promised = shorter * number(&same(&design["figures"]["figures"])["standard_error"]);
        assert!((number(&stated["promised"]) / promised - 1.0).abs() < 1e-9, "{own}: {promised}");
    }
}

#[test]
fn law_the_time_that_is_left_follows_from_the_error_that_was_reached() {
    let folder = sailed();
    run(&folder, &format!("{DESIGN} --accuracy 0.3").replace("--duration-s 125 ", "")).succeeds();
    let found = updated(&folder, None).unwrap();
    let accuracy = &found["accuracy"];
    let needed = number(&found["duration_s"]) * (number(&accuracy["reached"]) / 0.3).powi(2);
    assert!((number(&accuracy["needed_s"]) / needed - 1.0).abs() < 1e-12, "{accuracy}");
    let left = number(&accuracy["needed_s"]) - number(&found["duration_s"]);
    assert!((number(&accuracy["remaining_s"]) - left.max(0.0)).abs() < 1e-9, "{accuracy}");
    assert_eq!(accuracy["reached"], found["parameter_error"]["now"]);
    // A determinant needs the covariances between parameters, which the estimate of one run has not.
    run(&folder, &DESIGN.replace("a-relative", "d")).succeeds();
    let why = updated(&folder, None).unwrap_err();
    for piece in ["model.json", "`data.covariance`", "found none", "criterion d", "estimate --fit together"] {
        assert!(why.contains(piece), "{piece}: {why}");
    }
}

#[test]
fn refusals_of_updates() {
    let folder = sailed();
    let is_refused = |pieces: &[&str]| {
        let why = updated(&folder, None).unwrap_err();
        pieces.iter().for_each(|piece| assert!(why.contains(piece), "{piece}: {why}"));
    };
    let try_model = |broken: &dyn Fn(&mut Value), pieces: &[&str]| {
        let before = String::from_utf8(bytes(&folder, "model.json")).unwrap();
        change(&folder, "model.json", broken);
        is_refused(&[&["model.json"], pieces].concat());
        put(&folder, "model.json", &before);
    };
    try_model(&|m| m["data"]["vessel"] = "another".into(), &["`data.vessel`", "`another`", "moments"]);
    try_model(&|m| m["data"]["sample_rate_hz"] = 4.0.into(), &["`data.sample_rate_hz`", "4 Hz", "8 Hz"]);
    try_model(
        &|m| m["data"]["degrees"][0]["parameters"][0]["standard_error"] = Value::Null,
        &["`X_u`", "no standard error", "estimate --fit together"],
    );
    try_model(
        &|m| m["data"]["degrees"][0]["parameters"][0]["name"] = "X_other".into(),
        &["parameter `X_u`", "found none", "an estimate"],
    );
    try_model(
        &|m| m["data"]["degrees"][0]["parameters"][0]["fixed"] = true.into(),
        &["parameter `X_u`", "not estimated"],
    );
    try_model(&|m| m["data"]["samples"] = 0.into(), &["`data.samples`", "found 0"]);
    let covariance = |m: &mut Value, entries: &dyn Fn(usize, usize) -> f64, all: bool| {
        let degrees = m["data"]["degrees"].as_array().unwrap().iter();
        let names: Vec<Value> = degrees
            .flat_map(|degree| degree["parameters"].as_array().unwrap().iter().map(|p| p["name"].clone()))
            .skip(usize::from(!all))
            .collect();
        let n = names.len();
        let entries: Vec<f64> = (0..n * n).map(|k| entries(k / n, k % n)).collect();
        m["data"]["covariance"] = serde_json::json!({"joint": true, "names": names, "entries": entries});
    };
    let one = |i: usize, j: usize| f64::from(u8::from(i == j));
    try_model(
        &|m| covariance(m, &|i, j| -one(i, j), true),
        &["`data.covariance`", "a variance of -1", "`X_u`"],
    );
    try_model(
        &|m| covariance(m, &|i, j| if i + j == 1 { 2.0 } else { one(i, j) }, true),
        &["`data.covariance`", "2 between", "more than they vary"],
    );
    try_model(&|m| covariance(m, &one, false), &["`data.covariance`", "no `X_u`"]);
    // A trial of another design.
    run(&folder, &DESIGN.replace("--duration-s 125", "--duration-s 250")).succeeds();
    refused(&folder, 3, UPDATE, &["campaign.parquet"]);
    // A design without promise.
    run(&folder, "design --moments moments.json --out design.json").succeeds();
    is_refused(&["design.json", "`data.covariance`", "no promise", "--campaign"]);
    // Other moments.
    run(&folder, DESIGN).succeeds();
    run(&folder, DICTIONARY).succeeds();
    run(&folder, &MOMENTS.replace(" --estimator output-error", "")).succeeds();
    refused(&folder, 3, UPDATE, &["moments"]);
}
