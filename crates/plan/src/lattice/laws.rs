//! Laws of the bound, and comparison of the searches on maps.

use super::beam::{Bound, Left, Packing};
use super::watch::RadixHeap;
use crate::lattice::graph::{Graph, Reach, WITHIN_PER_POSE, WaysOut, within};
use crate::lattice::layered::Levels;
use crate::lattice::seconds::with_seconds;
use crate::lattice::watch::Watch;
use crate::lattice::{Demand, Limit, MoveId, Options, Pose, Problem, Step, dense, layered, plan, synthetic};

/// Basic moves of cost 1.
const LEVELS: Levels = Levels { unit: 1, step: 1 };

fn graph(problem: &Problem) -> Option<Graph<'_>> {
    let mut keep_going = |_| true;
    let mut watch = Watch::new(problem, 1 << 16, &mut keep_going);
    let live = Reach::new(problem, &mut watch)?.live();
    let graph = Graph::new(problem, &live, &mut watch)?;
    graph.lay_out(true, &mut watch)?;
    Some(graph)
}

/// A small map; with `seconds` basic actions of different cost.
fn map(seed: u64, seconds: bool) -> Problem {
    let mut file = synthetic::archipelago(7, 8, 4, 3, 2, seed);
    if seconds {
        file.basic[0].cost = 12.5;
        file.basic[1].cost = 31.7;
        file.informative[1].cost = 60.0;
    }
    file.into_problem().unwrap()
}

/// All uses left that can occur.
fn all_left(required: &[u32], packing: &Packing) -> Vec<Left> {
    let mut all = vec![packing.all()];
    for (slot, &count) in required.iter().enumerate() {
        let mut more = all.clone();
        for _ in 0..count {
            more = more.into_iter().filter_map(|left| packing.after(left, slot)).collect();
            all.extend(&more);
        }
    }
    all.sort_by_key(|left| left.packed);
    all.dedup();
    all
}

/// Exact remaining keys, by (uses left, node): Dijkstra's method backwards, one vector of uses after the other.
fn exact(graph: &Graph, packing: &Packing, all: &[Left]) -> Vec<Vec<Option<u64>>> {
    let position = |left: Left| all.iter().position(|&other| other == left).unwrap();
    let mut to_go: Vec<Vec<Option<u64>>> = vec![vec![None; graph.len()]; all.len()];
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by_key(|&k| all[k].total);
    for k in order {
        let mut queue = RadixHeap::new();
        for node in 0..graph.len() as u32 {
            let used = graph.arcs(node).iter().filter_map(|arc| {
                let (key, slot) = graph.price(arc.step);
                let after = packing.after(all[k], slot? as usize)?;
                Some(key + to_go[position(after)][arc.node as usize]?)
            });
            let at_goal = (all[k].total == 0 && graph.is_goal[node as usize]).then_some(0);
            to_go[k][node as usize] = used.chain(at_goal).min();
            if let Some(key) = to_go[k][node as usize] {
                queue.push(key, node);
            }
        }
        while let Some((key, node)) = queue.pop() {
            for back in graph.back(node) {
                let (step, None) = graph.price(graph.arc(back.arc).step) else { continue };
                let known = &mut to_go[k][back.from as usize];
                if known.is_none_or(|known| known > key + step) {
                    *known = Some(key + step);
                    queue.push(key + step, back.from);
                }
            }
        }
    }
    to_go
}

/// Checks the bound on all states.
fn check(graph: &Graph, bound: &Bound) {
    let required = graph.problem.required();
    let packing = Packing::new(&required);
    let all = all_left(&required, &packing);
    assert_eq!(all.len() as u32, required.iter().map(|count| count + 1).product::<u32>());
    let exact = exact(graph, &packing, &all);
    for (k, &left) in all.iter().enumerate() {
        for node in 0..graph.len() as u32 {
            let here = bound.key(node, left.total);
            if let Some(exact) = exact[k][node as usize] {
                assert!(here.is_some_and(|here| here <= exact), "admissible");
            }
            for arc in graph.arcs(node) {
                let (key, slot) = graph.price(arc.step);
                let after = slot.map_or(Some(left), |slot| packing.after(left, slot as usize));
                let there = after.and_then(|after| bound.key(arc.node, after.total));
                if let Some(there) = there {
                    assert!(here.is_some_and(|here| here <= key + there), "consistent");
                }
            }
        }
    }
}

