//! The lattice at sea.

use std::f64::consts::FRAC_PI_2;

use plan::{Grid, Mode};

fn grid(headings: usize) -> Grid {
    let modes = vec![Mode { name: "stop".into(), speed_m_s: 0.0 }];
    Grid { nx: 3, ny: 3, headings, cell_m: 100.0, origin_m: [0.0, 0.0], modes }
}

#[test]
fn levels_count_counter_clockwise_from_east() {
    let grid = grid(8);
    assert!((grid.heading_rad(0) - FRAC_PI_2).abs() < 1e-12);
    assert!(grid.heading_rad(2).abs() < 1e-12);
    for level in 0..8 {
        assert_eq!(grid.nearest_level(grid.heading_rad(level) + 0.3), level);
    }
}

#[test]
fn steps_point_along_their_level() {
    assert_eq!((0..4).map(|h| grid(4).step_along(h)).collect::<Vec<_>>(), [(1, 0), (0, 1), (-1, 0), (0, -1)]);
    assert_eq!(grid(8).step_along(1), (1, 1));
    assert_eq!(grid(16).step_along(1), (2, 1));
    assert_eq!(grid(16).step_along(7), (-2, 1));
}
