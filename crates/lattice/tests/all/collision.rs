//! Where swept boxes are free.

use lattice::collision::{FreeCells, Grid, Surroundings};

#[test]
fn boxes_may_touch_bounds_and_obstacles() {
    let cells = FreeCells::new(Grid { nx: 5, ny: 1, cell: 10.0, origin: [0.0, 0.0] });
    let around = |obstacles| Surroundings { bounds: [0.0, -5.0, 35.0, 5.0], obstacles };
    let hull = [[0.0, -5.0, 5.0, 5.0]];
    assert_eq!(cells.of(&around(vec![]), &hull), [true, true, true, true, false]);
    let between = around(vec![[15.0, -5.0, 20.0, 5.0]]);
    assert_eq!(cells.of(&between, &hull), [true, true, true, true, false]);
    let over = around(vec![[14.0, -5.0, 20.0, 5.0], [29.0, 4.0, 31.0, 9.0]]);
    assert_eq!(cells.of(&over, &hull), [true, false, true, false, false]);
    assert_eq!(cells.of(&around(vec![]), &[[-1.0, -5.0, 0.0, 5.0]]), [false, true, true, true, false]);
    assert_eq!(cells.of(&around(vec![]), &[[0.0, -6.0, 5.0, 5.0]]), [false; 5]);
}
