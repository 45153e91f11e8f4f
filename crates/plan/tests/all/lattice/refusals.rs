//! What a problem may not be, one fault at a time.

use crate::lattice::synthetic;
use plan::lattice::{Action, Cost, Goal, Invalid, Lattice, Move, Pose, Problem, ProblemFile, SchemaId};

const LATTICE: Lattice = Lattice { nx: 3, ny: 2, layers: 2 };
const START: Pose = Pose { i: 0, j: 0, layer: 0 };

fn actions() -> Vec<Action> {
    let step = |cost| Move { from: 0, di: 1, dj: 0, to: 1, cost: Cost::primary(cost) };
    vec![
        Action { name: "zigzag".into(), required: 1, moves: vec![step(0.0)] },
        Action { name: "forward".into(), required: 0, moves: vec![step(1.0)] },
    ]
}

fn refusal(lattice: Lattice, actions: Vec<Action>, start: Pose, goal: Goal) -> String {
    let error: Invalid = Problem::new(lattice, actions, start, goal, |_, _, _| true).unwrap_err();
    let line = error.to_string();
    assert!(!line.contains('\n') && line.contains("found") && line.contains("expected"), "{line}");
    line
}

fn broken(breaking: impl Fn(&mut Vec<Action>)) -> String {
    let mut actions = actions();
    breaking(&mut actions);
    refusal(LATTICE, actions, START, Goal::Any)
}

#[test]
fn the_unbroken_problem_is_accepted() {
    assert!(Problem::new(LATTICE, actions(), START, Goal::Any, |_, _, _| true).is_ok());
}

#[test]
fn lattices_without_poses_or_with_too_many_are_refused() {
    for lattice in
        [Lattice { nx: 0, ..LATTICE }, Lattice { ny: 0, ..LATTICE }, Lattice { layers: 0, ..LATTICE }]
    {
        assert!(refusal(lattice, actions(), START, Goal::Any).starts_with("lattice: found"));
    }
    let huge = Lattice { nx: usize::MAX, ..LATTICE };
    assert!(refusal(huge, actions(), START, Goal::Any).contains("2^32"));
}

#[test]
fn unknown_layers_are_refused() {
    assert!(broken(|a| a[0].moves[0].from = 2).contains("zigzag, move 0, from layer"));
    assert!(broken(|a| a[1].moves[0].to = 7).contains("forward, move 0, to layer: found 7"));
}

#[test]
fn costs_below_zero_or_not_finite_are_refused() {
    for cost in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(broken(|a| a[1].moves[0].cost.primary = cost).contains("primary cost"));
        assert!(broken(|a| a[1].moves[0].cost.secondary = cost).contains("secondary cost"));
    }
    assert!(broken(|a| a[1].moves[0].cost.primary = 1e300).contains("fewer digits"));
}

#[test]
fn actions_without_moves_or_with_one_name_are_refused() {
    assert!(broken(|a| a[0].moves.clear()).contains("no moves"));
    assert!(broken(|a| a[1].name = "zigzag".into()).contains("twice"));
}

#[test]
fn too_many_uses_are_refused() {
    assert!(broken(|a| a[0].required = 1_000_000).contains("required uses"));
    let many = |k: usize| Action { name: k.to_string(), required: 1, moves: actions()[0].moves.clone() };
    assert!(refusal(LATTICE, (0..129).map(many).collect(), START, Goal::Any).contains("129 bits"));
}

#[test]
fn ends_outside_of_the_lattice_are_refused() {
    let outside = Pose { i: 3, ..START };
    assert!(refusal(LATTICE, actions(), outside, Goal::Any).starts_with("start: found (3, 0, 0)"));
    assert!(refusal(LATTICE, actions(), START, Goal::Poses(vec![START, outside])).starts_with("goal: found"));
    assert!(refusal(LATTICE, actions(), START, Goal::Poses(vec![])).contains("at least one pose"));
}

fn file_refusal(breaking: impl Fn(&mut ProblemFile)) -> String {
    let mut file = synthetic::archipelago(9, 9, 4, 2, 1, 1);
    breaking(&mut file);
    file.into_problem().unwrap_err().to_string()
}

#[test]
fn boxes_and_numbers_of_files_are_checked() {
    assert!(file_refusal(|f| f.obstacles[1] = [2.0, 0.0, 1.0, 1.0]).starts_with("obstacles[1]"));
    assert!(file_refusal(|f| f.bounds[3] = f64::NAN).starts_with("bounds"));
    assert!(
        file_refusal(|f| f.basic[0].moves[0].swept[0] = [0.0, 1.0, 1.0, 0.0])
            .contains("forward, move 0, swept[0]")
    );
    assert!(file_refusal(|f| f.lattice.cell = 0.0).starts_with("lattice.cell"));
    assert!(file_refusal(|f| f.lattice.origin[0] = f64::INFINITY).starts_with("lattice.origin"));
    assert!(file_refusal(|f| f.basic[0].moves[0].to_h = 4).contains("to_h: found 4"));
    assert!(file_refusal(|f| f.informative[0].moves[0].h = 4).contains(", h: found 4"));
    assert!(file_refusal(|f| f.lattice.nx = 0).starts_with("lattice"));
    assert!(file_refusal(|f| f.start[0] = 9).starts_with("start"));
    assert!(file_refusal(|f| f.goal[2] = 4).starts_with("goal"));
    assert!(file_refusal(|f| f.basic[1].name = f.basic[0].name.clone()).contains("twice"));
    assert!(file_refusal(|f| f.basic[0].cost = -1.0).contains("primary cost"));
}

#[test]
fn other_schemas_are_refused() {
    let check = |schema: &str| SchemaId { schema: schema.into() }.check().unwrap_err().to_string();
    assert!(check("experiment-lattice-planning/2").contains("newer version"));
    assert!(check("design/1").contains("give a lattice problem"));
    assert!(file_refusal(|f| f.schema = "experiment-lattice-planning/2".into()).contains("newer version"));
}

#[test]
fn unknown_fields_are_refused() {
    let mut value = serde_json::to_value(synthetic::archipelago(5, 5, 4, 1, 1, 1)).unwrap();
    assert!(serde_json::from_value::<ProblemFile>(value.clone()).is_ok());
    value["lattice"]["pitch"] = 1.into();
    assert!(serde_json::from_value::<ProblemFile>(value).unwrap_err().to_string().contains("pitch"));
}
