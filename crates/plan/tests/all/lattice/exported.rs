//! Problems written as files for others, and read again.

use plan::lattice::{Goal, MoveId, Options, Pose, ProblemFile, plan};
use proptest::prelude::*;

use crate::lattice::random::{Costs, Small, small};

/// Whether both problems allow the same moves everywhere, and what their plans cost.
fn agree(small: &Small) {
    let problem = small.problem();
    let file = match (ProblemFile::of(&problem, "law", 3.7), problem.goal()) {
        (Err(refusal), Goal::Any) => return assert!(refusal.to_string().contains("any pose")),
        (Err(refusal), Goal::Poses(poses)) => {
            assert!(poses.len() != 1 && refusal.to_string().contains("one pose"), "{refusal}");
            return;
        }
        (Ok(file), _) => file,
    };
    let text = serde_json::to_string(&file).unwrap();
    let again = serde_json::from_str::<ProblemFile>(&text).unwrap().into_problem().unwrap();
    let lattice = problem.lattice();
    for (action, own) in problem.actions().iter().enumerate() {
        let other = again.actions().iter().position(|other| other.name == own.name).unwrap();
        assert_eq!(again.actions()[other].required, own.required);
        for index in 0..own.moves.len() {
            for pose in 0..lattice.nx * lattice.ny * lattice.layers {
                let (cell, layer) = (pose / lattice.layers, pose % lattice.layers);
                let pose = Pose { i: cell % lattice.nx, j: cell / lattice.nx, layer };
                let allowed = problem.is_allowed(pose, MoveId { action, index });
                assert_eq!(again.is_allowed(pose, MoveId { action: other, index }), allowed, "{pose:?}");
            }
        }
    }
    let cost = |problem| plan(problem, &Options::default(), &mut |_| true).map(|found| found.cost.primary);
    match (cost(&problem), cost(&again)) {
        (Ok(one), Ok(other)) => assert!((one - other).abs() < 1e-9, "{one} {other}"),
        (one, other) => assert_eq!(one.is_ok(), other.is_ok()),
    }
}

proptest! {
    #[test]
    fn law_an_exported_problem_is_the_same_problem(small in small(Costs::Both)) {
        agree(&small);
    }
}