#[test]
fn law_the_bound_is_admissible_and_consistent() {
    for seed in 0..12 {
        let problem = map(seed, seed % 2 == 1);
        let Some(graph) = graph(&problem) else { continue };
        let mut keep_going = |_| true;
        check(&graph, &Bound::new(&graph, &mut Watch::new(&problem, 1000, &mut keep_going)).unwrap());
    }
}

#[test]
fn law_searches_agree_on_maps() {
    let mut solved = 0;
    for seed in 0..20 {
        let problem = synthetic::archipelago(14, 15, 4, 4, 2, seed).into_problem().unwrap();
        let Some(graph) = graph(&problem) else { continue };
        let watch = || Watch::new(&problem, 1000, Box::leak(Box::new(|_| true)));
        let levels = Levels::of(&graph).unwrap();
        let one = layered::search(&graph, levels, u64::MAX, 1 << 30, &mut watch());
        let two = dense::search(&graph, u64::MAX, 1 << 30, &mut watch());
        let key = |verdict: &crate::lattice::watch::Verdict| verdict.plan.as_ref().map(|plan| plan.0);
        assert_eq!((key(&one), one.stopped_by), (key(&two), None));
        assert_eq!(one.possible.is_some(), two.possible.is_some());
        // Without room for levels the optimum is known.
        let blind = layered::search(&graph, levels, u64::MAX, 0, &mut watch());
        if let Some(key) = key(&one) {
            assert_eq!((blind.lower, blind.stopped_by), (key, Some(crate::lattice::Limit::Memory)));
        }
        let fronts = (
            layered::front(&graph, levels, u64::MAX, &mut watch()),
            dense::front(&graph, u64::MAX, 1 << 30, &mut watch()),
        );
        assert_eq!(fronts.0, fronts.1);
        let outcome = plan(&problem, &Options::default(), &mut |_| true);
        solved += usize::from(outcome.is_ok());
    }
    assert!(solved >= 10, "{solved} of 20 maps have a plan");
}

/// More count vectors than one block holds.
fn many_blocks(seed: u64) -> Problem {
    let mut file = synthetic::archipelago(6, 7, 4, 7, 2, seed);
    file.informative[3].count = 3;
    file.into_problem().unwrap()
}

/// Follows a walk through the graph; its key, if it ends in a goal with all uses.
fn followed(graph: &Graph, walk: &[u32]) -> Option<u64> {
    let packing = Packing::new(&graph.problem.required());
    let (mut node, mut left, mut sum) = (graph.start, packing.all(), 0);
    for &step in walk {
        let arc = graph.arcs(node).iter().find(|arc| arc.step == step)?;
        let (key, slot) = graph.price(step);
        left = slot.map_or(Some(left), |slot| packing.after(left, slot as usize))?;
        (node, sum) = (arc.node, sum + key);
    }
    (left.total == 0 && graph.is_goal[node as usize]).then_some(sum)
}

#[test]
fn law_many_blocks_agree_with_single_states() {
    let mut solved = 0;
    for seed in 0..12 {
        let problem = many_blocks(seed);
        let Some(graph) = graph(&problem) else { continue };
        let watch = || Watch::new(&problem, 1000, Box::leak(Box::new(|_| true)));
        let (bits, single) = (
            layered::search(&graph, LEVELS, u64::MAX, 1 << 30, &mut watch()),
            dense::search(&graph, u64::MAX, 1 << 30, &mut watch()),
        );
        let key = |verdict: &crate::lattice::watch::Verdict| verdict.plan.as_ref().map(|plan| plan.0);
        assert_eq!(key(&bits), key(&single), "seed {seed}");
        for (key, walk) in [&bits, &single].into_iter().filter_map(|verdict| verdict.plan.as_ref()) {
            assert_eq!(followed(&graph, walk), Some(*key), "seed {seed}");
            solved += 1;
        }
        let uses = |possible: &Option<Vec<u32>>| possible.as_ref().map(|counts| counts.iter().sum::<u32>());
        assert_eq!(uses(&bits.possible), uses(&single.possible), "seed {seed}");
        assert_eq!(
            layered::front(&graph, LEVELS, u64::MAX, &mut watch()),
            dense::front(&graph, u64::MAX, 1 << 30, &mut watch())
        );
    }
    assert!(solved >= 6, "{solved} plans");
}

