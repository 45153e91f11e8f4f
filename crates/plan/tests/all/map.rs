//! What a map of a planned trial shows.

use plan::voyage::{Hull, placed, round_minutes, widest};
use ship::engine::Pose;

#[test]
fn a_name_stands_in_the_longest_part_of_an_area() {
    let square = |west: f64, east: f64| vec![[west, 0.0], [east, 0.0], [east, 10.0], [west, 10.0]];
    assert_eq!(widest(&[square(0.0, 30.0)], 5.0), Some([0.0, 30.0]));
    assert_eq!(widest(&[square(0.0, 30.0), square(5.0, 12.0)], 5.0), Some([12.0, 30.0]));
    assert_eq!(widest(&[vec![[0.0, 0.0], [8.0, 0.0], [0.0, 8.0]]], 2.0), Some([0.0, 6.0]));
    assert_eq!(widest(&[square(0.0, 30.0)], 11.0), None);
}

#[test]
fn law_round_minutes_lie_between_their_ends_and_are_few() {
    for (from, to, minutes) in [(24.9, 25.02, 2.0), (-0.508, -0.5, 0.1), (10.0, 10.4, 5.0), (1.0, 9.0, 60.0)]
    {
        let all: Vec<f64> = round_minutes(from, to).collect();
        assert!(all.iter().all(|at| (from..=to).contains(at)) && all.len() <= 9, "{all:?}");
        let whole = |at: &f64| {
            let steps = at * 60.0 / minutes;
            (steps - steps.round()).abs() < 1e-6
        };
        assert!(all.iter().all(whole), "{all:?}");
        let apart = all.windows(2).all(|pair| ((pair[1] - pair[0]) * 60.0 / minutes - 1.0).abs() < 1e-6);
        assert!(apart && all.len() >= 3, "{all:?}");
    }
}

#[test]
fn law_points_of_a_body_fill_its_hull_and_turn_with_it() {
    let hull = Hull {
        length_m: 30.0,
        beam_m: 8.0,
        reference_m: 5.0,
        air_draught_m: None,
        draught_m: None,
        block_coefficient: None,
    };
    let body = hull.body(3.0);
    assert_eq!(body.len(), 11 * 4);
    let ends =
        |k: usize| body.iter().map(|p| p[k]).fold((9e9, -9e9), |(a, b): (f64, f64), v| (a.min(v), b.max(v)));
    assert_eq!((ends(0), ends(1)), ((-20.0, 10.0), (-4.0, 4.0)));
    // Heading east, forward is east and starboard is south.
    let east = Pose { x: 100.0, y: 200.0, psi: std::f64::consts::FRAC_PI_2 };
    let [ahead, aside] = [[10.0, 0.0], [0.0, 4.0]].map(|p| placed(east, &[p]).next().unwrap());
    assert!((ahead[0] - 210.0).abs() < 1e-9 && (ahead[1] - 100.0).abs() < 1e-9, "{ahead:?}");
    assert!((aside[0] - 200.0).abs() < 1e-9 && (aside[1] - 96.0).abs() < 1e-9, "{aside:?}");
}
