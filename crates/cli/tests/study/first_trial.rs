//! The chain before the first trial of a ship with forces: information, design, campaign, estimates, scores.

use serde_json::Value;
use tempfile::TempDir;

use crate::support::*;

const SIMULATE: &str =
    "simulate dictionary --vessel vessel.toml --dictionary dictionary.toml --out d.parquet";
const MOMENTS: &str = "moments --vessel vessel.toml --trajectories d.parquet --campaign campaign.toml --estimator output-error --out moments.json";
const DESIGN: &str = "design --moments moments.json --for output-error --out design.json";
const CAMPAIGN: &str = "simulate campaign --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --design design.json --out campaign.parquet";
const ESTIMATE: &str = "estimate --vessel vessel.toml --trajectories campaign.parquet --campaign campaign.toml --out estimates.parquet";

/// A study of Otter with a white current, sampled at 5 Hz.
fn otter(realizations: u32) -> TempDir {
    let folder = TempDir::new().unwrap();
    put(&folder, "vessel.toml", "preset = \"otter\"\nsample_rate_hz = 5.0\n");
    let maneuver = |name: &str, rest: &str| format!("[[maneuver]]\nname = \"{name}\"\n{rest}\n");
    let turn = "speed_m_s = 1.5\nduration_s = 20.0\nhelm = { n1 = 10.0, n2 = -10.0 }\n";
    let all = [
        maneuver("zig-zag", &format!("kind = \"zig-zag-test\"\nheading_rad = 0.35\n{turn}")),
        maneuver("circle", &format!("kind = \"turning-circle\"\nturn_rad = 1.5\n{turn}")),
        maneuver("accelerate", "kind = \"accelerate\"\nfrom_m_s = 1.0\nto_m_s = 2.0\nduration_s = 20.0\n"),
    ];
    put(&folder, "dictionary.toml", &all.concat());
    let campaign = format!(
        "seed = 1\nrealizations = {realizations}\nduration_s = 120.0\n[current]\nkind = \"white\"\nstd_m_s = 0.01\n[measurement]\n\
         std_u_m_s = 0.03\nstd_v_m_s = 0.02\nstd_r_rad_s = 0.01\n[random]\nsegments = 6\n[validation]\n\
         parameter_error_bound = 0.2\nsimulation_error_bound = 0.05\n[[validation.maneuver]]\nname = \"v\"\n\
         kind = \"turning-circle\"\nspeed_m_s = 1.8\nduration_s = 20.0\nturn_rad = 1.0\nhelm = {{ n1 = 8.0, n2 = -8.0 }}\n"
    );
    put(&folder, "campaign.toml", &campaign);
    folder
}

/// With half as much known of each number before as she is published with.
fn priors(folder: &TempDir) {
    let text = std::fs::read_to_string(repository().join("crates/ship/presets/otter.toml")).unwrap();
    let text = text.replace("sample_rate_hz = 20.0", "sample_rate_hz = 5.0");
    let line = |line: &str| match line.split_once("nominal = ").and_then(|(_, rest)| rest.split_once(',')) {
        Some((nominal, _)) if line.contains("parameter") => {
            let prior = 0.5 * nominal.parse::<f64>().unwrap().abs();
            line.replace(" },", &format!(", prior = {prior} }},")) + "\n"
        }
        _ => line.to_owned() + "\n",
    };
    put(folder, "vessel.toml", &text.lines().map(line).collect::<String>());
}

fn designed<'a>(document: &'a Value, key: &str) -> &'a Value {
    let all = document["data"]["designs"].as_array().unwrap();
    &all.iter().find(|own| own["design"] == "optimized").unwrap()[key]
}

fn numbers(of: &Value) -> Vec<f64> {
    of.as_object().unwrap().values().map(|own| own.as_f64().unwrap()).collect()
}

