//! Small files that would expand to much: counted before they expand, and refused.

use chart::enc::Cell;

use crate::enc::damaged::{base, refused};
use crate::enc::made::{area, edge, edge_between, line, node_at};

/// The bay with a line of pointers to one edge, each time.
fn bay_with(places: usize, pointers: usize) -> Cell {
    let file = [base(), edge(500, places), line(500, 30, std::iter::repeat_n(500, pointers))].concat();
    assert!(file.len() < 1_000_000, "{}", file.len());
    Cell::read(&file).unwrap()
}

#[test]
fn pointers_to_one_edge_over_and_over_are_refused() {
    refused(
        bay_with(100_000, 10_000).features(),
        &["COALNE 65535-5500-1", "places up to it", "report the cell"],
    );
    assert!(bay_with(100, 10).features().is_ok());
}

#[test]
fn objects_are_refused_that_take_more_places_than_are_allowed() {
    let cell = bay_with(1000, 20);
    let places: u64 = cell.features().unwrap().iter().map(|object| object.geometry.places()).sum();
    assert!(places > 20_000, "{places}");
    assert!(cell.features_within(places + 2000).is_ok());
    refused(cell.features_within(places - 2000), &["objects of more than", "allow more memory"]);
}

/// Rings of many edges take time that grows with the file: by the square of their number it would be hours.
#[test]
fn an_area_of_many_edges_out_of_order_is_read() {
    const EDGES: u32 = 40_000;
    let node = |k: u32| 1000 + k % EDGES;
    let nodes = (0..EDGES).flat_map(|k| node_at(node(k), k));
    let edges = (0..EDGES).flat_map(|k| edge_between(1000 + k, node(k), node(k + 1)));
    let backwards = (0..EDGES).rev().map(|k| 1000 + k * 7919 % EDGES);
    let file = [base(), nodes.collect(), edges.collect(), area(600, 112, backwards)].concat();
    let objects = Cell::read(&file).unwrap().features().unwrap();
    assert!(objects.iter().any(|object| object.id == "65535-5600-1"));
}
