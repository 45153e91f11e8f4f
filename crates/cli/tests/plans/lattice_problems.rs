//! `plan --problem`, its plans replayed from the problem's file alone.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::planned::{PLAN, small, small_with};
use crate::support::*;

pub const SOLVE: &str = "plan --problem problem.json --out plan.json";

/// The problems of the repository and, if available, the shared ones.
fn problems() -> Vec<PathBuf> {
    let shared = repository().join("../shared/data/lattice");
    let folders = [repository().join("fixtures/lattice"), shared];
    let mut files = Vec::new();
    for folder in folders {
        match fs::read_dir(&folder) {
            Ok(entries) => files.extend(entries.map(|e| e.unwrap().path())),
            Err(e) => println!("skipped: {}: {e}", folder.display()),
        }
    }
    files.retain(|file| file.extension().is_some_and(|e| e == "json"));
    files.sort();
    files
}

/// Replays the plan's moves on the problem's map, and returns their cost.
///
/// # Panics
/// At the first move that the problem does not allow, and at a wrong end.
pub fn replay(problem: &Value, plan: &Value) -> f64 {
    let numbers =
        |v: &Value| -> Vec<i64> { v.as_array().unwrap().iter().map(|n| n.as_i64().unwrap()).collect() };
    let actions = ["informative", "basic"].map(|kind| problem[kind].as_array().unwrap());
    let mut at = numbers(&problem["start"]);
    let mut cost = 0.0;
    let mut uses: BTreeMap<&str, i64> = BTreeMap::new();
    for step in plan["steps"].as_array().unwrap() {
        let action = actions.iter().copied().flatten().find(|a| a["name"] == step["action"]).unwrap();
        let moves = action["moves"].as_array().unwrap().iter().filter(|m| m["h"] == at[2]);
        let own =
            moves.clone().nth(step["variant"].as_u64().unwrap() as usize).unwrap_or_else(|| panic!("{step}"));
        assert_eq!(numbers(&json!([step["from"]["i"], step["from"]["j"], step["from"]["h"]])), at, "{step}");
        let int = |key: &str| own[key].as_i64().unwrap();
        assert_is_free(problem, &at, own);
        at = vec![at[0] + int("di"), at[1] + int("dj"), int("to_h")];
        let size = ["nx", "ny"].map(|key| problem["lattice"][key].as_i64().unwrap());
        assert!((0..2).all(|k| (0..size[k]).contains(&at[k])), "off the lattice: {step}");
        assert_eq!(numbers(&json!([step["to"]["i"], step["to"]["j"], step["to"]["h"]])), at, "{step}");
        assert_eq!(step["cost"].as_f64(), action["cost"].as_f64(), "{step}");
        cost += action["cost"].as_f64().unwrap();
        *uses.entry(step["action"].as_str().unwrap()).or_default() += 1;
    }
    assert_eq!(at, numbers(&problem["goal"]), "the plan ends elsewhere");
    for action in actions[0] {
        let used = uses.get(action["name"].as_str().unwrap()).copied().unwrap_or(0);
        assert_eq!(used, action["count"].as_i64().unwrap(), "{}", action["name"]);
        if used > 0 {
            assert_eq!(plan["counts"][action["name"].as_str().unwrap()], used);
        }
    }
    cost
}

fn assert_is_free(problem: &Value, at: &[i64], own: &Value) {
    let of = |v: &Value| -> Vec<f64> { v.as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect() };
    let (origin, bounds) = (of(&problem["lattice"]["origin"]), of(&problem["bounds"]));
    let pitch = problem["lattice"]["cell"].as_f64().unwrap();
    let node = [0, 1].map(|k| origin[k] + pitch * at[k] as f64);
    for swept in own["swept"].as_array().unwrap() {
        let swept: Vec<f64> = of(swept).iter().enumerate().map(|(k, s)| s + node[k % 2]).collect();
        let inside = (0..2).all(|k| swept[k] >= bounds[k] && swept[k + 2] <= bounds[k + 2]);
        assert!(inside, "{swept:?} leaves the bounds");
        for obstacle in problem["obstacles"].as_array().unwrap() {
            let obstacle = of(obstacle);
            let meets = (0..2).all(|k| swept[k] < obstacle[k + 2] && obstacle[k] < swept[k + 2]);
            assert!(!meets, "{swept:?} meets {obstacle:?}");
        }
    }
}

fn folder_with(problem: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "problem.json", problem);
    folder
}

#[test]
fn the_known_problems_are_solved_at_their_cost_or_said_to_have_no_plan() {
    let mut solved = 0;
    for file in problems() {
        let text = fs::read_to_string(&file).unwrap();
        let problem: Value = serde_json::from_str(&text).unwrap();
        let folder = folder_with(&text);
        if problem["expected"]["status"] == "infeasible" {
            refused(&folder, 4, SOLVE, &["problem.json", "none (proved)"]);
            continue;
        }
        let ran = run(&folder, &format!("{SOLVE} --json")).succeeds();
        let plan = json(&folder, "plan.json")["data"].take();
        assert_eq!(plan["status"], "optimal", "{ran}");
        assert_eq!(plan["cost"].as_f64(), problem["expected"]["cost"].as_f64(), "{ran}");
        assert_eq!(plan["cost"], plan["lower_bound"], "{ran}");
        assert_eq!(replay(&problem, &plan), plan["cost"].as_f64().unwrap(), "{ran}");
        let said: Value = serde_json::from_str(&ran.stdout).unwrap();
        assert_eq!([&said["cost"], &said["status"]], [&plan["cost"], &plan["status"]], "{ran}");
        solved += 1;
    }
    assert!(solved >= 2, "{solved}");
}

