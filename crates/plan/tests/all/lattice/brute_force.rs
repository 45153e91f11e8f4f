//! The search against brute force on random small problems.

use plan::lattice::{Action, Cost, Goal, Lattice, Move, NoPlan, Options, Pose, Reason, front, plan};
use proptest::prelude::*;

use crate::lattice::random::{Costs, Small, brute_force, proved, replay, small};

fn agrees(small: &Small) {
    let problem = small.problem();
    let least = brute_force(small);
    let expected = *least.last().unwrap();
    let outcome = plan(&problem, &Options::default(), &mut |_| true);
    assert_eq!(proved(small, &outcome), expected);
    if let Err(NoPlan::Infeasible(Reason::CountsCannotBeCombined { possible: Some(counts) })) = outcome {
        let most = (0..least.len()).filter(|&v| least[v].is_some()).map(|v| uses(small, v)).max();
        assert_eq!(most, Some(counts.iter().sum()), "counts of most uses");
    }
    let points = front(&problem, None, &Options::default(), &mut |_| true).expect("a small front");
    let tenths = |cost: f64| (cost * 10.0).round() as u64;
    let primary = |least: &Option<(u64, u64)>| least.map(|least| least.0);
    for (point, least) in points.iter().zip(&least) {
        assert_eq!(point.primary.map(tenths), primary(least), "front");
    }
    let Ok(best) = plan(&problem, &Options::default(), &mut |_| true) else { return };
    let near = front(&problem, Some(&best), &Options::default(), &mut |_| true).expect("a small front");
    let dearest = expected.expect("a plan");
    for (point, least) in near.iter().zip(&least) {
        let found = point.primary.map(tenths);
        let may_be_missing = least.is_some_and(|least| least > dearest);
        assert!(
            found == primary(least) || found.is_none() && may_be_missing,
            "{found:?}, not {least:?}, by {dearest:?}"
        );
    }
}

/// Uses in total of a mixed-radix number.
fn uses(small: &Small, mut vector: usize) -> u32 {
    let mut sum = 0;
    for action in small.actions.iter().filter(|action| action.required > 0) {
        let radix = action.required as usize + 1;
        sum += (vector % radix) as u32;
        vector /= radix;
    }
    sum
}

/// The move that is cheaper in the first cost leads out of the lattice, the other one has the lower second cost.
#[test]
fn oracle_a_dearer_move_with_the_lower_secondary_cost() {
    let step = |dj, primary, secondary| Move { from: 0, di: 0, dj, to: 0, cost: Cost { primary, secondary } };
    let action = |name: &str, required, moves| Action { name: name.to_owned(), required, moves };
    agrees(&Small {
        lattice: Lattice { nx: 2, ny: 4, layers: 1 },
        actions: vec![
            action("a0", 1, vec![step(-1, 0.4, 0.1), step(0, 0.5, 0.0)]),
            action("a1", 1, vec![step(0, 0.1, 0.0), step(-1, 0.0, 0.1)]),
            action("a2", 0, vec![step(0, 0.0, 0.0), step(-2, 0.0, 0.0)]),
        ],
        start: Pose { i: 0, j: 0, layer: 0 },
        goal: Goal::Any,
        closed: vec![false],
    });
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn oracle_paper_costs(small in small(Costs::Paper)) {
        agrees(&small);
    }

    #[test]
    fn oracle_free_basic_moves(small in small(Costs::SomeFree)) {
        agrees(&small);
    }

    #[test]
    fn oracle_seconds(small in small(Costs::Seconds)) {
        agrees(&small);
    }

    #[test]
    fn oracle_moves_then_seconds(small in small(Costs::MovesThenSeconds)) {
        agrees(&small);
    }

    #[test]
    fn oracle_two_criteria(small in small(Costs::Both)) {
        agrees(&small);
    }

    /// Results of a cancelled search are true.
    #[test]
    fn law_stopped_searches_bound_the_optimum(
        small in prop_oneof![small(Costs::Paper), small(Costs::MovesThenSeconds), small(Costs::Both)],
        polls in 0..400u32,
    ) {
        let mut left = polls;
        let mut keep_going = |_| { left = left.saturating_sub(1); left > 0 };
        let outcome = plan(&small.problem(), &Options { poll_every: 1, ..Options::default() }, &mut keep_going);
        let optimum = brute_force(&small).last().copied().flatten();
        let tenths = |cost: plan::lattice::Cost| ((cost.primary * 10.0).round() as u64, (cost.secondary * 10.0).round() as u64);
        match outcome {
            Ok(solution) => {
                let cost = replay(&small, &solution);
                let optimum = optimum.expect("a replayed plan exists");
                prop_assert!(tenths(solution.lower_bound) <= optimum && optimum <= cost);
                if solution.status == plan::lattice::Status::Optimal {
                    prop_assert_eq!(cost, optimum);
                }
            }
            Err(NoPlan::OutOfTime { lower_bound }) => {
                if let Some(optimum) = optimum {
                    prop_assert!(tenths(lower_bound) <= optimum);
                }
            }
            Err(NoPlan::Infeasible(_)) => prop_assert_eq!(optimum, None),
            other => prop_assert!(false, "{other:?}"),
        }
    }
}