#[test]
fn law_a_designed_trial_errs_as_predicted() {
    let folder = otter(96);
    for line in [SIMULATE, MOMENTS, &format!("{DESIGN} --duration-s 120"), CAMPAIGN, ESTIMATE] {
        run(&folder, line).succeeds();
    }
    let design = json(&folder, "design.json");
    assert!(design["data"].get("prior").is_none());
    assert_eq!(design["data"]["estimator"], "output-error");
    let predicted = &design["data"]["covariance"]["standard_errors"];
    let found = json(&folder, "estimate.json");
    let parameters = designed(&found, "parameters").as_array().unwrap();
    assert_eq!(parameters.len(), 4);
    for own in parameters {
        let [spread, stated] = ["spread", "predicted_se"].map(|key| own[key].as_f64().unwrap());
        let promised = predicted[own["name"].as_str().unwrap()].as_f64().unwrap();
        println!("{}: {promised} promised, {stated} stated, {spread} found", own["name"]);
        // Of 96 trials a standard deviation has a 99.7 % interval of 22 %. In a trial a maneuver begins where the last one ended.
        assert!((spread / stated - 1.0).abs() < 0.22, "{own:#}");
        assert!((spread / promised - 1.0).abs() < 0.35, "{own:#}: {promised}");
    }
}

#[test]
fn the_chain_of_a_ship_with_forces_goes_from_design_to_scores() {
    let folder = otter(6);
    priors(&folder);
    for line in [SIMULATE, MOMENTS] {
        run(&folder, line).succeeds();
    }
    let moments = json(&folder, "moments.json");
    let own = &moments["data"]["maneuvers"][0];
    assert!(own.get("degrees").is_none() && moments["data"].get("instruments").is_none());
    assert_eq!(own["output_error"]["F"].as_array().unwrap().len(), 16);
    let prior = &moments["data"]["prior"];
    assert_eq!(["parameters", "information"].map(|own| prior[own].as_array().unwrap().len()), [4, 16]);
    refused(&folder, 2, &format!("{DESIGN} --accuracy 0.1"), &["--duration-s", "priors of Otter count once"]);
    // Its length is that of the campaign's trials, if none is said.
    run(&folder, DESIGN).succeeds();
    let own = json(&folder, "design.json")["data"]["shares"].clone();
    let said = run(&folder, &format!("{DESIGN} --duration-s 120")).succeeds();
    assert!(said.stdout.contains("The trial contributes more than the prior"), "{said}");
    assert_eq!(own, json(&folder, "design.json")["data"]["shares"]);
    let shares = |name: &str| numbers(&json(&folder, name)["data"]["prior"]["shares"]);
    run(&folder, "design --moments moments.json --for output-error --duration-s 2 --out short.json")
        .succeeds();
    let (long, short) = (shares("design.json"), shares("short.json"));
    assert!(long.iter().zip(&short).all(|(long, short)| 0.0 < *long && long < short && *short < 1.0));
    run(&folder, "design --moments moments.json --for output-error --segments 6 --segment-samples 100 --out counts.json")
        .succeeds();
    // The design of the same vessel is taken as it is.
    for line in [CAMPAIGN, ESTIMATE] {
        run(&folder, line).succeeds();
    }
    run(
        &folder,
        "simulate validation --vessel vessel.toml --campaign campaign.toml --out validation.parquet",
    )
    .succeeds();
    run(
        &folder,
        "validate --vessel vessel.toml --campaign campaign.toml --estimates estimates.parquet --validation validation.parquet --out scores.parquet",
    )
    .succeeds();
    let scored = json(&folder, "validation.json");
    run(&folder, "monte-carlo --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --design design.json --estimator output-error --out counted.json").succeeds();
    let tally = json(&folder, "counted.json");
    let own = tally["data"]["counted"]["scores"][0]["designs"].as_array().unwrap();
    assert!(own.iter().all(|own| own["runs"] == 6 && own["not_converged"] == 0), "{tally:#}");
    assert!(scored["data"].to_string().contains("optimized"), "{scored:#}");
    run(&folder, "report --study . --results . --out report.html").succeeds();
    // Again, and with one thread, the bytes are the same.
    let first = bytes(&folder, "estimates.parquet");
    run(&folder, &format!("{ESTIMATE} --threads 1")).succeeds();
    assert_eq!(first, bytes(&folder, "estimates.parquet"));
    let moments = bytes(&folder, "moments.json");
    for shard in ["1/2", "2/2"] {
        run(
            &folder,
            &MOMENTS
                .replace("--out moments.json", &format!("--shard {shard} --out part-{}.json", &shard[..1])),
        )
        .succeeds();
    }
    run(&folder, &MOMENTS.replace("--out moments.json", "--gather part-1.json part-2.json --out whole.json"))
        .succeeds();
    assert_eq!(moments, bytes(&folder, "whole.json"));
}

