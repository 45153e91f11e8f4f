//! Legs of a passage, and the lines between their waypoints.

use plan::voyage::{Draft, STRAIGHT, append_leg};

fn straight(from: [f64; 2], to: [f64; 2], step: usize) -> Draft {
    Draft {
        what: STRAIGHT.to_owned(),
        informative: false,
        straight: true,
        steps: step..step + 1,
        from,
        to,
        turn_radius_m: None,
        samples: 10 * step..10 * step + 10,
        leaves: 10 * step + 10,
        then: Vec::new(),
    }
}

#[test]
fn straight_moves_on_one_course_are_one_leg_until_something_is_done_between() {
    let mut all = Vec::new();
    append_leg(&mut all, straight([0.0, 0.0], [100.0, 0.0], 0));
    append_leg(&mut all, Draft { turn_radius_m: Some(60.0), ..straight([100.0, 0.0], [300.0, 0.0], 1) });
    assert_eq!(all.len(), 1);
    let whole = (all[0].to, all[0].steps.clone(), all[0].samples.clone(), all[0].turn_radius_m);
    assert_eq!(whole, ([300.0, 0.0], 0..2, 0..20, Some(60.0)));
    // After a turn under way, on another course, after a stop, and next to a maneuver another leg begins.
    append_leg(&mut all, straight([300.0, 0.0], [400.0, 0.0], 2));
    append_leg(&mut all, straight([400.0, 0.0], [400.0, 50.0], 3));
    append_leg(&mut all, Draft { straight: false, ..straight([400.0, 50.0], [400.0, 90.0], 4) });
    append_leg(&mut all, straight([400.0, 90.0], [400.0, 99.0], 5));
    assert_eq!(all.len(), 5);
    all[4].then.push("turn".to_owned());
    append_leg(&mut all, straight([400.0, 99.0], [400.0, 110.0], 6));
    assert_eq!(all.len(), 6);
}

#[test]
fn law_a_place_next_to_a_line_is_as_far_from_it_as_from_its_nearest_point() {
    // Course 30 degrees; starboard is positive across.
    let (sin, cos) = libm::sincos(std::f64::consts::FRAC_PI_6);
    let line = straight([10.0, 20.0], [10.0 + 200.0 * cos, 20.0 + 200.0 * sin], 0).line();
    assert!((line.length_m - 200.0).abs() < 1e-9);
    for (along, across, away) in [(50.0, 7.0, 7.0), (150.0, -9.0, 9.0), (-3.0, 4.0, 5.0), (212.0, -5.0, 13.0)]
    {
        let place = [10.0 + along * cos - across * sin, 20.0 + along * sin + across * cos];
        let found = line.along(place);
        let back = line.place(found);
        assert!(libm::hypot(back[0] - place[0], back[1] - place[1]) < 1e-9);
        assert!((found[0] - along).abs() < 1e-9 && (found[1] - across).abs() < 1e-9, "{found:?}");
        assert!((line.away(place) - away).abs() < 1e-9);
    }
}
