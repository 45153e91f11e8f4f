//! Rings cut to a box (Sutherland and Hodgman 1974).

use crate::Bounds;

/// The part of a ring (not closed) inside the box, closed along the sides of the box; empty if there is none.
pub(crate) fn clip_ring(ring: &[[f64; 2]], bounds: &Bounds) -> Vec<[f64; 2]> {
    let sides = [(0, bounds.min[0], 1.0), (0, bounds.max[0], -1.0), (1, bounds.min[1], 1.0)];
    let sides = sides.into_iter().chain([(1, bounds.max[1], -1.0)]);
    sides.fold(ring.to_vec(), |ring, (axis, limit, sign)| half(&ring, axis, limit, sign))
}

/// The part where `sign · (p[axis] − limit) ≥ 0`.
fn half(ring: &[[f64; 2]], axis: usize, limit: f64, sign: f64) -> Vec<[f64; 2]> {
    let inside = |p: &[f64; 2]| sign * (p[axis] - limit) >= 0.0;
    let mut kept = Vec::with_capacity(ring.len() + 4);
    for (i, q) in ring.iter().enumerate() {
        let p = &ring[(i + ring.len() - 1) % ring.len()];
        if inside(p) != inside(q) {
            kept.push(cut(p, q, axis, limit));
        }
        if inside(q) {
            kept.push(*q);
        }
    }
    kept
}

fn cut(p: &[f64; 2], q: &[f64; 2], axis: usize, limit: f64) -> [f64; 2] {
    let t = (limit - p[axis]) / (q[axis] - p[axis]);
    let other = 1 - axis;
    let mut point = [limit; 2];
    point[other] = p[other] + t * (q[other] - p[other]);
    point
}