#[test]
fn what_forces_do_not_have_is_refused_by_name() {
    let folder = otter(2);
    run(&folder, SIMULATE).succeeds();
    let iv = MOMENTS.replace("--estimator output-error", "");
    refused(&folder, 3, &iv, &["vessel.toml", "`iv` computes", "add --estimator output-error"]);
    refused(
        &folder,
        2,
        &format!("{MOMENTS} --nominal least-squares"),
        &["--nominal", "a vessel with forces"],
    );
    let (noisy, calm) = ("std_u_m_s = 0.03", "std_u_m_s = 0.0");
    edit(&folder, "campaign.toml", noisy, calm);
    refused(&folder, 3, MOMENTS, &["campaign.toml", "`measurement.std_u_m_s`", "noise in every state"]);
    edit(&folder, "campaign.toml", calm, noisy);
    // Of a current that lasts nothing is predicted, and that is said.
    let (white, lasting) = ("kind = \"white\"", "kind = \"constant\"\naxes = \"earth\"");
    edit(&folder, "campaign.toml", white, lasting);
    let said = run(&folder, MOMENTS).succeeds();
    assert!(said.stdout.contains("of measurement errors alone, not of the current that lasts"), "{said}");
    let expected = &json(&folder, "moments.json")["data"]["disturbances"];
    assert!(expected["current_std_m_s"] == 0.0 && expected["lasting_current_left_out"] == true, "{expected}");
    edit(&folder, "campaign.toml", lasting, white);
    run(&folder, MOMENTS).succeeds();
    refused(
        &folder,
        3,
        "design --moments moments.json --out design.json",
        &["moments.json", "terms per sample", "--for output-error"],
    );
    run(&folder, &format!("{DESIGN} --duration-s 120")).succeeds();
    run(&folder, CAMPAIGN).succeeds();
    for estimator in ["ls", "iv", "prediction-error"] {
        let words = ["vessel.toml", &format!("`{estimator}` computes"), "take the estimator `output-error`"];
        refused(&folder, 3, &format!("{ESTIMATE} --estimator {estimator}"), &words);
    }
    let tally = format!(
        "{} --out validation.json",
        CAMPAIGN.replace("simulate campaign", "monte-carlo").replace(" --out campaign.parquet", "")
    );
    refused(&folder, 3, &tally, &["vessel.toml", "`iv` computes", "take the estimator `output-error`"]);
    let unstated = ESTIMATE.replace("--campaign campaign.toml", "");
    refused(&folder, 3, &unstated, &["campaign.parquet", "none stated", "add --campaign"]);
    refused(
        &folder,
        3,
        &format!("{ESTIMATE} --unknown-current earth"),
        &["campaign.parquet", "additional ones"],
    );
    let measured = MOMENTS.replace("d.parquet", "campaign.parquet");
    refused(&folder, 3, &measured, &["campaign.parquet", "`simulate dictionary`"]);
}

/// Stages that compute with terms alone, and what their remedies name.
const OF_TERMS: [(&str, &str, &str); 3] = [
    (
        "monte-carlo --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --out s.parquet",
        "`trials in rounds` computes",
        "`monte-carlo --estimator output-error`",
    ),
    (
        "design --refine design.json --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --out refined/",
        "`design --refine` computes",
        "`design --for output-error`",
    ),
    (
        "validate --vessel vessel.toml --trajectories d.parquet --design design.json --out s.parquet",
        "`validate --design` computes",
        "`estimate --folds`",
    ),
];

#[test]
fn what_serves_a_ship_with_forces_instead_of_stages_of_terms_is_true() {
    let folder = otter(2);
    std::fs::create_dir(folder.path().join("refined")).unwrap();
    in_rounds(&folder, FEW_ROUNDS);
    for (line, computes, instead) in OF_TERMS {
        refused(&folder, 3, line, &["vessel.toml", computes, instead, "or give it a vessel with terms"]);
    }
    for line in [SIMULATE, MOMENTS, &format!("{DESIGN} --duration-s 120")] {
        run(&folder, line).succeeds();
    }
    let tally =
        CAMPAIGN.replace("simulate campaign", "monte-carlo").replace("campaign.parquet", "validation.json");
    run(&folder, &format!("{tally} --estimator output-error")).succeeds();
    priors(&folder);
    let cross = "estimate --structure own --folds each --vessel vessel.toml --trajectories d.parquet --allow=mixed --window-s 10 --out scores.json";
    run(&folder, cross).succeeds();
}
