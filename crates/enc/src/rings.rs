//! Edges put together: end to end as lines, and closed as rings.

use std::collections::VecDeque;

/// A place in the cell's units: longitude, latitude.
pub(crate) type Place = [i32; 2];

/// An edge in its direction.
pub(crate) struct Run {
    pub places: Vec<Place>,
    /// Whether it may be gone along backwards, too.
    pub either_way: bool,
}

/// Outer and inner rings of a polygon.
type Rings = Vec<Vec<Place>>;

/// Edges as lines: those that follow each other become one.
pub(crate) fn runs(edges: Vec<Run>) -> Rings {
    let mut lines: Rings = Vec::new();
    for edge in edges {
        match lines.last_mut() {
            Some(line) if line.last() == edge.places.first() => line.extend(&edge.places[1..]),
            _ => lines.push(edge.places),
        }
    }
    lines
}

/// Polygons with these outer and inner edges. Almost all have one outer ring.
///
/// # Errors
/// Where a ring ends without being closed.
pub(crate) fn polygons(outside: Vec<Run>, inside: Vec<Run>) -> Result<Vec<Rings>, Place> {
    let mut polygons: Vec<Rings> = rings(outside)?.into_iter().map(|ring| vec![ring]).collect();
    for hole in rings(inside)? {
        let around =
            polygons.iter().position(|polygon| hole.iter().all(|place| encloses(&polygon[0], *place)));
        if let Some(polygon) = polygons.get_mut(around.unwrap_or(0)) {
            polygon.push(hole);
        }
    }
    Ok(polygons)
}

fn rings(edges: Vec<Run>) -> Result<Rings, Place> {
    let mut left: VecDeque<Run> = edges.into();
    let mut rings = Vec::new();
    while let Some(first) = left.pop_front() {
        let mut ring = first.places;
        while ring.first() != ring.last() {
            let [.., end] = ring[..] else { break };
            let follows = |run: &Run| {
                run.places.first() == Some(&end) || (run.either_way && run.places.last() == Some(&end))
            };
            let next = left.iter().position(follows).and_then(|k| left.remove(k)).ok_or(end)?;
            let mut places = next.places;
            if places.first() != Some(&end) {
                places.reverse();
            }
            ring.extend(&places[1..]);
        }
        rings.push(ring);
    }
    Ok(rings)
}

/// Whether a place is inside a ring or on its boundary.
fn encloses(ring: &[Place], [x, y]: Place) -> bool {
    let wide = |v: i32| i64::from(v);
    let mut inside = false;
    for pair in ring.windows(2) {
        let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
        // Exact: differences of 32-bit numbers have 33 bits, their products 66.
        let across = i128::from(wide(x1) - wide(x0)) * i128::from(wide(y) - wide(y0))
            - i128::from(wide(x) - wide(x0)) * i128::from(wide(y1) - wide(y0));
        let within = x0.min(x1) <= x && x <= x0.max(x1) && y0.min(y1) <= y && y <= y0.max(y1);
        if across == 0 && within {
            return true;
        }
        if (y0 > y) != (y1 > y) && ((across < 0) == (y1 > y0)) {
            inside = !inside;
        }
    }
    inside
}
