//! Recovers a shortest walk from distances alone, without parents.

use std::collections::BTreeMap;

use crate::lattice::graph::Graph;
use crate::lattice::watch::Walk;

/// Distance of a node with counts from the start, by slot; `None` if it was not reached.
pub(crate) type Distance<'a> = dyn Fn(u32, &[u32]) -> Option<u64> + 'a;

/// The walk to `node` with `counts`, which are reached according to the distances.
pub(crate) fn walk(graph: &Graph, mut node: u32, mut counts: Vec<u32>, distance: &Distance) -> Option<Walk> {
    let mut walk = Walk::new();
    loop {
        let here = distance(node, &counts)?;
        let Entry { along, before } = entry(graph, node, &mut counts, here, distance)?;
        walk.extend(along);
        match before {
            None => break,
            Some((from, step)) => {
                walk.push(step);
                node = from;
            }
        }
    }
    walk.reverse();
    Some(walk)
}

/// How a walk enters a node: over free basic moves (`along`, last first) after the move `before`, or from the
/// start.
struct Entry {
    along: Walk,
    before: Option<(u32, u32)>,
}

/// Searches backwards over free basic moves for a move from a smaller distance or smaller counts. The counts become
/// those before that move.
fn entry(graph: &Graph, node: u32, counts: &mut [u32], here: u64, distance: &Distance) -> Option<Entry> {
    let mut after: BTreeMap<u32, Option<(u32, u32)>> = BTreeMap::from([(node, None)]);
    let mut queue = vec![node];
    while let Some(at) = queue.pop() {
        if at == graph.start && here == 0 && counts.iter().all(|&count| count == 0) {
            return Some(Entry { along: along(&after, at), before: None });
        }
        for (from, step) in graph.ways_into(at) {
            let (key, slot) = graph.price(step);
            let Some(before) = here.checked_sub(key) else { continue };
            match slot.map(|slot| slot as usize) {
                Some(slot) if counts[slot] > 0 => {
                    counts[slot] -= 1;
                    if distance(from, counts) == Some(before) {
                        return Some(Entry { along: along(&after, at), before: Some((from, step)) });
                    }
                    counts[slot] += 1;
                }
                None if distance(from, counts) != Some(before) => {}
                None if key > 0 => {
                    return Some(Entry { along: along(&after, at), before: Some((from, step)) });
                }
                None => {
                    after.entry(from).or_insert_with(|| {
                        queue.push(from);
                        Some((at, step))
                    });
                }
                Some(_) => {}
            }
        }
    }
    None
}

/// The free moves from `at` to where the search began, last first.
fn along(after: &BTreeMap<u32, Option<(u32, u32)>>, mut at: u32) -> Walk {
    let mut moves = Walk::new();
    while let Some(&Some((next, step))) = after.get(&at) {
        moves.push(step);
        at = next;
    }
    moves.reverse();
    moves
}
