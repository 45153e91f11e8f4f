//! Conditions for a ring of a polygon: closed, with area, without crossing itself or another ring of the same polygon.

use std::cmp::Ordering;

/// What is wrong with the rings of one polygon.
#[derive(Clone, Debug, PartialEq)]
pub enum RingFault {
    /// No ring, or a ring of fewer than four positions, or one without area.
    Empty {
        /// The ring.
        ring: usize,
    },
    /// The last position is not the first.
    Open {
        /// The ring.
        ring: usize,
    },
    /// A coordinate is NaN or infinite.
    NotFinite {
        /// The ring.
        ring: usize,
    },
    /// Two edges cross at a point inside both.
    Crossing {
        /// Ring and edge of one.
        one: (usize, usize),
        /// Ring and edge of the other.
        other: (usize, usize),
        /// First position of the first edge.
        near: [f64; 2],
    },
}

/// The first fault of a polygon's rings (closed: the last position repeats the first), in any plane coordinates.
///
/// Rings may touch themselves and each other at points and along edges; only proper crossings are faults.
/// Edges are swept along the axis on which they are shorter: n log n for coastlines.
pub fn ring_fault(rings: &[Vec<[f64; 2]>]) -> Option<RingFault> {
    ring_fault_while(rings, &|| true).flatten()
}

/// [`ring_fault`] under a time limit; `None` once `keep_going` returns false.
pub(crate) fn ring_fault_while(
    rings: &[Vec<[f64; 2]>],
    keep_going: &dyn Fn() -> bool,
) -> Option<Option<RingFault>> {
    if rings.is_empty() {
        return Some(Some(RingFault::Empty { ring: 0 }));
    }
    if let Some(fault) = rings.iter().enumerate().find_map(|(k, r)| shape_fault(k, r)) {
        return Some(Some(fault));
    }
    // A bow tie may have no area either, so crossings are checked before areas.
    let crossing = crossing(rings, keep_going)?;
    let flat = || rings.iter().position(|r| doubled_area(r) == 0.0).map(|ring| RingFault::Empty { ring });
    Some(crossing.or_else(flat))
}

fn shape_fault(index: usize, ring: &[[f64; 2]]) -> Option<RingFault> {
    if ring.iter().flatten().any(|v| !v.is_finite()) {
        return Some(RingFault::NotFinite { ring: index });
    }
    if ring.len() > 1 && ring.first() != ring.last() {
        return Some(RingFault::Open { ring: index });
    }
    (ring.len() < 4).then_some(RingFault::Empty { ring: index })
}

/// Twice the signed area of a ring, closed or not: positive when counter-clockwise.
pub(crate) fn doubled_area(ring: &[[f64; 2]]) -> f64 {
    let Some(o) = ring.first() else { return 0.0 };
    let about = |p: &[f64; 2], q: &[f64; 2]| (p[0] - o[0]) * (q[1] - o[1]) - (q[0] - o[0]) * (p[1] - o[1]);
    ring.windows(2).map(|w| about(&w[0], &w[1])).sum()
}

struct Edge {
    low: f64,
    high: f64,
    side: [f64; 2],
    ends: [[f64; 2]; 2],
    place: (usize, usize),
}

/// Pairs of edges between two checks of the time limit.
const AT_ONCE: u64 = 1 << 16;

/// The first crossing; `None` if the time limit was reached.
fn crossing(rings: &[Vec<[f64; 2]>], keep_going: &dyn Fn() -> bool) -> Option<Option<RingFault>> {
    let mut edges = edges(rings);
    edges.sort_by(|a, b| a.low.total_cmp(&b.low));
    let mut pairs = 0_u64;
    for (i, a) in edges.iter().enumerate() {
        for b in edges[i + 1..].iter().take_while(|b| b.low <= a.high) {
            pairs += 1;
            if pairs.is_multiple_of(AT_ONCE) && !keep_going() {
                return None;
            }
            let apart = a.side[1] < b.side[0] || b.side[1] < a.side[0];
            if !apart && cross_properly(a.ends[0], a.ends[1], b.ends[0], b.ends[1]) {
                let (one, other) = (a.place.min(b.place), a.place.max(b.place));
                return Some(Some(RingFault::Crossing { one, other, near: rings[one.0][one.1] }));
            }
        }
    }
    Some(None)
}

/// All edges, with their extent along the axis of the sweep (`low`, `high`) and across it (`side`).
fn edges(rings: &[Vec<[f64; 2]>]) -> Vec<Edge> {
    let pairs = || rings.iter().flat_map(|r| r.windows(2));
    let along = |k: usize| pairs().map(|w| (w[1][k] - w[0][k]).abs()).sum::<f64>();
    let span = |k: usize| {
        let values = || rings.iter().flatten().map(|p| p[k]);
        values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
    };
    let axis = usize::from(along(0) * span(1) > along(1) * span(0));
    let edge = |ring: usize, i: usize, w: &[[f64; 2]]| {
        let (p, q) = (w[0], w[1]);
        Edge {
            low: p[axis].min(q[axis]),
            high: p[axis].max(q[axis]),
            side: [p[1 - axis].min(q[1 - axis]), p[1 - axis].max(q[1 - axis])],
            ends: [p, q],
            place: (ring, i),
        }
    };
    let of_ring = |(k, r): (usize, &Vec<[f64; 2]>)| {
        r.windows(2).enumerate().map(|(i, w)| edge(k, i, w)).collect::<Vec<_>>()
    };
    rings.iter().enumerate().flat_map(of_ring).collect()
}

// On which side of a line a point lies, decided exactly: ring checks must not depend on rounding.

/// `Greater` where a, b, c turn left, `Less` where they turn right, `Equal` where they are on one line.
/// Exact for finite coordinates whose products neither overflow nor underflow.
pub fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Ordering {
    let left = (a[0] - c[0]) * (b[1] - c[1]);
    let right = (a[1] - c[1]) * (b[0] - c[0]);
    let det = left - right;
    // Shewchuk's bound of the rounding error: (3 + 16 ε) ε, ε = 2⁻⁵³.
    if det.abs() > 3.3306690738754716e-16 * (left.abs() + right.abs()) {
        return det.total_cmp(&0.0);
    }
    exact_sign([(a[0], b[1]), (-a[0], c[1]), (-c[0], b[1]), (-a[1], b[0]), (a[1], c[0]), (c[1], b[0])])
}

/// Whether segments p q and r s cross at a point inside both.
pub fn cross_properly(p: [f64; 2], q: [f64; 2], r: [f64; 2], s: [f64; 2]) -> bool {
    let opposite = |a: Ordering, b: Ordering| a != Ordering::Equal && a == b.reverse();
    opposite(turn(p, q, r), turn(p, q, s)) && opposite(turn(r, s, p), turn(r, s, q))
}

/// Sign of a sum of products, by an expansion of non-overlapping terms that grows without rounding.
fn exact_sign(products: [(f64, f64); 6]) -> Ordering {
    let mut parts = [0.0; 12];
    let mut used = 0;
    for (x, y) in products {
        let product = x * y;
        for term in [libm::fma(x, y, -product), product] {
            let mut sum = term;
            for part in &mut parts[..used] {
                let (total, error) = two_sum(sum, *part);
                *part = error;
                sum = total;
            }
            parts[used] = sum;
            used += 1;
        }
    }
    let leading = parts.iter().rev().find(|v| **v != 0.0);
    leading.map_or(Ordering::Equal, |v| v.total_cmp(&0.0))
}

/// The rounded sum and its error.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}
