//! Problem files with known optima: our own, and those beside the repository if they are there.

use std::path::{Path, PathBuf};

use plan::lattice::{NoPlan, Options, Problem, ProblemFile, Reason, Solution, Status, front, plan};
use serde_json::Value;

fn json_files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut files: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|e| e == "json")).collect();
    files.sort();
    files
}

#[test]
fn oracle_own_files() {
    let files = json_files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/lattice"));
    assert_eq!(files.len(), 3);
    files.iter().for_each(|file| check(file));
}

#[test]
fn oracle_shared_files() {
    let files = json_files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/lattice"));
    if files.is_empty() {
        println!("left out: there is no folder ../shared/data/lattice beside the repository");
    }
    files.iter().for_each(|file| check(file));
}

fn check(file: &Path) {
    let text = std::fs::read_to_string(file).unwrap();
    let raw: Value = serde_json::from_str(&text).unwrap();
    let expected = &raw["expected"];
    let problem = serde_json::from_str::<ProblemFile>(&text).unwrap().into_problem().unwrap();
    match (plan(&problem, &Options::default(), &mut |_| true), expected["status"].as_str()) {
        (Ok(solution), Some("optimal")) => {
            assert_eq!(solution.status, Status::Optimal);
            let cost = replay(&raw, &problem, &solution);
            assert!((cost - solution.cost.primary).abs() < 1e-9, "{}", file.display());
            assert!((cost - expected["cost"].as_f64().unwrap()).abs() < 1e-9, "{}", file.display());
        }
        (Err(NoPlan::Infeasible(Reason::CountsCannotBeCombined { .. })), Some("infeasible")) => {}
        (outcome, expected) => panic!("{}: {outcome:?}, expected {expected:?}", file.display()),
    }
    let points = front(&problem, None, &Options::default(), &mut |_| true).expect("a small front");
    let row = |point: &plan::lattice::FrontPoint| {
        let counts = point.counts.iter().map(|&count| Some(f64::from(count)));
        counts.chain([point.primary]).collect::<Vec<_>>()
    };
    let rows: Vec<Vec<Option<f64>>> = points.iter().map(row).collect();
    let mut expected: Vec<Vec<Option<f64>>> =
        serde_json::from_value(expected["cost_by_counts"].clone()).unwrap();
    expected.sort_by_key(|row| {
        row[..row.len() - 1].iter().rev().map(|count| count.unwrap() as u32).collect::<Vec<_>>()
    });
    assert_eq!(rows, expected, "{}", file.display());
}

/// Makes the moves of a plan as the file has them, tests every box against every obstacle, and returns the cost.
fn replay(raw: &Value, problem: &Problem, solution: &Solution) -> f64 {
    let all: Vec<&Value> =
        ["informative", "basic"].iter().flat_map(|kind| raw[kind].as_array().unwrap()).collect();
    let mut pose: Vec<i64> = serde_json::from_value(raw["start"].clone()).unwrap();
    let (mut cost, mut uses) = (0.0, vec![0; all.len()]);
    for step in &solution.steps {
        let name = &problem.actions()[step.action].name;
        let index = all.iter().position(|action| action["name"] == name.as_str()).unwrap();
        let mut here = all[index]["moves"].as_array().unwrap().iter().filter(|m| m["h"] == pose[2]);
        let m = here.nth(step.variant).unwrap();
        assert!(is_free(raw, m, &pose), "{name} at {pose:?}");
        pose = vec![
            pose[0] + m["di"].as_i64().unwrap(),
            pose[1] + m["dj"].as_i64().unwrap(),
            m["to_h"].as_i64().unwrap(),
        ];
        assert_eq!([step.to.i as i64, step.to.j as i64, step.to.layer as i64], pose[..]);
        cost += all[index]["cost"].as_f64().unwrap();
        uses[index] += 1;
    }
    let goal: Vec<i64> = serde_json::from_value(raw["goal"].clone()).unwrap();
    assert_eq!(pose, goal);
    for (action, uses) in all.iter().zip(uses) {
        assert!(action.get("count").is_none_or(|count| *count == uses));
    }
    cost
}

fn is_free(raw: &Value, m: &Value, pose: &[i64]) -> bool {
    let numbers = |value: &Value| serde_json::from_value::<Vec<f64>>(value.clone()).unwrap();
    let (lattice, bounds) = (&raw["lattice"], numbers(&raw["bounds"]));
    let (cell, origin) = (lattice["cell"].as_f64().unwrap(), numbers(&lattice["origin"]));
    let (x, y) = (origin[0] + cell * pose[0] as f64, origin[1] + cell * pose[1] as f64);
    m["swept"].as_array().unwrap().iter().all(|swept| {
        let swept = numbers(swept);
        let [x0, y0, x1, y1] = [x + swept[0], y + swept[1], x + swept[2], y + swept[3]];
        let inside = x0 >= bounds[0] && y0 >= bounds[1] && x1 <= bounds[2] && y1 <= bounds[3];
        let apart = |o: &Value| {
            let o = numbers(o);
            x1 <= o[0] || x0 >= o[2] || y1 <= o[1] || y0 >= o[3]
        };
        inside && raw["obstacles"].as_array().unwrap().iter().all(apart)
    })
}

#[test]
fn oracle_free_cells_as_cell_by_cell() {
    for seed in 0..4 {
        let file = crate::lattice::synthetic::archipelago(17, 13, 8, 3, 1, seed);
        let raw = serde_json::to_value(&file).unwrap();
        let problem = file.into_problem().unwrap();
        for (action, a) in problem.actions().iter().enumerate() {
            let kinds = ["informative", "basic"].iter().flat_map(|kind| raw[kind].as_array().unwrap());
            let moves =
                kinds.clone().find(|b| b["name"] == a.name.as_str()).unwrap()["moves"].as_array().unwrap();
            for (index, m) in a.moves.iter().enumerate() {
                for cell in 0..17 * 13 {
                    let pose = plan::lattice::Pose { i: cell % 17, j: cell / 17, layer: m.from };
                    let (i, j) = (pose.i as i64 + i64::from(m.di), pose.j as i64 + i64::from(m.dj));
                    let inside = (0..17).contains(&i) && (0..13).contains(&j);
                    let expected = inside && is_free(&raw, &moves[index], &[pose.i as i64, pose.j as i64]);
                    let id = plan::lattice::MoveId { action, index };
                    assert_eq!(problem.is_allowed(pose, id), expected, "{} at {pose}", a.name);
                }
            }
        }
    }
}
