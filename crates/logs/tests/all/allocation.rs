//! Forces to thruster settings.

use logs::{Allocation, Law, Setting, Thruster};

fn thruster(law: Law, position_m: [f64; 2]) -> Thruster {
    Thruster { law, coefficient: 1.7, position_m }
}

#[test]
fn law_allocated_settings_make_the_forces_through_the_azimuth_map() {
    for (law, places) in [
        (Law::Quadratic, vec![[-0.4, -0.1], [-0.4, 0.1]]),
        (Law::Linear, vec![[11.0, 0.0], [-11.0, 0.0]]),
        (Law::Quadratic, vec![[11.0, 0.3], [-9.0, 2.0], [-9.0, -2.5]]),
    ] {
        let allocation = Allocation::new(places.iter().map(|p| thruster(law, *p)).collect());
        let mut near = vec![Setting::default(); places.len()];
        for k in 0..60 {
            let k = f64::from(k);
            let tau = [30.0 * (0.3 * k).cos(), 20.0 * (0.7 * k).sin(), 9.0 * (1.1 * k).sin()];
            let next = allocation.settings(tau, &near).unwrap();
            for (found, wanted) in allocation.forces(&next).into_iter().zip(tau) {
                approx::assert_abs_diff_eq!(found, wanted, epsilon = 1e-11);
            }
            for (next, near) in next.iter().zip(&near) {
                assert!((next.alpha - near.alpha).abs() <= std::f64::consts::FRAC_PI_2 + 1e-12);
            }
            near = next;
        }
    }
}

#[test]
fn law_no_other_components_with_the_same_forces_are_smaller() {
    let places = [[11.0, 0.3], [-9.0, 2.0], [-9.0, -2.5]];
    let allocation = Allocation::new(places.iter().map(|p| thruster(Law::Linear, *p)).collect());
    let f = allocation.components([3.0, -2.0, 5.0]).unwrap();
    // Steps that change no force: thrusters pull on each other along the lines between them.
    for (i, j) in [(0, 1), (1, 2), (0, 2)] {
        let line = [places[j][0] - places[i][0], places[j][1] - places[i][1]];
        let along: f64 = (0..2).map(|d| (f[j][d] - f[i][d]) * line[d]).sum();
        approx::assert_abs_diff_eq!(along, 0.0, epsilon = 1e-12);
    }
}

#[test]
fn forces_that_a_single_thruster_cannot_produce_are_reported() {
    let allocation = Allocation::new(vec![thruster(Law::Quadratic, [-2.0, 0.0])]);
    assert!(allocation.components([5.0, 3.0, -6.0]).is_ok());
    let refused = allocation.components([5.0, 3.0, 1.0]).unwrap_err();
    assert_eq!((refused.force, refused.wanted, refused.made), (2, 1.0, -6.0));
    assert!(Allocation::new(Vec::new()).components([1.0, 0.0, 0.0]).is_err());
}

#[test]
fn a_thruster_is_reversed_rather_than_turned_about() {
    let allocation = Allocation::new(vec![thruster(Law::Quadratic, [-2.0, 0.0])]);
    let found = allocation.settings([-1.7 * 4.0, 0.0, 0.0], &[Setting { n: 1.0, alpha: 0.0 }]).unwrap();
    approx::assert_abs_diff_eq!(found[0].n, -2.0, epsilon = 1e-14);
    approx::assert_abs_diff_eq!(found[0].alpha, 0.0, epsilon = 1e-14);
    let still = allocation.settings([0.0; 3], &[Setting { n: 1.0, alpha: 0.6 }]).unwrap();
    assert_eq!(still[0], Setting { n: 0.0, alpha: 0.6 });
}
