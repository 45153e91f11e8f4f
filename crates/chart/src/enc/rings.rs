//! Joins edges: end to end as lines, and closed as rings.

use std::collections::{HashMap, VecDeque};

/// A place in the cell's units: longitude, latitude.
pub(crate) type Place = [i32; 2];

/// An edge in its direction.
pub(crate) struct Run {
    pub places: Vec<Place>,
    /// Whether it may also be traversed backwards.
    pub either_way: bool,
}

/// Outer and inner rings of a polygon, or lines.
pub(crate) type Rings = Vec<Vec<Place>>;

/// Edges as lines: consecutive ones are joined.
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

/// Polygons with these outer and inner rings. Almost all have one outer ring. `count` is called with the
/// number of edges to be tested next, and may refuse.
pub(crate) fn polygons<E>(
    outside: Rings,
    inside: Rings,
    count: impl Fn(usize) -> Result<(), E>,
) -> Result<Vec<Rings>, E> {
    let mut polygons: Vec<Rings> = outside.into_iter().map(|ring| vec![ring]).collect();
    for hole in inside {
        let mut outer = 0;
        if polygons.len() > 1 {
            for (k, polygon) in polygons.iter().enumerate() {
                if holds(&polygon[0], &hole, &count)? {
                    outer = k;
                    break;
                }
            }
        }
        if let Some(polygon) = polygons.get_mut(outer) {
            polygon.push(hole);
        }
    }
    Ok(polygons)
}

/// Whether a ring contains another one that does not cross it: by the first place that is not on it.
fn holds<E>(ring: &[Place], hole: &[Place], count: impl Fn(usize) -> Result<(), E>) -> Result<bool, E> {
    for place in hole {
        count(ring.len())?;
        match side(ring, *place) {
            Side::On => {}
            side => return Ok(side == Side::Within),
        }
    }
    Ok(true)
}

/// Edges as rings: each continues with the first remaining edge that follows.
///
/// # Errors
/// Where a ring ends without being closed.
pub(crate) fn rings(edges: Vec<Run>) -> Result<Rings, Place> {
    let mut ends = Ends::of(&edges);
    let mut left: Vec<Option<Run>> = edges.into_iter().map(Some).collect();
    let mut rings = Vec::new();
    for first in 0..left.len() {
        let Some(Run { places: mut ring, .. }) = left[first].take() else { continue };
        while ring.first() != ring.last() {
            let [.., end] = ring[..] else { break };
            let next = ends.next_at(end, &left).and_then(|k| left[k].take()).ok_or(end)?;
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

/// The edges that may be traversed from a place, in order.
struct Ends(HashMap<Place, VecDeque<usize>>);

impl Ends {
    fn of(edges: &[Run]) -> Self {
        let mut own: HashMap<Place, VecDeque<usize>> = HashMap::new();
        for (k, edge) in edges.iter().enumerate() {
            let back = edge.places.last().filter(|_| edge.either_way);
            edge.places
                .first()
                .into_iter()
                .chain(back)
                .for_each(|end| own.entry(*end).or_default().push_back(k));
        }
        Self(own)
    }

    /// The first remaining edge that may be traversed from `end`.
    fn next_at(&mut self, end: Place, left: &[Option<Run>]) -> Option<usize> {
        let own = self.0.get_mut(&end)?;
        while let Some(k) = own.pop_front() {
            if left[k].is_some() {
                return Some(k);
            }
        }
        None
    }
}

/// The position of a place relative to a ring.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Within,
    On,
    Beyond,
}

/// On which side of a ring a place lies.
fn side(ring: &[Place], [x, y]: Place) -> Side {
    let wide = |v: i32| i64::from(v);
    let mut inside = false;
    for pair in ring.windows(2) {
        let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
        // Exact: differences of 32-bit numbers have 33 bits, their products 66.
        let across = i128::from(wide(x1) - wide(x0)) * i128::from(wide(y) - wide(y0))
            - i128::from(wide(x) - wide(x0)) * i128::from(wide(y1) - wide(y0));
        let within = x0.min(x1) <= x && x <= x0.max(x1) && y0.min(y1) <= y && y <= y0.max(y1);
        if across == 0 && within {
            return Side::On;
        }
        if (y0 > y) != (y1 > y) && ((across < 0) == (y1 > y0)) {
            inside = !inside;
        }
    }
    if inside { Side::Within } else { Side::Beyond }
}
