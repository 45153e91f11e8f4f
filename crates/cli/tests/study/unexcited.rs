//! Parameters that no maneuver excites apart from the others are held, and named.

use serde_json::Value;
use tempfile::TempDir;

use crate::support::*;

const DESIGNED: &str = "design --moments moments.json --for output-error --duration-s 125 --out design.json";
const MONTE_CARLO: &str = "monte-carlo --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml \
     --design design.json --estimator output-error --out validation.json";

/// Ahead alone, where |u| r is u r.
const AHEAD: &str = "duration_s = 30.0\n
[generate]\ncandidates = 60\nkinds = [\"zig-zag\", \"pseudo-random-binary\", \"combined\"]\nspeed_m_s = [0.5, 1.1]\n\
     start_m_s = [0.6, 1.0]\n
[generate.limits]\nu_m_s = 1.4\nv_m_s = 0.4\nr_rad_s = 0.5\n";

fn moments(flags: &str) -> String {
    format!(
        "moments --vessel vessel.toml --trajectories dictionary.parquet --campaign campaign.toml --estimator output-error \
         {flags} --out moments.json"
    )
}

/// The paper's ship with a term that differs from another astern alone; `keys` of it.
fn ahead(keys: &str) -> TempDir {
    let folder = written(2);
    let text = std::fs::read_to_string(repository().join("pipelines/paper/vessel.toml")).unwrap();
    let term = format!(
        "[[sway]]\nparameter = \"Y_abs_u_r\"\nterm = \"|u| r\"\nvalue = 0.002\nnominal = 0.002\n{keys}\n"
    );
    put(&folder, "vessel.toml", &format!("{text}\n{term}"));
    put(&folder, "dictionary.toml", AHEAD);
    run(&folder, DICTIONARY).succeeds();
    folder
}

#[test]
fn law_a_design_that_holds_a_parameter_is_that_of_a_vessel_in_which_it_is_fixed() {
    let folder = ahead("");
    // Of maneuvers in parts none is held.
    for (flags, out) in
        [("--shard 1/2", "one"), ("--shard 2/2", "other"), ("--gather one.json other.json", "moments")]
    {
        run(&folder, &moments(flags).replace("--out moments", &format!("--out {out}"))).succeeds();
    }
    run(&folder, DESIGNED).refuses(4, &["no maneuver excites", "(sway)", "add a maneuver"]);
    let said = run(&folder, &moments("")).succeeds();
    let words = "no maneuver excites `Y_abs_u_r` (`|u| r` in sway) apart from the others: is held at the model's values";
    assert!(said.stdout.contains(words), "{said}");
    let said = run(&folder, DESIGNED).succeeds();
    assert!(said.stdout.contains(words), "{said}");
    let design = json(&folder, "design.json");
    assert_eq!(design["data"]["held"][0]["parameter"], "Y_abs_u_r");
    run(&folder, MONTE_CARLO).succeeds();
    let tally = json(&folder, "validation.json");

    let fixed = ahead("fixed = true");
    let said = run(&fixed, &moments("")).succeeds();
    assert!(!said.stdout.contains("excites"), "{said}");
    run(&fixed, DESIGNED).succeeds();
    let own = json(&fixed, "design.json");
    assert_eq!(own["data"].get("held"), None);
    let shares = |of: &Value| of["data"]["shares"].as_object().unwrap().clone();
    assert_eq!(shares(&own).len(), shares(&design).len());
    for (name, share) in shares(&own) {
        let other = design["data"]["shares"][&name].as_f64().unwrap();
        assert!((share.as_f64().unwrap() - other).abs() < 1e-6, "{name}: {share} {other}");
    }
    run(&fixed, MONTE_CARLO).succeeds();
    let counted =
        |of: &Value| of["data"]["counted"]["scores"][0]["designs"][0]["not_identifiable"].as_u64().unwrap();
    assert_eq!(counted(&json(&fixed, "validation.json")), counted(&tally));
}