#[test]
fn law_moves_then_seconds_agree_with_single_states() {
    let mut solved = 0;
    for seed in 0..12 {
        let without = if seed % 2 == 0 { many_blocks(seed) } else { map(seed, false) };
        let problem = with_seconds(&without);
        let Some(graph) = graph(&problem) else { continue };
        let levels = Levels::of(&graph).unwrap();
        assert!(levels.are_partial());
        let watch = || Watch::new(&problem, 1000, Box::leak(Box::new(|_| true)));
        let search = |most: u64, memory: u64| layered::search(&graph, levels, most, memory, &mut watch());
        let (bits, single) =
            (search(u64::MAX, 1 << 30), dense::search(&graph, u64::MAX, 1 << 30, &mut watch()));
        let key = |verdict: &crate::lattice::watch::Verdict| verdict.plan.as_ref().map(|plan| plan.0);
        assert_eq!((key(&bits), bits.stopped_by), (key(&single), None), "seed {seed}");
        if let Some((key, walk)) = &bits.plan {
            assert_eq!(followed(&graph, walk), Some(*key), "seed {seed}");
            assert_eq!(search(*key, 1 << 30).plan, bits.plan);
            assert_eq!(search(*key - 1, 1 << 30).plan, None);
            let full = search(u64::MAX, 0);
            assert_eq!((full.stopped_by, &full.plan), (Some(Limit::Memory), &None));
            assert!(full.lower <= *key);
            solved += 1;
        }
        let primary = |key: u64| key / problem.units.radix;
        let single = dense::front(&graph, u64::MAX, 1 << 30, &mut watch()).unwrap();
        for most in [u64::MAX, key(&bits).unwrap_or(u64::MAX)] {
            let front = layered::front(&graph, levels, most, &mut watch()).unwrap();
            let front: Vec<_> = front.into_iter().map(|key| key.map(primary)).collect();
            let as_cheap = |key: &u64| *key <= primary(most);
            let least: Vec<_> = single.iter().map(|key| key.map(primary).filter(as_cheap)).collect();
            assert_eq!(front, least, "seed {seed}");
        }
        if seed == 1 {
            stop_everywhere(&problem, |watch| layered::search(&graph, levels, u64::MAX, 1 << 30, watch));
        }
    }
    assert!(solved >= 6, "{solved} plans");
}

/// Cancels a search at many points, most of them near its end; the lower bound never exceeds the optimum.
fn stop_everywhere(problem: &Problem, search: impl Fn(&mut Watch) -> crate::lattice::watch::Verdict) {
    let run = |limit: u64| {
        let mut polls = 0;
        let mut keep_going = |_| {
            polls += 1;
            polls < limit
        };
        let mut watch = Watch::new(problem, 1, &mut keep_going);
        let verdict = search(&mut watch);
        let lower = watch.lower.max(verdict.lower);
        (lower, verdict, polls)
    };
    let (_, whole, total) = run(u64::MAX);
    let optimum = whole.plan.map_or(u64::MAX, |plan| plan.0);
    for limit in (1..30).map(|k| total * k / 30).chain(total.saturating_sub(30)..=total) {
        let (lower, verdict, _) = run(limit);
        assert!(lower <= optimum, "{lower} after {limit} of {total} polls, optimum {optimum}");
        assert!(verdict.plan.is_none_or(|plan| plan.0 >= optimum));
    }
}

#[test]
fn law_bounds_of_stopped_searches_hold() {
    for seed in 0..6 {
        let problem = many_blocks(seed);
        if let Some(graph) = graph(&problem) {
            stop_everywhere(&problem, |watch| layered::search(&graph, LEVELS, u64::MAX, 1 << 30, watch));
        }
    }
}

#[test]
fn law_a_queue_beyond_its_memory_ends_a_search_without_a_claim() {
    let problem = synthetic::archipelago(14, 16, 4, 3, 2, 1).into_problem().unwrap();
    let graph = graph(&problem).unwrap();
    let watch = || Watch::new(&problem, 1000, Box::leak(Box::new(|_| true)));
    let optimum = dense::search(&graph, u64::MAX, 1 << 30, &mut watch()).plan.unwrap().0;
    let full = dense::search(&graph, u64::MAX, 0, &mut watch());
    assert_eq!((full.stopped_by, &full.plan), (Some(Limit::Memory), &None));
    assert!(full.lower <= optimum, "{} against {optimum}", full.lower);
    assert_eq!(dense::front(&graph, u64::MAX, 0, &mut watch()), None);
}

