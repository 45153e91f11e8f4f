//! Vessels that a plan has to hold for.

use ship::engine::Streams;

use plan::{Candidate, Deviations, Doubt};

const COVARIANCE: [[f64; 3]; 3] = [[4.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 0.0]];

fn rows(entries: [[f64; 3]; 3]) -> Vec<Vec<f64>> {
    entries.map(|row| row.to_vec()).to_vec()
}

#[test]
fn oracle_the_ellipsoid_has_so_many_standard_errors_in_every_direction() {
    let deviations = Deviations::ellipsoid(&rows(COVARIANCE), 3.0).unwrap();
    let nominal = [1.0, -2.0, 5.0];
    let doubt = Doubt { nominal: &nominal, deviations: &deviations, current_m_s: 0.0 };
    for direction in [[1.0, 0.0], [0.0, 1.0], [0.6, -0.8]] {
        let along = |who: &Candidate| {
            let off = doubt.parameters(who);
            direction[0] * (off[0] - nominal[0]) + direction[1] * (off[1] - nominal[1])
        };
        let values: Vec<f64> = doubt.axes().iter().map(along).collect();
        let [a, b] = direction;
        let variance = a * a * 4.0 + 2.0 * a * b * 1.0 + b * b * 2.0;
        let most = doubt.extreme(&values);
        assert!((along(&most) - 3.0 * variance.sqrt()).abs() < 1e-12);
        assert_eq!(doubt.parameters(&most)[2], 5.0);
        let others = doubt.neighbours(&most);
        assert!(others.len() > 3 && others.iter().all(|who| along(who) <= along(&most) + 1e-12));
    }
}

#[test]
fn law_a_linear_function_is_predicted_exactly_anywhere() {
    let (nominal, deviations) = ([1.0, -2.0], Deviations::Box(0.2));
    let doubt = Doubt { nominal: &nominal, deviations: &deviations, current_m_s: 0.5 };
    let linear = |who: &Candidate| {
        let ([a, b], [north, east]) = (doubt.parameters(who).try_into().unwrap(), doubt.current(who));
        7.0 + 3.0 * a - b + 4.0 * north - 2.0 * east
    };
    let values: Vec<f64> = doubt.axes().iter().map(linear).collect();
    let most = doubt.extreme(&values);
    // 12 for the nominal vessel, and 3·0.2·1, 0.2·2, √(4² + 2²)·0.5 of its parameters and of the current.
    assert!((linear(&most) - (12.0 + 0.6 + 0.4 + 5.0_f64.sqrt())).abs() < 1e-12);
    for who in doubt.neighbours(&most).iter().chain([&most]) {
        assert!((doubt.predicted(&values, who) - linear(who)).abs() < 1e-12, "{who:?}");
    }
}

#[test]
fn law_independent_numbers_are_an_ellipsoid_along_their_axes() {
    let own = Deviations::independent(&[2.0, 0.5], 1.5);
    assert_eq!(own, Deviations::ellipsoid(&[vec![4.0, 0.0], vec![0.0, 0.25]], 1.5).unwrap());
}

#[test]
fn law_numbers_stay_within_their_bounds_and_move_freely_in_them() {
    let nominal = [1.0, -2.0, 5.0];
    let bounds = vec![[0.5, 1.1], [f64::NEG_INFINITY, f64::INFINITY], [5.0, 5.0]];
    let deviations = Deviations::Box(0.5).within(Some(bounds));
    let doubt = Doubt { nominal: &nominal, deviations: &deviations, current_m_s: 0.0 };
    let at = |ends: [f64; 3]| doubt.parameters(&Candidate { at: ends.to_vec(), current: [0.0; 2] });
    assert_eq!(at([1.0, 1.0, 1.0]), [1.1, -3.0, 5.0]);
    assert_eq!(at([-1.0, -1.0, -1.0]), [0.5, -1.0, 5.0]);
    assert_eq!(at([0.1, 0.0, 0.0]), [1.05, -2.0, 5.0]);
    assert_eq!(Deviations::Box(0.5).within(None), Deviations::Box(0.5));
}

#[test]
fn law_a_covariance_that_is_not_positive_is_refused_where_that_shows() {
    let refused = |entries| Deviations::ellipsoid(&rows(entries), 1.0).unwrap_err().parameter;
    assert_eq!(refused([[4.0, 3.0, 0.0], [3.0, 2.0, 0.0], [0.0, 0.0, 1.0]]), 1);
    assert_eq!(refused([[-1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]]), 0);
    assert_eq!(refused([[1.0, 0.0, 0.0], [0.5, 2.0, 0.0], [0.0, 0.0, 1.0]]), 1);
    assert_eq!(refused([[f64::NAN, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]]), 0);
}

#[test]
fn law_no_draw_is_worse_than_the_extreme_of_a_linear_function() {
    let nominal = [2.0, -1.0, 0.5];
    for deviations in [Deviations::Box(0.35), Deviations::ellipsoid(&rows(COVARIANCE), 2.0).unwrap()] {
        let doubt = Doubt { nominal: &nominal, deviations: &deviations, current_m_s: 0.2 };
        let weights = [0.3, -1.0, 0.7];
        let value = |who: &Candidate| {
            let (own, current) = (doubt.parameters(who), doubt.current(who));
            weights.iter().zip(own).map(|(w, p)| w * p).sum::<f64>() + 2.0 * current[0] - current[1]
        };
        let values: Vec<f64> = doubt.axes().iter().map(value).collect();
        let most = value(&doubt.extreme(&values));
        for run in 0..200 {
            let (mut normal, mut uniform) = ([0.0; 3], [0.0; 5]);
            Streams::new(1, "normal").normals(run, 0, &mut normal);
            Streams::new(1, "uniform").normals(run, 0, &mut uniform);
            let uniform = uniform.map(|x: f64| x.clamp(-1.0, 1.0));
            let at = deviations.drawn(&uniform[..3], &normal);
            let who = Candidate { at, current: [uniform[3] * 0.7, uniform[4] * 0.7] };
            assert!(value(&who) <= most + 1e-12, "{who:?}");
        }
    }
}
