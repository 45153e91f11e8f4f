//! Polygons by their corners, and the cells that they close, against independent geometry.

use chart::{Class, Footprint, Mask, Plane, Polygon, Raster};

use crate::support::{from_polygon, from_segment, inside, square};

/// A box with a notch from the north.
const CORNERS: [[f64; 2]; 5] =
    [[24.98, 59.99], [25.02, 59.99], [25.02, 60.01], [24.99, 59.9995], [24.98, 60.01]];

/// The polygon, and its ring with the first position repeated.
fn notched() -> (Polygon, Vec<Vec<[f64; 2]>>) {
    let plane = Plane::new(25.0, 60.0).unwrap();
    let polygon = Polygon::of_corners(Class::NoGo, &CORNERS, &plane).unwrap();
    for [lon, lat] in CORNERS {
        assert!(polygon.inside_m(plane.to_plane(lon, lat)).abs() < 1e-6);
    }
    let ring = polygon.rings[0].iter().chain(polygon.rings[0].first()).copied().collect();
    (polygon, vec![ring])
}

#[test]
fn law_inside_m_is_the_distance_to_the_edge_and_below_0_outside() {
    let (polygon, rings) = notched();
    let edge_m = |p| rings[0].windows(2).map(|w| from_segment(p, w[0], w[1])).fold(f64::INFINITY, f64::min);
    let mut held = 0;
    for k in 0..10_000_i32 {
        let p = [f64::from(k % 100 - 50) * 31.0 + 0.7, f64::from(k / 100 - 50) * 29.0 + 0.3];
        let inside_m = polygon.inside_m(p);
        held += usize::from(inside(&rings, p));
        assert_eq!(inside_m > 0.0, inside(&rings, p), "{p:?}");
        assert!((inside_m.abs() - edge_m(p)).abs() < 1e-9, "{p:?}");
    }
    assert!((1000..9000).contains(&held), "{held}");
}

#[test]
fn law_free_cells_lie_outside_of_a_polygon_or_inside_of_it_as_a_whole() {
    let (polygon, rings) = notched();
    let raster = Raster::covering(&square(1400.0), 37.0).unwrap();
    let one = Footprint::swept(&[[1.0, 0.0], [-1.0, 1.0], [-1.0, -1.0]], &[(18.0, 18.0, 0.0)], 37.0).unwrap();
    let (within, beyond) = (Mask::within([&polygon], raster), Mask::beyond(&polygon, raster));
    let mut free = [0, 0, 0];
    for (col, row) in (0..raster.ny).flat_map(|row| (0..raster.nx).map(move |col| (col, row))) {
        let points = (0..=8).flat_map(|a| (0..=8).map(move |b| [a, b].map(|part| f64::from(part) / 8.0)));
        let low = raster.node(col, row);
        let mut points = points.map(|part| [0, 1].map(|k: usize| low[k] + part[k] * raster.cell_m));
        let (out, own) = (within.is_free(&one, col, row), beyond.is_free(&one, col, row));
        assert_eq!([out, own].map(|is| !is), [&within, &beyond].map(|m| m.closed()[row * raster.nx + col]));
        if out {
            assert!(points.all(|p| from_polygon(&rings, p) > 0.0), "{col} {row}");
        } else if own {
            assert!(points.all(|p| inside(&rings, p)), "{col} {row}");
        } else {
            // An edge passes through the cell.
            assert!(points.any(|p| polygon.inside_m(p).abs() < raster.cell_m / 8.0), "{col} {row}");
        }
        free[if out { 0 } else { 1 + usize::from(own) }] += 1;
    }
    assert!(free.iter().all(|cells| *cells > 50), "{free:?}");
}