#[test]
fn law_every_phase_polls() {
    let problem = map(1, false);
    let graph = graph(&problem).unwrap();
    let nodes = graph.len();
    let polls = |phase: &dyn Fn(&mut Watch)| {
        let mut polls = 0;
        let mut keep_going = |_| {
            polls += 1;
            true
        };
        phase(&mut Watch::new(&problem, 1, &mut keep_going));
        polls
    };
    let layouts = polls(&|watch| drop(layered::front(&graph, LEVELS, u64::MAX, watch)));
    assert!(layouts >= nodes, "{layouts} times for the arcs of {nodes} nodes");
    let layers = problem.required().iter().sum::<u32>() as usize + 1;
    let bounds = polls(&|watch| drop(Bound::new(&graph, watch)));
    assert!(bounds >= layers * nodes, "{bounds} times for {layers} layers of {nodes} nodes");
}

/// The memory of the search around start and goals is predicted, and the search stops at the limit that it is given.
#[test]
fn law_the_surroundings_fit_in_the_memory_that_they_are_given() {
    for seed in 0..20 {
        let problem = map(seed, seed % 2 == 0);
        let (poses, no_limit) = (problem.lattice().poses(), u64::MAX);
        let run = |memory: u64| {
            let mut keep_going = |_| true;
            within(&problem, no_limit / 4, memory, &mut Watch::new(&problem, 1000, &mut keep_going))
        };
        let tables = (poses * WITHIN_PER_POSE) as u64;
        assert_eq!(run(tables - 1), Err(Limit::Memory), "seed {seed}");
        let whole = run(no_limit).unwrap();
        match run(tables) {
            Ok(all) => assert_eq!(all, whole, "seed {seed}"),
            Err(limit) => assert_eq!(limit, Limit::Memory, "seed {seed}"),
        }
        let demand = Demand::new(problem.lattice(), problem.actions());
        let graph = graph(&problem).map_or(0, |graph| graph.bytes());
        assert!(demand.bytes() >= u128::from(tables + graph), "seed {seed}");
    }
}

#[test]
fn law_ways_out_are_the_shortest_walks_and_closed_poses_are_not_entered() {
    let mut walked = 0;
    for seed in 0..12 {
        let mut problem = map(seed, true);
        let (lattice, count) = (problem.lattice(), problem.lattice().poses());
        // Ends with keys of their own, and basic moves of several lengths.
        let end = |pose: Pose| [Some(0), None, Some(7), None, None][(7 * lattice.number(pose) + 3) % 5];
        let end = |pose: Pose| end(pose).filter(|_| lattice.number(pose) % 11 < 2);
        let actions: Vec<u32> = problem.actions().iter().map(|action| action.required).collect();
        let key = move |id: MoveId| (actions[id.action] == 0).then_some(1 + id.index as u64 % 3);
        let mut shortest: Vec<u64> =
            (0..count).map(|pose| end(lattice.pose(pose)).unwrap_or(u64::MAX)).collect();
        for _ in 0..count {
            for pose in 0..count {
                for arc in problem.arcs(pose) {
                    let Some(key) = key(problem.moves[arc.step as usize].id) else { continue };
                    let there = shortest[arc.node as usize].saturating_add(key);
                    shortest[pose] = shortest[pose].min(there);
                }
            }
        }
        let mut keep_going = |_| true;
        let watch = &mut Watch::new(&problem, 1000, &mut keep_going);
        let ways = WaysOut::new(&problem, (Box::new(end), Box::new(key.clone())), 1 << 30, watch).unwrap();
        for (pose, shortest) in shortest.into_iter().enumerate() {
            let pose = lattice.pose(pose);
            let Some(steps) = ways.steps(pose) else {
                assert_eq!(shortest, u64::MAX);
                continue;
            };
            let last = steps.last().map_or(pose, |step| step.to);
            assert!(steps.windows(2).all(|pair| pair[0].to == pair[1].from));
            let index = |step: &Step| {
                let moves = problem.actions()[step.action].moves.iter().enumerate();
                moves.filter(|(_, one)| one.from == step.from.layer).nth(step.variant).unwrap().0
            };
            let keys =
                steps.iter().map(|step| key(MoveId { action: step.action, index: index(step) }).unwrap());
            assert_eq!(keys.sum::<u64>() + end(last).unwrap(), shortest);
            walked += steps.len();
        }
        let closed = ways.closed();
        problem.close(&closed);
        let arcs = || {
            (0..count).flat_map(|pose| problem.arcs(pose).map(|arc| arc.node as usize).collect::<Vec<_>>())
        };
        assert!(arcs().all(|end| !closed[end]));
        assert_eq!(arcs().count(), problem.arc_count(|_| true));
    }
    assert!(walked > 100, "{walked}");
}
