//! `plan --rest-of` from a place: the rest of a plan from where the ship is.

use serde_json::Value;
use tempfile::TempDir;

use crate::geometry::local_m;
use crate::planned::*;
use crate::support::*;

/// A plan of the small study, and the command that resumes it after `done` steps from `from`.
fn resume(folder: &TempDir, done: usize, from: &str) -> Ran {
    run(
        folder,
        &format!(
            "plan --rest-of plan.json --done {done} --from {from} --vessel vessel.toml --trajectories dictionary.parquet \
             --config plan.toml --out rest.json"
        ),
    )
}

fn planned() -> TempDir {
    let folder = small();
    run(&folder, PLAN).succeeds();
    folder
}

/// The start of step `k`, as `--from`.
fn begin(plan: &Value, k: usize) -> String {
    let leg = &plan["data"]["voyage"]["legs"][k];
    let mode = plan["data"]["steps"][k]["from"]["mode"].as_str().unwrap();
    // A position at rest names no mode.
    let mode = if mode == "at rest" { String::new() } else { format!(",{mode}") };
    format!("{},{},{}{mode}", leg["longitude_deg"], leg["latitude_deg"], leg["heading_deg"])
}

#[test]
fn law_the_rest_of_a_best_plan_is_the_best_rest() {
    let folder = planned();
    let plan = json(&folder, "plan.json");
    let steps = plan["data"]["steps"].as_array().unwrap();
    let last =
        (0..steps.len()).rev().find(|k| plan["data"]["voyage"]["legs"][*k]["informative"] == true).unwrap();
    for done in [0, 1, last / 2, last] {
        resume(&folder, done, &begin(&plan, done)).succeeds();
        let rest = json(&folder, "rest.json");
        let cost = |steps: &[Value]| steps.iter().map(|step| step["cost"].as_f64().unwrap()).sum::<f64>();
        assert_eq!(rest["data"]["status"], "optimal");
        assert_eq!(rest["data"]["cost"].as_f64().unwrap(), cost(&steps[done..]), "after {done} steps");
        let uses = |name: &str| steps[done..].iter().filter(|step| step["action"] == name).count() as u64;
        for (name, count) in rest["data"]["counts"].as_object().unwrap() {
            assert_eq!(count.as_u64().unwrap(), uses(name), "{name} after {done} steps");
        }
    }
}

#[test]
fn law_the_rest_begins_where_the_ship_is() {
    let folder = planned();
    let plan = json(&folder, "plan.json");
    let leg = &plan["data"]["voyage"]["legs"][0];
    let [lon, lat] = ["longitude_deg", "latitude_deg"].map(|key| leg[key].as_f64().unwrap());
    for (east, north) in [(0.0004, 0.0003), (-0.0007, 0.0001), (0.0009, -0.0004)] {
        let at = [lon + east, lat + north];
        resume(&folder, 0, &format!("{},{},0", at[0], at[1])).succeeds();
        let rest = json(&folder, "rest.json");
        let first = &rest["data"]["voyage"]["legs"][0];
        let found = ["longitude_deg", "latitude_deg"].map(|key| first[key].as_f64().unwrap());
        let [x, y] = local_m(at, found);
        assert!(x.hypot(y) < 0.01, "{x} {y}");
        assert_eq!(rest["data"]["counts"], plan["data"]["counts"]);
        // Home is the start of the whole trial, up to a node of the moved lattice.
        let end = rest["data"]["voyage"]["passage"]["legs"].as_array().unwrap().last().unwrap();
        let end = ["longitude_deg", "latitude_deg"].map(|key| end[key].as_f64().unwrap());
        let [x, y] = local_m([24.985, 60.0], end);
        assert!(x.abs() <= 61.0 && y.abs() <= 61.0, "{x} {y}");
    }
}

#[test]
fn a_resume_that_makes_no_sense_is_refused() {
    let folder = planned();
    let plan = json(&folder, "plan.json");
    let steps = plan["data"]["steps"].as_array().unwrap().len();
    let at = begin(&plan, 0);
    resume(&folder, steps + 1, &at).refuses(3, &["plan.json", "--done", &format!("at most {steps}")]);
    resume(&folder, steps, &at).refuses(3, &["plan.json", "--done", "a maneuver that is left to do"]);
    resume(&folder, 1, "25.0,60.0,0").refuses(4, &["plan.toml", "start", "clear"]);
    resume(&folder, 1, "26.0,60.0,0").refuses(3, &["plan.toml", "start", "inside `area`"]);
    resume(&folder, 1, "24.985,60.0,0,full").refuses(3, &["plan.toml", "full"]);
    for wrong in ["24.985,60.0", "here,60.0,0", "24.985,60.0,0,half,0", "nan,60,0"] {
        let ran = resume(&folder, 1, wrong);
        assert!(ran.code == Some(2) && ran.stderr.contains("LONGITUDE,LATITUDE,HEADING"), "{ran}");
    }
    let line = "plan --rest-of plan.json --from -24.985,60.0,0 --vessel vessel.toml --trajectories dictionary.parquet --config plan.toml \
                --out rest.json";
    refused(&folder, 2, line, &["--done: found none", "how many steps", "add --done STEPS"]);
    let before = line.replace("plan --rest-of plan.json", "plan resume --plan plan.json --done 1");
    refused(&folder, 2, &before, &["'resume'"]);
    refused(&folder, 2, "plan --problem plan.json --done 1 --out rest.json", &["--done"]);
    assert!(!folder.path().join("rest.json").exists());
}