#[test]
fn an_infeasible_problem_prints_its_reason_as_one_object_and_writes_nothing() {
    let file = repository().join("fixtures/lattice/one_way_gates.json");
    let folder = folder_with(&fs::read_to_string(file).unwrap());
    let ran = run(&folder, &format!("{SOLVE} --json"));
    let said: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(said["exit_code"], 4, "{ran}");
    assert!(said["error"].as_str().unwrap().contains("counts cannot be combined"), "{ran}");
    assert_eq!(ran.stderr, format!("error: {}\n", said["error"].as_str().unwrap()));
    assert!(!folder.path().join("plan.json").exists());
}

/// The channel of the fixtures after a change of its JSON.
fn channel(change: impl FnOnce(&mut Value)) -> String {
    let text = fs::read_to_string(repository().join("fixtures/lattice/channel.json")).unwrap();
    let mut problem = serde_json::from_str(&text).unwrap();
    change(&mut problem);
    problem.to_string()
}

#[test]
fn files_that_are_no_problem_are_refused() {
    let whole = channel(|_| {});
    for (text, pieces) in [
        (whole[..whole.len() / 2].to_owned(), vec!["column"]),
        (String::new(), vec![]),
        ("not JSON".to_owned(), vec![]),
        ("[]".to_owned(), vec![]),
        (format!("{whole} {whole}"), vec![]),
        (channel(|p| p["schema"] = "experiment-lattice-planning/2".into()), vec!["planning/2", "planning/1"]),
        (channel(|p| p["schema"] = "something-else/1".into()), vec!["something-else/1"]),
        (channel(|p| p["obstacle"] = json!([])), vec!["`obstacle`", "`obstacles`"]),
        (channel(|p| p["basic"][0]["moves"][0]["toh"] = 0.into()), vec!["`toh`", "`to_h`"]),
        (channel(|p| p["start"] = json!([99, 0, 0])), vec!["start"]),
        (channel(|p| p["lattice"]["cell"] = 0.into()), vec!["lattice.cell"]),
        (channel(|p| p["lattice"]["cell"] = (-5).into()), vec!["lattice.cell"]),
        (channel(|p| p["lattice"]["nx"] = 0.into()), vec!["lattice"]),
        (channel(|p| p["basic"][0]["cost"] = (-1).into()), vec!["cost"]),
        (channel(|p| p["basic"][0]["name"] = p["informative"][0]["name"].clone()), vec!["jump", "twice"]),
        (channel(|p| p["informative"][0]["moves"] = json!([])), vec!["jump"]),
        (channel(|p| p["bounds"] = json!([60.0, 0.0, 0.0, 10.0])), vec!["bounds"]),
        (channel(|p| p["goal"] = Value::Null), vec!["null"]),
    ] {
        refused(&folder_with(&text), 3, SOLVE, &[&["problem.json"], &pieces[..]].concat());
    }
}

#[test]
fn bytes_that_are_no_text_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("problem.json"), [0xff, 0xfe, 0x00, 0x7b]).unwrap();
    refused(&folder, 3, SOLVE, &["problem.json"]);
}

#[test]
fn a_problem_that_is_not_there_and_one_over_itself_are_told() {
    let folder = folder_with(&channel(|_| {}));
    refused(&folder, 1, "plan --problem nothing.json --out plan.json", &["nothing.json"]);
    refused(&folder, 2, "plan --problem problem.json --out problem.json", &["--out", "problem.json"]);
    refused(&folder, 2, &format!("{SOLVE} --vessel vessel.toml"), &["--vessel"]);
    for limit in ["0", "-1", "nan", "inf"] {
        let ran = run(&folder, &format!("{SOLVE} --time-limit-s={limit}")).refuses(2, &["--time-limit-s"]);
        assert!(!folder.path().join("plan.json").exists(), "{ran}");
    }
}

#[test]
fn law_a_kept_problem_has_the_plans_cost() {
    let folder = small();
    run(&folder, &format!("{PLAN} --keep problem")).succeeds();
    refused(&folder, 2, &format!("{PLAN} --keep all"), &["--keep", "[possible values: problem]"]);
    let line = PLAN.replace("--out plan.json", "--keep problem --out problem.json");
    refused(&folder, 2, &line, &["--out: found problem.json", "written beside it"]);
    // A chart with its name.
    let taken = small_with(&[("land.geojson", "problem.json")]);
    fs::rename(taken.path().join("land.geojson"), taken.path().join("problem.json")).unwrap();
    refused(&taken, 2, &format!("{PLAN} --keep problem"), &["--out: found problem.json", "would replace"]);
    let planned = json(&folder, "plan.json");
    run(&folder, "plan --problem problem.json --out again.json").succeeds();
    let again = json(&folder, "again.json");
    assert_eq!(again["data"]["status"], "optimal");
    assert_eq!(
        (&again["data"]["cost"], &again["data"]["counts"]),
        (&planned["data"]["cost"], &planned["data"]["counts"])
    );
    let both = run(&folder, "plan --problem problem.json --keep problem --out x.json");
    assert!(both.code == Some(2), "{both}");
}
