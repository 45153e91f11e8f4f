//! Where swept boxes are free.

use plan::lattice::FreeCells;
use plan::lattice::LatticeFile;

#[test]
fn boxes_may_touch_bounds_and_obstacles() {
    let cells = FreeCells::new(LatticeFile { nx: 5, ny: 1, headings: 1, cell: 10.0, origin: [0.0, 0.0] });
    let free =
        |obstacles: &[[f64; 4]], swept: [f64; 4]| cells.of(&[0.0, -5.0, 35.0, 5.0], obstacles, &[swept]);
    let hull = [0.0, -5.0, 5.0, 5.0];
    assert_eq!(free(&[], hull), [true, true, true, true, false]);
    let between = [[15.0, -5.0, 20.0, 5.0]];
    assert_eq!(free(&between, hull), [true, true, true, true, false]);
    let over = [[14.0, -5.0, 20.0, 5.0], [29.0, 4.0, 31.0, 9.0]];
    assert_eq!(free(&over, hull), [true, false, true, false, false]);
    assert_eq!(free(&[], [-1.0, -5.0, 0.0, 5.0]), [false, true, true, true, false]);
    assert_eq!(free(&[], [0.0, -6.0, 5.0, 5.0]), [false; 5]);
}
