//! Why there is no plan, and the outcome when memory or time is short.

use crate::lattice::synthetic;
use plan::lattice::{
    Action, Cost, Goal, Lattice, Limit, Move, MoveId, NoPlan, Options, Pose, Problem, Reason, Solution,
    Status, plan,
};

const LATTICE: Lattice = Lattice { nx: 8, ny: 1, layers: 1 };

fn pose(i: usize) -> Pose {
    Pose { i, j: 0, layer: 0 }
}

/// Forward and back by one cell, jump by two; `allowed(action, i)`.
fn outcome(required: u32, goal: usize, allowed: impl Fn(usize, usize) -> bool) -> Result<Solution, NoPlan> {
    let step = |di, cost| Move { from: 0, di, dj: 0, to: 0, cost: Cost::primary(cost) };
    let actions = vec![
        Action { name: "jump".into(), required, moves: vec![step(2, 0.0)] },
        Action { name: "forward".into(), required: 0, moves: vec![step(1, 1.0)] },
        Action { name: "back".into(), required: 0, moves: vec![step(-1, 1.0)] },
    ];
    let goal = Goal::Poses(vec![pose(goal)]);
    let allowed = |id: MoveId, i, _| allowed(id.action, i);
    let problem = Problem::new(LATTICE, actions, pose(1), goal, allowed).unwrap();
    plan(&problem, &Options::default(), &mut |_| true)
}

fn reason(required: u32, goal: usize, allowed: impl Fn(usize, usize) -> bool) -> Reason {
    match outcome(required, goal, allowed) {
        Err(NoPlan::Infeasible(reason)) => reason,
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_enclosed_start_names_the_nearest_pose_with_room() {
    let found = reason(1, 6, |_, i| i > 3);
    assert_eq!(found, Reason::StartEnclosed { start: pose(1), nearest: Some((pose(4), 3.0)) });
    assert!(found.to_string().contains("(4, 0, 0), 3.0 cells away"));
}

#[test]
fn an_enclosed_goal_names_the_nearest_pose_with_room() {
    let found = reason(0, 6, |_, i| i < 3);
    assert_eq!(found, Reason::GoalEnclosed { goal: pose(6), nearest: Some((pose(4), 2.0)) });
}

#[test]
fn a_goal_that_cannot_be_reached_names_the_nearest_pose_that_is() {
    let found = reason(0, 6, |_, i| !(2..=4).contains(&i));
    assert_eq!(found, Reason::GoalUnreachable { nearest: Some((pose(3), 3.0)) });
}

#[test]
fn an_action_that_fits_nowhere_is_named() {
    let found = reason(1, 6, |action, _| action > 0);
    assert_eq!(found, Reason::FitsNowhere { action: 0, name: "jump".into(), elsewhere: None });
}

#[test]
fn an_action_that_fits_out_of_reach_is_named_with_a_place() {
    let found = reason(1, 2, |action, i| if action == 0 { i == 5 } else { i < 3 });
    assert_eq!(found, Reason::FitsNowhere { action: 0, name: "jump".into(), elsewhere: Some(pose(5)) });
}

#[test]
fn an_action_without_a_way_back_is_named() {
    let found = reason(1, 2, |action, i| if action == 0 { i == 3 } else { i < 4 });
    assert_eq!(found, Reason::NoWayBack { action: 0, name: "jump".into() });
}

#[test]
fn counts_that_cannot_be_combined_come_with_counts_that_can() {
    // Forward only: three jumps pass the goal, two are possible.
    let found = reason(3, 6, |action, _| action < 2);
    assert_eq!(found, Reason::CountsCannotBeCombined { possible: Some(vec![2]) });
}

#[test]
fn a_start_without_room_that_is_the_goal_needs_no_moves() {
    let Ok(solution) = outcome(0, 1, |_, i| i > 3) else { panic!("solved by staying") };
    assert!(solution.steps.is_empty() && solution.cost == Cost::default());
}

fn archipelago() -> Problem {
    synthetic::archipelago(20, 20, 4, 3, 2, 5).into_problem().unwrap()
}

#[test]
fn an_exhaustive_search_beyond_the_memory_is_refused() {
    let options = Options { memory_bytes: 100_000, ..Options::default() };
    let Err(NoPlan::TooLarge { states, bytes }) = plan(&archipelago(), &options, &mut |_| true) else {
        panic!()
    };
    assert!(states > 10_000 && bytes > 100_000);
}

#[test]
fn memory_that_is_too_small_is_said_and_bounds_stay_true() {
    let Ok(best) = plan(&archipelago(), &Options::default(), &mut |_| true) else { panic!() };
    assert_eq!(best.status, Status::Optimal);
    for kilobytes in (0..4000).step_by(50) {
        let options = Options { memory_bytes: kilobytes << 10, ..Options::default() };
        match plan(&archipelago(), &options, &mut |_| true) {
            Ok(found) => {
                assert!(
                    found.lower_bound.primary <= best.cost.primary && found.cost.primary >= best.cost.primary
                );
                match found.status {
                    Status::Optimal => assert_eq!(found.cost, best.cost),
                    Status::Feasible { stopped_by } => assert_eq!(stopped_by, Limit::Memory),
                }
            }
            Err(NoPlan::OutOfMemory { lower_bound }) => assert!(lower_bound.primary <= best.cost.primary),
            Err(NoPlan::TooLarge { bytes, .. }) => assert!(bytes > u128::from(kilobytes << 10) / 2),
            other => panic!("{kilobytes} kB: {other:?}"),
        }
    }
}

#[test]
fn a_search_cancelled_at_once_says_so() {
    let options = Options { poll_every: 1, ..Options::default() };
    match plan(&archipelago(), &options, &mut |_| false) {
        Ok(found) => assert_eq!(found.status, Status::Feasible { stopped_by: Limit::Time }),
        other => assert_eq!(other, Err(NoPlan::OutOfTime { lower_bound: Cost::default() })),
    }
}

#[test]
fn states_not_yet_followed_have_no_level() {
    // West by one cell at a time from 7 to 1; from 0 a leap leads to 6. When the goal is reached at level 6, cell 0 is
    // reached but not yet followed, and must not pass for the start of the step to 6.
    let still = |di: i32| Cost::primary(f64::from(di.signum().abs()));
    let act = |name: String, required, di| {
        let moves = vec![Move { from: 0, di, dj: 0, to: 0, cost: still(di) }];
        Action { name, required, moves }
    };
    let mut actions: Vec<_> = (0..7).map(|q| act(format!("stay_{q}"), 2, 0)).collect();
    actions.extend([act("west".into(), 0, -1), act("leap".into(), 0, 6)]);
    let goal = Goal::Poses(vec![pose(1)]);
    let problem = Problem::new(LATTICE, actions, pose(7), goal, |_, _, _| true).unwrap();
    let found = plan(&problem, &Options::default(), &mut |_| true).unwrap();
    assert_eq!((found.cost.primary, found.steps.len()), (6.0, 6 + 14));
    let ways = found.steps.windows(2).all(|pair| pair[0].to == pair[1].from);
    assert!(ways && found.steps[19].to == pose(1), "{:?}", found.steps);
}
