//! The border of the charted area: edges of charted polygons that no neighbour shares.

use std::collections::HashSet;

use crate::Polygon;

type Directed = [[u64; 2]; 2];

/// Edges with a charted polygon on one side only. Neighbours share a border when both have the same corners
/// on it, as the cells of electronic charts do; otherwise the border counts as uncharted on either side.
pub(crate) fn frontier(polygons: &[Polygon]) -> Vec<[[f64; 2]; 2]> {
    let edges = || polygons.iter().flat_map(Polygon::edges);
    let known: HashSet<Directed> = edges().map(directed).collect();
    let open = |edge: &[[f64; 2]; 2]| {
        let [from, to] = directed(*edge);
        !known.contains(&[to, from])
    };
    edges().filter(open).collect()
}

/// The bits of an edge's ends; adding zero normalizes negative zero.
fn directed(edge: [[f64; 2]; 2]) -> Directed {
    edge.map(|p| p.map(|v| (v + 0.0).to_bits()))
}
