//! A common clock and its sections.

use logs::{Grid, Samples, Section, sections};

#[test]
fn rounding_costs_no_row() {
    let grid = Grid::new(0.1, 0.1 + 0.1 * 30.0, 10.0);
    assert_eq!(grid.rows, 31);
    assert_eq!(grid.rows_within(0.3, 0.6), 2..6);
    assert_eq!(grid.rows_within(-5.0, 99.0), 0..31);
    assert_eq!(grid.rows_within(50.0, 60.0).len(), 0);
    assert_eq!(Grid::new(1.0, 0.5, 1.0).rows, 0);
}

#[test]
fn the_last_state_needs_no_input() {
    let nan = f64::NAN;
    let states =
        [vec![1.0; 8], vec![1.0, 1.0, 1.0, 1.0, nan, 1.0, 1.0, 1.0], vec![1.0; 8]].map(Samples::from);
    let input = [vec![1.0, 1.0, nan, 1.0, 1.0, 1.0, 1.0, nan].into()];
    let expected = [Section { start: 0, samples: 2 }, Section { start: 5, samples: 2 }];
    assert_eq!(sections(&states, &input), expected);
}
